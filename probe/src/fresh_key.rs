//! A fresh key for a board, in its file, and the file that was there before it under another name.
//!
//! A key crosses the line when a board gets it. What answers there may be no board, or a board behind a line that somebody
//! holds. So a key is made for one provisioning and sent once, and a key that exists is never sent. No file is erased: where
//! one is in the way, or its key was not taken, it gets another name beside the first.
//!
//! ```text
//! FILE          the fresh key, and after a failure again what was there before
//! FILE.old-1    what was there before
//! FILE.unused-1 a key that the board did not take
//! ```

use std::fs;
use std::path::{Path, PathBuf};

use hexsense_core::wire::change::Key;

use crate::key_file::{self, KeyFileError};

/// A key that was made for one provisioning.
pub struct FreshKey {
    /// The key.
    pub key: Key,
    /// Its file.
    pub file: PathBuf,
    /// What was there before, under its new name.
    pub before: Option<PathBuf>,
}

impl FreshKey {
    /// Makes a key and its file. A file that is there gets another name.
    ///
    /// # Errors
    /// [`KeyFileError`]; the file is then as it was before.
    pub fn make(file: &Path) -> Result<Self, KeyFileError> {
        let before = match fs::symlink_metadata(file) {
            Ok(_) => Some(set_aside(file, "old")?),
            Err(_) => None,
        };
        match key_file::create(file) {
            Ok(key) => Ok(Self {
                key,
                file: file.to_owned(),
                before,
            }),
            Err(error) => {
                restore(before.as_deref(), file)?;
                Err(error)
            }
        }
    }

    /// The board did not take the key: its file gets another name, which is returned, and what was there before gets its own
    /// back.
    ///
    /// # Errors
    /// [`KeyFileError::Write`].
    pub fn withdraw(self) -> Result<PathBuf, KeyFileError> {
        let unused = set_aside(&self.file, "unused")?;
        restore(self.before.as_deref(), &self.file)?;
        Ok(unused)
    }
}

/// Gives a file the first free name with this ending.
fn set_aside(file: &Path, ending: &str) -> Result<PathBuf, KeyFileError> {
    let names = (1_u32..).map(|number| format!("{}.{ending}-{number}", file.display()).into());
    let free = |name: &PathBuf| fs::symlink_metadata(name).is_err();
    let name = names.into_iter().find(free).unwrap_or_default();
    rename(file, &name)?;
    Ok(name)
}

fn restore(before: Option<&Path>, file: &Path) -> Result<(), KeyFileError> {
    before.map_or(Ok(()), |before| rename(before, file))
}

fn rename(from: &Path, to: &Path) -> Result<(), KeyFileError> {
    fs::rename(from, to).map_err(|reason| KeyFileError::Write {
        file: to.display().to_string(),
        reason,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names in a folder, in order.
    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn every_key_is_another_and_none_is_lost() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("board.key");
        let first = FreshKey::make(&file).unwrap();
        assert!(first.before.is_none() && key_file::load(&file).unwrap() == first.key);
        let second = FreshKey::make(&file).unwrap();
        assert!(second.key != first.key);
        assert!(key_file::load(&file).unwrap() == second.key);
        let before = second.before.unwrap();
        assert!(key_file::load(&before).unwrap() == first.key);
        let third = FreshKey::make(&file).unwrap();
        assert!(third.key != second.key);
        let unused = third.withdraw().unwrap();
        assert!(key_file::load(&file).unwrap() == second.key);
        assert!(key_file::load(&unused).is_ok());
        let expected = ["board.key", "board.key.old-1", "board.key.unused-1"];
        assert_eq!(names(folder.path()), expected);
    }

    #[test]
    fn a_key_that_cannot_be_written_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("no folder").join("board.key");
        assert!(FreshKey::make(&missing).is_err());
        assert!(names(folder.path()).is_empty());
    }
}
