//! The board's own estimate in the small campaign. What the board summed are sines of known amplitude on jacks and
//! sensors, and a scatter of ±10 counts from block to block.

use crate::page::{captioned, number, parsed};
use crate::small::SMALL_PAGE;

fn assert_near(cell: &str, expected: f64, relative: f64) {
    let found = number(cell);
    assert!(
        (found / expected - 1.0).abs() <= relative,
        "{found} for {expected}"
    );
}

fn rows(table: usize) -> Vec<Vec<String>> {
    let table = captioned(&parsed(&SMALL_PAGE), table);
    let cells = |row: &String| row.split(" | ").map(str::to_owned).collect();
    table.rows.iter().map(cells).collect()
}

#[test]
fn board_and_host_stand_side_by_side_in_counts_at_nominal_supply() {
    let table = captioned(&parsed(&SMALL_PAGE), 8);
    assert!(
        table
            .caption
            .contains("at nominal supply. ± is the standard uncertainty"),
        "{}",
        table.caption
    );
    assert_eq!(
        table.head,
        "Run | Channel | Board [counts] (2 columns) | Host [counts] (2 columns) | Board − host [%]"
    );
    // Host: what the sweeps hold. Board: the amplitude of the recording, ± 10·√(2/blocks) and up to 7 % more for the
    // drift. Blocks of 16 have no scatter but that of rounding.
    let expected = [
        (
            "heave",
            "ay",
            1010.0,
            Some(10.0 * f64::sqrt(2.0 / 750.0)),
            "1000.0 | 1.2",
        ),
        ("roll-sine", "ex", 520.0, None, "500.00 | 0.34"),
        ("roll-sine", "wx", 1290.0, None, "1300.0 | 5.6"),
    ];
    let rows = rows(8);
    assert_eq!(rows.len(), expected.len());
    for (row, (run, channel, board, uncertainty, host)) in rows.iter().zip(expected) {
        assert_eq!((row[0].as_str(), row[1].as_str()), (run, channel));
        assert_near(&row[2], board, 1e-3);
        if let Some(uncertainty) = uncertainty {
            assert_near(&row[3], 1.035 * uncertainty, 0.04);
        }
        assert_eq!(row[4..6].join(" | "), host);
        let host = number(&row[4]);
        assert!(
            (number(&row[6]) - 100.0 * (board / host - 1.0)).abs() < 0.05,
            "{row:?}"
        );
    }
}

#[test]
fn factors_are_the_movement_by_the_jacks_over_the_sensors_counts() {
    let table = captioned(&parsed(&SMALL_PAGE), 9);
    assert_eq!(
        table.head,
        "Run | Channel | Jacks [unit] | Sensor [counts] | Jacks / sensor [unit per count] | Fitted [unit per count] | \
         Difference [%] | Unit"
    );
    // A(2πf)² and A·2πf: 0.05 m at 0.5 Hz, 4° = 0.0698132 rad at 0.25 Hz. The fitted gains are those of table 1.
    let expected = [
        (
            "heave",
            "ay",
            0.493_480,
            1010.0,
            "0.00040000",
            4.0e-4,
            "m/s²",
        ),
        (
            "roll-sine",
            "ex",
            0.172_257,
            520.0,
            "0.00020000",
            2.0e-4,
            "rad/s²",
        ),
        (
            "roll-sine",
            "wx",
            0.109_662,
            1290.0,
            "0.000016000",
            1.6e-5,
            "rad/s",
        ),
    ];
    let rows = rows(9);
    assert_eq!(rows.len(), expected.len());
    for (row, (run, channel, truth, counts, fitted, gain, unit)) in rows.iter().zip(expected) {
        assert_eq!((row[0].as_str(), row[1].as_str()), (run, channel));
        assert_near(&row[2], truth, 2e-3);
        assert_near(&row[3], counts, 1e-3);
        assert_near(&row[4], truth / counts, 3e-3);
        assert_eq!(row[5], fitted);
        let difference = 100.0 * (truth / counts / gain - 1.0);
        assert!(
            (number(&row[6]) - difference).abs() < 0.6,
            "{row:?} {difference}"
        );
        assert_eq!(row[7], unit);
    }
}

#[test]
fn a_replay_is_identical_different_or_not_in_the_capture() {
    let table = captioned(&parsed(&SMALL_PAGE), 10);
    assert_eq!(
        table.head,
        "Run | Drive [Hz] | Block [scans] | Blocks | First scan | Replay"
    );
    let expected = [
        "heave | 0.5000 | 8 | 750 | 56256 | identical",
        "roll-sine | 0.2500 | 16 | 1000 | 83040 | different",
        "held-out | 0.1250 | 16 | 1000 | 9 | not in the capture",
    ];
    assert_eq!(table.rows, expected);
}
