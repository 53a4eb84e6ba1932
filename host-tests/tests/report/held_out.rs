//! The held-out movement of the small campaign: verdict, table, poses and curves.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use hexsense_probe::analysis::held_out::{Signals, compare};
use hexsense_probe::report::render;

use crate::page::{captioned, elements, of_section, parsed, words};
use crate::small::{SMALL_PAGE, evidence, numbers};

#[test]
fn before_after_share_mean_and_verdict_of_every_channel_stand_in_their_columns() {
    let table = captioned(&parsed(&SMALL_PAGE), 4);
    assert_eq!(
        table.caption,
        "Table 4. Verdicts. ± is the expanded uncertainty of the mean error, coverage factor 3 because nine channels \
         are judged at once."
    );
    assert_eq!(
        table.head,
        "Channel | Signal [rms] | Error before [rms] | Error after [rms] | of signal [%, limit 3] | \
         Mean error after (2 columns) | Verdict"
    );
    // 0.016 of 0.4 is 4 %; 0.00062 is more than its uncertainty.
    let expected = [
        "Linear acceleration, m/s² (8 columns)",
        "ax | 1.23 | 0.456 | 0.0123 | 1.0 | −0.0021 | 0.0045 | passes",
        "ay | 2.50 | 0.310 | 0.0500 | 2.0 | 0.0032 | 0.0054 | passes",
        "az | 3.60 | 0.720 | 0.0900 | 2.5 | 0.0043 | 0.0063 | passes",
        "Angular acceleration, rad/s² (8 columns)",
        "ex | 0.500 | 0.0234 | 0.00600 | 1.2 | 0.0011 | 0.0019 | passes",
        "ey | 0.400 | 0.0345 | 0.0160 | 4.0 | −0.0012 | 0.0018 | fails",
        "ez | 0.800 | 0.0567 | 0.00400 | 0.50 | 0.0013 | 0.0017 | passes",
        "Angular rate, rad/s (8 columns)",
        "wx | 0.0500 | 0.00678 | 0.000700 | 1.4 | 0.00021 | 0.00031 | passes",
        "wy | 0.0600 | 0.00789 | 0.000900 | 1.5 | −0.00022 | 0.00032 | passes",
        "wz | 0.0700 | 0.00891 | 0.00140 | 2.0 | 0.00062 | 0.00051 | fails",
    ];
    assert_eq!(table.rows, expected);
    assert!(SMALL_PAGE.contains("Run held-out moves all six degrees of freedom"));
}

#[test]
fn the_head_says_which_channels_fail_and_the_range_of_uncertainties() {
    let verdict = |html: &str| {
        let document = parsed(html);
        let verdicts = elements(&document, "div").into_iter();
        let verdict = verdicts.map(|div| (div.attribute("class").unwrap_or_default(), words(div)));
        let verdict = verdict.filter(|(class, _)| class.starts_with("verdict"));
        let [(class, text)] = verdict.collect::<Vec<_>>().try_into().unwrap();
        (class.to_owned(), text)
    };
    let range =
        "Expanded uncertainty (coverage factor 2) of the nine coefficients: 0.10 % to 2.2 %.";
    let (class, text) = verdict(&SMALL_PAGE);
    assert_eq!(class, "verdict fails");
    assert!(
        text.starts_with("Does not pass. On the held-out movement these channels fail: ey, wz.")
            && text.contains(range),
        "{text}"
    );

    let mut small = evidence();
    let channels = &mut small.verification.channels;
    (channels[4].rms_error_after, channels[8].mean_error) = (0.01, 0.0004);
    let (class, text) = verdict(&render(&small.verified()).unwrap());
    assert_eq!(class, "verdict passes");
    assert!(
        text.starts_with("Passes. All nine channels pass") && text.contains(range),
        "{text}"
    );

    let (class, text) = verdict(&render(&small.unverified()).unwrap());
    assert_eq!(class, "verdict ");
    assert!(
        text.starts_with("Calibrated, not yet verified. hexsense verify records")
            && text.contains(range),
        "{text}"
    );
}

#[test]
fn the_boards_poses_are_told_in_micrometres_and_microradians() {
    let poses = of_section(&SMALL_PAGE, "Verification on the held-out movement");
    assert!(
        poses.contains("from its own jack channels, 1886 times,")
            && poses.contains(
                "the point O to 0.25 µm and the attitude to 0.11 µrad, limits 0.5 µm and 0.5 µrad."
            ),
        "{poses}"
    );
}

/// Channel c swings by `size`·(c + 1) with a period of 10 s about `mean`·(c + 1): 20 s, and 1.5 s at each end that are
/// left out.
fn signals(size: f64, mean: f64) -> Signals {
    std::array::from_fn(|channel| {
        let swing = |n: i32| (TAU * (f64::from(n) / 100.0 - 1.5) / 10.0).sin();
        (0..2_300)
            .map(|n| (channel + 1) as f64 * (size * swing(n) + mean))
            .collect()
    })
}

#[test]
fn signal_error_and_mean_are_judged_by_their_own_channel_and_values() {
    let (reference, before, after) = (signals(1.0, 3.0), signals(1.5, 9.0), signals(1.1, 3.02));
    let results = numbers::results();
    let verdicts = compare(&reference, &after, &before, &results, 100.0);
    assert_eq!(verdicts.len(), 9);
    for (index, (verdict, result)) in verdicts.iter().zip(&results.channels).enumerate() {
        assert_eq!((&verdict.name, &verdict.unit), (&result.name, &result.unit));
        let scale = (index + 1) as f64;
        // White noise over 23 s; the value at rest by 0.001, its walk by 0.002·√100 s.
        let white = result.noise_density / 46f64.sqrt();
        let mean_uncertainty =
            3.0 * (white * white + (scale * 0.001).powi(2) + (scale * 0.02).powi(2)).sqrt();
        for (found, expected) in [
            (verdict.rms_signal, scale * FRAC_1_SQRT_2),
            (verdict.rms_error_before, 0.5 * scale * FRAC_1_SQRT_2),
            (verdict.rms_error_after, 0.1 * scale * FRAC_1_SQRT_2),
            (verdict.mean_error, 0.02 * scale),
            (verdict.mean_uncertainty, mean_uncertainty),
        ] {
            assert!(
                (found / expected - 1.0).abs() < 2e-3,
                "{verdict:?}: {found} for {expected}"
            );
        }
    }
}
