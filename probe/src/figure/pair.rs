//! Two panels over one time: curves, and below them, on a scale of its own, what lies between them.

use super::curve::{Point, Stretch};
use super::drawing::{Drawing, Panel};
use super::scale::Scale;

/// Between the two panels, pixels.
pub const GAP: f64 = 8.0;

/// Where two panels stand and what is written at them.
#[derive(Debug, Clone, Copy)]
pub struct Pair<'a> {
    /// The panel of the curves.
    pub upper: Panel<'a>,
    /// Height of the panel below, pixels.
    pub error_height: f64,
    /// Its scale upwards.
    pub error_y: &'a Scale,
    /// Name, above both.
    pub name: &'a str,
    /// Whether the time has numbers and a title; without, the pair below has.
    pub time: bool,
    /// Whether the scales upwards have numbers; without, the pair to the left has the same.
    pub numbers: bool,
    /// Unit of both and how many pixels left of the panels it stands.
    pub unit: Option<(&'a str, f64)>,
}

/// What is drawn into a panel; the first word is its class.
#[derive(Debug, Clone, Copy)]
pub enum Curve<'a> {
    /// A line.
    Line(&'a str, &'a [Point]),
    /// A band, under the lines that follow it.
    Band(&'a str, &'a [Stretch]),
}

impl Pair<'_> {
    /// Draws both panels, `curves` into the upper one, `errors` and a line at zero into the lower one.
    pub fn draw(&self, drawing: &mut Drawing, curves: &[Curve], errors: &[Curve]) {
        let upper = &self.upper;
        let lower = Panel {
            top: upper.top + upper.height + GAP,
            height: self.error_height,
            y: self.error_y,
            ..*upper
        };
        drawing.panel(upper, false, self.numbers);
        curves.iter().for_each(|curve| curve.draw(drawing, upper));
        drawing.name(upper, self.name);
        drawing.panel(&lower, self.time, self.numbers);
        let is_band = |curve: &&Curve| matches!(curve, Curve::Band(..));
        let bands = errors.iter().filter(is_band);
        bands.for_each(|band| band.draw(drawing, &lower));
        drawing.level(&lower, "", 0.0);
        let lines = errors.iter().filter(|curve| !is_band(curve));
        lines.for_each(|line| line.draw(drawing, &lower));
        if let Some((unit, distance)) = self.unit {
            drawing.y_title(upper, distance, unit);
            drawing.y_title(&lower, distance, unit);
        }
        if self.time {
            drawing.x_title(&lower, "time from the onset, s");
        }
    }
}

impl Curve<'_> {
    fn draw(&self, drawing: &mut Drawing, panel: &Panel) {
        match *self {
            Curve::Line(class, points) => drawing.line(panel, class, points),
            Curve::Band(class, stretches) => drawing.band(panel, class, stretches),
        }
    }
}
