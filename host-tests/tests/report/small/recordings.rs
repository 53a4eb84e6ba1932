//! The recordings of the small campaign, made by formulas: every jack follows its program but for an error of its own,
//! which is constant, and the driven sensors swing by known amplitudes.

use std::f64::consts::TAU;

use hexsense_core::channel::{CHANNELS, INERTIAL};
use hexsense_core::harmonics::Analyser;
use hexsense_core::sampling::{BlockSize, BlockSums};
use hexsense_core::wire::Drive;
use hexsense_probe::analysis::RecordedRun;
use hexsense_probe::campaign::{BoardSums, RunRecord};
use hexsense_probe::capture::Capture;
use hexsense_probe::geometry_file::GeometryFile;
use hexsense_probe::plan::Plan;
use host_tests::reference::gost;
use nalgebra::Vector3;

/// Counts that one metre of jack makes at nominal supply: 2 V/m by the sensor file, 65536 counts at 3.3 V.
pub const COUNTS_PER_M: f64 = 2.0 * 65_536.0 / 3.3;
/// What block means scatter about the sine, counts at nominal supply: +10 and −10 in turn.
const SCATTER: f64 = 10.0;

/// How one run was recorded.
pub struct Recording {
    pub run: &'static str,
    pub rate_hz: u32,
    pub first_scan: u64,
    /// Start of the movement, s from the start of the capture.
    pub onset_s: f64,
    /// Supply factor.
    pub supply: f32,
    /// Temperature at the first scan and at the last.
    pub temperature_c: [f32; 2],
    pub scans_lost: u64,
    /// Registered less calculated displacement of the jacks, mm.
    pub jack_errors_mm: [f64; 6],
    /// Drive of the run's sine, Hz, and the channels that swing with it: amplitude in counts at nominal supply.
    pub drive_hz: f64,
    pub waves: &'static [(usize, f64)],
}

#[rustfmt::skip]
pub const RECORDINGS: [Recording; 6] = [
    Recording {
        run: "zero", rate_hz: 1_000, first_scan: 0, onset_s: 0.0, supply: 1.02, temperature_c: [24.5, 25.0],
        scans_lost: 0, jack_errors_mm: [0.0; 6], drive_hz: 0.0, waves: &[],
    },
    Recording {
        run: "pitch", rate_hz: 1_000, first_scan: 11_000, onset_s: 1.75, supply: 1.0, temperature_c: [25.5, 26.0],
        scans_lost: 3, jack_errors_mm: [0.5, -1.0, 1.5, -2.5, 3.5, 4.5], drive_hz: 0.0, waves: &[],
    },
    Recording {
        run: "roll", rate_hz: 1_000, first_scan: 30_000, onset_s: 2.25, supply: 1.01, temperature_c: [26.5, 27.0],
        scans_lost: 5, jack_errors_mm: [-0.7, 1.2, 1.7, 2.2, -2.7, 3.2], drive_hz: 0.0, waves: &[],
    },
    Recording {
        run: "heave", rate_hz: 1_000, first_scan: 50_000, onset_s: 1.25, supply: 0.99, temperature_c: [27.5, 28.0],
        scans_lost: 8, jack_errors_mm: [0.9, 0.8, -0.7, 0.6, -0.4, 0.3], drive_hz: 0.5, waves: &[(1, 1010.0)],
    },
    Recording {
        run: "roll-sine", rate_hz: 2_000, first_scan: 70_000, onset_s: 1.5, supply: 0.995, temperature_c: [28.5, 31.5],
        scans_lost: 13, jack_errors_mm: [1.1, -1.3, 1.6, 1.8, -1.9, 2.1], drive_hz: 0.25,
        waves: &[(3, 520.0), (6, 1290.0)],
    },
    Recording {
        run: "held-out", rate_hz: 1_000, first_scan: 110_000, onset_s: 2.0, supply: 1.005, temperature_c: [35.0, 40.0],
        scans_lost: 21, jack_errors_mm: [0.0; 6], drive_hz: 0.0, waves: &[],
    },
];

impl Recording {
    pub fn record(&self, plan: &Plan, base: &GeometryFile) -> RecordedRun {
        let run = plan.run(self.run).unwrap();
        let rate = f64::from(self.rate_hz);
        let scans = ((self.onset_s + run.duration_s() + 1.0) * rate).round() as usize;
        let program = run.program();
        let mut capture = Capture::default();
        for scan in 0..scans {
            let time_s = scan as f64 / rate;
            let lengths = lengths(base, program.displacement(time_s - self.onset_s));
            let nominal = |channel: usize| match channel.checked_sub(INERTIAL) {
                None => self.sensor(channel, scan, time_s),
                Some(jack) => {
                    let displacement_m = lengths[jack] - 2.75 + 1e-3 * self.jack_errors_mm[jack];
                    32_768.0 + COUNTS_PER_M * displacement_m
                }
            };
            let raw = |channel| (nominal(channel) / f64::from(self.supply)).round() as u16;
            let [first, last] = self.temperature_c;
            let part = scan as f32 / (scans - 1) as f32;
            capture.scans.push(self.first_scan + scan as u64);
            capture.counts.push(std::array::from_fn(raw));
            capture.supply.push(self.supply);
            capture
                .temperature_c
                .push(first * (1.0 - part) + last * part);
        }
        RecordedRun {
            ratiometric: Default::default(),
            name: self.run.to_owned(),
            program,
            capture,
            rate_hz: self.rate_hz,
        }
    }

    fn sensor(&self, channel: usize, scan: usize, time_s: f64) -> f64 {
        let wave = self.waves.iter().find(|wave| wave.0 == channel);
        let wave = wave.map_or(0.0, |(_, amplitude)| {
            let scatter = if (scan / 8).is_multiple_of(2) {
                SCATTER
            } else {
                -SCATTER
            };
            amplitude * (TAU * self.drive_hz * time_s).cos() + scatter
        });
        30_000.0 + 100.0 * channel as f64 + wave
    }

    /// The run's record, without sums.
    pub fn note(&self, recorded: &RecordedRun) -> RunRecord {
        RunRecord {
            run: self.run.to_owned(),
            program_sha256: format!("{:02x}", 0x10 + self.scans_lost).repeat(32),
            rate_hz: self.rate_hz,
            block: BlockSize::Eight,
            set: None,
            onset_scan: None,
            scans: recorded.capture.scans.len() as u64,
            scans_lost: self.scans_lost,
            board_sums: Vec::new(),
        }
    }
}

/// Lengths of the jacks, m: |p + A·b − a| with A = Ry(ψ)·Rz(ϑ)·Rx(γ), p from home at a height of 2.129757 m.
pub fn lengths(base: &GeometryFile, at: [f64; 6]) -> [f64; 6] {
    let rotation = gost(at[3], at[4], at[5]);
    let position = Vector3::new(at[0], 2.129_757 + at[1], at[2]);
    let (lower, upper) = (base.geometry.lower(), base.geometry.upper());
    std::array::from_fn(|jack| (position + rotation * upper[jack] - lower[jack]).norm())
}

/// The sums that a board makes of `blocks` blocks from row `row` of the capture on.
pub fn sums(
    run: &RecordedRun,
    drive_hz: f64,
    block: BlockSize,
    row: usize,
    blocks: u32,
) -> BoardSums {
    let drive = Drive {
        increment: (drive_hz / f64::from(run.rate_hz) * 2f64.powi(64)) as u64,
        block,
        settle_blocks: 0,
        blocks,
    };
    let mut analyser = Analyser::new();
    analyser.start(drive);
    let rows = row..row + blocks as usize * block.scans();
    let scans = run.capture.counts[rows].chunks(block.scans());
    let first_scans = (run.capture.scans[row]..).step_by(block.scans());
    for (scans, first_scan) in scans.zip(first_scans) {
        analyser.take(&BlockSums::of_scans(scans, first_scan));
    }
    let report = |channel| analyser.report(channel).unwrap();
    BoardSums {
        drive,
        first_scan: report(0).1,
        channels: std::array::from_fn::<_, CHANNELS, _>(|channel| report(channel).2),
    }
}
