//! Tables as spreadsheets and other programs write them, through `hexsense kinematics` and as captures.

use std::fs;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use hexsense_probe::capture::Capture;

fn data(file: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    fs::read_to_string(folder.join(file)).unwrap()
}

fn pose_of(lengths: &str) -> Output {
    let arguments = "kinematics pose --geometry rexroth_emotion8000 --lengths -";
    Command::cargo_bin("hexsense")
        .unwrap()
        .args(arguments.split_whitespace())
        .write_stdin(lengths)
        .output()
        .unwrap()
}

/// Every row has the pose that belongs to lengths of 2.9 m.
fn assert_read(lengths: &str, rows: usize) {
    let output = pose_of(lengths);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{lengths:?}: {said}");
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().count(), rows + 1, "{lengths:?}");
    for line in text.lines().skip(1) {
        let cells = line.split(',').map(|cell| cell.parse().unwrap());
        let cells: Vec<f64> = cells.take(6).collect();
        for (found, right) in cells.iter().zip([0.0, 1.953168654, 0.0, 0.0, 0.0, 0.0]) {
            assert!((found - right).abs() < 1e-9, "{lengths:?}: {line}");
        }
    }
}

fn assert_refused(lengths: &str, words: &[&str]) {
    let output = pose_of(lengths);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success(), "{lengths:?} is read");
    for words in words {
        assert!(said.contains(words), "{lengths:?}: no {words:?} in {said}");
    }
}

#[test]
fn one_table_in_the_forms_of_many_programs_has_one_pose() {
    assert_read(&data("legs_semicolon_decimal_comma.csv"), 1);
    for table in [
        // With points, tabs, quotes, blanks, a byte order mark and a declared separator.
        "l1,l2,l3,l4,l5,l6\n2.9,2.9,2.9,2.9,2.9,2.9\n",
        "l1\tl2\tl3\tl4\tl5\tl6\r\n2.9\t2.9\t2.9\t2.9\t2.9\t2.9\r\n",
        "l1\tl2\tl3\tl4\tl5\tl6\r\n2,9\t2,9\t2,9\t2,9\t2,9\t2,9\r\n",
        "\"l1\",\"l2\",\"l3\",\"l4\",\"l5\",\"l6\"\n\"2.9\",2.9,2.9,2.9,2.9,2.9\n",
        "l1,l2,l3,l4,l5,l6\n\"2,9\",\"2,9\",\"2,9\",\"2,9\",\"2,9\",\"2,9\"\n",
        "\u{feff}l1 , l2, l3,l4,l5,l6  \r\n 2.9 ,2.9,2.9, 2.9,2.9,2.9  \r\n",
        "sep=;\r\nl1;l2;l3;l4;l5;l6\r\n2,90;2,90;2,90;2,90;2,90;2,90\r\n",
        "l1;l2;l3;l4;l5;l6\n2.9;2.9;2.9;2.9;2.9;2.9\n",
        "2,9;2,9;2,9;2,9;2,9;2,9",
        "2,9E+0;29e-1;2,9;2,9;2,9;2,9",
        // Columns beside the wanted ones, in another order, with a separator inside quotes; empty cells at the end.
        "note;l6;l5;l4;l3;l2;l1;;\n\"a; b\";2,9;2,9;2,9;2,9;2,9;2,9;;\n",
        "l1,l2,l3,l4,l5,l6,note,note\n2.9,2.9,2.9,2.9,2.9,2.9,,\n",
    ] {
        assert_read(table, 1);
    }
    let empty = "\r\n;;;;;\r\n  \r\n";
    let row = "2,9;2,9;2,9;2,9;2,9;2,9\r\n";
    assert_read(
        &format!("l1;l2;l3;l4;l5;l6\r\n{empty}{row}{empty}{row}{empty}"),
        2,
    );
}

#[test]
fn what_could_be_read_in_two_ways_is_refused_with_line_separator_and_mend() {
    let header = "l1;l2;l3;l4;l5;l6\n";
    assert_refused(
        &format!("{header}2,9;2,9;2,9;2,9;2,9;2,9\n2.9;2,9;2,9;2,9;2,9;2,9\n"),
        &["line 3", "\"2.9\" has a decimal point", "decimal commas"],
    );
    assert_refused(
        &format!("{header}2.9;2.9;2.9;2.9;2.9;2.9\n2,9;2,9;2,9;2,9;2,9;2,9\n"),
        &["\"2,9\" has a decimal comma", "decimal points"],
    );
    // Commas for both: twelve cells where six are wanted.
    assert_refused(
        "l1,l2,l3,l4,l5,l6\n2,9,2,9,2,9,2,9,2,9,2,9\n",
        &["line 2: 12 cells", "6", "taken apart at commas", "with ;"],
    );
    // 2,900 between commas is 2.9 or 2900.
    assert_refused(
        "l1,l2,l3,l4,l5,l6\n\"2,900\",\"2,900\",\"2,900\",\"2,900\",\"2,900\",\"2,900\"\n",
        &["line 2", "\"2,900\" may be", "thousands", "decimal points"],
    );
    assert_refused(
        "l1;l2;l3;l4;l5;l6;l1\n2,9;2,9;2,9;2,9;2,9;2,9;3\n",
        &["line 1", "l1 twice, as column 1 and column 7", "keep one"],
    );
    assert_refused(
        "l1 l2 l3 l4 l5 l6\n2.9 2.9 2.9 2.9 2.9 2.9\n",
        &["line 1", "no l1", "taken apart at commas"],
    );
    assert_refused(
        "l1;l2\tl3;l4;l5;l6\n",
        &["line 1", "both tabs and semicolons", "sep=;"],
    );
    assert_refused(
        &format!("{header}2,9;2,9;2,9;2,9;2,9\n"),
        &["line 2: 5 cells", "semicolons"],
    );
}

#[test]
fn a_capture_that_a_spreadsheet_saved_holds_the_same_numbers_and_is_recorded_as_the_same() {
    let crlf = data("capture_crlf.csv");
    let recorded = crlf.replace("\r\n", "\n");
    let capture = Capture::parse("run.csv", &recorded).unwrap();
    // By eye, from the file.
    assert_eq!(capture.scans, [82171, 82172, 82173]);
    assert_eq!(capture.counts[2][..4], [32649, 47855, 32886, 32755]);
    assert_eq!(capture.counts[0][14], 32730);
    assert_eq!(capture.supply, [0.999_424_46; 3]);
    assert_eq!(capture.temperature_c, [25.254_599; 3]);
    let european = crlf.replace(',', ";").replace('.', ",");
    let mut quoted = String::from("\u{feff}");
    for line in recorded.lines() {
        quoted += &format!("\"{}\"  \r\n\r\n", line.replace(',', "\",\""));
    }
    let tabs = recorded.replace(',', "\t").replace('\n', "\t\t\n") + "\t\t\t\n";
    for text in [&recorded, &crlf, &european, &quoted, &tabs] {
        assert_eq!(Capture::parse("run.csv", text).unwrap(), capture, "{text}");
        let as_recorded = Capture::as_recorded("run.csv", text).unwrap();
        assert_eq!(as_recorded, recorded, "{text}");
    }
}

#[test]
fn a_capture_without_its_header_or_with_another_is_refused_with_the_header_that_it_must_have() {
    let text = data("capture_crlf.csv");
    let said = |text: &str| Capture::parse("run.csv", text).unwrap_err().to_string();
    let rows = text.split_once('\n').unwrap().1;
    let refused = said(rows);
    assert!(
        refused.starts_with("run.csv, line 1: the header is missing"),
        "{refused}"
    );
    assert!(
        refused.contains("put this line above") && refused.contains("scan,ax,ay"),
        "{refused}"
    );
    let refused = said(&text.replace("ey", "ex"));
    assert!(
        refused.contains("ex twice, in columns 5 and 6"),
        "{refused}"
    );
    let refused = said(&text.replace("jack3", "leg3"));
    assert!(
        refused.contains("column 13 of the header is \"leg3\" and must be \"jack3\""),
        "{refused}"
    );
}
