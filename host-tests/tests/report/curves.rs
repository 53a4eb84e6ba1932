//! The curves of the small campaign's figures, read back by the numbers at their axes.

use crate::page::{elements, number, parsed, words};
use crate::small::SMALL_PAGE;

/// What is drawn, in the order of drawing: its class and its values by the axis that was numbered last.
pub type Drawn = Vec<(String, Vec<f64>)>;

/// Lines and dots of the figures whose caption contains `caption`.
fn drawn(caption: &str) -> Vec<Drawn> {
    let document = parsed(&SMALL_PAGE);
    let figures = elements(&document, "figure").into_iter();
    figures
        .filter(|figure| words(*figure).contains(caption))
        .map(read)
        .collect()
}

pub fn read(figure: roxmltree::Node) -> Drawn {
    let mut axis: Vec<(f64, f64)> = Vec::new();
    let (mut whole, mut drawn) = (false, Drawn::new());
    for node in figure.descendants() {
        let is = |key: &str, value: &str| {
            node.attribute(key)
                .is_some_and(|held| held.starts_with(value))
        };
        let pixels = |key: &str| {
            node.attribute(key)
                .map(|pixels| pixels.parse::<f64>().unwrap())
        };
        if is("class", "tick") && is("text-anchor", "end") {
            if std::mem::take(&mut whole) {
                axis.clear();
            }
            // A number stands 4 pixels below its place.
            axis.push((pixels("y").unwrap() - 4.0, number(&words(node))));
        } else if is("class", "grid") {
            whole = true;
        } else if is("class", "tenths line") {
            let ys = ys(node.attribute("d").unwrap());
            let values = ys.into_iter().map(|y| value(&axis, y)).collect();
            drawn.push((node.attribute("class").unwrap()[12..].to_owned(), values));
        } else if is("class", "dot ") && !axis.is_empty() {
            let y = pixels("cy").unwrap_or_else(|| pixels("y").unwrap() + 3.0);
            drawn.push((
                node.attribute("class").unwrap().to_owned(),
                vec![value(&axis, y)],
            ));
        }
    }
    drawn
}

fn value(axis: &[(f64, f64)], pixels: f64) -> f64 {
    let (first, last) = (axis[0], axis[axis.len() - 1]);
    first.1 + (pixels - first.0) * (last.1 - first.1) / (last.0 - first.0)
}

/// Pixels down of a path that is a point and then steps in tenths, as `M0 10l10-5-5 0`.
fn ys(path: &str) -> Vec<f64> {
    let path = path.replace('-', " -").replace(['M', 'l'], " ");
    let numbers: Vec<f64> = path
        .split_whitespace()
        .map(|number| number.parse().unwrap())
        .collect();
    let steps = numbers.chunks(2).map(|step| step[1] / 10.0);
    steps
        .scan(0.0, |y, step| {
            Some({
                *y += step;
                *y
            })
        })
        .collect()
}

/// The curves of this class.
pub fn of<'a>(drawn: &'a Drawn, class: &str) -> Vec<&'a [f64]> {
    let of_class = drawn.iter().filter(|(held, _)| held == class);
    of_class.map(|(_, values)| values.as_slice()).collect()
}

fn range(values: &[f64]) -> f64 {
    let high = values
        .iter()
        .fold(f64::NEG_INFINITY, |high, value| f64::max(high, *value));
    high - values
        .iter()
        .fold(f64::INFINITY, |low, value| f64::min(low, *value))
}

#[test]
fn every_jack_stands_off_its_program_by_its_own_error_with_its_sign() {
    for (run, errors_mm) in [
        ("pitch", [0.5, -1.0, 1.5, -2.5, 3.5, 4.5]),
        ("roll", [-0.7, 1.2, 1.7, 2.2, -2.7, 3.2]),
        ("heave", [0.9, 0.8, -0.7, 0.6, -0.4, 0.3]),
        ("roll-sine", [1.1, -1.3, 1.6, 1.8, -1.9, 2.1]),
    ] {
        let figures = drawn(&format!("Run {run}: displacement"));
        let errors = of(&figures[0], "error");
        assert_eq!(errors.len(), 6);
        for (jack, (error, expected)) in errors.iter().zip(errors_mm).enumerate() {
            let near = |value: &&f64| (**value - expected).abs() < 0.1;
            assert_eq!(
                error.iter().filter(near).count(),
                error.len(),
                "{run}, {jack}: {error:?}"
            );
        }
    }
}

#[test]
fn curves_of_the_held_out_movement_are_reference_value_error_before_and_after() {
    let figures = drawn("on the held-out movement, behind the low-pass");
    assert_eq!(figures.len(), 3);
    for figure in &figures {
        // Sines of 1 and 1.1; the values before were 1.5 times the reference.
        for (class, expected) in [
            ("reference fine", 2.0),
            ("measured fine", 2.2),
            ("before", 1.0),
            ("error", 0.2),
        ] {
            let curves = of(figure, class);
            assert_eq!(curves.len(), 3);
            for curve in curves {
                assert!(
                    (range(curve) / expected - 1.0).abs() < 0.03,
                    "{class}: {}",
                    range(curve)
                );
            }
        }
    }
}

#[test]
fn command_pose_and_their_difference_are_in_millimetres_and_degrees() {
    let figures = drawn("Command and measured pose");
    let [commands, poses, errors] =
        ["reference", "measured", "error"].map(|class| of(&figures[0], class));
    // Heave: 4 s of 0.05 m at 0.5 Hz. Roll: 0.04 rad from 1.5 s to 3.5 s at 0.25 Hz, from sin 135° down to −1.
    let expected = [100.0, 0.04f64.to_degrees() * (1.0 + 0.5f64.sqrt())];
    for (index, expected) in expected.into_iter().enumerate() {
        let (command, pose, error) = (commands[index], poses[index], errors[index]);
        assert!(
            (range(command) / expected - 1.0).abs() < 0.04,
            "{}",
            range(command)
        );
        // The base stayed at home.
        assert!(
            pose.iter().all(|pose| pose.abs() < 0.02 * expected),
            "{pose:?}"
        );
        for (command, error) in command.iter().zip(error) {
            assert!(
                (command + error).abs() < 0.03 * expected,
                "{command} {error}"
            );
        }
    }
}

/// Left, top, bottom and right of a frame, drawn as `M10 20V120H300`.
fn frame(path: &str) -> [f64; 4] {
    let numbers = path
        .split(['M', ' ', 'V', 'H'])
        .filter(|part| !part.is_empty());
    let numbers: Vec<f64> = numbers.map(|part| part.parse().unwrap()).collect();
    numbers.try_into().unwrap()
}

#[test]
fn panels_stand_inside_their_figure_and_none_covers_another() {
    let document = parsed(&SMALL_PAGE);
    let mut seen = 0;
    for figure in elements(&document, "svg") {
        let size: Vec<f64> = figure
            .attribute("viewBox")
            .unwrap()
            .split(' ')
            .map(number)
            .collect();
        let paths = figure
            .descendants()
            .filter(|node| node.attribute("class") == Some("frame"));
        let frames: Vec<[f64; 4]> = paths
            .map(|path| frame(path.attribute("d").unwrap()))
            .collect();
        for (place, [left, top, bottom, right]) in frames.iter().enumerate() {
            assert!(
                0.0 <= *left && left < right && *right <= size[2],
                "{frames:?}"
            );
            assert!(
                0.0 <= *top && top < bottom && *bottom <= size[3],
                "{frames:?}"
            );
            for [other_left, other_top, other_bottom, other_right] in &frames[..place] {
                let beside = right <= other_left || left >= other_right;
                let above = bottom <= other_top || top >= other_bottom;
                assert!(beside || above, "{frames:?}");
            }
            seen += 1;
        }
    }
    assert!(seen > 20, "{seen} panels");
}

#[test]
fn errors_on_the_holds_are_dots_of_their_run_in_the_order_of_time() {
    let figures = drawn("on the 5 holds");
    // Of each axis: three holds of the first run, in the upper panel and in the lower one, then two of the second.
    let expected = [
        [2.0, -2.0, 2.0, 2.0, -2.0],
        [5.0, 5.0, -5.0, -5.0, 5.0],
        [-7.0, 7.0, 7.0, -7.0, -7.0],
    ];
    let dots: Vec<_> = figures[0]
        .iter()
        .filter(|(class, _)| class.starts_with("dot "))
        .collect();
    assert_eq!(dots.len(), 3 * 10);
    for (axis, expected) in dots.chunks(10).zip(expected) {
        let lower = axis[3..6].iter().chain(&axis[8..]);
        let classes = ["first", "first", "first", "second", "second"];
        for (((class, value), expected), run) in lower.zip(expected).zip(classes) {
            assert_eq!(class, &format!("dot {run}"));
            assert!(
                (value[0] - expected).abs() < 0.1,
                "{} for {expected}",
                value[0]
            );
        }
    }
}

#[test]
fn bars_are_the_harmonics_on_a_scale_of_decades() {
    let document = parsed(&SMALL_PAGE);
    let figures = elements(&document, "figure").into_iter();
    let mut figures =
        figures.filter(|figure| words(*figure).contains("Run heave: driven channels"));
    let figure = figures.next().unwrap();
    let of_class = |class: &'static str| {
        let nodes = figure.descendants();
        nodes.filter(move |node| {
            node.attribute("class")
                .is_some_and(|held| held.starts_with(class))
        })
    };
    let tops: Vec<f64> = of_class("bar")
        .map(|bar| bar.attribute("y").unwrap().parse().unwrap())
        .collect();
    let limit = of_class("level limit")
        .next()
        .unwrap()
        .attribute("d")
        .unwrap();
    let limit: f64 = limit.split([' ', 'H']).nth(1).unwrap().parse().unwrap();
    // 1000 and 3 counts, with an uncertainty of 1.2 counts.
    let expected = (1000.0f64 / 3.0).ln() / (3.0f64 / 1.2).ln();
    let found = (tops[1] - tops[0]) / (limit - tops[1]);
    assert!(
        (found / expected - 1.0).abs() < 0.02,
        "{found} for {expected}"
    );
}
