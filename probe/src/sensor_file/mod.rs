//! The sensor file: what the data sheets say of the sensors, the jack transducers and the converter, as TOML.
//!
//! Tolerances are limits that the maker promises (±); noise is one standard deviation. Nothing in this file is
//! measured on the device at hand: it gives the first guess, and the widths from which uncertainties start.
//!
//! ```text
//! volts on the pin = zero_volts + volts_per_unit · value        counts = volts / supply · 65536
//! ```

mod check;

use std::fmt;
use std::path::Path;

use hexsense_core::calibration::truth::Site;
use hexsense_core::channel::{CHANNELS, INERTIAL, JACKS, Ratiometric, Triad};
use hexsense_core::facts::BoardFacts;
use hexsense_core::kinematics::Geometry;
use hexsense_core::transducers::Transducers;
use nalgebra::Vector3;
use serde::Deserialize;

use crate::files::{self, FileError, SETTINGS};
use crate::known_board;
pub use check::table_of;

/// The data sheets of everything that is wired to the board.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorFile {
    /// The file as it is, for copies.
    #[serde(skip)]
    pub text: String,
    /// The board that the sensors are connected to.
    #[serde(skip, default = "known_board::facts")]
    pub board: BoardFacts,
    /// Name of the set of sensors.
    pub name: String,
    /// Gravity where the base stands.
    #[serde(skip)]
    pub gravity: Gravity,
    gravity_m_s2: Option<f64>,
    gravity_uncertainty_m_s2: Option<f64>,
    latitude_deg: Option<f64>,
    height_m: Option<f64>,
    /// Frequencies of known disturbances, Hz; see [`SensorFile::disturbances_hz`].
    #[serde(default = "mains")]
    pub lines_hz: Vec<f64>,
    /// Nominal supply and reference of the converter, V.
    pub supply_v: f64,
    /// Place of the sensor block in the body frame, from O, m.
    pub lever_arm_m: [f64; 3],
    /// How far off that place may be in each axis, ± m.
    pub lever_arm_tolerance_m: f64,
    /// The three accelerometers; values in m/s².
    pub linear_acceleration: TriadSheet,
    /// The three angular accelerometers; values in rad/s².
    pub angular_acceleration: TriadSheet,
    /// The three rate gyros; values in rad/s.
    pub angular_rate: TriadSheet,
    /// The six jack displacement transducers.
    pub jacks: JackSheet,
    /// The converter of the board.
    pub adc: ConverterSheet,
}

/// Gravity where the base stands: the gains of the accelerometers are as good as this value, so a file must give it,
/// by `gravity_m_s2` or by `latitude_deg` and `height_m`. There is no default: over the Earth gravity differs by 0.5 %.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Gravity {
    /// The value, m/s².
    pub m_s2: f64,
    /// Its standard uncertainty, m/s²: the file's `gravity_uncertainty_m_s2`, else the usual size of local anomalies.
    pub uncertainty_m_s2: f64,
    /// Whether the file gives the value; otherwise it is that of the place.
    pub is_given: bool,
    /// Latitude (degrees) and height (m) of the place.
    pub place: Option<(f64, f64)>,
}

impl Gravity {
    /// Where the value comes from, in words.
    #[must_use]
    pub fn source(&self) -> String {
        let place = self.place.map(|(latitude_deg, height_m)| {
            format!("normal gravity of WGS 84 at latitude {latitude_deg}° and height {height_m} m")
        });
        match (self.is_given, place) {
            (true, Some(place)) => {
                format!("gravity_m_s2 of the sensor file, which agrees with {place}")
            }
            (false, Some(place)) => place,
            (_, None) => "gravity_m_s2 of the sensor file".to_owned(),
        }
    }

    /// A latitude that looks like radians.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let (latitude_deg, _) = self.place?;
        (latitude_deg != 0.0 && latitude_deg.abs() < core::f64::consts::PI).then(|| {
            format!(
                "latitude_deg is {latitude_deg}: is it in radians? Degrees are needed; {latitude_deg} rad would be \
                 {:.4}°. If the base stands at {latitude_deg}°, near the equator, nothing needs to be done",
                latitude_deg.to_degrees()
            )
        })
    }
}

impl fmt::Display for Gravity {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (value, uncertainty) = (self.m_s2, self.uncertainty_m_s2);
        write!(f, "{value:.5} ± {uncertainty} m/s² (1σ), {}", self.source())
    }
}

/// Data sheet of three sensors of one kind. "Unit" is the triad's: m/s², rad/s² or rad/s.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TriadSheet {
    /// Largest value that is measured, ± unit.
    pub full_scale: f64,
    /// Sensitivity, V per unit.
    pub volts_per_unit: f64,
    /// Output at zero, V.
    pub zero_volts: f64,
    /// Relative tolerance of the sensitivity, ±.
    pub gain_tolerance: f64,
    /// Tolerance of the zero, ± unit.
    pub bias_tolerance: f64,
    /// Noise density, unit/√Hz.
    pub noise_density: f64,
    /// Random walk of the zero: standard deviation of its change in 5 min, unit.
    pub bias_walk_5min: f64,
    /// Range of the second-order bandwidth, Hz.
    pub bandwidth_hz: [f64; 2],
    /// Range of its damping, dimensionless.
    pub damping: [f64; 2],
    /// Misalignment of each sensor to its axis, standard deviation, degrees.
    pub misalignment_deg: f64,
    /// Whether the output follows the supply of the converters, so that the supply factor does not act on it.
    #[serde(default)]
    pub ratiometric: bool,
}

/// Data sheet of the jack displacement transducers.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JackSheet {
    /// Change of the output from the shortest to the longest jack, V.
    pub full_stroke_volts: f64,
    /// Output at mid-stroke, V.
    pub zero_volts: f64,
    /// Relative tolerance of the sensitivity, ±.
    pub gain_tolerance: f64,
    /// Tolerance of the zero, ± m.
    pub offset_tolerance_m: f64,
    /// Noise at 1 kHz, m rms.
    pub noise_rms_m: f64,
    /// As [`TriadSheet::ratiometric`].
    #[serde(default)]
    pub ratiometric: bool,
}

/// Data sheet of the analog-to-digital converter and of the board's clock.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConverterSheet {
    /// Relative tolerance of the gain, ±.
    pub gain_tolerance: f64,
    /// Tolerance of the offset, ± 12-bit LSB (16 counts each).
    pub offset_tolerance_lsb: f64,
    /// Tolerance of the board's clock, ± ppm.
    pub clock_tolerance_ppm: f64,
}

impl SensorFile {
    /// Reads a sensor file.
    ///
    /// # Errors
    /// [`FileError`] with file, key, value and limit.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        Self::parse(&path.display().to_string(), &files::read(path, SETTINGS)?)
    }

    /// Reads `text`, which came from `file`.
    ///
    /// # Errors
    /// [`FileError::Syntax`] and [`FileError::Value`].
    pub fn parse(file: &str, text: &str) -> Result<Self, FileError> {
        let mut sheet: Self = files::from_toml(file, text)?;
        text.clone_into(&mut sheet.text);
        sheet.gravity = sheet.gravity_of(file)?;
        sheet.check(file)?;
        Ok(sheet)
    }

    /// Known disturbances below half of `rate_hz`, Hz: each of `lines_hz` with its multiples up to the fifth.
    ///
    /// The board's harmonic sums take scans in blocks of B, and mistake a disturbance at m·rate/B ± k·f for harmonic k of
    /// the drive f. The host chooses B so that no named disturbance lies there; it cannot avoid one that is not named.
    pub fn disturbances_hz(&self, rate_hz: u32) -> impl Iterator<Item = f64> + '_ {
        let multiples = self
            .lines_hz
            .iter()
            .flat_map(|line| (1..=MULTIPLES).map(move |multiple| f64::from(multiple) * line));
        multiples.filter(move |line| *line < f64::from(rate_hz) / 2.0)
    }

    /// Data sheet of one triad.
    #[must_use]
    pub fn triad(&self, triad: Triad) -> &TriadSheet {
        match triad {
            Triad::LinearAcceleration => &self.linear_acceleration,
            Triad::AngularAcceleration => &self.angular_acceleration,
            Triad::AngularRate => &self.angular_rate,
        }
    }

    /// Counts of the board that one volt makes at the nominal supply.
    #[must_use]
    pub fn counts_per_volt(&self) -> f64 {
        f64::from(self.board.counts_at_supply) / self.supply_v
    }

    /// The jack transducers on a base, as their data sheet promises them: at mid-stroke they read `zero_volts`.
    #[must_use]
    pub fn transducers(&self, geometry: &Geometry<f64>) -> Transducers<f64> {
        let stroke_m = geometry.length_max_m() - geometry.length_min_m();
        let counts_per_volt = self.counts_per_volt();
        Transducers {
            zero_length_m: (geometry.length_min_m() + geometry.length_max_m()) / 2.0,
            zero_counts: [self.jacks.zero_volts * counts_per_volt; JACKS],
            metres_per_count: [stroke_m / self.jacks.full_stroke_volts / counts_per_volt; JACKS],
            supplied: [!self.jacks.ratiometric; JACKS],
        }
    }

    /// The channels on which the supply factor does not act.
    #[must_use]
    pub fn ratiometric(&self) -> Ratiometric {
        let is_ratiometric = |channel: usize| match channel.checked_sub(INERTIAL) {
            None => self.triad(Triad::ALL[channel / 3]).ratiometric,
            Some(_) => self.jacks.ratiometric,
        };
        (0..CHANNELS)
            .filter(|channel| is_ratiometric(*channel))
            .fold(Ratiometric::NONE, Ratiometric::with)
    }

    /// Where the sensor block stands, and gravity there.
    #[must_use]
    pub fn site(&self) -> Site {
        Site {
            lever_arm_m: Vector3::from(self.lever_arm_m),
            gravity_m_s2: self.gravity.m_s2,
        }
    }
}

/// Multiples of a disturbance that are reckoned with.
const MULTIPLES: u32 = 5;

/// Mains, where the file names no disturbance.
fn mains() -> Vec<f64> {
    vec![50.0]
}

impl TriadSheet {
    /// Counts per unit and counts at zero, as the data sheet promises them.
    #[must_use]
    pub fn nominal_counts(&self, counts_per_volt: f64) -> (f64, f64) {
        (
            self.volts_per_unit * counts_per_volt,
            self.zero_volts * counts_per_volt,
        )
    }

    /// Standard deviation of the delay of one sensor, s, all bandwidths B and dampings ζ within their ranges equally
    /// likely: a second-order response lags by ζ/πB behind slow motion.
    #[must_use]
    pub fn delay_deviation_s(&self) -> f64 {
        let ([slow, fast], [soft, hard]) = (self.bandwidth_hz, self.damping);
        let inverse = if fast > slow {
            (fast / slow).ln() / (fast - slow)
        } else {
            1.0 / slow
        };
        let (mean, square) = (
            (soft + hard) / 2.0 * inverse,
            (soft * soft + soft * hard + hard * hard) / 3.0 / (slow * fast),
        );
        (square - mean * mean).max(0.0).sqrt() / core::f64::consts::PI
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hexsense_core::calibration::gravity::ANOMALY_M_S2;

    fn with_gravity(keys: &str) -> Result<Gravity, FileError> {
        let papers = twin::papers::sensor_file(1);
        let lines = papers.lines().map(|line| match line {
            line if line.starts_with("gravity_m_s2") => format!("{keys}\n"),
            line if line.starts_with("gravity_uncertainty") => String::new(),
            line => format!("{line}\n"),
        });
        SensorFile::parse("sensors.toml", &lines.collect::<String>()).map(|file| file.gravity)
    }

    #[test]
    fn disturbances_are_the_lines_with_their_multiples_and_mains_where_nothing_is_said() {
        let papers = twin::papers::sensor_file(1);
        let kept = papers.lines().filter(|line| !line.starts_with("lines_hz"));
        let text: String = kept.flat_map(|line| [line, "\n"]).collect();
        let disturbances = |lines: &str, rate_hz| {
            SensorFile::parse("sensors.toml", &format!("{lines}\n{text}"))
                .map(|file| file.disturbances_hz(rate_hz).collect::<Vec<f64>>())
        };
        let mains = disturbances("", 1_000).unwrap();
        assert_eq!(mains, [50.0, 100.0, 150.0, 200.0, 250.0]);
        let two = disturbances("lines_hz = [7.5, 400.0]", 1_000).unwrap();
        assert_eq!(two, [7.5, 15.0, 22.5, 30.0, 37.5, 400.0]);
        let error = disturbances("lines_hz = [50.0, -1.0]", 1_000).unwrap_err();
        assert!(error.to_string().contains("lines_hz is -1"), "{error}");
    }

    #[test]
    fn sensors_and_jacks_are_ratiometric_where_their_table_says_so() {
        let papers = twin::papers::sensor_file(1);
        let channels = |text: &str| {
            SensorFile::parse("sensors.toml", text)
                .unwrap()
                .ratiometric()
        };
        assert_eq!(channels(&papers).bits(), 0);
        let gyros = papers.replace("[angular_rate]", "[angular_rate]\nratiometric = true");
        assert_eq!(channels(&gyros).bits(), 0b111 << 6);
        let jacks = papers.replace("[jacks]", "[jacks]\nratiometric = true");
        assert_eq!(channels(&jacks).bits(), 0b11_1111 << 9);
    }

    /// 3.3 V of supply and a zero at its middle leave 1.65 V to either side.
    #[test]
    fn a_full_scale_may_reach_the_rail_and_not_go_beyond() {
        let with_full_scale = |full_scale: f64| {
            let papers = twin::papers::sensor_file(1);
            let mut file = SensorFile::parse("sensors.toml", &papers).unwrap();
            let sheet = &mut file.angular_rate;
            (sheet.volts_per_unit, sheet.zero_volts) = (-0.825, 1.65);
            sheet.full_scale = full_scale;
            sheet.bias_tolerance = 0.0;
            file.check("sensors.toml")
        };
        with_full_scale(2.0).unwrap();
        let error = with_full_scale(2.001).unwrap_err().to_string();
        for words in [
            "angular_rate.full_scale",
            "2.001",
            "3.3 V",
            "volts_per_unit",
        ] {
            assert!(error.contains(words), "{error}");
        }
    }

    #[test]
    fn gravity_is_given_by_value_or_by_place_and_never_guessed() {
        let value = with_gravity("gravity_m_s2 = 9.8155\ngravity_uncertainty_m_s2 = 1e-5").unwrap();
        assert_eq!((value.m_s2, value.uncertainty_m_s2), (9.8155, 1e-5));
        let place = with_gravity("latitude_deg = 90.0\nheight_m = 0.0").unwrap();
        assert!((place.m_s2 - 9.832_184_937_8).abs() < 1e-9);
        assert_eq!(place.uncertainty_m_s2, ANOMALY_M_S2);
        for keys in ["", "latitude_deg = 55.0", "height_m = 3.0"] {
            let message = with_gravity(keys).unwrap_err().to_string();
            assert!(message.contains("not given"), "{message}");
            assert!(
                message.contains("latitude_deg") && message.contains("height_m"),
                "{message}"
            );
        }
        let message = with_gravity("latitude_deg = 91.0\nheight_m = 0.0").unwrap_err();
        assert!(
            message.to_string().contains("latitude_deg is 91"),
            "{message}"
        );
    }

    /// 9.8155 at 55° by hand: 9.780325·(1 + 0.00193185·0.67101)/√(1 − 0.00669438·0.67101) = 9.81507.
    #[test]
    fn a_value_and_a_place_that_contradict_each_other_are_refused_with_both_numbers() {
        let place = "latitude_deg = 55.0\nheight_m = 0.0";
        let both = with_gravity(&format!("gravity_m_s2 = 9.8155\n{place}")).unwrap();
        assert_eq!(both.m_s2, 9.8155);
        let said = both.to_string();
        assert!(said.starts_with("9.81550 ± 0.0005 m/s² (1σ)"), "{said}");
        assert!(
            said.contains("gravity_m_s2") && said.contains("latitude 55°"),
            "{said}"
        );
        for value in ["9.8", "9.8137", "9.8166"] {
            let keys = format!("gravity_m_s2 = {value}\n{place}");
            let said = with_gravity(&keys).unwrap_err().to_string();
            assert!(said.contains(&format!("gravity_m_s2 is {value}")), "{said}");
            assert!(
                said.contains("9.81507") && said.contains("leave one out"),
                "{said}"
            );
        }
    }

    #[test]
    fn gravity_that_is_nowhere_on_the_earth_is_refused_and_a_latitude_in_radians_is_asked_about() {
        for value in ["9.7639", "9.8341", "9.7", "9.9"] {
            let said = with_gravity(&format!("gravity_m_s2 = {value}")).unwrap_err();
            assert!(
                said.to_string().contains("it must be 9.764 to 9.834"),
                "{said}"
            );
        }
        let said = with_gravity("latitude_deg = 0.0\nheight_m = 9000.0").unwrap_err();
        assert!(
            said.to_string()
                .contains("latitude_deg 0 and height_m 9000"),
            "{said}"
        );
        let warning = |latitude: &str| {
            let keys = format!("latitude_deg = {latitude}\nheight_m = 20.0");
            with_gravity(&keys).unwrap().warning()
        };
        let asked = warning("0.973").unwrap();
        assert!(
            asked.contains("in radians?") && asked.contains("55.7488°"),
            "{asked}"
        );
        // Singapore and Kuala Lumpur are right, and are asked too; Jakarta is not.
        assert!(warning("1.35").is_some() && warning("3.139").is_some());
        assert_eq!((warning("-6.2"), warning("55.75")), (None, None));
    }
}
