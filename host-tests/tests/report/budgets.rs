//! The budgets of the small campaign: two terms, 3 to 4, so that they combine to 5.

use crate::page::{Table, parsed, tables, widths};
use crate::small::SMALL_PAGE;

/// Tables of one quantity, in the order of the channels.
fn of(quantity: &str) -> Vec<Table> {
    let tables = tables(&parsed(&SMALL_PAGE)).into_iter();
    tables
        .filter(|table| table.head.ends_with(&format!("|  | {quantity}")))
        .collect()
}

fn assert_rows(quantity: &str, expected: [(&str, &str); 9]) {
    let tables = of(quantity);
    assert_eq!(tables.len(), 9);
    for (table, (channel, rows)) in tables.iter().zip(expected) {
        assert_eq!(table.head, format!("{channel} |  | {quantity}"));
        let rows: Vec<&str> = rows.split("; ").collect();
        assert_eq!(table.rows, rows, "{channel}");
    }
}

#[test]
fn terms_of_the_coefficients_their_sum_in_squares_and_twice_it() {
    assert_rows(
        "k, %",
        [
            (
                "ax",
                "clock |  | 0.080; noise |  | 0.060; dust |  | < 0.001; combined (2 columns) | 0.100; expanded, U (2 columns) | 0.200",
            ),
            (
                "ay",
                "clock |  | 0.240; noise |  | 0.180; combined (2 columns) | 0.300; expanded, U (2 columns) | 0.600",
            ),
            (
                "az",
                "clock |  | 0.320; noise |  | 0.240; combined (2 columns) | 0.400; expanded, U (2 columns) | 0.800",
            ),
            (
                "ex",
                "clock |  | 0.040; noise |  | 0.030; combined (2 columns) | 0.050; expanded, U (2 columns) | 0.100",
            ),
            (
                "ey",
                "clock |  | 0.120; noise |  | 0.090; combined (2 columns) | 0.150; expanded, U (2 columns) | 0.300",
            ),
            (
                "ez",
                "clock |  | 0.160; noise |  | 0.120; combined (2 columns) | 0.200; expanded, U (2 columns) | 0.400",
            ),
            (
                "wx",
                "clock |  | 0.400; noise |  | 0.300; combined (2 columns) | 0.500; expanded, U (2 columns) | 1.000",
            ),
            (
                "wy",
                "clock |  | 0.600; noise |  | 0.450; combined (2 columns) | 0.750; expanded, U (2 columns) | 1.500",
            ),
            (
                "wz",
                "clock |  | 0.880; noise |  | 0.660; combined (2 columns) | 1.100; expanded, U (2 columns) | 2.200",
            ),
        ],
    );
}

#[test]
fn terms_of_the_offsets_their_sum_in_squares_and_twice_it() {
    assert_rows(
        "u0, counts",
        [
            (
                "ax",
                "noise |  | 4.8; clock |  | 3.6; combined (2 columns) | 6.0; expanded, U (2 columns) | 12.0",
            ),
            (
                "ay",
                "noise |  | 1.4; clock |  | 1.0; combined (2 columns) | 1.7; expanded, U (2 columns) | 3.4",
            ),
            (
                "az",
                "noise |  | 0.2; clock |  | 0.2; combined (2 columns) | 0.3; expanded, U (2 columns) | 0.6",
            ),
            (
                "ex",
                "noise |  | 10.0; clock |  | 7.5; combined (2 columns) | 12.5; expanded, U (2 columns) | 25.0",
            ),
            (
                "ey",
                "noise |  | 3.1; clock |  | 2.3; combined (2 columns) | 3.9; expanded, U (2 columns) | 7.8",
            ),
            (
                "ez",
                "noise |  | 0.4; clock |  | 0.3; combined (2 columns) | 0.5; expanded, U (2 columns) | 0.9",
            ),
            (
                "wx",
                "noise |  | 16.0; clock |  | 12.0; combined (2 columns) | 20.0; expanded, U (2 columns) | 40.0",
            ),
            (
                "wy",
                "noise |  | 2.2; clock |  | 1.7; combined (2 columns) | 2.8; expanded, U (2 columns) | 5.6",
            ),
            (
                "wz",
                "noise |  | 0.3; clock |  | 0.2; combined (2 columns) | 0.4; expanded, U (2 columns) | 0.8",
            ),
        ],
    );
}

#[test]
fn a_bar_is_as_long_as_its_term_beside_the_largest() {
    let widths = widths(&parsed(&SMALL_PAGE));
    // The third term of ax is 0.0001 % beside 0.08 %.
    assert_eq!(widths[..3], ["100.0%", "75.0%", "0.1%"]);
    assert!(
        widths[3..]
            .chunks(2)
            .all(|pair| pair == ["100.0%", "75.0%"]),
        "{widths:?}"
    );
    assert_eq!(widths.len(), 3 + 2 * 17);
}
