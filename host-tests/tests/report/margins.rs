//! The margins of the small campaign's plan, as `hexsense plan` draws them.

use hexsense_probe::geometry_file::GeometryFile;
use hexsense_probe::plan::Run;
use hexsense_probe::plan::margins::margins;

use crate::curves::{of, read};
use crate::page::{elements, parsed, words};
use crate::small::SMALL;
use crate::small::recordings::lengths;

const STEP_S: f64 = 0.002;

/// Least and greatest stroke, speed and acceleration of each jack: lengths by the formula, their differences in time.
fn extremes(run: &Run, base: &GeometryFile) -> [[(f64, f64); 6]; 3] {
    let program = run.program();
    let last = (program.duration_s() / STEP_S).round() as usize;
    let at = |row: usize| lengths(base, program.displacement(row as f64 * STEP_S));
    let rows: Vec<[f64; 6]> = (0..=last).map(at).collect();
    let mut found = [[(0.0, 0.0); 6]; 3];
    for three in rows.windows(3) {
        for jack in 0..6 {
            let [before, now, after] = [three[0][jack], three[1][jack], three[2][jack]];
            let values = [
                now - 2.75,
                (after - before) / (2.0 * STEP_S),
                (after - 2.0 * now + before) / (STEP_S * STEP_S),
            ];
            for (found, value) in found.iter_mut().zip(values) {
                let (low, high) = found[jack];
                found[jack] = (f64::min(low, value), f64::max(high, value));
            }
        }
    }
    found
}

#[test]
fn every_jacks_curve_goes_as_far_as_its_stroke_speed_and_acceleration() {
    let mut base = SMALL.campaign.geometry.clone();
    (base.speed_max_m_s, base.acceleration_max_m_s2) = (Some(0.3), Some(0.5));
    let mut plan = SMALL.campaign.plan.clone();
    plan.runs
        .retain(|run| run.name == "roll" || run.name == "held-out");
    let figure = margins(&plan, &base);
    let document = parsed(&figure);
    let drawn = read(document.root());
    // Home is in the middle of 1.3 m of stroke.
    let limits = [0.65, 0.3, 0.5];
    for (place, run) in plan.runs.iter().enumerate() {
        for ((quantity, of_jacks), limit) in extremes(run, &base).iter().enumerate().zip(limits) {
            for (jack, (low, high)) in (1..).zip(of_jacks) {
                let curves = of(&drawn, &format!("jack{jack}"));
                assert_eq!(curves.len(), 2 * 3);
                let curve = curves[3 * place + quantity].iter().copied();
                let ends = [
                    curve.clone().fold(f64::INFINITY, f64::min),
                    curve.fold(f64::NEG_INFINITY, f64::max),
                ];
                for (found, expected) in ends.into_iter().zip([low / limit, high / limit]) {
                    let what = format!(
                        "{}, jack {jack}, {quantity}: {found} for {expected}",
                        run.name
                    );
                    assert!((found - expected).abs() < 0.01, "{what}");
                }
            }
        }
    }
}

#[test]
fn panels_are_named_by_run_and_quantity_and_their_axis_by_what_it_is_a_fraction_of() {
    let figure = margins(&SMALL.campaign.plan, &SMALL.campaign.geometry);
    let document = parsed(&figure);
    let texts: Vec<String> = elements(&document, "text").into_iter().map(words).collect();
    assert_eq!(texts[0], "What the jacks of base seven use of their limits");
    let expected = [
        "pitch",
        "roll",
        "heave",
        "roll-sine",
        "together",
        "lift",
        "held-out",
    ]
    .into_iter()
    .flat_map(|run| {
        ["length", "speed", "acceleration"].map(|quantity| format!("{run}: {quantity}"))
    });
    let named = texts.iter().filter(|text| text.contains(": ")).cloned();
    assert!(named.eq(expected), "{texts:?}");
    assert_eq!(
        texts
            .iter()
            .filter(|text| *text == "fraction of limit")
            .count(),
        7
    );
}
