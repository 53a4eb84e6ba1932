//! Sensor signals of the sine runs with the fitted harmonics, what the fit leaves, and the harmonics themselves.

use hexsense_core::channel::{INERTIAL, NAMES};
use hexsense_core::harmonics::Harmonics;

use super::ReportInput;
use super::page::Page;
use crate::analysis::AnalysisError;
use crate::analysis::condense::{Counts, Sweep};
use crate::figure::curve::{Point, Stretch, envelope, group_of, means};
use crate::figure::drawing::{Drawing, Panel, Sample, WIDTH};
use crate::figure::markup::text;
use crate::figure::number::{fixed, rounded, significant};
use crate::figure::pair::{self, Curve, Pair};
use crate::figure::scale::Scale;

/// Points of a curve.
const POINTS: usize = 400;
const LEFT: f64 = 66.0;
const TOP: f64 = 50.0;
const SIGNAL_WIDTH: f64 = 560.0;
const SIGNAL_HEIGHT: f64 = 124.0;
const RESIDUAL_HEIGHT: f64 = 64.0;
const BARS_LEFT: f64 = LEFT + SIGNAL_WIDTH + 66.0;
const BARS_WIDTH: f64 = WIDTH - BARS_LEFT - 4.0;
const ROW_HEIGHT: f64 = SIGNAL_HEIGHT + RESIDUAL_HEIGHT + 76.0;

/// Channels that a degree of freedom drives, as indices of a scan: its accelerometer, or its angular accelerometer
/// and its gyro.
#[must_use]
pub fn driven(sweep: &Sweep) -> Vec<usize> {
    match sweep.freedom as usize {
        axis @ 0..3 => vec![axis],
        rotation => vec![rotation, rotation + 3],
    }
}

/// The section: one figure for each sine run.
///
/// # Errors
/// [`AnalysisError::Gap`].
pub fn section(page: &mut Page, input: &ReportInput) -> Result<(), AnalysisError> {
    page.section("Sensor signals and fitted harmonics");
    page.paragraph(
        "Each signal is fitted by an offset, a drift and five harmonics of the drive frequency, over the stretch of a \
         sine run in which transients have died away. Only the first harmonic enters the coefficients. Residuals \
         hold what is no harmonic: noise, structural vibration, mains. Means are over whole periods of the mains, ranges \
         from the least sample to the greatest.",
    );
    for sweep in input.sweeps() {
        let Some(run) = input.run(&sweep.name) else {
            continue;
        };
        let counts = Counts::new(run)?;
        let rate = f64::from(run.rate_hz);
        let traces: Vec<Trace> = driven(sweep)
            .into_iter()
            .filter(|channel| *channel < INERTIAL)
            .map(|channel| Trace::new(sweep, channel, &counts.channel(channel), rate))
            .collect();
        let amplitudes: Vec<String> = traces.iter().map(Trace::amplitude).collect();
        let caption = format!(
            "Run {}: driven channels at {} Hz, {} s of estimate. First harmonic (± standard uncertainty by the \
             residuals) and root mean square of the residuals: {}. To the right the harmonics with the standard \
             uncertainty of an amplitude as a dashed line.",
            text(&sweep.name),
            fixed(sweep.omega / std::f64::consts::TAU, 5),
            fixed(sweep.length_s, 1),
            amplitudes.join("; "),
        );
        page.figure(&caption, &figure(sweep, &traces));
    }
    Ok(())
}

/// One channel over the estimate, counts over s from the onset.
struct Trace<'a> {
    channel: usize,
    fit: &'a Harmonics,
    signal: Vec<Stretch>,
    fitted: Vec<Point>,
    residual: Vec<Point>,
    residual_range: Vec<Stretch>,
}

impl<'a> Trace<'a> {
    fn new(sweep: &'a Sweep, channel: usize, counts: &[f64], rate_hz: f64) -> Self {
        let fit = &sweep.sensors[channel];
        let length = (sweep.length_s * rate_hz).round() as usize;
        let window = counts.iter().skip(sweep.first).take(length);
        let (mut signal, mut fitted, mut residual) = (Vec::new(), Vec::new(), Vec::new());
        for (scan, count) in window.enumerate() {
            let time_s = (sweep.first + scan) as f64 / rate_hz - sweep.onset_s;
            let place = (scan as f64 + 0.5) / length as f64 - 0.5;
            let value = value(fit, sweep.omega * scan as f64 / rate_hz, place);
            signal.push((time_s, *count));
            fitted.push((time_s, value));
            residual.push((time_s, count - value));
        }
        let group = group_of(signal.len(), POINTS, rate_hz);
        Self {
            channel,
            fit,
            signal: envelope(&signal, group),
            fitted: means(&fitted, group),
            residual_range: envelope(&residual, group),
            residual: means(&residual, group),
        }
    }

    fn amplitude(&self) -> String {
        let [value, uncertainty] = rounded(
            self.fit.first().amplitude(),
            self.fit.uncertainty.amplitude[0],
        );
        format!(
            "{} {value} ± {uncertainty} counts, residuals {} counts",
            NAMES[self.channel],
            significant(self.fit.residual_rms, 3)
        )
    }
}

/// A fitted signal at phase `theta` of the drive, rad, and `place` in the window, −½ to ½.
pub(super) fn value(fit: &Harmonics, theta: f64, place: f64) -> f64 {
    let harmonics = (1..).zip(&fit.harmonics).map(|(k, harmonic)| {
        let (sine, cosine) = (f64::from(k) * theta).sin_cos();
        harmonic.cosine * cosine + harmonic.sine * sine
    });
    fit.offset + fit.drift * place + harmonics.sum::<f64>()
}

fn figure(sweep: &Sweep, traces: &[Trace]) -> String {
    let height = TOP + traces.len() as f64 * ROW_HEIGHT - 28.0;
    let mut drawing = Drawing::new(&format!("Sensor signals in run {}", sweep.name), height);
    drawing.legend(
        LEFT,
        14.0,
        &[
            (Sample::Band, "raw", "signal, range"),
            (Sample::Line, "measured", "fit"),
            (Sample::Line, "error", "residual, mean"),
            (Sample::Band, "error-range", "range"),
        ],
    );
    for (index, trace) in traces.iter().enumerate() {
        trace.draw(&mut drawing, TOP + index as f64 * ROW_HEIGHT);
    }
    drawing.finish()
}

impl Trace<'_> {
    fn draw(&self, drawing: &mut Drawing, top: f64) {
        let ends = |stretches: &[Stretch]| -> Vec<f64> {
            stretches
                .iter()
                .flat_map(|stretch| [stretch.1, stretch.2])
                .collect()
        };
        let start_s = self.signal.first().map_or(0.0, |stretch| stretch.0);
        let end_s = self.signal.last().map_or(0.0, |stretch| stretch.0);
        let x = Scale::between(start_s, end_s, 4);
        let (y, residual_y) = (
            Scale::around(ends(&self.signal)),
            Scale::symmetric(ends(&self.residual_range)),
        );
        let upper = Panel {
            left: LEFT,
            top,
            width: SIGNAL_WIDTH,
            height: SIGNAL_HEIGHT,
            x: &x,
            y: &y,
        };
        let pair = Pair {
            upper,
            error_height: RESIDUAL_HEIGHT,
            error_y: &residual_y,
            name: NAMES[self.channel],
            time: true,
            numbers: true,
            unit: Some(("counts", 54.0)),
        };
        let curves = [
            Curve::Band("raw", &self.signal),
            Curve::Line("measured", &self.fitted),
        ];
        let residuals = [
            Curve::Band("error-range", &self.residual_range),
            Curve::Line("error", &self.residual),
        ];
        pair.draw(drawing, &curves, &residuals);
        self.draw_harmonics(drawing, top);
    }

    fn draw_harmonics(&self, drawing: &mut Drawing, top: f64) {
        let amplitudes = self.fit.harmonics.map(|harmonic| harmonic.amplitude());
        let uncertainty = self.fit.uncertainty.amplitude[0];
        let x = Scale::between(0.4, amplitudes.len() as f64 + 0.6, 5);
        let y = Scale::decades(amplitudes.into_iter().chain([uncertainty]));
        let panel = Panel {
            left: BARS_LEFT,
            top,
            width: BARS_WIDTH,
            height: SIGNAL_HEIGHT + pair::GAP + RESIDUAL_HEIGHT,
            x: &x,
            y: &y,
        };
        drawing.panel(&panel, true, true);
        for (k, amplitude) in (1..).zip(amplitudes) {
            let class = if k == 1 { "" } else { "overtone" };
            drawing.bar(&panel, class, 0.11 * BARS_WIDTH, (f64::from(k), amplitude));
        }
        if uncertainty > 0.0 {
            drawing.level(&panel, "limit", uncertainty);
        }
        drawing.x_title(&panel, "harmonic of the drive");
        drawing.y_title(&panel, 42.0, "amplitude, counts");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hexsense_core::harmonics::Series;

    #[test]
    fn the_drawn_fit_is_the_signal_that_was_fitted() {
        let omega = 0.0031;
        let signal: Vec<f64> = (0..6000)
            .map(|n| {
                let theta = omega * f64::from(n);
                32_768.0
                    + 0.02 * f64::from(n)
                    + 5e3 * (theta - 0.4).cos()
                    + 30.0 * (3.0 * theta).sin()
            })
            .collect();
        let fit = Series::fit(omega, &signal).unwrap();
        for (n, sample) in signal.iter().enumerate() {
            let place = (n as f64 + 0.5) / 6000.0 - 0.5;
            assert!(
                (value(&fit, omega * n as f64, place) - sample).abs() < 1e-6,
                "sample {n}"
            );
        }
    }
}
