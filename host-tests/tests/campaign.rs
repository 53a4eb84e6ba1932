//! Whole campaigns on the twin, without a chip: the results hold, and so do their uncertainties.

use host_tests::coverage::{Coverage, coverage};

/// Enough to see a wrong sign, a forgotten term or a doubled one; `cargo xtask coverage` is the whole statistic.
const CAMPAIGNS: u64 = 20;

fn figures() -> Coverage {
    coverage(CAMPAIGNS, 1, || ())
}

#[test]
fn gains_are_right_to_half_a_percent_and_their_uncertainties_neither_too_small_nor_padded() {
    let figures = figures();
    let gains: Vec<_> = figures
        .coefficients
        .iter()
        .filter(|c| c.name.ends_with(".gain"))
        .collect();
    assert_eq!(gains.len(), 9);
    for gain in &gains {
        let limit = if gain.name == "ay.gain" || gain.name.starts_with('e') {
            0.01
        } else {
            0.005
        };
        assert!(gain.worst_error < limit, "{gain:?}");
    }
    let mean = |of: fn(&host_tests::coverage::Coefficient) -> f64| {
        gains.iter().map(|gain| of(gain)).sum::<f64>() / gains.len() as f64
    };
    let (coverage, median) = (
        mean(|gain| gain.coverage),
        mean(|gain| gain.median_error_over_u),
    );
    assert!((0.90..=0.99).contains(&coverage), "{coverage}: {gains:?}");
    assert!((0.2..=0.5).contains(&median), "{median}: {gains:?}");
    for offset in figures
        .coefficients
        .iter()
        .filter(|c| c.name.ends_with(".offset"))
    {
        assert!(offset.coverage >= 0.8, "{offset:?}");
    }
}
