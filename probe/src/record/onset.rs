//! The onset of a run: when the base begins to move, seen in the jacks while the run is recorded.
//!
//! The motion controller starts some seconds after the start command. With [windows](super::jacks) of the jacks,
//!
//! ```text
//! detected:  |Δ_k − rest_k| > max(2 mm, 8σ of a window at rest)     k: the jack that moved most
//! onset    = middle of that window − (time at which the program is that far from home)
//! ```
//!
//! This is good to about a tenth of a second: enough to know when the run ends and when to sum. The analysis finds the
//! onset for itself.

use hexsense_core::channel::JACKS;
use hexsense_core::kinematics::displacements;
use hexsense_core::wire::telemetry::Block;

use super::jacks::{Displacements, JackMeans, STEP_MS, WINDOW};
use super::rest::AtRest;
use crate::geometry_file::GeometryFile;
use crate::plan::Run;

/// Least movement that is taken for the start, m.
const LEAST_M: f64 = 0.002;
const SIGMAS: f64 = 8.0;
/// Step at which the program is looked up, s.
const STEP_S: f64 = 0.01;

/// Watches the jacks for the start of one run.
#[derive(Debug)]
pub struct OnsetWatch {
    /// Displacements of the program from home, every [`STEP_S`].
    program: Vec<Displacements>,
    rest: AtRest,
}

impl OnsetWatch {
    /// A watch for `run` on a base whose rest is known.
    #[must_use]
    pub fn new(run: &Run, geometry: &GeometryFile, rest: AtRest) -> Self {
        let (program, base) = (run.program(), &geometry.geometry);
        let home = displacements(base, &base.home());
        let from_home = |now: [f64; JACKS]| std::array::from_fn(|jack| now[jack] - home[jack]);
        Self {
            program: program.jack_rows(base, STEP_S).map(from_home).collect(),
            rest,
        }
    }

    /// Takes a block; returns the scan of the onset as soon as the base moves.
    pub fn watch(&mut self, block: &Block, jacks: &mut JackMeans) -> Option<u64> {
        let mean = jacks.push(block)?;
        let moved = |jack: usize| (mean[jack] - self.rest.mean_m[jack]).abs();
        let jack = (0..JACKS).max_by(|a, b| moved(*a).total_cmp(&moved(*b)))?;
        if moved(jack) <= LEAST_M.max(SIGMAS * self.rest.deviation_m[jack]) {
            return None;
        }
        let reached = self
            .program
            .iter()
            .position(|now| now[jack].abs() >= moved(jack))?;
        let rate = f64::from(block.header.rate_hz);
        let end = block.header.first_scan + u64::from(block.header.scans);
        let half_window_s = 1e-3 * f64::from(STEP_MS) * WINDOW as f64 / 2.0;
        let before_s = reached as f64 * STEP_S + half_window_s;
        Some(end.saturating_sub((before_s * rate).round() as u64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry_file::GeometryFile;
    use crate::plan::campaign;
    use crate::record::rest::{RestWatch, Unrest};
    use crate::sensor_file::SensorFile;
    use hexsense_core::channel::{CHANNELS, INERTIAL};
    use hexsense_core::wire::StreamContent;
    use hexsense_core::wire::telemetry::Header;

    /// Frame `index`, of `scans` scans at `rate_hz`, of a base whose jacks follow `program` from scan `onset` on.
    fn block(
        index: u64,
        (rate_hz, scans): (u32, u8),
        onset: u64,
        run: &Run,
        geometry: &GeometryFile,
        sensors: &SensorFile,
    ) -> Block {
        let base = &geometry.geometry;
        let stroke_m = base.length_max_m() - base.length_min_m();
        let volts_per_m = sensors.jacks.full_stroke_volts / stroke_m;
        let scan = |row: u8| {
            let scan = index * u64::from(scans) + u64::from(row);
            let time_s = scan.saturating_sub(onset) as f64 / f64::from(rate_hz);
            let jacks = displacements(base, &run.program().pose(base, time_s));
            let mut scan = [0; CHANNELS];
            for (count, jack) in scan[INERTIAL..].iter_mut().zip(jacks) {
                let volts = sensors.jacks.zero_volts + jack * volts_per_m;
                *count = (volts * sensors.counts_per_volt()) as u16;
            }
            scan
        };
        let header = Header {
            first_scan: index * u64::from(scans),
            scans,
            rate_hz,
            supply: 1.0,
            temperature_c: 30.0,
            set: None,
            dropped: 0,
            content: StreamContent {
                counts: true,
                values: false,
                pose: false,
            },
            supply_is_old: false,
        };
        Block {
            header,
            counts: Some((0..scans).map(scan).collect()),
            values: None,
        }
    }

    #[test]
    fn the_onset_of_every_run_is_found_to_a_tenth_of_a_second() {
        let geometry = GeometryFile::load("an-74tk-200").unwrap();
        let sensors = SensorFile::parse("sensors.toml", &twin::papers::sensor_file(1)).unwrap();
        let plan = campaign::plan(&geometry).unwrap();
        let moving = plan.runs.iter().filter(|run| run.rest_s.is_none());
        let frames = [(1_000, 16), (1_000, 1), (2_000, 4), (4_000, 16)];
        for (run, frame) in moving.zip(frames.into_iter().cycle()) {
            let onset = 3 * u64::from(frame.0) + 456;
            let blocks = |index| block(index, frame, onset, run, &geometry, &sensors);
            let mut jacks = JackMeans::new(&geometry, &sensors);
            let mut rest = RestWatch::new(&geometry);
            let mut indices = 0_u64..;
            let rest = indices.find_map(|index| rest.learn(&blocks(index), &mut jacks).unwrap());
            let mut watch = OnsetWatch::new(run, &geometry, rest.unwrap());
            let found = indices
                .find_map(|index| watch.watch(&blocks(index), &mut jacks))
                .unwrap();
            let off_s = found.abs_diff(onset) as f64 / f64::from(frame.0);
            assert!(off_s < 0.1, "{}, {frame:?}: {off_s} s", run.name);
        }
    }

    #[test]
    fn a_base_that_still_moves_is_not_at_rest() {
        let geometry = GeometryFile::load("an-74tk-200").unwrap();
        let sensors = SensorFile::parse("sensors.toml", &twin::papers::sensor_file(1)).unwrap();
        let plan = campaign::plan(&geometry).unwrap();
        let heave = plan.run("heave").unwrap();
        let mut jacks = JackMeans::new(&geometry, &sensors);
        let mut rest = RestWatch::new(&geometry);
        let unrest = (0..64).find_map(|index| {
            rest.learn(
                &block(index, (1_000, 16), 0, heave, &geometry, &sensors),
                &mut jacks,
            )
            .err()
        });
        assert!(matches!(unrest, Some(Unrest::Moving { moved_m, .. }) if moved_m > 0.01));
    }
}
