use super::*;
use crate::geometry_file::GeometryFile;
use hexsense_core::channel::INERTIAL;
use hexsense_core::kinematics::{Pose, displacements};
use hexsense_core::records::{JackCoefficients, MotionBase, TriadCoefficients};
use hexsense_core::wire::BoardPose;
use nalgebra::{UnitQuaternion, Vector3};

const ID: SetId = SetId([3; 8]);

fn set() -> CoefficientSet {
    let triad = TriadCoefficients {
        offset: [32_768.0; 3],
        matrix: [[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]],
        offset_uncertainty: [1.0; 3],
        matrix_uncertainty: [[1e-7; 3]; 3],
        delay_s: 0.0,
    };
    let geometry = GeometryFile::load("an-74tk-200").unwrap().geometry;
    CoefficientSet {
        board: [1; 12],
        geometry: "base".try_into().unwrap(),
        geometry_hash: [1; 8],
        unix_s: 0,
        temperature_c: 30.0,
        provenance: [2; 32],
        ratiometric: Default::default(),
        build: None,
        triads: [triad; 3],
        base: MotionBase::new(&geometry),
        jacks: JackCoefficients {
            zero_length_m: geometry.mid_length_m() as f32,
            zero_counts: [31_000.25; 6],
            metres_per_count: [2.3e-5; 6],
        },
    }
}

/// Ten blocks in which the base rises and turns, with counts that are not whole blocks of one number.
fn moving(set: &CoefficientSet) -> (Capture, Vec<PoseReport>) {
    let geometry = GeometryFile::load("an-74tk-200").unwrap().geometry;
    let mut capture = Capture::default();
    for scan in 0..160_u64 {
        let turn = Vector3::new(0.1, -0.05, 0.15) * scan as f64 / 160.0;
        let pose = Pose {
            position: geometry.home().position + Vector3::new(0.1, 0.2, -0.1) * scan as f64 / 160.0,
            rotation: UnitQuaternion::from_scaled_axis(turn),
        };
        let counts =
            displacements(&geometry, &pose).map(|metres| (metres / 2.3e-5 + 31_000.25) / 0.998);
        capture.scans.push(5_000 + scan);
        capture.supply.push(0.998);
        capture.temperature_c.push(30.0);
        let mut row = [0; 15];
        for (count, there) in row[INERTIAL..].iter_mut().zip(counts) {
            *count = there.round() as u16;
        }
        capture.counts.push(row);
    }
    let mut board = Tracker::<f32>::new(&set.base, &set.jacks, set.ratiometric).unwrap();
    let reports = (0..10).map(|index| {
        let scan = 5_000 + 16 * index;
        let outcome = board.next(&block(&capture, scan, BlockSize::default()).unwrap());
        PoseReport {
            block: BlockSize::default(),
            first_scan: scan,
            set: ID,
            outcome: outcome.map(Into::into).map_err(Into::into),
        }
    });
    let reports = reports.collect();
    (capture, reports)
}

#[test]
fn single_precision_follows_a_moving_base_within_the_limit() {
    let set = set();
    let (capture, reports) = moving(&set);
    let difference = compare(&capture, (1_000, BlockSize::Sixteen), &reports, &set, ID).unwrap();
    assert_eq!(difference.poses, 10);
    assert!(difference.largest_m > 0.0, "{difference:?}");
    // The last block's middle is at 151.5 of 160 steps; whole counts are a hundredth of a millimetre each.
    let pose = double(&reports[9].outcome.unwrap());
    let expected = Vector3::y() * 2.129757 + Vector3::new(0.1, 0.2, -0.1) * 151.5 / 160.0;
    assert!((pose.position - expected).norm() < 2e-5, "{pose:?}");
}

#[test]
fn a_pose_that_is_off_missing_refused_or_of_another_set_is_found() {
    let set = set();
    let (capture, good) = moving(&set);
    let spoilt = |change: &dyn Fn(&mut Vec<PoseReport>)| {
        let mut reports = good.clone();
        change(&mut reports);
        compare(&capture, (1_000, BlockSize::Sixteen), &reports, &set, ID).unwrap_err()
    };
    let off = spoilt(&|reports| {
        let mut pose = reports[7].outcome.unwrap();
        pose.position_m[2] += 1e-6;
        reports[7].outcome = Ok(pose);
    });
    assert!(
        matches!(off, BoardPoseError::Off { scan: 5112, .. }),
        "{off}"
    );
    let turned = spoilt(&|reports| {
        let mut pose = reports[7].outcome.unwrap();
        pose.rotation[1] += 1e-6;
        reports[7].outcome = Ok(pose);
    });
    assert!(matches!(turned, BoardPoseError::Off { .. }), "{turned}");
    let missing = spoilt(&|reports| drop(reports.drain(..2)));
    let expected = BoardPoseError::Missing { poses: 8, due: 10 };
    assert_eq!(missing, expected);
    let late = compare(&capture, (1_000, BlockSize::Sixteen), &good[1..], &set, ID);
    assert_eq!(late.unwrap().poses, 9, "one of ten may be late");
    let refused = spoilt(&|reports| reports[0].outcome = Err(PoseRefusal::Singular));
    assert!(matches!(
        refused,
        BoardPoseError::Refused { scan: 5000, .. }
    ));
    let other = spoilt(&|reports| reports[2].set = SetId([4; 8]));
    assert!(matches!(other, BoardPoseError::OtherSet { scan: 5032, .. }));
}

#[test]
fn a_pose_may_be_half_a_micrometre_and_half_a_microradian_off_and_no_more() {
    assert!(is_close(5e-7, 5e-7));
    assert!(!is_close(5e-7_f64.next_up(), 0.0) && !is_close(0.0, 5e-7_f64.next_up()));
    assert!(!is_close(f64::NAN, 0.0) && !is_close(0.0, f64::NAN));
}

#[test]
fn people_read_metres_and_degrees_or_why_there_is_no_pose() {
    let set = set();
    let (_, reports) = moving(&set);
    // Ry(20°)·Rz(30°)·Rx(10°) as a quaternion, multiplied by hand.
    let report = PoseReport {
        outcome: Ok(BoardPose {
            position_m: [0.1234, 2.2345, -0.3456],
            rotation: [0.943_714_4, 0.127_679_44, 0.189_307_86, 0.239_298_34],
            residual_m: 1.5e-6,
            condition_bound: 99.0,
            iterations: 3,
        }),
        ..reports[9]
    };
    let text = line(&report, &set).unwrap();
    let expected = "pose      x 0.1234 m, y 2.2345 m, z -0.3456 m; roll 10.000°, yaw 20.000°, pitch 30.000°; \
                    cond(J) ";
    assert!(text.starts_with(expected), "{text}");
    let document = to_json(&report, &set).unwrap();
    for (key, expected) in [
        ("x", 0.1234),
        ("y", 2.2345),
        ("z", -0.3456),
        ("roll", 10f64.to_radians()),
        ("yaw", 20f64.to_radians()),
        ("pitch", 30f64.to_radians()),
        ("residual", 1.5e-6),
        ("iterations", 3.0),
    ] {
        let found = document[key].as_f64().unwrap();
        assert!((found - expected).abs() < 1e-6, "{key}: {found}");
    }
    let none = PoseReport {
        outcome: Err(PoseRefusal::OutsideStroke {
            jack: 3,
            length_m: 4.5,
        }),
        ..reports[0]
    };
    assert!(
        line(&none, &set)
            .unwrap()
            .contains("none: jack 3 reads 4.5 m")
    );
    assert!(to_json(&none, &set).unwrap()["refused"].is_string());
}
