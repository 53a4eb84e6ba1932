//! Reading and replacing the files that people touch, with errors that say where something is wrong.
//!
//! A file is never left half written: its text goes to a file beside it, which then takes its name. Both reach the disk
//! before the next thing is done, so that this holds when the power goes, too. That file is always a new one: a link of
//! its name is taken away and not followed.
//!
//! A file that is read whole has a [`Limit`], so that no file, and no device in its place, takes all memory.

mod limit;
mod reading;

use std::fmt::Display;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;

pub use limit::{CAPTURE, KEY, LOG, Limit, NOTES, SETTINGS};
pub use reading::read;

/// Most letters that are told of what is wrong with a file.
const MAX_TOLD: usize = 1_000;

/// Why a file cannot be used. Every message starts with the file's name.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The system does not let it be read.
    #[error("{file}: cannot be read: {reason}")]
    Read {
        /// The file.
        file: String,
        /// The system's reason.
        reason: io::Error,
    },
    /// Larger than such a file can be.
    #[error(
        "{file}: is larger than {} bytes, and {} is smaller; see that the right file is named",
        limit.bytes,
        limit.kind
    )]
    Large {
        /// The file.
        file: String,
        /// How large it may be.
        limit: Limit,
    },
    /// The system does not let it be written.
    #[error("{file}: cannot be written: {reason}; what was there before is unchanged")]
    Write {
        /// The file.
        file: String,
        /// The system's reason.
        reason: io::Error,
    },
    /// The system does not let a growing file be written on.
    #[error(
        "{file}: cannot be written on: {reason}; the {rows} scans before are in it and stay readable; make room there, \
         or record into another place"
    )]
    BrokenOff {
        /// The file.
        file: String,
        /// The system's reason.
        reason: io::Error,
        /// Whole rows in it.
        rows: u64,
    },
    /// Not TOML or JSON, or a key is missing, unknown or of another type.
    #[error("{file}: {problem}")]
    Syntax {
        /// The file.
        file: String,
        /// The parser's words, with line and column.
        problem: String,
    },
    /// A value that cannot be.
    #[error("{file}: {key} is {value}; {limit}")]
    Value {
        /// The file.
        file: String,
        /// The key, with its table and its index from 1.
        key: String,
        /// The value there.
        value: String,
        /// What it must be.
        limit: String,
    },
    /// A line of a table that cannot be.
    #[error("{file}, line {line}: {problem}")]
    Line {
        /// The file.
        file: String,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        problem: String,
    },
}

impl FileError {
    /// The error that `key` of `file` is `value` but must be something else.
    pub fn value(
        file: &str,
        key: impl Into<String>,
        value: impl Display,
        limit: impl Into<String>,
    ) -> Self {
        Self::Value {
            file: file.to_owned(),
            key: key.into(),
            value: value.to_string(),
            limit: limit.into(),
        }
    }
}

/// Creates a file, in place of whatever has its name. What a link leads to stays as it is.
///
/// # Errors
/// The system's.
pub fn create(path: &Path) -> io::Result<File> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    File::create_new(path)
}

/// Reads `text`, which came from `file`, as TOML.
///
/// # Errors
/// [`FileError::Syntax`].
pub fn from_toml<T: DeserializeOwned>(file: &str, text: &str) -> Result<T, FileError> {
    toml::from_str(text).map_err(|error| {
        // It quotes the line, which may be the whole file.
        let problem = error.to_string();
        let told: String = problem.trim_end().chars().take(MAX_TOLD).collect();
        let cut = if told.len() < problem.trim_end().len() {
            " …"
        } else {
            ""
        };
        FileError::Syntax {
            file: file.to_owned(),
            problem: told + cut,
        }
    })
}

/// Writes `text` as the whole content of `path`, at once: the old content stays until the new one is complete.
///
/// # Errors
/// [`FileError::Write`].
pub fn replace(path: &Path, text: &str) -> Result<(), FileError> {
    write_part(path, text)?;
    let part = part_of(path);
    fs::rename(&part, path).map_err(|reason| write_error(path, reason))?;
    sync_folder_of(path);
    Ok(())
}

/// Writes `text` to the file beside `path` that [`replace`] would give its name: what is known of a thing under way.
///
/// # Errors
/// [`FileError::Write`].
pub fn write_part(path: &Path, text: &str) -> Result<(), FileError> {
    let part = part_of(path);
    let mut file = create(&part).map_err(|reason| write_error(path, reason))?;
    let written = file.write_all(text.as_bytes());
    written.and_then(|()| file.sync_all()).map_err(|reason| {
        // Half a file is of no use, and on a full disk it takes room. The error at hand says what is wrong.
        let _ = fs::remove_file(&part);
        write_error(path, reason)
    })
}

/// Puts the names in the folder of `path` on the disk. Where the system has no such thing, names reach the disk when it
/// thinks fit, which is not worth failing for.
pub fn sync_folder_of(path: &Path) {
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

fn write_error(path: &Path, reason: io::Error) -> FileError {
    FileError::Write {
        file: path.display().to_string(),
        reason,
    }
}

/// Name of the file that becomes `path` when it is complete.
#[must_use]
pub fn part_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    PathBuf::from(name)
}

/// `value` when it is a number inside `range`.
///
/// # Errors
/// [`FileError::Value`].
pub fn within(
    file: &str,
    key: &str,
    value: f64,
    range: RangeInclusive<f64>,
) -> Result<f64, FileError> {
    if range.contains(&value) {
        return Ok(value);
    }
    let limit = format!("it must be {} to {}", range.start(), range.end());
    Err(FileError::value(file, key, value, limit))
}

/// Lower-case hexadecimal digits of `bytes`.
#[must_use]
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The `N` bytes that `text` spells in hexadecimal digits; `None` when it does not.
#[must_use]
pub fn from_hex<const N: usize>(text: &str) -> Option<[u8; N]> {
    let digits = text.as_bytes();
    if digits.len() != 2 * N || !digits.iter().all(u8::is_ascii_hexdigit) {
        return None;
    }
    let mut bytes = [0; N];
    for (byte, pair) in bytes.iter_mut().zip(digits.chunks_exact(2)) {
        *byte = u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()?;
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_cannot_be_replaced_stays_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plan.toml");
        replace(&path, "old").unwrap();
        fs::create_dir(part_of(&path)).unwrap();
        let error = replace(&path, "new").unwrap_err().to_string();
        assert!(error.contains("plan.toml: cannot be written"), "{error}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_in_the_place_of_a_part_is_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let [path, other] = ["plan.toml", "other"].map(|name| folder.path().join(name));
        fs::write(&other, "mine").unwrap();
        std::os::unix::fs::symlink(&other, part_of(&path)).unwrap();
        replace(&path, "new").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(fs::read_to_string(&other).unwrap(), "mine");
        assert!(path.symlink_metadata().unwrap().is_file());
    }

    #[test]
    fn a_value_may_lie_on_either_end_of_its_range_and_not_beyond() {
        let is_within = |value: f64| within("plan.toml", "period_s", value, 1e-3..=0.1).is_ok();
        assert!(is_within(1e-3) && is_within(0.1));
        assert!(!is_within(1e-3_f64.next_down()) && !is_within(0.1_f64.next_up()));
        assert!(!is_within(f64::NAN) && !is_within(f64::INFINITY));
        let error = within("plan.toml", "period_s", 0.2, 1e-3..=0.1).unwrap_err();
        let told = "plan.toml: period_s is 0.2; it must be 0.001 to 0.1";
        assert_eq!(error.to_string(), told);
    }

    #[test]
    fn hexadecimal_digits_come_back_as_bytes_or_not_at_all() {
        assert_eq!(from_hex(&hex(&[0, 0xA5, 0xFF])), Some([0, 0xA5, 0xFF]));
        for text in ["", "00a5", "00a5f", "00a5fg", "00a5ff00", "+0a5ff", "äää"] {
            assert_eq!(from_hex::<3>(text), None, "{text}");
        }
    }
}
