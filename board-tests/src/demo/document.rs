//! What the demo prints: one JSON document, or tables for people.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Duration;

use hexsense_probe::analysis::held_out::{ChannelVerdict, MEAN_COVERAGE};
use hexsense_probe::analysis::results::Measured;
use serde::Serialize;

use super::arguments::Arguments;
use super::judgement::{Judged, Replay, Samples, truths};
use super::story::Told;

/// The whole result.
#[derive(Serialize)]
pub struct Document {
    seed: u64,
    geometry: String,
    channels: Vec<Channel>,
    held_out: Vec<ChannelVerdict>,
    power_cycle: PowerCycle,
    samples: Samples,
    replay_equal: bool,
    replay: Replay,
    wall_seconds: f64,
}

#[derive(Serialize)]
struct Channel {
    name: String,
    unit: String,
    offset: Compared,
    gain: Compared,
    sensitivity: f64,
    cross: [Measured; 3],
}

/// An estimate beside its truth.
#[derive(Serialize)]
struct Compared {
    truth: f64,
    estimate: f64,
    expanded_uncertainty: f64,
}

#[derive(Serialize)]
struct PowerCycle {
    uploaded_id: String,
    read_back_id: String,
    identical: bool,
}

impl Compared {
    fn new(truth: f64, measured: Measured) -> Self {
        let Measured {
            estimate,
            expanded_uncertainty,
            ..
        } = measured;
        Self {
            truth,
            estimate,
            expanded_uncertainty,
        }
    }

    /// Error in units of the expanded uncertainty.
    fn error_over_uncertainty(&self) -> f64 {
        (self.estimate - self.truth) / self.expanded_uncertainty
    }
}

impl Document {
    /// Puts everything together.
    pub fn new(
        arguments: &Arguments,
        told: &Told,
        judged: Judged,
        wall: Duration,
    ) -> anyhow::Result<Self> {
        let channels = judged.results.channels.into_iter().zip(truths(told)?);
        let channels = channels.map(|(channel, (offset, gain))| Channel {
            name: channel.name,
            unit: channel.unit,
            offset: Compared::new(offset, channel.offset),
            gain: Compared::new(gain, channel.gain),
            sensitivity: channel.sensitivity,
            cross: channel.cross,
        });
        let identical = told.uploaded_id == told.read_back_id;
        Ok(Self {
            seed: arguments.seed,
            geometry: arguments.geometry.clone(),
            channels: channels.collect(),
            held_out: judged.held_out,
            power_cycle: PowerCycle {
                uploaded_id: told.uploaded_id.clone(),
                read_back_id: told.read_back_id.clone(),
                identical,
            },
            samples: judged.samples,
            replay_equal: judged.replay.holds(),
            replay: judged.replay,
            wall_seconds: wall.as_secs_f64(),
        })
    }

    /// Writes the document beside the captures.
    pub fn save(&self, folder: &Path) -> anyhow::Result<()> {
        Ok(std::fs::write(
            folder.join("demo.json"),
            serde_json::to_string_pretty(self)?,
        )?)
    }

    /// Whether the set came back, nothing was lost, the captures give what the board computed, and every channel passed
    /// on the held-out movement.
    pub fn holds(&self) -> bool {
        self.power_cycle.identical
            && self.replay_equal
            && self.samples.lost == 0
            && self.held_out.iter().all(ChannelVerdict::passes)
    }

    /// The document as tables.
    pub fn table(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write_table(&mut text);
        text
    }

    fn write_table(&self, text: &mut String) -> std::fmt::Result {
        writeln!(
            text,
            "\nGeometry {}, seed {}. Value = M·(u − u0); U is the expanded uncertainty, k = 2.\n",
            self.geometry, self.seed
        )?;
        writeln!(
            text,
            "      {:>9} {:>9} {:>6}   {:>13} {:>13} {:>7}  {:>8} {:>9}  {:>11}",
            "u0",
            "truth",
            "U",
            "gain k = M_ii",
            "truth",
            "U, %",
            "error, %",
            "error / U",
            "S = 1/k"
        )?;
        for channel in &self.channels {
            let (offset, gain) = (&channel.offset, &channel.gain);
            writeln!(
                text,
                "{:<4}  {:>9.1} {:>9.1} {:>6.1}   {:>13.6e} {:>13.6e} {:>7.3}  {:>+8.3} {:>+9.2}  {:>11.4}  counts per {}",
                channel.name,
                offset.estimate,
                offset.truth,
                offset.expanded_uncertainty,
                gain.estimate,
                gain.truth,
                100.0 * gain.expanded_uncertainty / gain.estimate.abs(),
                100.0 * (gain.estimate / gain.truth - 1.0),
                gain.error_over_uncertainty(),
                channel.sensitivity,
                channel.unit
            )?;
        }
        self.write_held_out(text)?;
        let PowerCycle {
            uploaded_id,
            read_back_id,
            identical,
        } = &self.power_cycle;
        let same = if *identical {
            "the same"
        } else {
            "NOT THE SAME"
        };
        writeln!(
            text,
            "\nPower cycle: set {uploaded_id} was uploaded, set {read_back_id} came back: {same}."
        )?;
        let Replay { sums, values, .. } = self.replay;
        let equal = |equal| if equal { "equal" } else { "NOT EQUAL" };
        writeln!(
            text,
            "Replay of the captures: {sums} harmonic sums of the board {}, {values} values {}, to the last bit.",
            equal(self.replay.sums_equal),
            equal(self.replay.values_equal)
        )?;
        writeln!(
            text,
            "Scans: {} taken, {} lost. {:.0} s.",
            self.samples.taken, self.samples.lost, self.wall_seconds
        )
    }

    fn write_held_out(&self, text: &mut String) -> std::fmt::Result {
        writeln!(
            text,
            "\nHeld-out movement, six degrees of freedom at once, values against truth behind a 2 Hz low-pass:\n"
        )?;
        writeln!(
            text,
            "      {:>11} {:>13} {:>13} {:>8}   {:>11} {:>11}",
            "rms signal", "error before", "error after", "after, %", "mean error", "its limit"
        )?;
        for channel in &self.held_out {
            writeln!(
                text,
                "{:<4}  {:>11.4} {:>13.5} {:>13.5} {:>8.2}   {:>+11.5} {:>11.5}  {:<7} {}",
                channel.name,
                channel.rms_signal,
                channel.rms_error_before,
                channel.rms_error_after,
                100.0 * channel.rms_error_after / channel.rms_signal,
                channel.mean_error,
                channel.mean_uncertainty,
                channel.unit,
                if channel.passes() { "" } else { "FAILS" }
            )?;
        }
        writeln!(
            text,
            "\n(limit of the mean: expanded uncertainty with k = {MEAN_COVERAGE}, nine channels being judged at once)"
        )
    }
}
