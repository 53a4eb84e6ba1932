//! The keys of a coefficient file, to and from a set.

use std::time::UNIX_EPOCH;

use hexsense_core::channel::{NAMES, Ratiometric};
use hexsense_core::records::{
    BuildId, CoefficientSet, JackCoefficients, MotionBase, TriadCoefficients,
};
use serde::{Deserialize, Serialize};

use super::sources::Sources;
use crate::date;
use crate::files::{self, FileError};

/// Kind and version of the file.
pub const FORMAT: &str = "hexsense coefficients, version 3";

/// The whole file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Keys {
    /// What kind of file this is, and its version.
    pub format: String,
    /// Identity of the set.
    pub id: String,
    board: String,
    geometry: String,
    geometry_hash: String,
    date_utc: String,
    temperature_c: f64,
    provenance_sha256: String,
    /// Names of the channels on which the supply factor does not act.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    ratiometric: Vec<String>,
    /// The firmware that recorded the captures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    firmware_build: Option<String>,
    linear_acceleration: Table,
    angular_acceleration: Table,
    angular_rate: Table,
    base: BaseTable,
    jacks: JackTable,
    /// What the set was found from; a set that comes from a board does not say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sources: Option<Sources>,
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

impl Keys {
    /// The keys of a set with this identity.
    pub fn of(id: String, set: &CoefficientSet, sources: Option<Sources>) -> Self {
        let [linear_acceleration, angular_acceleration, angular_rate] =
            set.triads.each_ref().map(Table::of);
        Self {
            format: FORMAT.to_owned(),
            id,
            board: files::hex(&set.board),
            geometry: set.geometry.to_string(),
            geometry_hash: files::hex(&set.geometry_hash),
            date_utc: date::utc(set.unix_s),
            temperature_c: wide(set.temperature_c),
            provenance_sha256: files::hex(&set.provenance),
            ratiometric: ratiometric_names(set.ratiometric),
            firmware_build: set.build.map(|build| build.to_string()),
            linear_acceleration,
            angular_acceleration,
            angular_rate,
            base: BaseTable::of(&set.base),
            jacks: JackTable::of(&set.jacks),
            sources,
        }
    }

    /// The set that the keys of `file` mean.
    ///
    /// # Errors
    /// [`FileError::Value`].
    pub fn to_set(&self, file: &str) -> Result<CoefficientSet, FileError> {
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
            provenance: digits(file, "provenance_sha256", &self.provenance_sha256)?,
            triads: [
                &self.linear_acceleration,
                &self.angular_acceleration,
                &self.angular_rate,
            ]
            .map(Table::to_triad),
            base: self.base.to_base(),
            jacks: self.jacks.to_jacks(),
            ratiometric: self.ratiometric(file)?,
            build: self.build(file)?,
        })
    }
}

impl Keys {
    fn build(&self, file: &str) -> Result<Option<BuildId>, FileError> {
        let build = self.firmware_build.as_deref();
        let build = build.map(|build| digits(file, "firmware_build", build));
        Ok(build.transpose()?.map(BuildId))
    }

    fn ratiometric(&self, file: &str) -> Result<Ratiometric, FileError> {
        self.ratiometric
            .iter()
            .try_fold(Ratiometric::NONE, |channels, name| {
                let channel = NAMES.iter().position(|known| known == name);
                let channel = channel.ok_or_else(|| {
                    let limit = format!("channels are {}", NAMES.join(", "));
                    FileError::value(file, "ratiometric", name, limit)
                })?;
                Ok(channels.with(channel))
            })
    }
}

fn ratiometric_names(channels: Ratiometric) -> Vec<String> {
    let named = NAMES.iter().enumerate();
    named
        .filter(|(channel, _)| channels.has(*channel))
        .map(|(_, name)| (*name).to_owned())
        .collect()
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
