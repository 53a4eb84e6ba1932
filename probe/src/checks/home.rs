//! The base at home before and after each run, against the zero run.
//!
//! The zero run defines the offsets, and each sine run is about home. So home must be the same place in all runs.

use hexsense_core::channel::JACKS;

use super::movements::Movements;
use super::rests::{Rest, Zero, runs_beyond};
use crate::analysis::check::{Check, Figure, jack_name, judge};

/// Largest distance of a jack at home from where it was in the zero run, of the stroke.
const OF_STROKE: f64 = 0.0005;
/// The same for a base with a short stroke, m.
const AT_LEAST_M: f64 = 0.0005;

/// Largest distance of a jack at home from where it was in the zero run, m.
pub(super) fn limit_m(movements: &Movements) -> f64 {
    (OF_STROKE * movements.stroke_m).max(AT_LEAST_M)
}

/// The check of the jacks at home.
pub(super) fn check(zero: Option<&Zero>, rests: &[Rest], limit_m: f64) -> Check {
    let pairs = rests.iter().filter_map(|rest| Some((rest, &zero?.rest)));
    let figures: Vec<(Figure, &str)> = pairs
        .flat_map(|(rest, zero)| {
            (0..JACKS).map(move |jack| {
                let figure = Figure {
                    name: jack_name(jack),
                    value: (rest.jacks_m[jack] - zero.jacks_m[jack]).abs(),
                    limit: limit_m,
                };
                (figure, rest.run)
            })
        })
        .collect();
    let runs = runs_beyond(&figures);
    judge(
        "home",
        "m",
        figures.into_iter().map(|(figure, _)| figure).collect(),
        "the base stands at the same place before and after each run",
        |names| {
            format!(
                "home moved in run {runs} ({}): see whether the servos hold the base, and repeat these runs",
                names.join(", ")
            )
        },
    )
}
