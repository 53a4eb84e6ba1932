//! Displacement of the jacks, calculated and registered, and their difference.
//!
//! *Calculated* is the jack program: the program's pose through inverse kinematics. *Registered* is what the
//! transducers said. Both are from mid-stroke, over the time from the onset of the movement.

use hexsense_core::channel::{INERTIAL, JACKS};
use hexsense_core::kinematics::displacements;

use super::ReportInput;
use super::page::Page;
use crate::analysis::condense::Counts;
use crate::analysis::{AnalysisError, RecordedRun};
use crate::figure::curve::{Point, Stretch, envelope, group_of, means};
use crate::figure::drawing::{Drawing, Panel, Sample, WIDTH};
use crate::figure::markup::text;
use crate::figure::number::fixed;
use crate::figure::pair::{Curve, Pair};
use crate::figure::scale::Scale;

/// Shown before the onset and after the end of a movement, s.
const AROUND_S: f64 = 0.5;
/// Points of a curve, about two for each three pixels.
const POINTS: usize = 200;
const COLUMNS: usize = 3;
const GAP: f64 = 14.0;
const LEFT: f64 = 58.0;
const TOP: f64 = 50.0;
const CURVE_HEIGHT: f64 = 104.0;
const ERROR_HEIGHT: f64 = 54.0;
const ROW_HEIGHT: f64 = CURVE_HEIGHT + ERROR_HEIGHT + 42.0;

/// One jack in one run, mm over s.
struct Track {
    calculated: Vec<Point>,
    registered: Vec<Point>,
    error: Vec<Point>,
    error_range: Vec<Stretch>,
}

/// The section: one figure for each run that moves.
///
/// # Errors
/// [`AnalysisError::Gap`].
pub fn section(page: &mut Page, input: &ReportInput) -> Result<(), AnalysisError> {
    page.section("Jack displacement, calculated and registered");
    page.paragraph(
        "Calculated displacement is the program of the motion controller: the program's pose through inverse \
         kinematics. Registered displacement is that of the transducers. The onset of a run is where the jack that \
         moves most fits its program best, so a delay that all jacks share does not show; what remains is how the \
         servos follow. Displacement is from mid-stroke.",
    );
    let condensed = &input.analysis.condensed;
    let holds = condensed
        .hold_runs
        .iter()
        .map(|run| (&run.name, run.onset_s));
    let sines = input.sweeps().map(|sweep| (&sweep.name, sweep.onset_s));
    for (name, onset_s) in holds.chain(sines) {
        let Some(run) = input.run(name) else { continue };
        let tracks = tracks(input, run, onset_s)?;
        let rms = tracks
            .each_ref()
            .map(|track| root_mean_square(&track.error));
        let caption = format!(
            "Run {}: displacement of the six jacks and, below each, registered minus calculated, as mean and range of \
             the samples that share a point. Root mean square of the mean difference, jacks 1 to 6: {} mm. The start \
             of the movement is {} s after the start of the recording.",
            text(name),
            rms.map(|rms| fixed(rms, 2)).join(", "),
            fixed(onset_s, 2),
        );
        page.figure(&caption, &figure(name, &tracks));
    }
    Ok(())
}

fn root_mean_square(points: &[Point]) -> f64 {
    let squares: f64 = points.iter().map(|point| point.1 * point.1).sum();
    (squares / points.len().max(1) as f64).sqrt()
}

fn tracks(
    input: &ReportInput,
    run: &RecordedRun,
    onset_s: f64,
) -> Result<[Track; JACKS], AnalysisError> {
    let base = &input.campaign.geometry.geometry;
    let transducers = input.campaign.sensors.transducers(base);
    let counts = Counts::new(run)?;
    let rate = f64::from(run.rate_hz);
    let scan = |time_s: f64| ((onset_s + time_s) * rate).max(0.0) as usize;
    let end = scan(run.program.duration_s() + AROUND_S).min(counts.len());
    let range = scan(-AROUND_S).min(end)..end;
    let time_s = |scan: usize| scan as f64 / rate - onset_s;
    let calculated: Vec<[f64; JACKS]> = range
        .clone()
        .map(|scan| displacements(base, &run.program.pose(base, time_s(scan))))
        .collect();
    let group = group_of(range.len(), POINTS, rate);
    Ok(std::array::from_fn(|jack| {
        let registered = counts.channel(INERTIAL + jack);
        let mm = |scan: usize| 1e3 * transducers.displacement_m(jack, registered[scan]);
        let points = |y: &dyn Fn(usize) -> f64| -> Vec<Point> {
            range.clone().map(|scan| (time_s(scan), y(scan))).collect()
        };
        let program = |scan: usize| 1e3 * calculated[scan - range.start][jack];
        let error = points(&|scan| mm(scan) - program(scan));
        Track {
            calculated: means(&points(&program), group),
            registered: means(&points(&mm), group),
            error: means(&error, group),
            error_range: envelope(&error, group),
        }
    }))
}

fn figure(name: &str, tracks: &[Track; JACKS]) -> String {
    let rows = JACKS.div_ceil(COLUMNS);
    let mut drawing = Drawing::new(
        &format!("Jack displacement in run {name}"),
        TOP + rows as f64 * ROW_HEIGHT + 14.0,
    );
    let curves = || {
        tracks
            .iter()
            .flat_map(|track| track.calculated.iter().chain(&track.registered))
    };
    let ranges = tracks.iter().flat_map(|track| &track.error_range);
    let times = || curves().map(|point| point.0);
    let x = Scale::between(
        times().fold(f64::INFINITY, f64::min),
        times().fold(f64::NEG_INFINITY, f64::max),
        3,
    );
    let y = Scale::around(curves().map(|point| point.1));
    let error_y = Scale::symmetric(ranges.flat_map(|range| [range.1, range.2]));
    drawing.legend(
        LEFT,
        14.0,
        &[
            (Sample::Line, "reference", "calculated"),
            (Sample::Line, "measured", "registered"),
            (Sample::Line, "error", "registered − calculated, mean"),
            (Sample::Band, "error-range", "range"),
        ],
    );
    let width = (WIDTH - LEFT - (COLUMNS - 1) as f64 * GAP - 4.0) / COLUMNS as f64;
    for (jack, track) in tracks.iter().enumerate() {
        let (row, column) = (jack / COLUMNS, jack % COLUMNS);
        let left = LEFT + column as f64 * (width + GAP);
        let top = TOP + row as f64 * ROW_HEIGHT;
        let upper = Panel {
            left,
            top,
            width,
            height: CURVE_HEIGHT,
            x: &x,
            y: &y,
        };
        let pair = Pair {
            upper,
            error_height: ERROR_HEIGHT,
            error_y: &error_y,
            name: &format!("jack {}", jack + 1),
            time: row + 1 == rows,
            numbers: column == 0,
            unit: (column == 0).then_some(("mm", 44.0)),
        };
        let curves = [
            Curve::Line("reference", &track.calculated),
            Curve::Line("measured", &track.registered),
        ];
        let errors = [
            Curve::Band("error-range", &track.error_range),
            Curve::Line("error", &track.error),
        ];
        pair.draw(&mut drawing, &curves, &errors);
    }
    drawing.finish()
}
