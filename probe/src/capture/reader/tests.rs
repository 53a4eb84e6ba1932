use super::*;

const HEADER: &str = "scan,ax,ay,az,ex,ey,ez,wx,wy,wz,jack1,jack2,jack3,jack4,jack5,jack6,supply,temperature_c,\
                      ax_m_s2,ay_m_s2,az_m_s2,ex_rad_s2,ey_rad_s2,ez_rad_s2,wx_rad_s,wy_rad_s,wz_rad_s";
const COUNTS: std::ops::RangeInclusive<usize> = 2..=16;
const DECIMALS: std::ops::RangeInclusive<usize> = 17..=27;

/// The cells of a row; no two are alike.
fn cells(scan: u64) -> Vec<String> {
    let counts = (1_001..=1_015).map(|count| count.to_string());
    let values = (1..=9).map(|value| format!("-0.{value}"));
    let middle = ["0.998", "31.5"].map(str::to_owned);
    let first = [scan.to_string()].into_iter();
    first.chain(counts).chain(middle).chain(values).collect()
}

/// Reads a file of three rows, of which the second is changed.
fn read(change: impl FnOnce(&mut Vec<String>)) -> Result<Capture, String> {
    let mut second = cells(101);
    change(&mut second);
    let rows = [cells(100), second, cells(1 << 53)].map(|row| row.join(",") + "\n");
    let text = format!("{HEADER}\n{}", rows.concat());
    Capture::parse("run.csv", &text).map_err(|error| error.to_string())
}

/// The file with this cell in a column, from 1.
fn with(column: usize, cell: &str) -> Result<Capture, String> {
    read(|row| cell.clone_into(&mut row[column - 1]))
}

fn assert_bad(column: usize, cells: &[&str]) {
    for cell in cells {
        let error = with(column, cell).unwrap_err();
        let place = format!("run.csv, line 3: column {column}: ");
        assert!(error.starts_with(&place), "{cell}: {error}");
    }
}

#[test]
fn every_cell_is_read_into_its_own_place() {
    let capture = read(|_| {}).unwrap();
    assert_eq!(capture.scans, [100, 101, 1 << 53]);
    let counts = [
        1_001, 1_002, 1_003, 1_004, 1_005, 1_006, 1_007, 1_008, 1_009, 1_010, 1_011, 1_012, 1_013,
        1_014, 1_015,
    ];
    assert_eq!(capture.counts, [counts; 3]);
    assert_eq!(capture.supply, [0.998; 3]);
    assert_eq!(capture.temperature_c, [31.5; 3]);
    let values = [-0.1, -0.2, -0.3, -0.4, -0.5, -0.6, -0.7, -0.8, -0.9];
    assert_eq!(capture.values, Some(vec![values; 3]));
}

#[test]
fn a_count_is_a_whole_number_of_sixteen_bits() {
    for column in COUNTS {
        for (cell, count) in [("0", 0), ("65535", 65_535)] {
            assert_eq!(with(column, cell).unwrap().counts[1][column - 2], count);
        }
        let bad = ["65536", "-1", "1.5", "1e3", "nan", "inf", "", "x"];
        assert_bad(column, &bad);
    }
}

#[test]
fn supply_temperature_and_values_are_finite_numbers() {
    for column in DECIMALS {
        for cell in ["3.4028235e38", "-3.4028235e38", "0", "1e-50"] {
            with(column, cell).unwrap();
        }
        // The first number that rounds to infinity lies half of a last place above the largest.
        let beyond = ["3.4028236e38", "-3.4028236e38", "1e39"];
        let named = ["nan", "NaN", "-nan", "inf", "-inf", "infinity"];
        assert_bad(column, &beyond);
        assert_bad(column, &named);
        assert_bad(column, &["", "x", "0x10", "31.5 C"]);
    }
}

#[test]
fn a_scan_counter_is_a_whole_number_that_a_board_can_have_and_rises() {
    assert_bad(
        1,
        &[
            "9007199254740993",
            "18446744073709551615",
            "18446744073709551616",
            "-1",
            "1.5",
            "nan",
            "",
            "x",
        ],
    );
    for (scan, follows) in [("99", false), ("100", false), ("101", true), ("102", true)] {
        let read = with(1, scan);
        assert_eq!(read.is_ok(), follows, "{scan}: {read:?}");
        if let Err(error) = read {
            assert!(error.ends_with(&format!("scan {scan} does not follow scan 100")));
        }
    }
}

#[test]
fn a_row_without_a_cell_or_with_one_twice_is_refused() {
    for column in 0..27 {
        for row in [
            read(|row| drop(row.remove(column))),
            read(|row| row.insert(column, row[column].clone())),
        ] {
            let error = row.unwrap_err();
            assert!(error.starts_with("run.csv, line 3: "), "{column}: {error}");
        }
    }
    let error = read(|row| drop(row.pop())).unwrap_err();
    assert_eq!(error, "run.csv, line 3: column 27 is missing");
    let error = read(|row| row.push("0.5".to_owned())).unwrap_err();
    assert_eq!(error, "run.csv, line 3: there are more than 27 columns");
}

#[test]
fn a_header_without_a_column_or_with_one_twice_or_in_another_order_is_refused() {
    let names: Vec<&str> = HEADER.split(',').collect();
    let refused = |names: &[&str]| {
        let text = names.join(",") + "\n" + &cells(100).join(",") + "\n";
        let error = Capture::parse("run.csv", &text).unwrap_err().to_string();
        let told = error.starts_with("run.csv, line 1: ") && error.contains("the header");
        assert!(told, "{error}");
    };
    for column in 0..27 {
        let mut without = names.clone();
        without.remove(column);
        refused(&without);
        let mut twice = names.clone();
        twice.insert(column, names[column]);
        refused(&twice);
        let mut swapped = names.clone();
        swapped.swap(column, (column + 1) % 27);
        refused(&swapped);
    }
    refused(&names[..17]);
}

#[test]
fn a_capture_without_values_has_eighteen_columns_and_no_more() {
    let text = |columns: usize| {
        let names: Vec<&str> = HEADER.split(',').take(18).collect();
        names.join(",") + "\n" + &cells(100)[..columns].join(",") + "\n"
    };
    let parse = |columns| Capture::parse("run.csv", &text(columns));
    assert_eq!(parse(18).unwrap().values, None);
    let error = |columns| parse(columns).unwrap_err().to_string();
    assert_eq!(error(17), "run.csv, line 2: column 18 is missing");
    assert_eq!(error(19), "run.csv, line 2: there are more than 18 columns");
}

#[test]
fn the_last_row_is_whole_when_its_line_ends() {
    let text = format!(
        "{HEADER}\n{}\n{}",
        cells(100).join(","),
        cells(101).join(",")
    );
    assert!(Capture::parse("run.csv", &(text.clone() + "\n")).is_ok());
    let error = Capture::parse("run.csv", &text).unwrap_err().to_string();
    assert_eq!(error, "run.csv, line 3: the file is cut off here");
}
