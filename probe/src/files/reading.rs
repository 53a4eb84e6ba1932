//! Files that are read whole, each with a limit, so that no file, and no device in its place, takes all memory.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use super::FileError;
use super::limit::Limit;

/// The text of a file. No more of it is read than `limit` allows, and of a file that has a size nothing when it is too
/// large.
///
/// # Errors
/// [`FileError::Read`] and [`FileError::Large`].
pub fn read(path: &Path, limit: Limit) -> Result<String, FileError> {
    let file = || path.display().to_string();
    let read = || {
        if may_never_end(path) {
            return Err(io::Error::other(
                "it is a pipe, into which nobody may ever write",
            ));
        }
        let opened = File::open(path)?;
        let size = opened.metadata()?.len();
        let mut text = String::new();
        if size <= limit.bytes {
            text.reserve_exact(size as usize);
            opened.take(limit.bytes + 1).read_to_string(&mut text)?;
        }
        Ok((size.max(text.len() as u64), text))
    };
    match read() {
        Ok((size, text)) if size <= limit.bytes => Ok(text),
        Ok(_) => Err(FileError::Large {
            file: file(),
            limit,
        }),
        Err(reason) => Err(FileError::Read {
            file: file(),
            reason,
        }),
    }
}

/// Whether a path is a named pipe. Those that a shell makes for a command's output are under /dev.
#[cfg(unix)]
fn may_never_end(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    let is_pipe = fs::metadata(path).is_ok_and(|metadata| metadata.file_type().is_fifo());
    is_pipe && !path.starts_with("/dev")
}

/// Other systems have no named pipes among their files.
#[cfg(not(unix))]
fn may_never_end(_path: &Path) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::{KEY, SETTINGS};

    #[test]
    fn a_file_may_be_as_large_as_its_limit_and_no_larger() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("key");
        fs::write(&path, [b'a'; 1_024]).unwrap();
        assert_eq!(read(&path, KEY).unwrap().len(), 1_024);
        fs::write(&path, [b'a'; 1_025]).unwrap();
        let error = read(&path, KEY).unwrap_err().to_string();
        assert!(error.contains("key: is larger than 1024 bytes"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn a_device_without_an_end_is_read_up_to_the_limit() {
        let endless = read(Path::new("/dev/zero"), SETTINGS);
        assert!(
            matches!(endless, Err(FileError::Large { .. })),
            "{endless:?}"
        );
    }
}
