//! `hexsense kinematics` against published platforms, and with rows that are none.

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use tempfile::TempDir;

/// A folder with `geometry.toml`: a published platform of `geometries.csv`, z up as published, in units so large that
/// they pass for metres.
fn platform(name: &str, scale: f64, lengths: [f64; 2], home_height: f64) -> TempDir {
    let mut hinges = [String::new(), String::new()];
    for row in data("geometries.csv").iter().filter(|row| row[0] == name) {
        for (list, from) in hinges.iter_mut().zip([4, 7]) {
            let c = numbers::<3>(&row[from..from + 3]).map(|c| c * scale);
            *list += &format!("[{:?}, {:?}, {:?}], ", c[0], c[1], c[2]);
        }
    }
    let [lower, upper] = hinges;
    let text = format!(
        "name = {name:?}\naxes = \"z-up\"\nlength_min = {:?}\nlength_max = {:?}\nhome_height = {home_height:?}\n\
         lower = [{lower}]\nupper = [{upper}]\n",
        lengths[0], lengths[1],
    );
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("geometry.toml"), text).unwrap();
    folder
}

/// NASA's platform in hundreds of its own units.
fn nasa() -> TempDir {
    platform("nasa_msfc_cdsl", 0.01, [0.5, 3.0], -1.1131)
}

fn mathworks() -> TempDir {
    platform("mathworks_demo", 1.0, [1.0, 6.0], 2.0)
}

/// Rows of a published table, cell by cell, without the header.
fn data(file: &str) -> Vec<Vec<String>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host-tests/tests/data");
    let text = fs::read_to_string(folder.join(file)).unwrap();
    let cells = |line: &str| line.split(',').map(str::to_owned).collect();
    text.lines().skip(1).map(cells).collect()
}

fn numbers<const N: usize>(cells: &[String]) -> [f64; N] {
    let numbers: Vec<f64> = cells.iter().map(|cell| cell.parse().unwrap()).collect();
    numbers.try_into().unwrap()
}

fn run(folder: &TempDir, arguments: &str, input: &str) -> Output {
    Command::cargo_bin("hexsense")
        .unwrap()
        .current_dir(folder.path())
        .args(["kinematics"])
        .args(arguments.split_whitespace())
        .args(["--geometry", "geometry.toml"])
        .write_stdin(input)
        .output()
        .unwrap()
}

/// The table that the command prints, header included.
fn table(folder: &TempDir, arguments: &str, input: &str) -> String {
    let output = run(folder, arguments, input);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// Rows of a printed table under the header that it must have.
fn rows<const N: usize>(table: &str, header: &str) -> Vec<[f64; N]> {
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some(header));
    lines
        .map(|line| numbers(&line.split(',').map(str::to_owned).collect::<Vec<_>>()))
        .collect()
}

fn lengths_of(table: &str) -> Vec<[f64; 6]> {
    rows(table, "l1_m,l2_m,l3_m,l4_m,l5_m,l6_m")
}

fn poses(table: &str) -> Vec<[f64; 9]> {
    rows(
        table,
        "x_m,y_m,z_m,roll_rad,pitch_rad,yaw_rad,residual_m,condition,iterations",
    )
}

fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() <= tolerance, "{found:?} is not {expected:?}");
    }
}

fn csv(row: &[f64]) -> String {
    row.iter().map(f64::to_string).collect::<Vec<_>>().join(",")
}

/// NASA's pose as published: z up, R = Rx·Ry·Rz, in hundreds of its units; and its published lengths.
fn nasa_case() -> ([f64; 6], [f64; 6]) {
    let n: [f64; 12] = numbers(&data("nasa_cdsl_legs.csv")[0]);
    let [roll, pitch, yaw] = [n[0], n[1], n[2]].map(f64::to_radians);
    let pose = [n[3], n[4], n[5] - 111.31].map(|c| c * 0.01);
    let units: [f64; 6] = numbers(&data("nasa_cdsl_legs.csv")[0][6..]);
    (
        [pose[0], pose[1], pose[2], roll, pitch, yaw],
        units.map(|length| length * 0.01),
    )
}

/// Scripts of earlier versions call the jacks legs.
#[test]
fn the_former_names_of_the_command_and_its_argument_are_taken() {
    let found = table(&mathworks(), "legs --poses -", "0,2,0,0,0,0");
    let back = table(&mathworks(), "pose --legs -", &found);
    assert_near(&poses(&back)[0][..6], &[0.0, 2.0, 0.0, 0.0, 0.0, 0.0], 1e-9);
}

#[test]
fn nasas_published_pose_has_its_published_lengths_and_they_have_the_pose() {
    let (pose, lengths) = nasa_case();
    let folder = nasa();
    let found = table(&folder, "lengths --poses - --convention xyz", &csv(&pose));
    // Lengths that a symmetric pose makes equal differ by 0.002 units in the published table.
    assert_near(&lengths_of(&found)[0], &lengths, 2.5e-5);

    // The table of one command is the input of the other, with a header and from a file.
    fs::write(folder.path().join("lengths.csv"), &found).unwrap();
    let found = table(&folder, "pose --lengths lengths.csv --convention xyz", "");
    let [x, y, z, roll, pitch, yaw, residual, condition, iterations] = poses(&found)[0];
    assert_near(&[x, y, z, roll, pitch, yaw], &pose, 1e-9);
    assert!(residual <= 1e-10 && condition > 1.0 && iterations >= 1.0);
}

#[test]
fn mathworks_demo_has_its_published_lengths_at_its_home_in_z_up_axes() {
    for convention in ["zyx", "xyz"] {
        let found = table(
            &mathworks(),
            &format!("lengths --poses - --convention {convention}"),
            "0,0,2,0,0,0",
        );
        assert_near(&lengths_of(&found)[0], &[3.153800684; 6], 1e-9);
    }
    // The default has Y up.
    let found = table(&mathworks(), "lengths --poses -", "0,2,0,0,0,0");
    assert_near(&lengths_of(&found)[0], &[3.153800684; 6], 1e-9);
}

#[test]
fn the_three_conventions_are_three_different_poses_and_each_comes_back() {
    let pose = [0.1, 0.2, 1.9, 0.2, -0.15, 0.1];
    let mut printed = Vec::new();
    for (convention, pose) in [
        ("zyx", pose),
        ("xyz", pose),
        ("gost", [0.1, 1.9, -0.2, 0.2, -0.15, 0.1]),
    ] {
        let option = format!("--convention {convention}");
        let lengths = table(
            &mathworks(),
            &format!("lengths --poses - {option}"),
            &csv(&pose),
        );
        let found = table(
            &mathworks(),
            &format!("pose --lengths - {option}"),
            &lengths,
        );
        assert_near(&poses(&found)[0], &pose, 1e-9);
        printed.push(lengths_of(&lengths)[0]);
    }
    for (one, other) in [(0, 1), (1, 2), (0, 2)] {
        let apart = (0..6).any(|k| (printed[one][k] - printed[other][k]).abs() > 5e-3);
        assert!(apart, "{one} and {other} are the same");
    }
}

/// Lengths of a pose far from home have other poses too; a seed near one of them finds that one.
#[test]
fn a_seed_decides_the_branch_and_the_rows_after_it_stay_there_until_they_jump() {
    let folder = platform("dietmaier40", 1.0, [0.0, 5.0], 1.0);
    // Poses 2 and 3 of the table; its rotations are not turns about one axis, so the angles come from the matrix.
    for row in [1, 2] {
        let n: [f64; 16] = numbers(&data("dietmaier40_poses.csv")[row]);
        // R = Rz·Ry·Rx by rows.
        let (roll, pitch, yaw) = (n[11].atan2(n[12]), (-n[10]).asin(), n[7].atan2(n[4]));
        let pose = [n[1], n[2], n[3], roll, pitch, yaw];
        let lengths = "1.0,0.645275,1.086284,1.503439,1.281933,0.771071\n".repeat(3);
        let seed = format!("pose --lengths - --convention zyx --seed {}", csv(&pose));
        let found = poses(&table(&folder, &seed, &lengths));
        assert_eq!(found.len(), 3);
        for found in found {
            assert_near(&found, &pose, 1e-5);
            assert!((found[7] / n[15] - 1.0).abs() < 1e-4, "{found:?}");
        }
    }
}

#[test]
fn a_jump_is_solved_from_home_and_said_so() {
    let input = "0,0,2,0,0,0\n0.01,0,2,0,0,0\n0.4,0,2.2,0,0,0.2\n";
    let lengths = table(&mathworks(), "lengths --poses - --convention zyx", input);
    let seed = "pose --lengths - --convention zyx --seed 0.01,-0.01,2,0,0,0";
    let output = run(&mathworks(), seed, &lengths);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.ends_with("from the row before: 1\n"), "{said}");
    let found = poses(&String::from_utf8(output.stdout).unwrap());
    assert_near(&found[1], &[0.01, 0.0, 2.0, 0.0, 0.0, 0.0], 1e-9);
    assert_near(&found[2], &[0.4, 0.0, 2.2, 0.0, 0.0, 0.2], 1e-9);
}

#[test]
fn a_long_table_keeps_its_order_and_stops_at_its_bad_row() {
    let height = |row: u32| 2.0 + 1e-6 * f64::from(row);
    let mut input = String::from("note,z,y,x,yaw,pitch,roll\n");
    for row in 0..30_000 {
        input += &format!("n,{},0,0,0,0,0\n", height(row));
    }
    let lengths = table(&mathworks(), "lengths --poses - --convention zyx", &input);
    let found = poses(&table(
        &mathworks(),
        "pose --lengths - --convention zyx",
        &lengths,
    ));
    assert_eq!(found.len(), 30_000);
    for (row, found) in (0..).zip(found) {
        assert_near(&found, &[0.0, 0.0, height(row), 0.0, 0.0, 0.0], 1e-9);
    }

    // The row after line 20,000, counted with the header, says nothing.
    let bad = input.replace(&format!("n,{},", height(19_999)), "n,high,");
    let output = run(&mathworks(), "lengths --poses - --convention zyx", &bad);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success());
    assert_eq!(
        said,
        "hexsense: standard input, line 20001: \"high\" is not a finite number\n"
    );
    assert_eq!(
        lengths_of(&String::from_utf8(output.stdout).unwrap()).len(),
        19_999
    );
}

#[test]
fn rows_that_are_no_rows_are_refused_with_file_line_and_reason() {
    let home = csv(&[3.153800684; 6]);
    let cases = [
        (
            "lengths --poses -",
            "",
            "standard input, line 1: there is no row",
        ),
        (
            "lengths --poses -",
            "0,2,0,0,0\n",
            "line 1: 5 cells; there must be 6",
        ),
        (
            "lengths --poses -",
            "0,2,0,0,0,0\n\n0,2,0,0,nan,0\n",
            "line 3: \"nan\"",
        ),
        ("lengths --poses -", "0,2,0,0,,0\n", "line 1: \"\""),
        (
            "lengths --poses -",
            "0,2,0,0,1e999,0\n",
            "line 1: \"1e999\"",
        ),
        (
            "lengths --poses -",
            "0,1e200,0,0,0,0\n",
            "line 1: y is 1e200 m, beyond ±100 m; if it is in millimetres",
        ),
        (
            "lengths --poses -",
            "x,y,z,roll,pitch,heading\n",
            "line 1: the header has no yaw",
        ),
        ("lengths --poses none.csv", "", "none.csv: cannot be read"),
        (
            "pose --lengths -",
            "3,3,3,3,3,30\n",
            "line 1: jack 6 is 30 m long",
        ),
        (
            "pose --lengths -",
            "1,6,1,6,1,6\n",
            "line 1: no pose that can be reached",
        ),
        (
            "pose --lengths - --seed 0,2,0,0,0",
            &home,
            "5 numbers; there must be 6",
        ),
        (
            "pose --lengths - --seed 0,2,0,0,0,inf",
            &home,
            "\"inf\" is not a finite",
        ),
        (
            "pose --lengths - --seed 0,2,0,0,0,90",
            &home,
            "yaw is 90.0 rad, beyond ±π rad (180°); if it is in degrees",
        ),
        (
            "pose --lengths - --convention zxy",
            &home,
            "[possible values: gost, zyx, xyz, z-down]",
        ),
    ];
    for (arguments, input, expected) in cases {
        let output = run(&mathworks(), arguments, input);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success(), "{arguments} with {input:?}");
        assert!(said.contains(expected), "{expected:?} is not in: {said}");
    }
}
