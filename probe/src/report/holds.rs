//! The accelerometers on the holds: mean counts against the specific force that the pose says, with the fit.

use hexsense_core::calibration::triad::MeasuredHold;
use hexsense_core::channel::{NAMES, Triad};

use super::ReportInput;
use super::page::Page;
use crate::analysis::AnalysisError;
use crate::analysis::assumptions::Assumptions;
use crate::figure::curve::Point;
use crate::figure::drawing::{Drawing, Panel, Sample, WIDTH};
use crate::figure::markup::text;
use crate::figure::number::fixed;
use crate::figure::scale::Scale;

const LEFT: f64 = 66.0;
const GAP: f64 = 62.0;
const TOP: f64 = 50.0;
const FIT_HEIGHT: f64 = 190.0;
const ERROR_TOP: f64 = TOP + FIT_HEIGHT + 56.0;
const ERROR_HEIGHT: f64 = 90.0;

/// The section.
///
/// # Errors
/// [`AnalysisError::Pose`] and [`AnalysisError::Tolerance`].
pub fn section(page: &mut Page, input: &ReportInput) -> Result<(), AnalysisError> {
    page.section("Accelerometers on the holds");
    page.paragraph(
        "On each hold, after settling, the pose from the jacks gives the true specific force: gravity in body axes. \
         The holds before the movement, at home, are among them. The vertical accelerometer feels little change of \
         gravity on a tilted base; most of what is known of its sensitivity comes from the heave sine.",
    );
    let condensed = &input.analysis.condensed;
    let assumptions = Assumptions::new(&input.campaign.geometry, &input.campaign.sensors);
    let holds = condensed.holds(&assumptions)?;
    let names: Vec<&str> = condensed
        .hold_runs
        .iter()
        .map(|run| run.name.as_str())
        .collect();
    let axes: [Axis; 3] = std::array::from_fn(|axis| Axis::new(input, &holds, axis));
    let caption = format!(
        "Mean counts on the {} holds against true specific force (the part that the other two axes contribute is \
         taken out), with the fitted line; below, calibrated value minus true value in the order of time. Each run has an offset \
         of its own in the fit, because a bias wanders between runs; here all are compared with the offset of the zero \
         run. \
         Root mean square of the differences: {}.",
        holds.len(),
        (0..3)
            .map(|axis| format!("{} {} mm/s²", NAMES[axis], fixed(axes[axis].rms(), 2)))
            .collect::<Vec<_>>()
            .join(", "),
    );
    page.figure(&text(&caption).to_string(), &figure(&axes, &names));
    Ok(())
}

/// One accelerometer: the holds of each run.
struct Axis {
    /// True specific force, m/s², and counts.
    fits: [Vec<Point>; 2],
    /// Number of the hold in the order of time, and error of the value, mm/s².
    errors: [Vec<Point>; 2],
    /// Counts at zero force and counts per m/s².
    line: (f64, f64),
}

impl Axis {
    fn new(input: &ReportInput, holds: &[MeasuredHold], axis: usize) -> Self {
        let triad = Triad::LinearAcceleration.index();
        let fit = &input.analysis.estimate.fits[triad];
        let offset = &input.analysis.estimate.offsets[triad];
        let own = fit.sensitivity[(axis, axis)];
        let (mut fits, mut errors) = <([Vec<Point>; 2], [Vec<Point>; 2])>::default();
        for (number, hold) in (1..).zip(holds) {
            let (truth, run) = (hold.truth[axis], hold.run.min(1));
            let all = (fit.sensitivity.row(axis) * hold.truth)[0];
            fits[run].push((truth, hold.counts[axis] - (all - own * truth)));
            let value = (fit.matrix * (hold.counts - offset))[axis];
            errors[run].push((f64::from(number), 1e3 * (value - truth)));
        }
        Self {
            fits,
            errors,
            line: (offset[axis], own),
        }
    }

    fn rms(&self) -> f64 {
        let errors = || self.errors.iter().flatten();
        let squares: f64 = errors().map(|point| point.1 * point.1).sum();
        (squares / errors().count().max(1) as f64).sqrt()
    }
}

fn figure(axes: &[Axis; 3], names: &[&str]) -> String {
    let mut drawing = Drawing::new(
        "Accelerometers on the holds",
        ERROR_TOP + ERROR_HEIGHT + 40.0,
    );
    let label = |run: usize| names.get(run).copied().unwrap_or_default().to_owned();
    let (first, second) = (format!("run {}", label(0)), format!("run {}", label(1)));
    drawing.legend(
        LEFT,
        14.0,
        &[
            (Sample::Dot, "first", &first),
            (Sample::Square, "second", &second),
            (Sample::Line, "reference", "fit"),
        ],
    );
    let width = (WIDTH - LEFT - 2.0 * GAP - 4.0) / 3.0;
    let errors = axes.iter().flat_map(|axis| axis.errors.iter().flatten());
    let error_y = Scale::symmetric(errors.map(|point| point.1));
    let holds = axes[0].errors.iter().map(Vec::len).sum::<usize>();
    let order = Scale::between(0.4, holds as f64 + 0.6, 3);
    for (index, axis) in axes.iter().enumerate() {
        let points = || axis.fits.iter().flatten();
        let x = Scale::around(points().map(|point| point.0));
        let y = Scale::around(points().map(|point| point.1));
        let left = LEFT + index as f64 * (width + GAP);
        let upper = Panel {
            left,
            top: TOP,
            width,
            height: FIT_HEIGHT,
            x: &x,
            y: &y,
        };
        let lower = Panel {
            top: ERROR_TOP,
            height: ERROR_HEIGHT,
            x: &order,
            y: &error_y,
            ..upper
        };
        drawing.panel(&upper, true, true);
        let ends = points()
            .map(|point| point.0)
            .fold(None, |ends: Option<Point>, force| {
                let (low, high) = ends.unwrap_or((force, force));
                Some((low.min(force), high.max(force)))
            });
        if let Some((low, high)) = ends {
            let on_line = |force: f64| (force, axis.line.0 + axis.line.1 * force);
            drawing.line(&upper, "reference", &[on_line(low), on_line(high)]);
        }
        drawing.panel(&lower, true, true);
        drawing.level(&lower, "", 0.0);
        for (run, (class, square)) in [("first", false), ("second", true)].into_iter().enumerate() {
            drawing.dots(&upper, class, square, &axis.fits[run]);
            drawing.dots(&lower, class, square, &axis.errors[run]);
        }
        drawing.name(&upper, NAMES[index]);
        drawing.x_title(&upper, "true specific force, m/s²");
        drawing.x_title(&lower, "hold, in the order of time");
        if index == 0 {
            drawing.y_title(&upper, 54.0, "counts");
            drawing.y_title(&lower, 54.0, "error, mm/s²");
        }
    }
    drawing.finish()
}
