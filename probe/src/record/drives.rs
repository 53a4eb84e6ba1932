//! What the board is asked to estimate in a run: up to three drive frequencies, and one block for all of them.
//!
//! The board adds the scans of a block up before it multiplies by sine and cosine; a large block costs it less work. Two
//! things limit the block (see [`hexsense_core::harmonics::choice`]): the fifth harmonic may turn by a tenth of a turn in it,
//! and no known disturbance may lie where block sums would mistake it for a harmonic, at m·rate/B ± k·f. Whether the link
//! carries the stream does not depend on the block. All of this is known before anything moves.
//!
//! Known disturbances are those of the sensor file ([`SensorFile::disturbances_hz`]) and the run's own frequencies.

use hexsense_core::excitation::{Multisine, Signal};
use hexsense_core::facts::BoardFacts;
use hexsense_core::harmonics::choice::mistaken;
use hexsense_core::harmonics::{ANALYSERS, DriveError, increment, largest_block};
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::{Drive, Refusal, StreamContent, telemetry};

use crate::plan::Run;
use crate::sensor_file::SensorFile;

/// A frequency that a run drives, and when it does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveLine {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Start of the estimate, s from the start of the program.
    pub start_s: f64,
    /// Length of the estimate, s.
    pub length_s: f64,
}

/// What the board is asked for in one run.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveChoice {
    /// Scans that the board takes at a time.
    pub block: BlockSize,
    /// One for each analyser, at most [`ANALYSERS`].
    pub lines: Vec<DriveLine>,
}

/// Why the board cannot estimate what a run drives. Nothing has moved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoChoice {
    /// The link does not carry this stream.
    #[error("run {run} at {rate_hz} Hz: {refusal}")]
    Link {
        /// The run.
        run: String,
        /// Scan rate, Hz.
        rate_hz: u32,
        /// What the board would say.
        refusal: Refusal,
    },
    /// The board refuses it in every block.
    #[error("run {run} drives at {frequency_hz} Hz, scanned at {rate_hz} Hz: {reason}")]
    Drive {
        /// The run.
        run: String,
        /// Drive frequency, Hz.
        frequency_hz: f64,
        /// Scan rate, Hz.
        rate_hz: u32,
        /// Why.
        reason: DriveError,
    },
}

impl DriveChoice {
    /// Chooses for `run`, scanned at `rate_hz` and streamed with `content`.
    ///
    /// # Errors
    /// [`NoChoice`].
    pub fn new(
        run: &Run,
        sensors: &SensorFile,
        rate_hz: u32,
        content: StreamContent,
    ) -> Result<Self, NoChoice> {
        let mut lines = lines(run);
        let own = lines.iter().map(|line| line.frequency_hz);
        let asked = Asked {
            run,
            rate_hz,
            disturbances_hz: own.chain(sensors.disturbances_hz(rate_hz)).collect(),
        };
        lines.truncate(ANALYSERS);
        let block = match lines.is_empty() {
            true => BlockSize::default(),
            false => asked.block(&lines)?,
        };
        carried(&sensors.board, content, rate_hz, block).map_err(|refusal| NoChoice::Link {
            run: run.name.clone(),
            rate_hz,
            refusal,
        })?;
        for line in &lines {
            let drive = line.drive(rate_hz, block, 0);
            drive
                .ok_or(DriveError::Frequency)
                .and_then(|drive| drive.check())
                .map_err(|reason| asked.drive_error(line, reason))?;
        }
        Ok(Self { block, lines })
    }
}

impl DriveLine {
    /// The drive for this line, after so many blocks; `None` when the board cannot make this frequency at this rate.
    #[must_use]
    pub fn drive(&self, rate_hz: u32, block: BlockSize, settle_blocks: u32) -> Option<Drive> {
        let scans = self.length_s * f64::from(rate_hz);
        Some(Drive {
            increment: increment(self.frequency_hz, rate_hz)?,
            block,
            settle_blocks,
            blocks: (scans / block.scans() as f64).round() as u32,
        })
    }

    /// How far a disturbance must stay away from what is mistaken for a harmonic, Hz.
    fn distance_hz(&self) -> f64 {
        2.0 / self.length_s
    }
}

/// A run with everything that its block depends on.
struct Asked<'a> {
    run: &'a Run,
    rate_hz: u32,
    disturbances_hz: Vec<f64>,
}

impl Asked<'_> {
    /// The largest block that every line allows; single scans when disturbances forbid every block.
    fn block(&self, lines: &[DriveLine]) -> Result<BlockSize, NoChoice> {
        let mut largest = BlockSize::ThirtyTwo;
        for line in lines {
            let allowed = largest_block(
                line.frequency_hz,
                self.rate_hz.into(),
                line.length_s * line.frequency_hz,
                &self.disturbances_hz,
                line.distance_hz(),
            );
            let allowed = allowed.ok_or_else(|| self.drive_error(line, DriveError::Frequency))?;
            largest = largest.min(allowed);
        }
        let sizes = BlockSize::ALL
            .into_iter()
            .rev()
            .filter(|size| *size <= largest);
        let clean = |size: &BlockSize| lines.iter().all(|line| !self.is_disturbed(line, *size));
        Ok(sizes.into_iter().find(clean).unwrap_or(BlockSize::One))
    }

    fn is_disturbed(&self, line: &DriveLine, block: BlockSize) -> bool {
        let lines_hz = &self.disturbances_hz;
        let rate = f64::from(self.rate_hz);
        mistaken(line.frequency_hz, rate, block, lines_hz, line.distance_hz()).is_some()
    }

    fn drive_error(&self, line: &DriveLine, reason: DriveError) -> NoChoice {
        NoChoice::Drive {
            run: self.run.name.clone(),
            frequency_hz: line.frequency_hz,
            rate_hz: self.rate_hz,
            reason,
        }
    }
}

/// What the board would say to this stream.
fn carried(
    board: &BoardFacts,
    content: StreamContent,
    rate_hz: u32,
    block: BlockSize,
) -> Result<(), Refusal> {
    // Only these rates: the product with another could overflow.
    if !board.rates_hz.contains(&rate_hz) {
        return Err(Refusal::Rate { hz: rate_hz });
    }
    let limit = board.max_telemetry_bits_per_s();
    let bits_per_s = telemetry::bits_per_second(content, rate_hz, block, limit);
    if bits_per_s > limit {
        return Err(Refusal::LinkCapacity { bits_per_s, limit });
    }
    Ok(())
}

/// The frequencies of a run: the largest of each degree of freedom first, then the next of each, and so on.
fn lines(run: &Run) -> Vec<DriveLine> {
    let program = run.program();
    let by_freedom: Vec<Vec<DriveLine>> = program
        .signals
        .iter()
        .map(|(_, signal)| lines_of(signal))
        .collect();
    let most = by_freedom.iter().map(Vec::len).max().unwrap_or(0);
    let mut lines: Vec<DriveLine> = Vec::new();
    for place in 0..most {
        let next = by_freedom.iter().filter_map(|lines| lines.get(place));
        for line in next {
            if !lines.contains(line) {
                lines.push(*line);
            }
        }
    }
    lines
}

/// The frequencies of one degree of freedom, largest amplitude first.
fn lines_of(signal: &Signal) -> Vec<DriveLine> {
    match signal {
        Signal::Ramps(_) => Vec::new(),
        Signal::Sine(sine) => vec![DriveLine {
            frequency_hz: sine.frequency_hz,
            start_s: sine.estimate_start_s(),
            length_s: sine.estimate_s,
        }],
        Signal::Multisine(multisine) => lines_of_multisine(multisine),
    }
}

fn lines_of_multisine(multisine: &Multisine) -> Vec<DriveLine> {
    let timing = multisine.timing();
    let mut tones: Vec<_> = multisine.lines().to_vec();
    tones.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    let tones = tones.into_iter().map(|tone| DriveLine {
        frequency_hz: f64::from(tone.harmonic) * timing.fundamental_hz,
        start_s: timing.estimate_start_s(),
        length_s: timing.estimate_s(),
    });
    tones.collect()
}

#[cfg(test)]
mod tests;
