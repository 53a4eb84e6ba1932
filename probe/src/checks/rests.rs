//! Stretches at rest: the zero run, and the rests before and after each movement.

use hexsense_core::channel::{INERTIAL, JACKS};

use super::movements::{Movement, STEP_S};
use crate::analysis::check::Figure;
use crate::analysis::noise::Scatter;

/// Rows kept off the movement at either end: 0.5 s.
const GUARD: usize = 50;
/// Least rows of a rest that is of use: 0.3 s.
const LEAST: usize = 30;
/// Rows of a mean that shows whether a sensor answers: 0.1 s, so that noise is small beside movement.
const SMOOTHED: usize = 10;

/// The zero run, and what the sensors scatter in it.
pub(super) struct Zero<'a> {
    pub(super) rest: Rest<'a>,
    pub(super) rate_hz: f64,
    /// Density of the noise, counts/√Hz.
    pub(super) density: [f64; INERTIAL],
    /// Standard deviation of means over [`SMOOTHED`] rows, counts.
    pub(super) deviation: [f64; INERTIAL],
}

/// A stretch at rest.
pub(super) struct Rest<'a> {
    pub(super) run: &'a str,
    /// Middle, s from the start of the scan counter.
    pub(super) time_s: f64,
    pub(super) length_s: f64,
    pub(super) jacks_m: [f64; JACKS],
    pub(super) sensors: [f64; INERTIAL],
}

/// What a run at rest holds; `None` when it is too short to be of use.
pub(super) fn zero_run<'a>(movement: &'a Movement) -> Option<Zero<'a>> {
    let rest = rest(movement, 0, movement.shown.len())?;
    let density = core::array::from_fn(|channel| {
        let mut scatter = Scatter::default();
        scatter.add(&movement.counts.channel(channel), movement.run.rate_hz);
        scatter.density()
    });
    Some(Zero {
        rest,
        rate_hz: f64::from(movement.run.rate_hz),
        density,
        deviation: core::array::from_fn(|channel| deviation(movement, channel)),
    })
}

/// Standard deviation of a sensor's means over [`SMOOTHED`] rows in a run, counts.
pub(super) fn deviation(movement: &Movement, channel: usize) -> f64 {
    let scans = SMOOTHED as f64 * STEP_S * f64::from(movement.run.rate_hz);
    let means: Vec<f64> = movement
        .counts
        .scans()
        .chunks_exact((scans.round() as usize).max(1))
        .map(|scans| scans.iter().map(|scan| scan[channel]).sum::<f64>() / scans.len() as f64)
        .collect();
    let count = means.len().max(1) as f64;
    let mean = means.iter().sum::<f64>() / count;
    let squares = means.iter().map(|value| (value - mean).powi(2));
    (squares.sum::<f64>() / count).sqrt()
}

/// The rests before and after the movement of a run.
pub(super) fn rests<'a>(movement: &'a Movement) -> Vec<Rest<'a>> {
    let Some(during) = &movement.during else {
        return Vec::new();
    };
    let before = rest(movement, 0, during.start.saturating_sub(GUARD));
    let after = rest(movement, during.end + GUARD, movement.shown.len());
    before.into_iter().chain(after).collect()
}

fn rest<'a>(movement: &'a Movement, from: usize, to: usize) -> Option<Rest<'a>> {
    let rows = movement
        .shown
        .get(from..to)
        .filter(|rows| rows.len() >= LEAST)?;
    let jacks_m = core::array::from_fn(|jack| {
        rows.iter().map(|row| row[jack]).sum::<f64>() / rows.len() as f64
    });
    let rate_hz = f64::from(movement.run.rate_hz);
    let scan = |row: usize| (row as f64 * STEP_S * rate_hz).round() as usize;
    let scans = movement.counts.scans().get(scan(from)..scan(to))?;
    let sensors = core::array::from_fn(|channel| {
        scans.iter().map(|scan| scan[channel]).sum::<f64>() / scans.len() as f64
    });
    let start = movement
        .run
        .capture
        .scans
        .first()
        .map_or(0.0, |scan| *scan as f64 / rate_hz);
    Some(Rest {
        run: &movement.run.name,
        time_s: start + (from + to) as f64 / 2.0 * STEP_S,
        length_s: rows.len() as f64 * STEP_S,
        jacks_m,
        sensors,
    })
}

/// Names of the runs with a figure beyond its limit, the worst first.
pub(super) fn runs_beyond(figures: &[(Figure, &str)]) -> String {
    let mut beyond: Vec<_> = figures
        .iter()
        .filter(|(figure, _)| figure.share() > 1.0)
        .collect();
    beyond.sort_by(|(a, _), (b, _)| b.share().total_cmp(&a.share()));
    let mut runs: Vec<&str> = Vec::new();
    for (_, run) in beyond {
        if !runs.contains(run) {
            runs.push(run);
        }
    }
    runs.join(", ")
}
