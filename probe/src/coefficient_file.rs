//! The coefficient file: a coefficient set as TOML that people can read, print and keep.
//!
//! It carries exactly the set that the board stores, and the set's identity. A file that lost its end, or in which a
//! number was changed, no longer has the identity that it states, and is refused.

use std::path::Path;
use std::time::UNIX_EPOCH;

use hexsense_core::channel::{JACKS, Triad};
use hexsense_core::records::{
    CoefficientSet, JackCoefficients, MAX_ENCODED, MotionBase, RecordError, TriadCoefficients,
};
use serde::{Deserialize, Serialize};

use crate::date;
use crate::files::{self, FileError};

const FORMAT: &str = "hexsense coefficients, version 2";

/// Why a file gives no coefficient set.
#[derive(Debug, thiserror::Error)]
pub enum CoefficientFileError {
    /// The file cannot be read or written, or one of its values cannot be.
    #[error(transparent)]
    File(#[from] FileError),
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
        "{file} says it is set {stated}, but its numbers are those of set {found}; it was changed or damaged: \
         take the original, or calibrate again"
    )]
    Identity {
        /// The file.
        file: String,
        /// Identity in the file.
        stated: String,
        /// Identity of its numbers.
        found: String,
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

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    format: String,
    id: String,
    board: String,
    geometry: String,
    geometry_hash: String,
    date_utc: String,
    temperature_c: f64,
    captures_sha256: String,
    linear_acceleration: Table,
    angular_acceleration: Table,
    angular_rate: Table,
    base: BaseTable,
    jacks: JackTable,
}

/// One triad: value = matrix · (counts − offset), in m/s², rad/s² or rad/s.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    offset_counts: [f64; 3],
    offset_standard_uncertainty: [f64; 3],
    matrix_unit_per_count: [[f64; 3]; 3],
    matrix_standard_uncertainty: [[f64; 3]; 3],
    delay_s: f64,
}

/// The motion base, m, axes with Y up.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BaseTable {
    lower: [[f64; 3]; 6],
    upper: [[f64; 3]; 6],
    length_min: f64,
    length_max: f64,
    home_height: f64,
}

/// Its jacks: length = zero_length + metres_per_count · (counts − zero_counts), in m.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct JackTable {
    zero_length: f64,
    zero_counts: [f64; 6],
    metres_per_count: [f64; 6],
}

/// The set as a file.
///
/// # Errors
/// [`CoefficientFileError::Record`] for a set that no board would take.
pub fn to_text(file: &str, set: &CoefficientSet) -> Result<String, CoefficientFileError> {
    let keys = Keys::of(file, set)?;
    Ok(toml::to_string(&keys).expect("a set is made of tables, lists, strings and numbers"))
}

/// The set as JSON, with the keys of the file.
///
/// # Errors
/// [`CoefficientFileError::Record`] for a set that no board would take.
pub fn to_json(set: &CoefficientSet) -> Result<serde_json::Value, CoefficientFileError> {
    let keys = Keys::of("the set", set)?;
    Ok(serde_json::to_value(keys).expect("a set is made of tables, lists, strings and numbers"))
}

/// Writes the set to `path`, whole or not at all.
///
/// # Errors
/// [`CoefficientFileError::File`] and [`CoefficientFileError::Record`].
pub fn save(path: &Path, set: &CoefficientSet) -> Result<(), CoefficientFileError> {
    let file = path.display().to_string();
    let text = to_text(&file, set)?;
    parse(&file, &text)?;
    Ok(files::replace(path, &text)?)
}

/// Reads the set in `path`.
///
/// # Errors
/// Every variant of [`CoefficientFileError`].
pub fn load(path: &Path) -> Result<CoefficientSet, CoefficientFileError> {
    parse(&path.display().to_string(), &files::read(path)?)
}

/// Reads `text`, which came from `file`.
///
/// # Errors
/// Every variant of [`CoefficientFileError`].
pub fn parse(file: &str, text: &str) -> Result<CoefficientSet, CoefficientFileError> {
    let keys: Keys = files::from_toml(file, text).map_err(|error| match error {
        FileError::Syntax { file, problem } => CoefficientFileError::Incomplete { file, problem },
        other => other.into(),
    })?;
    if keys.format != FORMAT {
        return Err(FileError::value(
            file,
            "format",
            format!("{:?}", keys.format),
            format!("it must be {FORMAT:?}"),
        )
        .into());
    }
    let set = keys.to_set(file)?;
    let found = identity(file, &set)?;
    if found != keys.id {
        return Err(CoefficientFileError::Identity {
            file: file.to_owned(),
            stated: keys.id,
            found,
        });
    }
    Ok(set)
}

/// Identity of a set that is fit to be stored.
fn identity(file: &str, set: &CoefficientSet) -> Result<String, CoefficientFileError> {
    let mut buffer = [0; MAX_ENCODED];
    let encoded = set.check().and_then(|()| set.encode(&mut buffer));
    let encoded = encoded.map_err(|reason| CoefficientFileError::Record {
        file: file.to_owned(),
        reason,
    })?;
    Ok(CoefficientSet::id_of(encoded).to_string())
}

impl Keys {
    fn of(file: &str, set: &CoefficientSet) -> Result<Self, CoefficientFileError> {
        let [linear_acceleration, angular_acceleration, angular_rate] =
            set.triads.each_ref().map(Table::of);
        Ok(Self {
            format: FORMAT.to_owned(),
            id: identity(file, set)?,
            board: files::hex(&set.board),
            geometry: set.geometry.to_string(),
            geometry_hash: files::hex(&set.geometry_hash),
            date_utc: date::utc(set.unix_s),
            temperature_c: wide(set.temperature_c),
            captures_sha256: files::hex(&set.provenance),
            linear_acceleration,
            angular_acceleration,
            angular_rate,
            base: BaseTable::of(&set.base),
            jacks: JackTable::of(&set.jacks),
        })
    }

    fn to_set(&self, file: &str) -> Result<CoefficientSet, FileError> {
        let date = humantime::parse_rfc3339(&self.date_utc)
            .ok()
            .and_then(|date| date.duration_since(UNIX_EPOCH).ok())
            .ok_or_else(|| {
                FileError::value(
                    file,
                    "date_utc",
                    &self.date_utc,
                    "it must be like 2026-01-31T12:00:00Z",
                )
            })?;
        Ok(CoefficientSet {
            board: digits(file, "board", &self.board)?,
            geometry: self.geometry.as_str().try_into().map_err(|_| {
                FileError::value(
                    file,
                    "geometry",
                    &self.geometry,
                    "it is too long for a coefficient set",
                )
            })?,
            geometry_hash: digits(file, "geometry_hash", &self.geometry_hash)?,
            unix_s: date.as_secs(),
            temperature_c: self.temperature_c as f32,
            provenance: digits(file, "captures_sha256", &self.captures_sha256)?,
            triads: [
                &self.linear_acceleration,
                &self.angular_acceleration,
                &self.angular_rate,
            ]
            .map(Table::to_triad),
            base: self.base.to_base(),
            jacks: self.jacks.to_jacks(),
        })
    }
}

fn digits<const N: usize>(file: &str, key: &str, text: &str) -> Result<[u8; N], FileError> {
    files::from_hex(text).ok_or_else(|| {
        FileError::value(
            file,
            key,
            text,
            format!("it must have {} hexadecimal digits", 2 * N),
        )
    })
}

impl Table {
    fn of(triad: &TriadCoefficients) -> Self {
        Self {
            offset_counts: triad.offset.map(wide),
            offset_standard_uncertainty: triad.offset_uncertainty.map(wide),
            matrix_unit_per_count: triad.matrix.map(|row| row.map(wide)),
            matrix_standard_uncertainty: triad.matrix_uncertainty.map(|row| row.map(wide)),
            delay_s: wide(triad.delay_s),
        }
    }

    fn to_triad(&self) -> TriadCoefficients {
        TriadCoefficients {
            offset: self.offset_counts.map(narrow),
            matrix: self.matrix_unit_per_count.map(|row| row.map(narrow)),
            offset_uncertainty: self.offset_standard_uncertainty.map(narrow),
            matrix_uncertainty: self.matrix_standard_uncertainty.map(|row| row.map(narrow)),
            delay_s: narrow(self.delay_s),
        }
    }
}

impl BaseTable {
    fn of(base: &MotionBase) -> Self {
        Self {
            lower: base.lower.map(|hinge| hinge.map(wide)),
            upper: base.upper.map(|hinge| hinge.map(wide)),
            length_min: wide(base.length_min_m),
            length_max: wide(base.length_max_m),
            home_height: wide(base.home_height_m),
        }
    }

    fn to_base(&self) -> MotionBase {
        MotionBase {
            lower: self.lower.map(|hinge| hinge.map(narrow)),
            upper: self.upper.map(|hinge| hinge.map(narrow)),
            length_min_m: narrow(self.length_min),
            length_max_m: narrow(self.length_max),
            home_height_m: narrow(self.home_height),
        }
    }
}

impl JackTable {
    fn of(jacks: &JackCoefficients) -> Self {
        Self {
            zero_length: wide(jacks.zero_length_m),
            zero_counts: jacks.zero_counts.map(wide),
            metres_per_count: jacks.metres_per_count.map(wide),
        }
    }

    fn to_jacks(&self) -> JackCoefficients {
        JackCoefficients {
            zero_length_m: narrow(self.zero_length),
            zero_counts: self.zero_counts.map(narrow),
            metres_per_count: self.metres_per_count.map(narrow),
        }
    }
}

fn narrow(value: f64) -> f32 {
    value as f32
}

/// The `f64` with the shortest digits that still give this `f32`, so that a file shows 0.1 and not 0.10000000149.
fn wide(value: f32) -> f64 {
    value
        .to_string()
        .parse()
        .unwrap_or_else(|_| f64::from(value))
}

/// The set as a table for people: each channel with offset, gain, sensitivity and expanded uncertainty (k = 2).
#[must_use]
pub fn table(set: &CoefficientSet) -> String {
    let mut text = String::from(
        "channel   offset u0, counts          gain M_ii, unit/count                 sensitivity, counts/unit\n",
    );
    for triad in Triad::ALL {
        let coefficients = &set.triads[triad.index()];
        for axis in 0..3 {
            let (gain, uncertainty) = (
                coefficients.matrix[axis][axis],
                coefficients.matrix_uncertainty[axis][axis],
            );
            text += &format!(
                "{:<7} {:>10.2} ± {:<8.2}   {:>13.6e} ± {:<9.2e} {:<7}   {:>10.3}\n",
                hexsense_core::channel::NAMES[triad.first_channel() + axis],
                coefficients.offset[axis],
                2.0 * coefficients.offset_uncertainty[axis],
                gain,
                2.0 * uncertainty,
                triad.unit(),
                1.0 / gain,
            );
        }
    }
    text + "± is the expanded uncertainty, coverage factor 2\n\n" + &base_table(set)
}

/// Base and jack transducers as a table for people.
fn base_table(set: &CoefficientSet) -> String {
    let (base, jacks) = (&set.base, &set.jacks);
    let mut text = format!(
        "base {}: jacks {:.4} m to {:.4} m, O at {:.4} m at home\n\
         jack   lower hinge x, y, z, m          upper hinge x, y, z, m          {:.4} m at, counts   mm per count\n",
        set.geometry, base.length_min_m, base.length_max_m, base.home_height_m, jacks.zero_length_m,
    );
    for jack in 0..JACKS {
        let [lower, upper] = [base.lower[jack], base.upper[jack]]
            .map(|[x, y, z]| format!("{x:>9.4} {y:>9.4} {z:>9.4}"));
        text += &format!(
            "jack{}  {lower}   {upper}   {:>16.2} {:>14.6}\n",
            jack + 1,
            jacks.zero_counts[jack],
            1e3 * jacks.metres_per_count[jack],
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry_file::GeometryFile;

    fn set() -> CoefficientSet {
        let triad = TriadCoefficients {
            offset: [32768.1, 32000.0 / 3.0, 40000.7],
            matrix: [
                [1.0 / 3.0, 1e-3, -1e-7],
                [0.1, 0.7, 0.2],
                [-0.01, 0.02, 1e-2],
            ],
            offset_uncertainty: [0.1, 0.2, 0.3],
            matrix_uncertainty: [[1e-5 / 3.0; 3]; 3],
            delay_s: 0.00123,
        };
        CoefficientSet {
            board: *b"\x01board\xff\x00uid2",
            geometry: "an-74tk-200".try_into().unwrap(),
            geometry_hash: [7; 8],
            unix_s: 1_780_000_000,
            temperature_c: 31.7,
            provenance: [9; 32],
            triads: [triad; 3],
            base: MotionBase::new(&GeometryFile::load("an-74tk-200").unwrap().geometry),
            jacks: JackCoefficients {
                zero_length_m: 2.75,
                zero_counts: [32_768.1; 6],
                metres_per_count: [1e-4 / 3.0; 6],
            },
        }
    }

    #[test]
    fn a_file_gives_the_very_same_bytes() {
        let (mut before, mut after) = ([0; MAX_ENCODED], [0; MAX_ENCODED]);
        let read = parse("c.toml", &to_text("c.toml", &set()).unwrap()).unwrap();
        assert_eq!(
            set().encode(&mut before).unwrap(),
            read.encode(&mut after).unwrap()
        );
    }

    #[test]
    fn a_file_cut_anywhere_is_refused() {
        let text = to_text("c.toml", &set()).unwrap();
        for length in 0..text.trim_end().len() {
            let error = parse("c.toml", &text[..length]).expect_err("a cut file");
            assert!(error.to_string().starts_with("c.toml"), "{error}");
        }
    }

    #[test]
    fn a_changed_number_is_refused_by_the_identity() {
        let text = to_text("c.toml", &set())
            .unwrap()
            .replace("40000.7", "40000.8");
        assert!(matches!(
            parse("c.toml", &text),
            Err(CoefficientFileError::Identity { .. })
        ));
    }
}
