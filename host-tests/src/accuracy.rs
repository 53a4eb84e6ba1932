//! Accuracy of the board's estimator on noise-free counts, over the whole range of drives.
//!
//! | error | of the board's sums, against |
//! |---|---|
//! | `of_arithmetic` | least squares in `f64` on the very block sums: tables, integers and the solution |
//! | `of_blocks` | least squares in `f64` on single scans, with the block that the host chooses |
//! | `of_counts` | the sine before its rounding to whole counts, an error of every estimator |
//!
//! Each is the largest over sixteen phases: the distance of two first harmonics as complex numbers over the amplitude.
//! A signal without offset fills the converter's range; one that rides on gravity has 3000 counts for 1 m/s².

use std::f64::consts::TAU;
use std::sync::Mutex;
use std::thread;

use hexsense_core::channel::{CHANNELS, INERTIAL};
use hexsense_core::harmonics::{
    Analyser, Drive, HARMONICS, Harmonic, Harmonics, Series, increment, largest_block, solve,
};
use hexsense_core::sampling::{BlockSize, BlockSums};
use serde::Serialize;

/// Phases of each case.
const PHASES: usize = 16;
/// One turn of a drive's phase.
const TURN: f64 = 18_446_744_073_709_551_616.0;

/// A drive to be estimated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Case {
    /// Scan rate, Hz.
    pub rate_hz: u32,
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Summed periods, nearly.
    pub periods: f64,
    /// Offset over amplitude.
    pub offset: f64,
}

/// What was found of a case.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Errors {
    /// The case.
    pub case: Case,
    /// Scans of a block, as a host chooses it.
    pub block: usize,
    /// Summed scans.
    pub scans: usize,
    /// See the module.
    pub of_arithmetic: f64,
    /// See the module.
    pub of_blocks: f64,
    /// See the module.
    pub of_counts: f64,
}

/// Cases of the published table, then a grid of frequencies off the table of sines and of the rates, with and without
/// gravity, from one period to a hundred. Cases of more than `most_scans` are left out.
#[must_use]
pub fn cases(most_scans: f64) -> Vec<Case> {
    let published = include_str!("../tests/data/estimator_f32_errors.csv");
    let published = published.lines().skip(1).map(|line| {
        let cell: Vec<f64> = line.split(',').flat_map(str::parse).collect();
        Case {
            rate_hz: cell[0] as u32,
            frequency_hz: cell[1],
            periods: cell[2],
            offset: cell[4],
        }
    });
    const FREQUENCIES_HZ: [f64; 10] = [
        0.01, 0.010_37, 0.033_1, 0.101_3, 0.500_3, 2.001_9, 7.013, 12.53, 31.07, 49.93,
    ];
    let grid = [1_000, 2_000, 4_000].into_iter().flat_map(|rate_hz| {
        let frequencies = FREQUENCIES_HZ.into_iter();
        frequencies.flat_map(move |frequency_hz| {
            let periods = [1.0, 3.0, 10.0, 100.0].into_iter();
            periods.map(move |periods| Case {
                rate_hz,
                frequency_hz,
                periods,
                offset: 9.806_65,
            })
        })
    });
    let scans = |case: &Case| case.periods * f64::from(case.rate_hz) / case.frequency_hz;
    let mut cases: Vec<Case> = published.chain(grid).collect();
    // Thirteen blocks are needed; five harmonics within twelve scans are not a case.
    cases.retain(|case| (50.0..=most_scans).contains(&scans(case)));
    cases.sort_by(|a, b| scans(b).total_cmp(&scans(a)));
    cases
}

/// Measures all cases, on all cores.
#[must_use]
pub fn measure(cases: &[Case]) -> Vec<Errors> {
    let open = Mutex::new(cases.iter());
    let found = Mutex::new(Vec::new());
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                while let Some(case) = open.lock().ok().and_then(|mut open| open.next()) {
                    let errors = case.errors();
                    if let Ok(mut found) = found.lock() {
                        found.push(errors);
                    }
                }
            });
        }
    });
    found.into_inner().unwrap_or_default()
}

impl Case {
    /// The drive that a host chooses without a disturbance.
    fn drive(&self) -> Drive {
        let rate = f64::from(self.rate_hz);
        let block = largest_block(self.frequency_hz, rate, self.periods, &[], 0.0)
            .unwrap_or(BlockSize::One);
        let scans = self.periods * rate / self.frequency_hz;
        Drive {
            increment: increment(self.frequency_hz, self.rate_hz).unwrap_or(0),
            block,
            settle_blocks: 0,
            blocks: (scans / block.scans() as f64).round() as u32,
        }
    }

    fn amplitude(&self) -> f64 {
        if self.offset == 0.0 {
            32_000.0
        } else {
            3_000.0
        }
    }

    /// Counts of all phases at scan `n`.
    fn counts(&self, drive: &Drive, n: usize) -> [u16; PHASES] {
        let turns = drive.increment.wrapping_mul(n as u64) as f64 / TURN;
        let (sine, cosine) = (TAU * turns).sin_cos();
        PHASE.with(|phases| {
            phases.map(|(of_sine, of_cosine)| {
                let wave = cosine * of_cosine - sine * of_sine;
                (32_768.0 + self.amplitude() * (self.offset + wave)).round() as u16
            })
        })
    }

    /// The largest errors of all phases.
    #[must_use]
    pub fn errors(&self) -> Errors {
        let drive = self.drive();
        let block = drive.block.scans();
        let scans = drive.blocks as usize * block;
        let omega = TAU * (drive.increment as f64 / TURN);
        let board = self.board(&drive);
        let single = (0..scans).map(|n| self.counts(&drive, n).map(f64::from));
        let single: [Harmonics; PHASES] = fitted(omega, single);
        let means = (0..drive.blocks as usize).map(|number| {
            let counts = (number * block..(number + 1) * block).map(|n| self.counts(&drive, n));
            let sums = counts.fold([0.0; PHASES], |sums: [f64; PHASES], counts| {
                std::array::from_fn(|phase| sums[phase] + f64::from(counts[phase]))
            });
            sums.map(|sum| sum / block as f64)
        });
        let means = fitted(omega * block as f64, means).map(|fit| unsummed(&fit, omega, block));
        let truth = PHASE.with(|phases| {
            phases.map(|(sine, cosine)| Harmonic {
                cosine: self.amplitude() * cosine,
                sine: -self.amplitude() * sine,
            })
        });
        let largest = |of: &dyn Fn(usize) -> Harmonic| {
            let errors = (0..PHASES).map(|phase| {
                let (board, other) = (board[phase], of(phase));
                (board.cosine - other.cosine).hypot(board.sine - other.sine)
            });
            errors.fold(0.0, f64::max) / self.amplitude()
        };
        Errors {
            case: *self,
            block,
            scans,
            of_arithmetic: largest(&|phase| means[phase]),
            of_blocks: largest(&|phase| single[phase].first()),
            of_counts: largest(&|phase| truth[phase]),
        }
    }

    /// First harmonics by the board's sums.
    fn board(&self, drive: &Drive) -> [Harmonic; PHASES] {
        // One phase more than an analyser has channels.
        let mut analysers = [Analyser::new(), Analyser::new()];
        analysers
            .iter_mut()
            .for_each(|analyser| analyser.start(*drive));
        let block = drive.block.scans();
        for number in 0..drive.blocks as usize {
            let mut sums = [0; PHASES];
            for n in number * block..(number + 1) * block {
                for (sum, count) in sums.iter_mut().zip(self.counts(drive, n)) {
                    *sum += u32::from(count);
                }
            }
            let first_scan = (number * block) as u64;
            let mut last = [0; INERTIAL];
            last[0] = sums[CHANNELS];
            for (analyser, inertial) in analysers.iter_mut().zip([sums.first_chunk(), Some(&last)])
            {
                analyser.take(&BlockSums {
                    first_scan,
                    inertial: inertial.copied().unwrap_or_default(),
                    jacks: std::array::from_fn(|jack| sums[INERTIAL + jack]),
                });
            }
        }
        std::array::from_fn(|phase| {
            let report = analysers[phase / CHANNELS].report(phase % CHANNELS);
            let solved = report.and_then(|(drive, _, sums)| solve(&drive, &sums));
            solved.map_or(Harmonic::default(), |solved| solved.first())
        })
    }
}

fn fitted(
    omega: f64,
    samples: impl ExactSizeIterator<Item = [f64; PHASES]>,
) -> [Harmonics; PHASES] {
    Series::fit_all(omega, samples).unwrap_or([const { Harmonics::NONE }; PHASES])
}

/// First harmonic of a signal from that of the means of its blocks.
fn unsummed(means: &Harmonics, omega: f64, block: usize) -> Harmonic {
    let scans = block as f64;
    let gain = (omega * scans / 2.0).sin() / (omega / 2.0).sin() / scans;
    // The first mean is half a block after the first scan.
    let late = omega * (scans - 1.0) / 2.0;
    let (first, (sine, cosine)) = (means.first(), late.sin_cos());
    Harmonic {
        cosine: (first.cosine * cosine - first.sine * sine) / gain,
        sine: (first.cosine * sine + first.sine * cosine) / gain,
    }
}

thread_local! {
    /// Sine and cosine of the phases.
    static PHASE: [(f64, f64); PHASES] =
        std::array::from_fn(|phase| (TAU * phase as f64 / PHASES as f64 + 0.01).sin_cos());
}

const _: () = assert!(HARMONICS == 5 && CHANNELS + 1 == PHASES);
