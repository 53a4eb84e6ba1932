//! A verified campaign on the twin, with all its files.

use std::path::PathBuf;

use hexsense_core::channel::CHANNELS;
use hexsense_core::harmonics::Analyser;
use hexsense_core::records::{CoefficientSet, JackCoefficients, MotionBase};
use hexsense_core::sampling::{BLOCK, BlockSize, BlockSums, Calibrator};
use hexsense_core::wire::Drive;
use hexsense_probe::analysis::RecordedRun;
use hexsense_probe::analysis::held_out::{HeldOut, compare, held_out};
use hexsense_probe::analysis::results::{Analysis, analyse};
use hexsense_probe::campaign::{
    BoardPoses, BoardRecord, BoardSums, Campaign, RunRecord, Verification,
};
use hexsense_probe::characteristics::Characterisation;
use hexsense_probe::geometry_file::GeometryFile;
use hexsense_probe::plan::{self, Purpose};
use hexsense_probe::report::{ReportInput, Verified};
use hexsense_probe::sensor_file::SensorFile;
use host_tests::bench::{Laboratory, Movement, RATE_HZ};

/// What is known of a verified campaign.
pub struct Evidence {
    pub campaign: Campaign,
    pub board: BoardRecord,
    pub set: CoefficientSet,
    pub runs: Vec<RecordedRun>,
    pub records: Vec<RunRecord>,
    pub analysis: Analysis,
    pub held_out_run: RecordedRun,
    pub curves: HeldOut,
    pub verification: Verification,
    pub characterisation: Characterisation,
}

impl Evidence {
    pub fn gather(geometry: &str, seed: u64) -> Self {
        let geometry = GeometryFile::load(geometry).unwrap();
        let sensors = SensorFile::parse("papers", &twin::papers::sensor_file(seed)).unwrap();
        let plan = plan::campaign::plan(&geometry).unwrap();
        let mut laboratory = Laboratory::new(seed, &geometry);
        let mut record = |run: &plan::Run| {
            laboratory.record(&Movement::new(
                &run.name,
                run.program(),
                run.rest_s,
                &geometry,
            ))
        };
        let runs: Vec<RecordedRun> = plan.runs_to(Purpose::Calibrate).map(&mut record).collect();
        let mut held_out_run = record(plan.run("held-out").unwrap());
        let analysis = analyse(&geometry, &sensors, &runs).unwrap();
        let characterisation = Characterisation::new(&geometry, &sensors, &runs).unwrap();
        let set = set(&geometry, &analysis);
        let calibrator = Calibrator::new(&set);
        let capture = &mut held_out_run.capture;
        let scans = capture.counts.iter().zip(&capture.supply);
        capture.values = Some(
            scans
                .map(|(scan, supply)| calibrator.apply(scan, *supply))
                .collect(),
        );
        let results = &analysis.results;
        let curves = held_out(&geometry, &sensors, &held_out_run, results).unwrap();
        let channels = compare(
            &curves.reference,
            &curves.after,
            &curves.before,
            results,
            200.0,
        );
        let records = runs
            .iter()
            .chain([&held_out_run])
            .map(|run| run_record(run, &analysis))
            .collect();
        let board = BoardRecord {
            board: "01626f617264ff0075696432".to_owned(),
            hardware: "NUCLEO-G474RE, STM32G474RE".to_owned(),
            firmware: "0.1.0".to_owned(),
            wire: 1,
            facts: hexsense::FACTS,
            build: None,
        };
        let campaign = Campaign {
            folder: PathBuf::from("campaign"),
            plan,
            geometry,
            sensors,
        };
        Self {
            campaign,
            board,
            set,
            runs,
            records,
            analysis,
            held_out_run,
            curves,
            verification: Verification {
                board_pose: BoardPoses {
                    poses: 1886,
                    largest_m: 2.46e-7,
                    largest_rad: 1.14e-7,
                    limit: 5e-7,
                },
                channels,
            },
            characterisation,
        }
    }

    /// What the report is made of before the held-out movement.
    pub fn unverified(&self) -> ReportInput<'_> {
        ReportInput {
            campaign: &self.campaign,
            board: &self.board,
            set: &self.set,
            runs: &self.runs,
            records: &self.records,
            analysis: &self.analysis,
            characterisation: &self.characterisation,
            verified: None,
        }
    }

    /// What it is made of after that.
    pub fn verified(&self) -> ReportInput<'_> {
        let verified = Verified {
            run: &self.held_out_run,
            curves: &self.curves,
            verification: &self.verification,
        };
        ReportInput {
            verified: Some(verified),
            ..self.unverified()
        }
    }
}

fn set(geometry: &GeometryFile, analysis: &Analysis) -> CoefficientSet {
    CoefficientSet {
        board: *b"\x01board\xff\x00uid2",
        geometry: geometry.name.as_str().try_into().unwrap(),
        geometry_hash: *geometry.hash.first_chunk().unwrap(),
        unix_s: 1_780_000_000,
        temperature_c: 27.2,
        provenance: [0xa5; 32],
        ratiometric: Default::default(),
        build: None,
        triads: analysis.triads,
        base: MotionBase::new(&geometry.geometry),
        jacks: JackCoefficients {
            zero_length_m: 2.75,
            zero_counts: [32_768.0; 6],
            metres_per_count: [2e-5; 6],
        },
    }
}

/// A record as the host writes it, with the sums that a board would have kept over the estimate.
fn run_record(run: &RecordedRun, analysis: &Analysis) -> RunRecord {
    let condensed = &analysis.condensed;
    let mut sweeps = condensed.turns.iter().chain([&condensed.heave]);
    let sweep = sweeps.find(|sweep| sweep.name == run.name);
    let board_sums = sweep.into_iter().map(|sweep| {
        let first = (sweep.first - 100) / BLOCK * BLOCK;
        let drive = Drive {
            increment: (sweep.sine.frequency_hz / f64::from(RATE_HZ) * 2f64.powi(64)) as u64,
            block: BlockSize::default(),
            settle_blocks: (first / BLOCK) as u32,
            blocks: (sweep.length_s * f64::from(RATE_HZ) / BLOCK as f64) as u32,
        };
        let mut analyser = Analyser::new();
        analyser.start(drive);
        let blocks = run.capture.counts.as_chunks::<BLOCK>().0.iter();
        for (block, first_scan) in blocks.zip(run.capture.scans.iter().step_by(BLOCK)) {
            analyser.take(&BlockSums::of_scans(block, *first_scan));
        }
        let report = |channel| analyser.report(channel).unwrap();
        let channels: [_; CHANNELS] = std::array::from_fn(|channel| report(channel).2);
        BoardSums {
            drive,
            first_scan: report(0).1,
            channels,
        }
    });
    RunRecord {
        run: run.name.clone(),
        program_sha256: "5e".repeat(32),
        rate_hz: RATE_HZ,
        onset_scan: None,
        scans: run.capture.scans.len() as u64,
        scans_lost: 0,
        block: BlockSize::default(),
        set: None,
        board_sums: board_sums.collect(),
    }
}
