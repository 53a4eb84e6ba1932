//! Every jack against its own program.
//!
//! A servo follows its program with a constant gain, a lag and an inertia:
//!
//! ```text
//! x(t) = x₀ + g·p(t) + d·ṗ(t) + e·p̈(t) + r(t)        p: program, from mid-stroke; x: what the transducer shows
//! ```
//!
//! The gain g comes from one fit over all runs: they differ in frequency and have holds, so that g, d and e are told
//! apart. It is one within what transducer and servo promise together. The residual r comes from a fit of each run,
//! because the start of a run is known to half a row only, which is in d. A residual as large as 0.1 % of the stroke is
//! a step, a slip or a stick. Two jacks whose plugs are exchanged each follow the other's program.
//!
//! Only the board's copy of the displacement is checked here. An error of a transducer that the servo reads too moves the
//! base and leaves its reading as the program is.

use hexsense_core::channel::JACKS;
use hexsense_core::least_squares::NormalEquations;
use nalgebra::Vector4;

use super::movements::{Movement, Movements, STEP_S};
use crate::analysis::check::{Check, Figure, Verdict, jack_name, judge};
use crate::analysis::onset::most_moved;

/// Largest deviation of a jack's gain from one: several times what a displacement transducer (0.05 %), the converter
/// (0.1 %) and a servo at rest (0.1 %) promise.
const GAIN_LIMIT: f64 = 0.01;
/// Largest residual, of the stroke. Friction and the lags that the fit does not know leave a tenth of it.
const RESIDUAL_OF_STROKE: f64 = 0.001;
/// Largest residual of a base with a short stroke, m.
const RESIDUAL_M: f64 = 0.001;
/// Least correlation of a jack with a program that it follows.
const FOLLOWS: f64 = 0.9;

/// How one jack follows the program of one jack.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Following {
    gain: f64,
    /// Correlation of what was shown with what was fitted.
    correlation: f64,
}

impl Following {
    fn is_good(&self) -> bool {
        self.correlation >= FOLLOWS && self.gain > 0.0
    }
}

/// The checks of the jacks.
pub fn checks(movements: &Movements) -> Vec<Check> {
    let movement = right_programs(movements);
    if movement.verdict == Verdict::Fail {
        return vec![movement];
    }
    let followings: Vec<Option<Following>> = (0..JACKS)
        .map(|jack| follow(movements, jack, jack))
        .collect();
    vec![
        movement,
        follows(movements, &followings),
        gains(&followings),
        residuals(movements, &followings),
    ]
}

/// Whether half of the jacks that a run moves follow its program: a jack or two may be at fault, more are not.
fn right_programs(movements: &Movements) -> Check {
    let moving = movements
        .runs
        .iter()
        .filter(|movement| !movement.program.is_empty());
    let figures = moving.map(|movement| Figure {
        name: movement.run.name.clone(),
        value: astray(movement),
        limit: 0.5,
    });
    judge(
        "movement",
        "of the moving jacks",
        figures.collect(),
        "the base made the movement of each run",
        |names| {
            format!(
                "the base did not make the movement of {}: was the right program loaded, and do geometry file and base \
                 belong together?",
                names.join(", ")
            )
        },
    )
}

/// Share of the jacks that a run moves, at least half as far as the one that it moves most, which do not follow.
fn astray(movement: &Movement) -> f64 {
    let moving = most_moved(&movement.program);
    let follows =
        |jack: &&usize| following(|| rows(movement, **jack, **jack)).is_some_and(|f| f.is_good());
    1.0 - moving.iter().filter(follows).count() as f64 / moving.len() as f64
}

/// Whether each jack follows its program at all, and if not, whose program it follows.
fn follows(movements: &Movements, followings: &[Option<Following>]) -> Check {
    let figures = followings.iter().enumerate().map(|(jack, following)| {
        let correlation = following.map_or(0.0, |f| f.correlation * f.gain.signum());
        Figure {
            name: jack_name(jack),
            value: 1.0 - correlation,
            limit: 1.0 - FOLLOWS,
        }
    });
    judge(
        "jacks follow",
        "1 − correlation",
        figures.collect(),
        "each jack follows its own program",
        |names| explained(movements, names),
    )
}

/// Why the jacks of these names do not follow.
fn explained(movements: &Movements, names: &[String]) -> String {
    let jacks = (0..JACKS).filter(|jack| names.contains(&jack_name(*jack)));
    let causes = jacks.map(|jack| {
        let name = jack_name(jack);
        let best = (0..JACKS)
            .filter_map(|other| Some((other, follow(movements, jack, other)?)))
            .max_by(|(_, a), (_, b)| a.correlation.total_cmp(&b.correlation));
        match best {
            None => format!("{name} does not move: is it connected?"),
            Some((_, best)) if best.correlation < FOLLOWS => format!(
                "{name} follows no program: is it connected, and was the right program loaded?"
            ),
            Some((other, best)) if other == jack && best.gain < 0.0 => {
                format!("{name} moves the wrong way: its transducer is inverted")
            }
            Some((other, _)) => format!(
                "{name} follows the program of {}: are their plugs exchanged?",
                jack_name(other)
            ),
        }
    });
    causes.collect::<Vec<_>>().join("; ")
}

fn gains(followings: &[Option<Following>]) -> Check {
    let figures = followings
        .iter()
        .enumerate()
        .filter_map(|(jack, following)| {
            let following = following.filter(Following::is_good)?;
            Some(Figure {
                name: jack_name(jack),
                value: (following.gain - 1.0).abs(),
                limit: GAIN_LIMIT,
            })
        });
    let figures: Vec<Figure> = figures.collect();
    let all = figures.len();
    judge(
        "jack gain",
        "relative",
        figures,
        "each jack moves as far as it is told",
        |names| {
            if names.len() == all {
                "all jacks move too far or not far enough: full_stroke_volts in [jacks] of the sensor file, the stroke in \
                 the geometry file, or the scale of the motion controller is wrong"
                    .to_owned()
            } else {
                format!(
                    "{} shows another displacement than it is told to make: calibrate or replace its transducer",
                    names.join(", ")
                )
            }
        },
    )
}

fn residuals(movements: &Movements, followings: &[Option<Following>]) -> Check {
    let limit = (RESIDUAL_OF_STROKE * movements.stroke_m).max(RESIDUAL_M);
    let good = (0..JACKS).filter(|jack| followings[*jack].is_some_and(|f| f.is_good()));
    let mut found: Vec<(Figure, &str)> = good
        .flat_map(|jack| {
            movements.runs.iter().filter_map(move |movement| {
                let figure = Figure {
                    name: jack_name(jack),
                    value: residual_m(movement, jack)?,
                    limit,
                };
                Some((figure, movement.run.name.as_str()))
            })
        })
        .collect();
    found.sort_by(|(a, _), (b, _)| b.value.total_cmp(&a.value));
    let run_of = |name: &String| {
        let found = found.iter().find(|(figure, _)| figure.name == *name);
        found.map_or("", |(_, run)| *run)
    };
    let figures = found.iter().map(|(figure, _)| figure.clone()).collect();
    judge(
        "jack residual",
        "m",
        figures,
        "no jack steps, slips or sticks",
        |names| {
            let places = names
                .iter()
                .map(|name| format!("{name} in run {}", run_of(name)));
            let places = places.collect::<Vec<_>>().join(", ");
            let cause = if names.len() > JACKS / 2 {
                "most jacks leave their programs: was the right program loaded"
            } else {
                "a jack leaves its program: does its transducer slip, or is its plug loose"
            };
            format!("{cause}? Repeat the run ({places})")
        },
    )
}

/// A row of a fit: the columns of a program, and what a jack showed, m.
type Row = (Vector4<f64>, f64);

/// Rows of a run: the program of `other` and what `jack` showed.
fn rows<'a>(movement: &'a Movement, jack: usize, other: usize) -> impl Iterator<Item = Row> + 'a {
    let during = movement.during.clone().unwrap_or(0..0);
    let shown = movement.shown.get(during).unwrap_or_default();
    let rows = shown.iter().enumerate();
    rows.map(move |(row, shown)| (columns(&movement.program, row, other), shown[jack]))
}

fn fit(rows: impl Iterator<Item = Row>) -> Option<Vector4<f64>> {
    let mut equations = NormalEquations::<4>::default();
    rows.for_each(|(columns, shown)| equations.add(&columns, shown, 1.0));
    equations.solve().map(|solution| solution.unknowns)
}

/// Fits what `jack` showed in all runs to the program of `other`; `None` when it did not move.
fn follow(movements: &Movements, jack: usize, other: usize) -> Option<Following> {
    let runs = || movements.runs.iter();
    following(|| runs().flat_map(move |movement| rows(movement, jack, other)))
}

/// How rows follow the program in their columns; `None` when nothing moves.
fn following<R: Iterator<Item = Row>>(rows: impl Fn() -> R) -> Option<Following> {
    let unknowns = fit(rows())?;
    let mean = rows().map(|(_, shown)| shown).sum::<f64>() / rows().count() as f64;
    let (mut squares, mut left) = (0.0, 0.0);
    for (columns, shown) in rows() {
        squares += (shown - mean).powi(2);
        left += (shown - columns.dot(&unknowns)).powi(2);
    }
    (squares > 0.0).then(|| Following {
        gain: unknowns[1],
        correlation: (1.0 - left / squares).max(0.0).sqrt(),
    })
}

/// Largest residual of a jack in a run, m; `None` when the run does not determine its fit.
fn residual_m(movement: &Movement, jack: usize) -> Option<f64> {
    let unknowns = fit(rows(movement, jack, jack))?;
    let residuals =
        rows(movement, jack, jack).map(|(columns, shown)| (shown - columns.dot(&unknowns)).abs());
    Some(residuals.fold(0.0, f64::max))
}

/// One, the program, its speed and its acceleration in a row.
fn columns(program: &[[f64; JACKS]], row: usize, jack: usize) -> Vector4<f64> {
    let at = |row: usize| {
        program
            .get(row)
            .or(program.last())
            .map_or(0.0, |row| row[jack])
    };
    let (before, now, after) = (at(row.saturating_sub(1)), at(row), at(row + 1));
    Vector4::new(
        1.0,
        now,
        (after - before) / (2.0 * STEP_S),
        (after - 2.0 * now + before) / (STEP_S * STEP_S),
    )
}
