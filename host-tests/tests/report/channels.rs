//! The coefficients of the small campaign, cell by cell.

use crate::page::{captioned, parsed};
use crate::small::SMALL_PAGE;

#[test]
fn every_cell_of_the_nine_channels_is_that_of_its_channel_and_column() {
    let table = captioned(&parsed(&SMALL_PAGE), 1);
    assert_eq!(
        table.caption,
        "Table 1. The nine channels. ± is the expanded uncertainty U, coverage factor 2. The column 95 % is half the \
         interval that holds the true k with that probability; it is narrower where tolerances, which have an end, are \
         the largest terms. The noise density is that of the rests before the movements."
    );
    assert_eq!(
        table.head,
        "Channel | Offset u0 [counts] (2 columns) | Coefficient k (2 columns) | U(k)/k [%] | 95 % [± % of k] | \
         Sensitivity S (2 columns) | Noise density"
    );
    // S = 1/k; its U is S times U(k)/k.
    let expected = [
        "Linear acceleration: k in 10⁻⁴ m/s² per count, S in counts per m/s², noise density in 10⁻³ (m/s²)/√Hz \
         (10 columns)",
        "ax | 32100 | 12 | 5.000 | 0.010 | 0.20 | 0.18 | 2000.0 | 4.0 | 1.23",
        "ay | 32850.5 | 3.4 | 4.000 | 0.024 | 0.60 | 0.55 | 2500 | 15 | 2.34",
        "az | 33000.25 | 0.56 | 8.000 | 0.064 | 0.80 | 0.60 | 1250 | 10 | 4.56",
        "Angular acceleration: k in 10⁻⁴ rad/s² per count, S in counts per rad/s², noise density in 10⁻² (rad/s²)/√Hz \
         (10 columns)",
        "ex | 31000 | 25 | −2.0000 | 0.0020 | 0.10 | 0.090 | −5000.0 | 5.0 | 3.45",
        "ey | 31500.5 | 7.8 | 1.0000 | 0.0030 | 0.30 | 0.27 | 10000 | 30 | 5.67",
        "ez | 31999.75 | 0.91 | 2.500 | 0.010 | 0.40 | 0.34 | 4000 | 16 | 6.78",
        "Angular rate: k in 10⁻⁵ rad/s per count, S in counts per rad/s, noise density in 10⁻⁴ (rad/s)/√Hz \
         (10 columns)",
        "wx | 34000 | 40 | 1.600 | 0.016 | 1.0 | 0.90 | 62500 | 625 | 1.11",
        "wy | 34100.5 | 5.6 | 3.200 | 0.048 | 1.5 | 1.3 | 31250 | 469 | 2.22",
        "wz | 34200.25 | 0.78 | 6.40 | 0.14 | 2.2 | 1.9 | 15625 | 344 | 3.33",
    ];
    assert_eq!(table.rows, expected);
}

#[test]
fn every_element_of_the_matrices_and_every_delay_stands_in_its_place() {
    let table = captioned(&parsed(&SMALL_PAGE), 5);
    assert!(
        table.caption.starts_with("Table 5. The matrices M in full"),
        "{}",
        table.caption
    );
    assert!(table.caption.ends_with("± as above."), "{}", table.caption);
    assert_eq!(
        table.head,
        "Row | by counts of X (2 columns) | by counts of Y (2 columns) | by counts of Z (2 columns)"
    );
    let expected = [
        "Linear acceleration, 10⁻⁴ m/s² per count; 1.50 ± 0.11 ms behind the jacks (7 columns)",
        "ax | 5.000 | 0.010 | 0.0123 | 0.0011 | −0.0231 | 0.0012",
        "ay | 0.0312 | 0.0013 | 4.000 | 0.024 | 0.0132 | 0.0014",
        "az | −0.0213 | 0.0015 | 0.0321 | 0.0016 | 8.000 | 0.064",
        "Angular acceleration, 10⁻⁴ rad/s² per count; −2.30 ± 0.12 ms behind the jacks (7 columns)",
        "ex | −2.0000 | 0.0020 | 0.0141 | 0.0017 | 0.0242 | 0.0018",
        "ey | 0.0343 | 0.0019 | 1.0000 | 0.0030 | −0.0444 | 0.0021",
        "ez | 0.0545 | 0.0022 | 0.0646 | 0.0023 | 2.500 | 0.010",
        "Angular rate, 10⁻⁵ rad/s per count; 4.70 ± 0.13 ms behind the jacks (7 columns)",
        "wx | 1.600 | 0.016 | 0.151 | 0.024 | 0.252 | 0.025",
        "wy | 0.353 | 0.026 | 3.200 | 0.048 | 0.454 | 0.027",
        "wz | −0.555 | 0.028 | 0.656 | 0.029 | 6.40 | 0.14",
    ];
    assert_eq!(table.rows, expected);
}
