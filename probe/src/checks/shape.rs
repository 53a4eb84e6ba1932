//! The shape of each sensor's signal in the sine runs: its third harmonic beside that of the base.
//!
//! A sensor that clips, sticks or answers to something else makes harmonics that the base does not. Odd ones tell most: a
//! sine cut at 70 % of its amplitude has a third harmonic of 8 % of its first. Friction in the jacks gives the base itself
//! a third harmonic, so that of the pose is taken off first. With the drive Ω and the coordinate q,
//!
//! ```text
//! angular rate 3iΩ·q₃      acceleration −9Ω²·q₃      statistic = |measured₃ − base₃| / |measured₁|
//! ```
//!
//! in each channel along the driven axis. The nonlinearity of the converter leaves some parts in ten thousand.

use hexsense_core::channel::{NAMES, Triad};
use hexsense_core::excitation::DegreeOfFreedom;
use nalgebra::Complex;

use crate::analysis::AnalysisError;
use crate::analysis::assumptions::Assumptions;
use crate::analysis::check::{Check, Figure, judge};
use crate::analysis::condense::Sweep;
use crate::analysis::poses::{complex, pose_harmonics};
use crate::analysis::results::Analysis;

/// Largest third harmonic that the base does not explain, of the first.
const LIMIT: f64 = 0.02;
/// Standard deviations of the noise that are allowed beside it.
const DEVIATIONS: f64 = 5.0;

/// The check of the channels that the sine runs drive.
///
/// # Errors
/// [`AnalysisError::Pose`] and [`AnalysisError::Tolerance`].
pub fn check(assumptions: &Assumptions, analysis: &Analysis) -> Result<Check, AnalysisError> {
    let condensed = &analysis.condensed;
    let mut figures = Vec::new();
    for sweep in std::iter::once(&condensed.heave).chain(&condensed.turns) {
        let pose = pose_harmonics(sweep, assumptions)?;
        for (triad, axis) in driven(sweep.freedom) {
            let coordinate = &pose[coordinate(sweep.freedom)];
            let base = complex(&coordinate.harmonics[2]) * derivative(triad, sweep, 3);
            let first = complex(&coordinate.harmonics[0]) * derivative(triad, sweep, 1);
            figures.push(figure(analysis, sweep, (triad, axis), first, base));
        }
    }
    Ok(judge(
        "signal shape",
        "third harmonic over the first",
        figures,
        "each sensor follows the base without distortion",
        |names| {
            format!(
                "{} distorts: does it reach the end of its range (full_scale), is it loose, or does its supply break in?",
                names.join(", ")
            )
        },
    ))
}

/// The third harmonic of one channel.
fn figure(
    analysis: &Analysis,
    sweep: &Sweep,
    (triad, axis): (Triad, usize),
    first: Complex<f64>,
    base: Complex<f64>,
) -> Figure {
    let channel = triad.first_channel() + axis;
    let measured = |k: usize| complex(&sweep.sensors[channel].harmonics[k - 1]);
    // The sensor's own gain and delay, from the first harmonic: delays turn the third by three times as much.
    let answer = measured(1) / first;
    let turned = Complex::from_polar(answer.norm(), 3.0 * answer.arg());
    let left = measured(3) - base * turned;
    let density = analysis.condensed.noise[triad.index()].density[axis];
    let noise = density / sweep.length_s.sqrt();
    Figure {
        name: NAMES[channel].to_owned(),
        value: left.norm() / measured(1).norm(),
        limit: LIMIT + DEVIATIONS * noise / measured(1).norm(),
    }
}

/// The channels that a degree of freedom drives, as triad and axis.
fn driven(freedom: DegreeOfFreedom) -> Vec<(Triad, usize)> {
    match freedom {
        DegreeOfFreedom::Surge => vec![(Triad::LinearAcceleration, 0)],
        DegreeOfFreedom::Heave => vec![(Triad::LinearAcceleration, 1)],
        DegreeOfFreedom::Sway => vec![(Triad::LinearAcceleration, 2)],
        DegreeOfFreedom::Roll | DegreeOfFreedom::Yaw | DegreeOfFreedom::Pitch => {
            let axis = coordinate(freedom) - 3;
            vec![
                (Triad::AngularAcceleration, axis),
                (Triad::AngularRate, axis),
            ]
        }
    }
}

/// Place of a degree of freedom among the coordinates of a pose.
fn coordinate(freedom: DegreeOfFreedom) -> usize {
    freedom as usize
}

/// What a triad measures of a coordinate's harmonic `k`.
fn derivative(triad: Triad, sweep: &Sweep, k: u8) -> Complex<f64> {
    let rate = Complex::new(0.0, f64::from(k) * sweep.omega);
    match triad {
        Triad::AngularRate => rate,
        Triad::LinearAcceleration | Triad::AngularAcceleration => rate * rate,
    }
}
