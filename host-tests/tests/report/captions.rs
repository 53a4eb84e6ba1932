//! Captions of the figures, the place of the sensors, and the order of the small campaign's page.

use crate::page::{captioned, elements, of_section, parsed, words};
use crate::small::SMALL_PAGE;

fn captions() -> Vec<String> {
    let document = parsed(&SMALL_PAGE);
    elements(&document, "figcaption")
        .into_iter()
        .map(words)
        .collect()
}

/// The numbers that stand between `before` and `after`.
fn numbers(caption: &str, before: &str, after: &str) -> Vec<f64> {
    let inside = caption
        .split_once(before)
        .unwrap()
        .1
        .split_once(after)
        .unwrap()
        .0;
    inside
        .split(", ")
        .map(|number| number.parse().unwrap())
        .collect()
}

#[test]
fn sections_stand_in_their_order() {
    let document = parsed(&SMALL_PAGE);
    let titles: Vec<String> = elements(&document, "h2").into_iter().map(words).collect();
    let expected = [
        "1Coefficients",
        "2Conditions",
        "3Checks of the bench",
        "4Verification on the held-out movement",
        "5Matrices and delays",
        "6Uncertainty budgets",
        "7Jack displacement, calculated and registered",
        "8Accelerometers on the holds",
        "9The place of the sensor block",
        "10Sensor signals and fitted harmonics",
        "11The board's own estimate",
        "12The motion system: a first look",
    ];
    assert_eq!(titles, expected);
    let contents: Vec<String> = elements(&document, "li").into_iter().map(words).collect();
    assert!(
        contents
            .iter()
            .zip(expected)
            .all(|(title, expected)| expected.ends_with(title.as_str()))
    );
    let links: Vec<&str> = elements(&document, "a")
        .iter()
        .filter_map(|a| a.attribute("href"))
        .collect();
    assert_eq!(links[10], "#section-11");
}

#[test]
fn the_error_of_every_jack_and_the_onset_of_every_run_are_in_their_caption() {
    // What each jack was recorded off its program, without sign; transducers and converter round to 0.01 mm.
    let expected = [
        ("pitch", [0.5, 1.0, 1.5, 2.5, 3.5, 4.5], "1.75"),
        ("roll", [0.7, 1.2, 1.7, 2.2, 2.7, 3.2], "2.25"),
        ("heave", [0.9, 0.8, 0.7, 0.6, 0.4, 0.3], "1.25"),
        ("roll-sine", [1.1, 1.3, 1.6, 1.8, 1.9, 2.1], "1.50"),
    ];
    let captions = captions();
    let of_jacks: Vec<_> = captions
        .iter()
        .filter(|caption| caption.contains("displacement of the six jacks"))
        .collect();
    assert_eq!(of_jacks.len(), expected.len());
    for (caption, (run, errors_mm, onset_s)) in of_jacks.into_iter().zip(expected) {
        assert!(
            caption.contains(&format!(" Run {run}: displacement")),
            "{caption}"
        );
        let shown = numbers(caption, "jacks 1 to 6: ", " mm");
        assert_eq!(shown.len(), 6);
        for (shown, expected) in shown.iter().zip(errors_mm) {
            assert!((shown - expected).abs() < 0.0101, "{caption}");
        }
        assert!(
            caption.contains(&format!("is {onset_s} s after the start of the recording.")),
            "{caption}"
        );
    }
}

#[test]
fn the_accelerometers_errors_on_the_holds_are_those_of_their_axes() {
    let captions = captions();
    let caption = captions
        .iter()
        .find(|caption| caption.contains("on the 5 holds"))
        .unwrap();
    assert!(
        caption.ends_with(
            "Root mean square of the differences: ax 2.00 mm/s², ay 5.00 mm/s², az 7.00 mm/s²."
        ),
        "{caption}"
    );
}

#[test]
fn driven_channels_have_their_amplitude_uncertainty_and_residual() {
    let captions = captions();
    let of = |run: &str| {
        let start = format!("Run {run}: driven channels");
        captions
            .iter()
            .find(|caption| caption.contains(&start))
            .unwrap()
    };
    let heave = of("heave");
    assert!(
        heave.contains("at 0.50100 Hz, 6.0 s of estimate.")
            && heave.contains(
                "of the residuals: ay 1000.0 ± 1.2 counts, residuals 34.5 counts. To the right"
            ),
        "{heave}"
    );
    let roll = of("roll-sine");
    assert!(
        roll.contains("at 0.25050 Hz, 8.0 s of estimate.")
            && roll.contains(
                ": ex 500.00 ± 0.34 counts, residuals 7.89 counts; wx 1300.0 ± 5.6 counts, residuals 0.912 counts. To"
            ),
        "{roll}"
    );
}

#[test]
fn the_place_of_the_sensors_is_told_by_file_and_as_found() {
    let document = parsed(&SMALL_PAGE);
    let table = captioned(&document, 6);
    assert!(
        table
            .caption
            .contains("from O in body axes, mm: by the sensor file"),
        "{}",
        table.caption
    );
    assert_eq!(
        table.head,
        "Axis | Sensor file (2 columns) | Found (2 columns)"
    );
    let expected = [
        "X | 400 | 30 | 412.3 | 4.5",
        "Y | −250 | 30 | −261.1 | 5.6",
        "Z | 100 | 30 | 87.70 | 0.67",
    ];
    assert_eq!(table.rows, expected);
    let table = captioned(&document, 7);
    assert!(
        table
            .caption
            .contains("specific force at the sensor block, m/s²;"),
        "{}",
        table.caption
    );
    assert_eq!(
        table.head,
        "Sine run | Channel | Predicted | Measured | Difference | u | Limit | "
    );
    let expected = [
        "roll | ax | 0.0101 | 0.0112 | 0.0023 | 0.0004 | 0.0056 | agrees",
        "roll | ay | 0.0201 | 0.0222 | 0.0078 | 0.0005 | 0.0067 | differs",
        "yaw | az | 0.0301 | 0.0332 | 0.0089 | 0.0006 | 0.0091 | agrees",
    ];
    assert_eq!(table.rows, expected);
    let section = of_section(&SMALL_PAGE, "The place of the sensor block");
    assert!(
        section.contains("Warning: roll sine, ay: something does not fit."),
        "{section}"
    );
    assert!(
        section.contains("or up to what 50 mm would make."),
        "{section}"
    );
}
