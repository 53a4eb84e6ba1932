//! The verdict: calibrated values against the base's own pose on a movement that nothing was fitted to.

use hexsense_core::channel::{NAMES, Triad};

use super::page::{Page, row};
use super::{ReportInput, Verified, channels};
use crate::analysis::AnalysisError;
use crate::analysis::condense::Counts;
use crate::analysis::filter::zero_phase_low_pass;
use crate::analysis::held_out::{
    CORNER_HZ, ChannelVerdict, MEAN_COVERAGE, RATE_HZ, Signals, failures,
};
use crate::campaign::BoardPoses;
use crate::figure::curve::Point;
use crate::figure::drawing::{Drawing, Panel, Sample, WIDTH};
use crate::figure::markup::text;
use crate::figure::number::{align, rounded, significant};
use crate::figure::pair::{self, Curve, Pair};
use crate::figure::scale::Scale;

/// Values behind the low-pass are drawn at this rate, Hz: ten times its corner.
const DRAWN_HZ: f64 = 20.0;
const LEFT: f64 = 62.0;
const GAP: f64 = 52.0;
const TOP: f64 = 50.0;
const CURVE_HEIGHT: f64 = 104.0;
const ERROR_HEIGHT: f64 = 64.0;

/// Class and sentences of the verdict at the head of the report.
#[must_use]
pub fn verdict(input: &ReportInput) -> (&'static str, String) {
    let relative = input
        .analysis
        .results
        .channels
        .iter()
        .map(|channel| 100.0 * channel.gain.expanded_uncertainty / channel.gain.estimate.abs());
    let (low, high) = relative.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), percent| {
        (low.min(percent), high.max(percent))
    });
    let found = format!(
        "<p>Expanded uncertainty (coverage factor 2) of the nine coefficients: {} % to {} %.</p>",
        significant(low, 2),
        significant(high, 2)
    );
    let Some(verified) = input.verified else {
        let open = "<p><b>Calibrated, not yet verified.</b> <code>hexsense verify</code> records the held-out \
                    movement and completes this report.</p>";
        return ("", format!("{open}{found}"));
    };
    let failed = failures(&verified.verification.channels);
    if failed.is_empty() {
        let passed = "<p><b>Passes.</b> All nine channels pass on the held-out movement, which no coefficient was \
                      fitted to.</p>";
        return ("passes", format!("{passed}{found}"));
    }
    let failed = format!(
        "<p><b>Does not pass.</b> On the held-out movement these channels fail: {}.</p>",
        text(&failed.join(", "))
    );
    ("fails", format!("{failed}{found}"))
}

/// The section; it is left out before the movement is recorded.
///
/// # Errors
/// [`AnalysisError`] when the run has gaps or its movement is not found.
pub fn section(page: &mut Page, input: &ReportInput) -> Result<(), AnalysisError> {
    let Some(verified) = input.verified else {
        return Ok(());
    };
    page.section("Verification on the held-out movement");
    page.paragraph(&format!(
        "Run {} moves all six degrees of freedom at once, and no coefficient is fitted to it. The reference is the base's \
         own pose by the jacks, differentiated to what the sensors feel at the place that was found for them. Values and \
         reference pass the same zero-phase {CORNER_HZ} Hz low-pass, and the delay of each triad is taken out. Before: by sensitivity and offset of the \
         data sheet. After: by the coefficients stored on the board, as the board computed them. A channel passes when \
         the rms error about its mean is at most 3 % of the signal's rms, and the mean error is within its \
         uncertainty.",
        text(&verified.run.name)
    ));
    table(page, &verified.verification.channels);
    let onset_s = Counts::new(verified.run)?.onset_s(&input.campaign.geometry.geometry)?;
    for triad in Triad::ALL {
        let caption = format!(
            "{} on the held-out movement, behind the low-pass, and below each channel, the error about its mean before \
             and after calibration.",
            channels::triad_name(triad)
        );
        page.figure(&caption, &figure(&verified, triad, onset_s));
    }
    poses(page, &verified.verification.board_pose);
    Ok(())
}

/// What the board's single precision cost its own poses.
fn poses(page: &mut Page, poses: &BoardPoses) {
    let micro = |value: f64| significant(1e6 * value, 2);
    page.paragraph(&format!(
        "During the run the board also found the pose of the base from its own jack channels, {} times, in single \
         precision. From the same counts and coefficients double precision finds the same poses: the point O to {} µm \
         and the attitude to {} µrad, limits {limit} µm and {limit} µrad.",
        poses.poses,
        micro(poses.largest_m),
        micro(poses.largest_rad),
        limit = significant(1e6 * poses.limit, 1),
    ));
}

fn table(page: &mut Page, verdicts: &[ChannelVerdict]) {
    let mut body = String::new();
    for triad in Triad::ALL {
        let of_triad = verdicts.iter().filter(|verdict| {
            NAMES[triad.first_channel()..triad.first_channel() + 3].contains(&verdict.name.as_str())
        });
        body += &rows(triad, &of_triad.collect::<Vec<_>>());
    }
    let head = "<tr><th>Channel</th><th class=\"n\">Signal<small>rms</small></th>\
                <th class=\"n\">Error before<small>rms</small></th><th class=\"n\">Error after<small>rms</small></th>\
                <th class=\"n\">of signal<small>%, limit 3</small></th>\
                <th class=\"n\" colspan=\"2\">Mean error after</th><th>Verdict</th></tr>";
    page.table(
        &format!(
            "Verdicts. ± is the expanded uncertainty of the mean error, coverage factor {MEAN_COVERAGE} because nine \
             channels are judged at once."
        ),
        head,
        &body,
    );
}

fn rows(triad: Triad, verdicts: &[&ChannelVerdict]) -> String {
    let column = |cell: &dyn Fn(&ChannelVerdict) -> String| {
        let mut cells: Vec<String> = verdicts.iter().map(|verdict| cell(verdict)).collect();
        align(&mut cells);
        cells
    };
    let mean = |verdict: &ChannelVerdict| rounded(verdict.mean_error, verdict.mean_uncertainty);
    let share = |verdict: &ChannelVerdict| 100.0 * verdict.rms_error_after / verdict.rms_signal;
    let columns = [
        ("n", column(&|verdict| significant(verdict.rms_signal, 3))),
        (
            "n",
            column(&|verdict| significant(verdict.rms_error_before, 3)),
        ),
        (
            "n",
            column(&|verdict| significant(verdict.rms_error_after, 3)),
        ),
        ("n", column(&|verdict| significant(share(verdict), 2))),
        ("n", column(&|verdict| mean(verdict)[0].clone())),
        ("u", column(&|verdict| mean(verdict)[1].clone())),
    ];
    let mut rows = format!(
        "<tr><td class=\"group\" colspan=\"8\">{}, {}</td></tr>\n",
        channels::triad_name(triad),
        triad.unit()
    );
    for (index, verdict) in verdicts.iter().enumerate() {
        let (class, word) = if verdict.passes() {
            ("passes", "passes")
        } else {
            ("fails", "fails")
        };
        let mut cells = vec![("name", text(&verdict.name).to_string())];
        cells.extend(
            columns
                .iter()
                .map(|(class, column)| (*class, column[index].clone())),
        );
        cells.push((class, word.to_owned()));
        rows += &row(cells);
    }
    rows
}

/// One channel behind the low-pass, over s from the onset.
struct Comparison {
    reference: Vec<Point>,
    after: Vec<Point>,
    error_before: Vec<Point>,
    error_after: Vec<Point>,
}

impl Comparison {
    fn new(verified: &Verified, channel: usize, onset_s: f64) -> Self {
        let curves = verified.curves;
        let smooth = |values: &[f64]| zero_phase_low_pass(values, CORNER_HZ, RATE_HZ);
        let rate = f64::from(verified.run.rate_hz);
        let (start_s, step_s) = (curves.first / rate - onset_s, curves.group as f64 / rate);
        let end_s = verified.run.program.duration_s();
        let drawn = |values: &[f64]| -> Vec<Point> {
            let points = values
                .iter()
                .enumerate()
                .map(|(index, value)| (start_s + index as f64 * step_s, *value));
            let points = points.step_by((RATE_HZ / DRAWN_HZ) as usize);
            points
                .filter(|point| (0.0..=end_s).contains(&point.0))
                .collect()
        };
        let error = |values: &Signals| -> Vec<Point> {
            let pairs = values[channel].iter().zip(&curves.reference[channel]);
            let difference: Vec<f64> = pairs.map(|(value, truth)| value - truth).collect();
            about_mean(drawn(&smooth(&difference)))
        };
        Self {
            reference: drawn(&smooth(&curves.reference[channel])),
            after: drawn(&smooth(&curves.after[channel])),
            error_before: error(&curves.before),
            error_after: error(&curves.after),
        }
    }

    fn draw(&self, drawing: &mut Drawing, triad: Triad, axis: usize, x: &Scale) {
        let width = (WIDTH - LEFT - 2.0 * GAP - 4.0) / 3.0;
        let left = LEFT + axis as f64 * (width + GAP);
        let y = Scale::around(
            self.reference
                .iter()
                .chain(&self.after)
                .map(|point| point.1),
        );
        let errors = self.error_before.iter().chain(&self.error_after);
        let error_y = Scale::symmetric(errors.map(|point| point.1));
        let upper = Panel {
            left,
            top: TOP,
            width,
            height: CURVE_HEIGHT,
            x,
            y: &y,
        };
        let pair = Pair {
            upper,
            error_height: ERROR_HEIGHT,
            error_y: &error_y,
            name: NAMES[triad.first_channel() + axis],
            time: true,
            numbers: true,
            unit: (axis == 0).then_some((triad.unit(), 46.0)),
        };
        let curves = [
            Curve::Line("reference fine", &self.reference),
            Curve::Line("measured fine", &self.after),
        ];
        let errors = [
            Curve::Line("before", &self.error_before),
            Curve::Line("error", &self.error_after),
        ];
        pair.draw(drawing, &curves, &errors);
    }
}

fn about_mean(points: Vec<Point>) -> Vec<Point> {
    let mean = points.iter().map(|point| point.1).sum::<f64>() / points.len().max(1) as f64;
    points.into_iter().map(|(x, y)| (x, y - mean)).collect()
}

fn figure(verified: &Verified, triad: Triad, onset_s: f64) -> String {
    let title = format!("{} on the held-out movement", channels::triad_name(triad));
    let mut drawing = Drawing::new(&title, TOP + CURVE_HEIGHT + pair::GAP + ERROR_HEIGHT + 38.0);
    drawing.legend(
        LEFT,
        14.0,
        &[
            (Sample::Line, "reference fine", "reference"),
            (Sample::Line, "measured fine", "calibrated value"),
            (Sample::Line, "before", "error before"),
            (Sample::Line, "error", "error after"),
        ],
    );
    let x = Scale::between(0.0, verified.run.program.duration_s(), 3);
    for axis in 0..3 {
        let comparison = Comparison::new(verified, triad.first_channel() + axis, onset_s);
        comparison.draw(&mut drawing, triad, axis, &x);
    }
    drawing.finish()
}
