//! The margins of a plan as a figure: what the six jacks use of stroke, speed and acceleration, and of the angles of
//! their hinges where the geometry file limits those, against time.
//!
//! One row of panels for each run that moves, one panel for each quantity; hinges have a row of their own. All uses
//! are fractions of what there is, signed as in [`Room::fraction`], so that ±1 is the limit in every panel. The file
//! stands on its own.

use super::hinges::{Joint, Swings, swings};
use super::uses::{JACKS, JackRow, Quantity, Room, rows};
use super::{Plan, Run};
use crate::figure::curve::Point;
use crate::figure::drawing::{Anchor, Drawing, Panel, Sample};
use crate::figure::scale::Scale;
use crate::geometry_file::GeometryFile;
use crate::plan::limits::step_s;

const STYLE: &str = include_str!("margins.css");
/// Classes and labels of the jacks.
const LINES: [(&str, &str); JACKS] = [
    ("jack1", "jack 1"),
    ("jack2", "jack 2"),
    ("jack3", "jack 3"),
    ("jack4", "jack 4"),
    ("jack5", "jack 5"),
    ("jack6", "jack 6"),
];
/// Points of a curve; a panel is about 240 pixels wide.
const POINTS: usize = 600;
/// Places in the figure, pixels.
const HEAD: f64 = 62.0;
const LEFT: f64 = 56.0;
const COLUMN: f64 = 284.0;
const WIDTH: f64 = 254.0;
const ROW: f64 = 154.0;
const HEIGHT: f64 = 92.0;

/// The figure as the text of an SVG file.
#[must_use]
pub fn margins(plan: &Plan, geometry: &GeometryFile) -> String {
    let moving: Vec<&Run> = plan
        .runs
        .iter()
        .filter(|run| run.rest_s.is_none())
        .collect();
    let title = format!("What the jacks of {} use of their limits", geometry.name);
    let joints: Vec<(Joint, f64)> = Joint::ALL
        .into_iter()
        .filter_map(|joint| Some((joint, joint.limit_deg(geometry)?)))
        .collect();
    let rows_of_run = 1 + u8::from(!joints.is_empty());
    let height = HEAD + ROW * moving.len() as f64 * f64::from(rows_of_run);
    let mut drawing = Drawing::new(&title, height);
    drawing.text(LEFT, 18.0, Anchor::Start, "name", &title);
    let jacks = LINES.map(|(class, label)| (Sample::Line, class, label));
    let limit = (Sample::Line, "limit", "limit");
    drawing.legend(LEFT, 38.0, &[jacks.as_slice(), &[limit]].concat());
    for (run, row) in moving.into_iter().zip(0_u16..) {
        let top = HEAD + ROW * f64::from(row) * f64::from(rows_of_run) + 14.0;
        draw_run(&mut drawing, top, run, plan.period_s, geometry);
        draw_hinges(
            &mut drawing,
            top + ROW,
            run,
            plan.period_s,
            geometry,
            &joints,
        );
    }
    drawing.finish_alone(STYLE)
}

fn draw_run(drawing: &mut Drawing, top: f64, run: &Run, period_s: f64, geometry: &GeometryFile) {
    let time = Scale::between(0.0, run.duration_s(), 4);
    let fraction = Scale::between(-1.15, 1.15, 3);
    let room = Room::of(geometry);
    let curves = curves(run, period_s, geometry);
    for (quantity, column) in Quantity::ALL.into_iter().zip(0..) {
        let name = format!("{}: {quantity}", run.name);
        let panel = panel(drawing, (column, top), (&time, &fraction), &name);
        if room.limit(quantity, 0, 0.0).is_infinite() {
            let (x, y) = (panel.left + WIDTH / 2.0, top + HEIGHT / 2.0 - 8.0);
            let none = "no limit in the geometry file";
            drawing.text(x, y, Anchor::Middle, "none", none);
            continue;
        }
        for limit in [-1.0, 1.0] {
            drawing.level(&panel, "limit", limit);
        }
        for (points, (class, _)) in curves[quantity as usize].iter().zip(LINES) {
            drawing.line(&panel, class, points);
        }
    }
}

/// Draws an empty panel in a column, with the scales to the right and upwards.
fn panel<'a>(
    drawing: &mut Drawing,
    (column, top): (u8, f64),
    (x, y): (&'a Scale, &'a Scale),
    name: &str,
) -> Panel<'a> {
    let panel = Panel {
        left: LEFT + COLUMN * f64::from(column),
        top,
        width: WIDTH,
        height: HEIGHT,
        x,
        y,
    };
    drawing.panel(&panel, true, column == 0);
    drawing.name(&panel, name);
    drawing.x_title(&panel, "time, s");
    if column == 0 {
        drawing.y_title(&panel, 38.0, "fraction of limit");
    }
    panel
}

/// Angles of the hinges as fractions of their limits, a panel for each end of the jacks that has one.
fn draw_hinges(
    drawing: &mut Drawing,
    top: f64,
    run: &Run,
    period_s: f64,
    geometry: &GeometryFile,
    joints: &[(Joint, f64)],
) {
    if joints.is_empty() {
        return;
    }
    let time = Scale::between(0.0, run.duration_s(), 4);
    // An angle has no sign.
    let fraction = Scale::between(0.0, 1.15, 3);
    let swings: Vec<Swings> = swings(run, &geometry.geometry, step_s(run, period_s)).collect();
    let group = (swings.len() / POINTS).max(1);
    for (&(joint, limit_deg), column) in joints.iter().zip(0_u8..) {
        let name = format!("{}: angle of the {joint}s", run.name);
        let panel = panel(drawing, (column, top), (&time, &fraction), &name);
        drawing.level(&panel, "limit", 1.0);
        for (jack, (class, _)) in LINES.into_iter().enumerate() {
            let widest = |group: &[Swings]| {
                let angles = group.iter().map(|at| {
                    let angle_rad = at.angles_rad[joint as usize][jack];
                    (at.time_s, angle_rad.to_degrees() / limit_deg)
                });
                angles.max_by(|a, b| a.1.total_cmp(&b.1))
            };
            let points: Vec<Point> = swings.chunks(group).filter_map(widest).collect();
            drawing.line(&panel, class, &points);
        }
    }
}

/// Uses of the six jacks against time: length, speed, acceleration. Of a group of samples the one with the largest use
/// is kept, so that a peak of a single sample still shows.
fn curves(run: &Run, period_s: f64, geometry: &GeometryFile) -> [[Vec<Point>; JACKS]; 3] {
    let room = Room::of(geometry);
    let step_s = step_s(run, period_s);
    let group = ((run.duration_s() / step_s) as usize / POINTS).max(1);
    let mut curves: [[Vec<Point>; JACKS]; 3] = Default::default();
    let mut add = |rows: &[JackRow]| {
        for (quantity, curves) in Quantity::ALL.into_iter().zip(&mut curves) {
            for (jack, curve) in curves.iter_mut().enumerate() {
                let uses = rows.iter().map(|row| {
                    let value = row.values[quantity as usize][jack];
                    (row.time_s, room.fraction(quantity, jack, value))
                });
                curve.extend(uses.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())));
            }
        }
    };
    let mut gathered = Vec::with_capacity(group);
    for row in rows(run, geometry, step_s) {
        gathered.push(row);
        if gathered.len() == group {
            add(&gathered);
            gathered.clear();
        }
    }
    add(&gathered);
    curves
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::campaign;
    use crate::plan::uses::uses;

    #[test]
    fn the_peak_of_every_curve_is_the_use_of_the_run() {
        let geometry = GeometryFile::load("an-74tk-200").unwrap();
        let plan = campaign::plan(&geometry).unwrap();
        let run = plan.run("held-out").unwrap();
        let curves = curves(run, plan.period_s, &geometry);
        for (quantity, used) in uses(run, &geometry, plan.period_s).all() {
            let of_jack = &curves[quantity as usize][used.jack - 1];
            assert!(of_jack.len() <= 2 * POINTS);
            let peak = of_jack
                .iter()
                .fold(0.0_f64, |peak, point| peak.max(point.1.abs()));
            assert_eq!(peak, used.fraction, "{quantity}");
        }
    }

    #[test]
    fn every_moving_run_has_six_lines_in_each_panel_that_has_a_limit() {
        let mut geometry = GeometryFile::load("an-74tk-200").unwrap();
        let plan = campaign::plan(&geometry).unwrap();
        let lines = |geometry: &GeometryFile| {
            margins(&plan, geometry)
                .matches("class=\"tenths line")
                .count()
        };
        assert_eq!(lines(&geometry), 7 * 3 * 6);
        geometry.speed_max_m_s = None;
        assert_eq!(lines(&geometry), 7 * 2 * 6);
        geometry.upper_hinge_angle_max_deg = Some(40.0);
        assert_eq!(lines(&geometry), 7 * 3 * 6);
        geometry.lower_hinge_angle_max_deg = Some(40.0);
        assert_eq!(lines(&geometry), 7 * 4 * 6);
    }
}
