//! A small campaign whose every number is written down here: nothing in it is computed by the analysis, and no two
//! sensors, jacks, axes, runs or boards are alike. What the report must show of it is worked out by hand.

mod analysed;
pub mod numbers;
pub mod recordings;

use std::path::PathBuf;
use std::sync::LazyLock;

use hexsense_core::facts::BoardFacts;
use hexsense_core::records::{
    BuildId, CoefficientSet, JackCoefficients, MotionBase, TriadCoefficients,
};
use hexsense_core::sampling::BlockSize;
use hexsense_probe::analysis::RecordedRun;
use hexsense_probe::analysis::held_out::HeldOut;
use hexsense_probe::analysis::results::Analysis;
use hexsense_probe::campaign::{BoardRecord, Campaign, RunRecord};
use hexsense_probe::characteristics::{Characterisation, Characteristics};
use hexsense_probe::geometry_file::GeometryFile;
use hexsense_probe::plan::Plan;
use hexsense_probe::report::render;
use hexsense_probe::sensor_file::SensorFile;

use crate::evidence::Evidence;

use analysed::{condensed, estimate};
use recordings::{RECORDINGS, Recording, sums};

/// The campaign.
pub static SMALL: LazyLock<Evidence> = LazyLock::new(evidence);

/// Its report.
pub static SMALL_PAGE: LazyLock<String> = LazyLock::new(|| render(&SMALL.verified()).unwrap());

/// All files of the campaign, on which a test may change a number.
pub fn evidence() -> Evidence {
    let geometry = geometry();
    let plan = plan(&geometry);
    let record = |recording: &Recording| recording.record(&plan, &geometry);
    let mut runs: Vec<RecordedRun> = RECORDINGS.iter().map(record).collect();
    let notes = RECORDINGS.iter().zip(&runs);
    let mut records: Vec<RunRecord> = notes.map(|(recording, run)| recording.note(run)).collect();
    let held_out_run = runs.pop().unwrap();
    sum_up(&mut records, &runs);
    let sensors = SensorFile::parse("sensors.toml", include_str!("sensors.toml")).unwrap();
    let condensed = condensed();
    let characterisation = Characterisation {
        sweeps: vec![condensed.heave.clone(), condensed.turns[0].clone()],
        characteristics: Characteristics {
            frequency_response: numbers::frequency_response(),
        },
    };
    Evidence {
        board: board(),
        set: set(&geometry),
        campaign: Campaign {
            folder: PathBuf::from("/somewhere/spring"),
            plan,
            geometry,
            sensors,
        },
        runs,
        records,
        analysis: Analysis {
            condensed,
            estimate: estimate(),
            results: numbers::results(),
            triads: [triad(); 3],
        },
        characterisation,
        held_out_run,
        curves: curves(),
        verification: numbers::verification(),
    }
}

fn geometry() -> GeometryFile {
    let text = GeometryFile::load("an-74tk-200").unwrap().text;
    let name = text.replace("name = \"an-74tk-200\"", "name = \"base seven\"");
    let (before, after) = name.split_once("note = ").unwrap();
    let after = after.split_once('\n').unwrap().1;
    let text = format!("{before}note = \"Where it stands.\"\n{after}");
    let text = text.replace("hinge_tolerance = 0.0005", "hinge_tolerance = 0.0004");
    GeometryFile::parse("geometry.toml", &text).unwrap()
}

fn plan(geometry: &GeometryFile) -> Plan {
    let hash: String = geometry
        .hash
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let head =
        format!("geometry = \"base seven\"\ngeometry_sha256 = \"{hash}\"\nperiod_s = 0.002\n");
    Plan::parse("plan.toml", &(head + include_str!("runs.toml"))).unwrap()
}

/// Not the board that the set names.
fn board() -> BoardRecord {
    BoardRecord {
        board: "0a1b2c3d4e5f60718293a4b5".to_owned(),
        hardware: "interface board, second".to_owned(),
        firmware: "1.2.3".to_owned(),
        wire: 45,
        facts: BoardFacts {
            nominal_supply_v: 3.0,
            ..hexsense::FACTS
        },
        build: None,
    }
}

fn triad() -> TriadCoefficients {
    TriadCoefficients {
        offset: [32_000.0, 33_000.0, 34_000.0],
        matrix: [[1e-3, 0.0, 0.0], [0.0, 2e-3, 0.0], [0.0, 0.0, 3e-3]],
        offset_uncertainty: [1.0, 2.0, 3.0],
        matrix_uncertainty: [[1e-6; 3]; 3],
        delay_s: 0.001,
    }
}

fn set(geometry: &GeometryFile) -> CoefficientSet {
    CoefficientSet {
        board: *b"another one.",
        geometry: "base seven".try_into().unwrap(),
        geometry_hash: [7; 8],
        unix_s: 1_780_000_000,
        temperature_c: 27.3,
        provenance: std::array::from_fn(|index| index as u8),
        ratiometric: Default::default(),
        build: Some(BuildId([0xb0, 0xb1, 0xb2, 0xb3, 0xb4, 0xb5, 0xb6, 0xb7])),
        triads: [triad(); 3],
        base: MotionBase::new(&geometry.geometry),
        jacks: JackCoefficients {
            zero_length_m: 2.75,
            zero_counts: [32_768.0; 6],
            metres_per_count: [2e-5; 6],
        },
    }
}

/// The heave run's sums are right, one of roll-sine's is off by one, and those of the held-out run are of other scans.
fn sum_up(records: &mut [RunRecord], runs: &[RecordedRun]) {
    records[3].board_sums = vec![sums(&runs[3], 0.5, BlockSize::Eight, 6_256, 750)];
    let mut changed = sums(&runs[4], 0.25, BlockSize::Sixteen, 13_040, 1_000);
    changed.channels[14].sine[4] += 1;
    records[4].board_sums = vec![changed.clone()];
    changed.first_scan = 9;
    records[5].board_sums = vec![changed];
}

/// Errors about the mean of 0.5 before the calibration and 0.1 after it.
fn curves() -> HeldOut {
    let wave = |size: f64| -> [Vec<f64>; 9] {
        std::array::from_fn(|channel| {
            let place = |n: i32| (f64::from(n) / 100.0 + channel as f64).sin();
            (0..1_300).map(|n| (1.0 + size) * place(n)).collect()
        })
    };
    HeldOut {
        reference: wave(0.0),
        before: wave(0.5),
        after: wave(0.1),
        jacks: vec![[32_768.0; 6]; 1_300],
        first: 500.0,
        group: 10,
    }
}
