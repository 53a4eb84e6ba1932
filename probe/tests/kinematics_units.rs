//! `hexsense kinematics` with the units, the axes and the special attitudes that tables really have. Sources of
//! `tests/data` are in its README.

use std::f64::consts::FRAC_PI_2;
use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use hexsense_probe::geometry_file::GeometryFile;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data");
const LENGTHS: &str = "l1_m,l2_m,l3_m,l4_m,l5_m,l6_m";
const POSE: &str = "x_m,y_m,z_m,roll_rad,pitch_rad,yaw_rad,residual_m,condition,iterations";

fn run(arguments: &str, input: &str) -> Output {
    Command::cargo_bin("hexsense")
        .unwrap()
        .current_dir(DATA)
        .arg("kinematics")
        .args(arguments.split_whitespace())
        .write_stdin(input)
        .output()
        .unwrap()
}

/// The rows that the command prints under `header`.
fn rows(arguments: &str, input: &str, header: &str) -> Vec<Vec<f64>> {
    let output = run(arguments, input);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments}: {said}");
    let text = String::from_utf8(output.stdout).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(header));
    let numbers = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect();
    lines.map(numbers).collect()
}

fn said(arguments: &str, input: &str) -> String {
    let output = run(arguments, input);
    assert!(!output.status.success(), "{arguments} with {input:?}");
    String::from_utf8(output.stderr).unwrap()
}

fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
    assert!(found.len() >= expected.len());
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() <= tolerance, "{found:?} is not {expected:?}");
    }
}

fn csv(rows: &[Vec<f64>]) -> String {
    let line = |row: &Vec<f64>| row.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n";
    rows.iter().map(line).collect()
}

#[test]
fn degrees_and_millimetres_are_read_where_the_header_says_so_and_refused_where_it_does_not() {
    let command = "lengths --geometry rexroth_emotion8000 --poses";
    let taken_as_radians = said(&format!("{command} poses_in_degrees.csv"), "");
    assert!(
        taken_as_radians.contains("line 2: roll is 10.0 rad, beyond ±π rad (180°)")
            && taken_as_radians.contains("roll_deg"),
        "{taken_as_radians}"
    );
    let row = "0.1,1.9,-0.2,10,10,10\n";
    // The published hinges and GOST's matrix, in Python.
    let expected = [2.813850, 3.156641, 2.803116, 2.811993, 2.186448, 3.510685];
    for (header, row) in [
        ("x,y,z,roll_deg,pitch_deg,yaw_deg\n", row),
        (
            "x_mm,y_m,z_mm,roll_deg,pitch_deg,yaw_deg\n",
            "100,1.9,-200,10,10,10\n",
        ),
        (
            "X [mm],Y [mm],Z [mm],Roll (deg),Pitch (deg),Yaw (deg)\n",
            "100,1900,-200,10,10,10\n",
        ),
    ] {
        let found = rows(&format!("{command} -"), &format!("{header}{row}"), LENGTHS);
        assert_near(&found[0], &expected, 1e-6);
    }
    let far = said(&format!("{command} -"), "100,1900,-200,0.1,0.1,0.1\n");
    assert!(
        far.contains("y is 1900.0 m, beyond ±100 m") && far.contains("y_mm"),
        "{far}"
    );
}

#[test]
fn lengths_in_millimetres_are_read() {
    let input = format!(
        "l1_mm,l2_mm,l3_mm,l4_mm,l5_mm,l6_mm\n{}",
        "2900,".repeat(5) + "2900\n"
    );
    let command = "pose --geometry rexroth_emotion8000 --lengths -";
    let found = rows(command, &input, POSE);
    assert_near(&found[0], &[0.0, 1.953168654, 0.0, 0.0, 0.0, 0.0], 1e-9);
    let far = said(command, "2900,2900,2900,2900,2900,2900\n");
    assert!(far.contains("l1 is 2900.0 m, beyond ±100 m"), "{far}");
}

/// From the seat, 10° nose up, 20° right wing down, 30° nose right, O 1.9 m up and 0.2 m to the right: written with z
/// down, and by the turns of GOST 20058-80, whose yaw is nose left.
#[test]
fn a_pose_with_z_down_is_the_pose_of_the_standard_with_yaw_to_the_right() {
    let command = "lengths --geometry rexroth_emotion8000 --poses -";
    let header = "x,y,z,roll_deg,pitch_deg,yaw_deg\n";
    let z_down = format!("{header}0.1,0.2,-1.9,20,10,30\n");
    let found = rows(&format!("{command} --convention z-down"), &z_down, LENGTHS);
    let standard = rows(
        command,
        &format!("{header}0.1,1.9,0.2,20,10,-30\n"),
        LENGTHS,
    );
    assert_near(&found[0], &standard[0], 1e-12);
    // Hinges with z down and R = Rz·Ry·Rx, in Python.
    let expected = [
        4.0394931667,
        2.6323012364,
        3.7351019189,
        1.7400244257,
        3.0228963561,
        2.4138718418,
    ];
    assert_near(&found[0], &expected, 1e-9);
}

/// A base with jacks long enough for a platform that stands on its nose.
fn wide(folder: &Path) -> String {
    let preset = GeometryFile::load("an-74tk-200").unwrap().text;
    let wide = preset.replace("length_min = 2.10", "length_min = 0.1");
    let path = folder.join("wide.toml");
    fs::write(&path, wide.replace("length_max = 3.40", "length_max = 9.0")).unwrap();
    path.display().to_string()
}

#[test]
fn at_ninety_degrees_of_pitch_the_printed_pose_has_the_very_lengths() {
    let folder = tempfile::tempdir().unwrap();
    let wide = wide(folder.path());
    for convention in ["gost", "zyx", "xyz", "z-down"] {
        let up = match convention {
            "gost" => "0.2,2.5,0.1",
            "z-down" => "0.2,0.1,-2.5",
            _ => "0.2,0.1,2.5",
        };
        for pitch in [FRAC_PI_2, -FRAC_PI_2] {
            let options = format!("--geometry {wide} --convention {convention}");
            let pose = format!("{up},0.3,{pitch:?},0.2");
            let lengths = rows(&format!("lengths {options} --poses -"), &pose, LENGTHS);
            let seed = format!("pose {options} --lengths - --seed {pose}");
            let found = rows(&seed, &csv(&lengths), POSE);
            let again = csv(&[found[0][..6].to_vec()]);
            let again = rows(&format!("lengths {options} --poses -"), &again, LENGTHS);
            assert_near(&again[0], &lengths[0], 1e-9);
        }
    }
}

/// 77 poses that the real base reported: surge, sway and heave from its neutral pose, z down, R = Rx·Ry·Rz. With z up
/// that is x, −y, −z, roll, −pitch, −yaw.
#[test]
fn every_pose_that_the_real_rexroth_1500_reported_is_inside_its_stroke_and_comes_back() {
    const NEUTRAL_M: f64 = 1.551;
    let text = fs::read_to_string(format!("{DATA}/rexroth_emotion1500_poses.csv")).unwrap();
    let poses: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| {
            let n: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            vec![n[0], -n[1], NEUTRAL_M - n[2], n[3], -n[4], -n[5]]
        })
        .collect();
    assert_eq!(poses.len(), 77);
    let options = "--geometry rexroth_emotion1500 --convention xyz";
    let lengths = rows(
        &format!("lengths {options} --poses -"),
        &csv(&poses),
        LENGTHS,
    );
    for length in lengths.iter().flatten() {
        assert!((1.4295..2.2295).contains(length), "{length}");
    }
    let found = rows(&format!("pose {options} --lengths -"), &csv(&lengths), POSE);
    assert_eq!(found.len(), 77);
    for (found, pose) in found.iter().zip(&poses) {
        assert_near(found, pose, 1e-9);
    }
}
