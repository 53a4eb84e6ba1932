//! What the board would record of a plan if base, sensors and converter were exactly as their files say.
//!
//! Poses come from the program, jack lengths from inverse kinematics, what the sensors feel from differences of
//! neighbouring poses, and all of it becomes counts. There is no noise: noise enters a forecast as a density.

use hexsense_core::calibration::truth::Site;
use hexsense_core::channel::{CHANNELS, INERTIAL, NAMES, Scan, Triad};
use hexsense_core::excitation::Program;
use hexsense_core::kinematics::{Pose, displacements};
use nalgebra::Vector3;

use crate::analysis::RecordedRun;
use crate::capture::Capture;
use crate::geometry_file::GeometryFile;
use crate::sensor_file::SensorFile;

/// Rate of ideal scans, Hz: without noise nothing is gained by the board's own rate, which is higher.
pub const RATE_HZ: u32 = 200;
/// Rest before and after a movement, s.
const REST_S: f64 = 2.0;

/// A bench without tolerances.
#[derive(Debug, Clone, Copy)]
pub struct Ideal<'a> {
    /// The base.
    pub base: &'a GeometryFile,
    /// The sensors.
    pub sensors: &'a SensorFile,
}

/// A signal that leaves the range of the converter, by the files.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "run {run}: by the sensor file {} has {volts:.2} V at {time_s:.2} s, outside the 0 to {supply_v} V of the \
     converter; check {} and zero_volts of that table, or make the movement smaller",
    NAMES[*channel], key_of(*channel)
)]
pub struct Clipped {
    /// The run.
    pub run: String,
    /// The channel, from 0.
    pub channel: usize,
    /// Time from the start of the program, s.
    pub time_s: f64,
    /// What its pin would have, V.
    pub volts: f64,
    /// The end of the range, V.
    pub supply_v: f64,
}

/// The key of the sensor file by which a channel becomes volts.
fn key_of(channel: usize) -> &'static str {
    match channel / 3 {
        0 => "linear_acceleration.volts_per_unit",
        1 => "angular_acceleration.volts_per_unit",
        2 => "angular_rate.volts_per_unit",
        _ => "jacks.full_stroke_volts",
    }
}

impl Ideal<'_> {
    /// Records `program`, or a rest of `rest_s`, from scan `first` of the board on. The jacks follow the program; the
    /// sensors feel `felt`, which is the program itself unless jacks and base disagree.
    ///
    /// # Errors
    /// [`Clipped`], for the first signal that the converter cannot measure.
    pub fn record(
        &self,
        name: &str,
        program: Program,
        felt: &Program,
        rest_s: Option<f64>,
        first: u64,
    ) -> Result<RecordedRun, Clipped> {
        let period_s = 1.0 / f64::from(RATE_HZ);
        let lead_s = if rest_s.is_some() { 0.0 } else { REST_S };
        let length_s = rest_s.unwrap_or_else(|| program.duration_s() + 2.0 * REST_S);
        let scans = (length_s / period_s).round() as usize;
        let geometry = &self.base.geometry;
        let at = |step: usize| felt.pose(geometry, (step as f64 - 1.0) * period_s - lead_s);
        let poses: Vec<Pose<f64>> = (0..scans + 2).map(at).collect();
        let rows = poses.windows(3).zip(0..).map(|(around, scan)| {
            let time_s = f64::from(scan) * period_s - lead_s;
            let counts = self.scan(&program.pose(geometry, time_s), around, period_s);
            self.in_range(name, time_s, counts)
        });
        let counts = rows.collect::<Result<_, _>>()?;
        Ok(RecordedRun {
            name: name.to_owned(),
            capture: Capture {
                scans: (first..).take(scans).collect(),
                counts,
                supply: vec![1.0; scans],
                temperature_c: vec![25.0; scans],
                values: None,
            },
            program,
            rate_hz: RATE_HZ,
            ratiometric: self.sensors.ratiometric(),
        })
    }

    /// The counts of a scan, as the converter gives them.
    fn in_range(&self, run: &str, time_s: f64, counts: [f64; CHANNELS]) -> Result<Scan, Clipped> {
        let most = f64::from(self.sensors.board.counts_at_supply);
        match counts
            .iter()
            .position(|count| !(0.0..=most).contains(count))
        {
            None => Ok(counts.map(|count| count.round() as _)),
            Some(channel) => Err(Clipped {
                run: run.to_owned(),
                channel,
                time_s,
                volts: counts[channel] / self.sensors.counts_per_volt(),
                supply_v: self.sensors.supply_v,
            }),
        }
    }

    /// Counts of all channels: jacks at `pose`, sensors at the middle one of the three poses `around`.
    fn scan(&self, pose: &Pose<f64>, around: &[Pose<f64>], period_s: f64) -> [f64; CHANNELS] {
        let felt = felt(around, period_s, &self.sensors.site());
        let geometry = &self.base.geometry;
        let transducers = self.sensors.transducers(geometry);
        let jacks = displacements(geometry, pose);
        core::array::from_fn(|channel| {
            if channel < INERTIAL {
                let (triad, axis) = (Triad::ALL[channel / 3], channel % 3);
                let sheet = self.sensors.triad(triad);
                let (per_unit, zero) = sheet.nominal_counts(self.sensors.counts_per_volt());
                zero + per_unit * felt[triad.index()][axis]
            } else {
                let jack = channel - INERTIAL;
                transducers.counts(jack, jacks[jack])
            }
        })
    }
}

/// Specific force, angular acceleration and rate at the middle one of three poses, `period_s` apart, in body axes.
fn felt(around: &[Pose<f64>], period_s: f64, site: &Site) -> [Vector3<f64>; 3] {
    let [before, now, after] = [0, 1, 2].map(|index| &around[index]);
    let rate = |from: &Pose<f64>, to: &Pose<f64>| {
        (from.rotation.inverse() * to.rotation).scaled_axis() / period_s
    };
    let (arriving, leaving) = (rate(before, now), rate(now, after));
    let (turning, speeding) = ((arriving + leaving) / 2.0, (leaving - arriving) / period_s);
    let linear = (after.position - now.position * 2.0 + before.position) / (period_s * period_s);
    let arm = site.lever_arm_m;
    let force = now
        .rotation
        .inverse_transform_vector(&(linear + Vector3::y() * site.gravity_m_s2))
        + speeding.cross(&arm)
        + turning.cross(&turning.cross(&arm));
    [force, speeding, turning]
}
