//! The coefficient file: a coefficient set as TOML that people can read, print and keep.
//!
//! It carries exactly the set that the board stores, and the set's identity. A file that lost its end, or in which a
//! number was changed, no longer has the identity that it states, and is refused.
//!
//! - `keys`: the keys of the file, to and from a set.
//! - `sources`: what the set was found from.
//! - `table`: a set as tables for people.

mod keys;
mod sources;
mod table;

use std::path::Path;

use hexsense_core::channel::NAMES;
use hexsense_core::records::{CoefficientSet, MAX_ENCODED, MAX_VALUE, RecordError};

use crate::files::{self, FileError, SETTINGS};
use crate::sensor_file::table_of;
use keys::{FORMAT, Keys};
pub use sources::{Sources, text_digest};
pub use table::table;

/// Why a file gives no coefficient set.
#[derive(Debug, thiserror::Error)]
pub enum CoefficientFileError {
    /// The file cannot be read or written, or one of its values cannot be.
    #[error(transparent)]
    File(#[from] FileError),
    /// A file of another version, or of another kind.
    #[error(
        "{file}: format is {format:?}; it must be {FORMAT:?}; {}",
        way_forward(format)
    )]
    Format {
        /// The file.
        file: String,
        /// What it says that it is.
        format: String,
    },
    /// The file is not whole.
    #[error(
        "{file} is not a whole coefficient file; it was cut off or is something else. {problem}"
    )]
    Incomplete {
        /// The file.
        file: String,
        /// What the parser misses.
        problem: String,
    },
    /// The numbers are not those that the identity was made of.
    #[error(
        "{file} says it is set {stated}, but its numbers are not those of that set; it was changed or damaged: \
         take the original, or calibrate again"
    )]
    Identity {
        /// The file.
        file: String,
        /// Identity in the file.
        stated: String,
    },
    /// The digests are not those that the set carries.
    #[error(
        "{file}: the table sources is not that of set {stated}; it was changed or damaged: take the original, or \
         calibrate again"
    )]
    Sources {
        /// The file.
        file: String,
        /// Identity in the file.
        stated: String,
    },
    /// A value could be too large.
    #[error(
        "{file}: with the offset_counts and row {row} of the matrix in [{table}], {channel} can reach {value:.1e} at a count \
         from 0 to 65535; the board takes a set only if every value stays below {MAX_VALUE:e}, and every offset. Take the \
         original file, or calibrate again"
    )]
    Values {
        /// The file.
        file: String,
        /// The table of the triad.
        table: &'static str,
        /// Row of the matrix, from 1.
        row: usize,
        /// The channel.
        channel: &'static str,
        /// The largest value, or the largest offset where that is the greater, and infinite when it cannot be computed.
        value: f32,
    },
    /// The set is not usable.
    #[error("{file}: {reason}")]
    Record {
        /// The file.
        file: String,
        /// What is wrong with it.
        reason: RecordError,
    },
}

/// The set as a file.
///
/// # Errors
/// [`CoefficientFileError::Record`] for a set that no board would take.
pub fn to_text(
    file: &str,
    set: &CoefficientSet,
    sources: &Sources,
) -> Result<String, CoefficientFileError> {
    let keys = Keys::of(identity(file, set)?, set, Some(sources.clone()));
    Ok(toml::to_string(&keys).expect("a set is made of tables, lists, strings and numbers"))
}

/// The set as JSON, with the keys of the file.
///
/// # Errors
/// [`CoefficientFileError::Record`] for a set that no board would take.
pub fn to_json(set: &CoefficientSet) -> Result<serde_json::Value, CoefficientFileError> {
    let keys = Keys::of(identity("the set", set)?, set, None);
    Ok(serde_json::to_value(keys).expect("a set is made of tables, lists, strings and numbers"))
}

/// Writes the set to `path`, whole or not at all. Its provenance is that of `sources`.
///
/// # Errors
/// [`CoefficientFileError::File`], [`CoefficientFileError::Record`] and [`CoefficientFileError::Sources`].
pub fn save(
    path: &Path,
    set: &CoefficientSet,
    sources: &Sources,
) -> Result<(), CoefficientFileError> {
    let file = path.display().to_string();
    let text = to_text(&file, set, sources)?;
    parse(&file, &text)?;
    Ok(files::replace(path, &text)?)
}

/// Reads the set in `path`, and what it was found from.
///
/// # Errors
/// Every variant of [`CoefficientFileError`].
pub fn load(path: &Path) -> Result<(CoefficientSet, Sources), CoefficientFileError> {
    parse(&path.display().to_string(), &files::read(path, SETTINGS)?)
}

/// Reads `text`, which came from `file`.
///
/// # Errors
/// Every variant of [`CoefficientFileError`].
pub fn parse(file: &str, text: &str) -> Result<(CoefficientSet, Sources), CoefficientFileError> {
    check_format(file, text)?;
    let keys: Keys = files::from_toml(file, text).map_err(|error| match error {
        FileError::Syntax { file, problem } => CoefficientFileError::Incomplete { file, problem },
        other => other.into(),
    })?;
    let set = keys.to_set(file)?;
    let (file, stated) = (file.to_owned(), keys.id);
    if identity(&file, &set)? != stated {
        return Err(CoefficientFileError::Identity { file, stated });
    }
    match keys.sources {
        Some(sources) if sources.provenance() == set.provenance => Ok((set, sources)),
        _ => Err(CoefficientFileError::Sources { file, stated }),
    }
}

/// Refuses another kind of file, or another version, by its first key: its other keys are not known then.
fn check_format(file: &str, text: &str) -> Result<(), CoefficientFileError> {
    #[derive(serde::Deserialize)]
    struct Head {
        format: String,
    }
    match toml::from_str(text) {
        Ok(Head { format }) if format != FORMAT => Err(CoefficientFileError::Format {
            file: file.to_owned(),
            format,
        }),
        // What is no TOML, or has no format, is told with the line that is wrong.
        _ => Ok(()),
    }
}

/// What to do with a file of another format.
fn way_forward(format: &str) -> &'static str {
    match format.strip_prefix("hexsense coefficients, version ") {
        Some("1" | "2") => {
            "files of versions 1 and 2 do not name all that they were found from. If the campaign's folder still has the \
             captures, move the file away and run `hexsense calibrate` with the same --geometry, --sensors and --out: it \
             computes the coefficients anew from recorded runs. Otherwise calibrate again"
        }
        Some(_) => "install the hexsense that wrote it, or calibrate again",
        None => "give the coefficients.toml of a campaign",
    }
}

/// Identity of a set that is fit to be stored.
fn identity(file: &str, set: &CoefficientSet) -> Result<String, CoefficientFileError> {
    let mut buffer = [0; MAX_ENCODED];
    let encoded = set.check().and_then(|()| set.encode(&mut buffer));
    let encoded = encoded.map_err(|reason| too_large(file, set, reason))?;
    Ok(CoefficientSet::id_of(encoded).to_string())
}

/// The reason, with table, row and value where values are too large.
fn too_large(file: &str, set: &CoefficientSet, reason: RecordError) -> CoefficientFileError {
    let file = file.to_owned();
    let RecordError::Values { triad } = reason else {
        return CoefficientFileError::Record { file, reason };
    };
    let first = 3 * triad as usize;
    let coefficients = &set.triads[triad as usize];
    let reach = |row: usize| {
        let value = coefficients.largest(coefficients.matrix[row]);
        value.max(coefficients.offset[row].abs())
    };
    let largest = (0..3).max_by(|one, other| reach(*one).total_cmp(&reach(*other)));
    let row = largest.unwrap_or_default();
    CoefficientFileError::Values {
        file,
        table: table_of(triad),
        row: row + 1,
        channel: NAMES[first + row],
        value: reach(row),
    }
}

#[cfg(test)]
mod printed;
#[cfg(test)]
mod tests;
