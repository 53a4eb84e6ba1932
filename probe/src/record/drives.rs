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
mod tests {
    use super::*;
    use crate::known_board;
    use crate::plan::{Freedom, Purpose, SineEntry};
    use hexsense_core::harmonics::choice::MAX_TURN;

    const COUNTS: StreamContent = StreamContent {
        counts: true,
        values: false,
        pose: false,
    };
    const ALL: StreamContent = StreamContent {
        counts: true,
        values: true,
        pose: true,
    };

    fn run(frequency_hz: f64) -> Run {
        let entry = SineEntry {
            freedom: Freedom::Heave,
            amplitude_deg: None,
            amplitude_m: Some(0.01),
            frequency_hz,
            fade_s: 2.0,
            settle_s: 2.0,
            estimate_s: (3.0 / frequency_hz).max(3.0),
        };
        Run {
            name: "heave".to_owned(),
            purpose: Purpose::Calibrate,
            rest_s: None,
            ramps: Vec::new(),
            sine: vec![entry],
            multisine: None,
        }
    }

    fn sensors(lines: &str) -> SensorFile {
        let papers = twin::papers::sensor_file(1);
        let kept = papers.lines().filter(|line| !line.starts_with("lines_hz"));
        let text: String = kept.flat_map(|line| [line, "\n"]).collect();
        SensorFile::parse("sensors.toml", &format!("{lines}\n{text}")).unwrap()
    }

    fn chosen(frequency_hz: f64, rate_hz: u32, lines: &str) -> Result<BlockSize, NoChoice> {
        DriveChoice::new(&run(frequency_hz), &sensors(lines), rate_hz, COUNTS)
            .map(|choice| choice.block)
    }

    #[test]
    fn every_drive_from_a_hundredth_to_fifty_hertz_is_taken_at_every_rate_in_the_block_that_it_allows()
     {
        for frequency_hz in [
            0.01, 0.03, 0.1, 0.5, 1.0, 2.5, 5.0, 7.7, 10.0, 20.0, 33.0, 50.0,
        ] {
            for rate_hz in known_board::FACTS.rates_hz {
                let block =
                    |lines| DriveChoice::new(&run(frequency_hz), &sensors(lines), rate_hz, COUNTS);
                let choice = block("lines_hz = []").unwrap();
                let turn = |scans| 5.0 * frequency_hz * scans as f64 / f64::from(rate_hz);
                let scans = choice.block.scans();
                assert!(turn(scans) <= MAX_TURN || scans == 1);
                // The run's own frequency may forbid the largest.
                let allowed = [1, 4, 8, 16, 32]
                    .into_iter()
                    .rfind(|scans| turn(*scans) <= MAX_TURN);
                assert!(scans <= allowed.unwrap_or(1));
                let drive = choice.lines[0].drive(rate_hz, choice.block, 7).unwrap();
                drive.check().unwrap();
                block("").unwrap();
            }
        }
        assert_eq!(chosen(50.0, 1_000, "lines_hz = []"), Ok(BlockSize::One));
        assert_eq!(chosen(9.9, 4_000, "lines_hz = []"), Ok(BlockSize::Four));
    }

    #[test]
    fn the_block_keeps_known_disturbances_off_the_harmonics() {
        // 16 scans at 1 kHz come at 62.5 Hz: 59.5 Hz is the third harmonic of 1 Hz below it; 8 scans come at 125 Hz.
        assert_eq!(
            chosen(0.5, 1_000, "lines_hz = []").unwrap(),
            BlockSize::ThirtyTwo
        );
        assert_eq!(
            chosen(1.0, 1_000, "lines_hz = []").unwrap(),
            BlockSize::Sixteen
        );
        assert_eq!(
            chosen(1.0, 1_000, "lines_hz = [59.5]").unwrap(),
            BlockSize::Eight
        );
        // Multiples of a disturbance count.
        assert_eq!(
            chosen(1.0, 1_000, "lines_hz = [29.75]").unwrap(),
            BlockSize::Eight
        );
        // Mains of 50 Hz is what is expected where nothing is said.
        assert_eq!(
            chosen(1.0, 1_000, "").unwrap(),
            chosen(1.0, 1_000, "lines_hz = [50.0]").unwrap()
        );
    }

    #[test]
    fn a_disturbance_forbids_a_block_and_no_stream() {
        // At 4 kHz blocks of 32 and 16 come at multiples of 125 Hz, blocks of 8 at 500 Hz.
        assert_eq!(
            chosen(1.0, 4_000, "lines_hz = [124.0]").unwrap(),
            BlockSize::Four
        );
        let error = DriveChoice::new(&run(1.0), &sensors(""), 4_000, ALL).unwrap_err();
        assert!(
            matches!(
                error,
                NoChoice::Link {
                    refusal: Refusal::LinkCapacity { .. },
                    ..
                }
            ),
            "{error}"
        );
    }

    #[test]
    fn a_multisine_takes_the_largest_line_of_each_freedom() {
        let text = std::fs::read_to_string(
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/multisine-run.toml"),
        )
        .unwrap();
        let head = "geometry = \"\"\ngeometry_sha256 = \"\"\nperiod_s = 0.002\n";
        let plan = crate::plan::Plan::parse("plan.toml", &(head.to_owned() + &text)).unwrap();
        let choice = DriveChoice::new(&plan.runs[0], &sensors(""), 1_000, ALL).unwrap();
        let hertz: Vec<f64> = choice.lines.iter().map(|line| line.frequency_hz).collect();
        for (found, expected) in hertz.iter().zip([0.3, 0.4, 0.5]) {
            assert!((found - expected).abs() < 1e-12, "{hertz:?}");
        }
        assert_eq!(hertz.len(), ANALYSERS);
        assert!(
            choice
                .lines
                .iter()
                .all(|line| line.start_s == 15.0 && line.length_s == 20.0)
        );
    }

    #[test]
    fn a_rest_is_taken_in_blocks_of_sixteen() {
        let rest = Run {
            rest_s: Some(10.0),
            sine: Vec::new(),
            ..run(1.0)
        };
        let choice = DriveChoice::new(&rest, &sensors(""), 4_000, COUNTS).unwrap();
        assert_eq!((choice.block, choice.lines.len()), (BlockSize::Sixteen, 0));
    }
}
