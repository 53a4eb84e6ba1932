//! The key in a file: whoever has it may change what the board keeps.
//!
//! 64 hexadecimal digits and a newline, readable by its owner alone. A key file is never overwritten: the key in it may
//! be the only way to change a board again.

use std::fs::OpenOptions;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use hexsense_core::wire::change::Key;

use crate::files::{self, FileError};

/// Where the key of a board is when nothing else is said: in the present folder, under the board's unique id.
#[must_use]
pub fn default_of(board: &[u8; 12]) -> PathBuf {
    format!("hexsense-{}.key", files::hex(board)).into()
}

/// Why there is no key. Every message starts with the file's name, and none holds what is in it.
#[derive(Debug, thiserror::Error)]
pub enum KeyFileError {
    /// No such file.
    #[error(
        "{file}: there is no such key file; name that of the board with --key FILE, or give a board that has no key \
         one with `hexsense provision`"
    )]
    Missing {
        /// The file.
        file: String,
    },
    /// The system does not let it be read.
    #[error("{file}: the key cannot be read: {reason}")]
    Read {
        /// The file.
        file: String,
        /// The system's reason.
        reason: io::Error,
    },
    /// Something else is in it.
    #[error(
        "{file}: this is no key file, which holds 64 hexadecimal digits and nothing else; name the right one with \
         --key FILE"
    )]
    Content {
        /// The file.
        file: String,
    },
    /// Others than its owner can read it, or write it.
    #[error(
        "{file}: others than its owner can use this key file (mode {mode:03o}), and whoever has the key can change the \
         board; allow its owner alone with `chmod 600 {file}`. If others may have read it, give the board a new key with \
         `hexsense provision`"
    )]
    Open {
        /// The file.
        file: String,
        /// Its permissions.
        mode: u32,
    },
    /// A key that anybody would try first.
    #[error(
        "{file}: all bytes of this key are the same, which no random key is, and nothing is done with it; name the right \
         one with --key FILE"
    )]
    Trivial {
        /// The file.
        file: String,
    },
    /// It is there already.
    #[error(
        "{file}: is there already, and key files are never overwritten; name another with --key FILE"
    )]
    Exists {
        /// The file.
        file: String,
    },
    /// The system does not let it be written.
    #[error("{file}: the key cannot be written: {reason}; name another place with --key FILE")]
    Write {
        /// The file.
        file: String,
        /// The system's reason.
        reason: io::Error,
    },
    /// The system has no random numbers.
    #[error("{file}: no key can be made, since the system gives no random numbers: {reason}")]
    Random {
        /// The file.
        file: String,
        /// The system's reason.
        reason: getrandom::Error,
    },
}

/// The key in a file.
///
/// # Errors
/// [`KeyFileError::Missing`], [`KeyFileError::Read`], [`KeyFileError::Content`], [`KeyFileError::Open`] and
/// [`KeyFileError::Trivial`].
pub fn load(path: &Path) -> Result<Key, KeyFileError> {
    let file = path.display().to_string();
    let text = match files::read(path, files::KEY) {
        Ok(text) => text,
        Err(FileError::Read { reason, .. }) => {
            return Err(match reason.kind() {
                ErrorKind::NotFound => KeyFileError::Missing { file },
                ErrorKind::InvalidData => KeyFileError::Content { file },
                _ => KeyFileError::Read { file, reason },
            });
        }
        Err(_) => return Err(KeyFileError::Content { file }),
    };
    let Some(key) = files::from_hex::<32>(text.trim_end()) else {
        return Err(KeyFileError::Content { file });
    };
    if let Some(mode) = open_to_others(path) {
        return Err(KeyFileError::Open { file, mode });
    }
    if key.iter().all(|byte| *byte == key[0]) {
        return Err(KeyFileError::Trivial { file });
    }
    Ok(Key(key))
}

/// The permissions of a file that others than its owner can read or write.
#[cfg(unix)]
fn open_to_others(path: &Path) -> Option<u32> {
    use std::os::unix::fs::PermissionsExt;
    let mode = std::fs::metadata(path).ok()?.permissions().mode() & 0o777;
    (mode & 0o077 != 0).then_some(mode)
}

/// Other systems have no such permissions.
#[cfg(not(unix))]
fn open_to_others(_path: &Path) -> Option<u32> {
    None
}

/// Makes a random key and a file with it.
///
/// # Errors
/// [`KeyFileError::Exists`], [`KeyFileError::Write`] and [`KeyFileError::Random`].
pub fn create(path: &Path) -> Result<Key, KeyFileError> {
    let file = path.display().to_string();
    let mut key = [0; 32];
    if let Err(reason) = getrandom::fill(&mut key) {
        return Err(KeyFileError::Random { file, reason });
    }
    save(path, &Key(key)).map_err(|reason| match reason.kind() {
        ErrorKind::AlreadyExists => KeyFileError::Exists { file },
        _ => KeyFileError::Write { file, reason },
    })?;
    Ok(Key(key))
}

fn save(path: &Path, key: &Key) -> io::Result<()> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    let mut file = options.open(path)?;
    let written = file
        .write_all(format!("{}\n", files::hex(&key.0)).as_bytes())
        .and_then(|()| file.sync_all());
    if written.is_err() {
        // Half a key is of no use, and would be in the way of a whole one.
        let _ = std::fs::remove_file(path);
    }
    written
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(path: &Path, text: &str) {
        std::fs::write(path, text).unwrap();
        allow(path, 0o600);
    }

    #[cfg(unix)]
    fn allow(path: &Path, mode: u32) {
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    }

    #[cfg(not(unix))]
    fn allow(_: &Path, _: u32) {}

    #[cfg(unix)]
    #[test]
    fn a_key_that_others_can_read_or_write_is_refused_until_they_cannot() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("board.key");
        create(&path).unwrap();
        for mode in [0o644, 0o640, 0o604, 0o620, 0o602, 0o660, 0o777] {
            allow(&path, mode);
            let error = load(&path).unwrap_err().to_string();
            assert!(error.contains(&format!("mode {mode:o}")), "{error}");
            assert!(error.contains("chmod 600"), "{error}");
        }
        for mode in [0o600, 0o400] {
            allow(&path, mode);
            load(&path).unwrap();
        }
    }

    #[test]
    fn a_key_of_equal_bytes_is_refused_and_not_printed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("board.key");
        for byte in ["00", "ff", "5e"] {
            write(&path, &byte.repeat(32));
            let error = load(&path).unwrap_err().to_string();
            assert!(
                error.contains("all bytes of this key are the same"),
                "{error}"
            );
            assert!(!error.contains(&byte.repeat(2)), "{error}");
        }
        write(&path, &("00".repeat(31) + "01"));
        load(&path).unwrap();
    }

    #[test]
    fn what_is_too_large_for_a_key_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("board.key");
        write(&path, &("5ec5".repeat(16) + &" ".repeat(2_000)));
        let error = load(&path).unwrap_err();
        assert!(matches!(error, KeyFileError::Content { .. }), "{error}");
    }

    #[test]
    fn a_key_that_was_made_is_read_back_and_never_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("board.key");
        let key = create(&path).unwrap();
        assert!(load(&path).unwrap() == key);
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!((text.len(), text.ends_with('\n')), (65, true));
        let error = create(&path).unwrap_err();
        assert!(matches!(error, KeyFileError::Exists { .. }), "{error}");
        assert!(load(&path).unwrap() == key);
        assert!(create(&folder.path().join("other.key")).unwrap() != key);
    }

    #[cfg(unix)]
    #[test]
    fn a_key_file_is_its_owners_alone() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("board.key");
        create(&path).unwrap();
        let mode = std::fs::metadata(&path).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
    }

    #[test]
    fn what_is_no_key_is_named_and_not_printed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("board.key");
        let missing = load(&path).unwrap_err().to_string();
        assert!(
            missing.contains("board.key") && missing.contains("hexsense provision"),
            "{missing}"
        );
        let digits = "5ec".repeat(22);
        let spaced = format!(" {}", &digits[..64]);
        let spelt = format!("{}g", &digits[..63]);
        for text in [
            "",
            &digits[..62],
            &digits[..63],
            &digits[..65],
            &spaced,
            &spelt,
        ] {
            write(&path, text);
            let error = load(&path).unwrap_err().to_string();
            assert!(error.contains("board.key: this is no key file"), "{error}");
            assert!(!error.contains("5ec5ec"), "{error}");
        }
        write(&path, &digits[..64]);
        let key = load(&path).unwrap().0;
        assert_eq!(key[..3], [0x5e, 0xc5, 0xec]);
    }
}
