//! A figure as SVG: panels with axes, and lines, bands, dots and bars in them.
//!
//! Places are in pixels of the page's column, [`WIDTH`] wide, from the upper left corner. How things look is decided
//! by class names in `style.css`.

use std::fmt::Write as _;

use super::curve::{Point, Stretch};
use super::markup::text;
use super::path::path;
use super::scale::Scale;

/// Width of every figure, pixels.
pub const WIDTH: f64 = 900.0;

/// A figure that grows by what is drawn.
pub struct Drawing {
    height: f64,
    title: String,
    body: String,
}

/// A field with two scales.
#[derive(Debug, Clone, Copy)]
pub struct Panel<'a> {
    /// Left edge, pixels.
    pub left: f64,
    /// Upper edge, pixels.
    pub top: f64,
    /// Width, pixels.
    pub width: f64,
    /// Height, pixels.
    pub height: f64,
    /// Scale to the right.
    pub x: &'a Scale,
    /// Scale upwards.
    pub y: &'a Scale,
}

impl Panel<'_> {
    fn right(&self) -> f64 {
        self.left + self.width
    }

    fn bottom(&self) -> f64 {
        self.top + self.height
    }

    fn at(&self, (x, y): Point) -> Point {
        (
            self.left + self.x.place(x) * self.width,
            self.bottom() - self.y.place(y) * self.height,
        )
    }
}

/// Where a text is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// At its first letter.
    Start,
    /// At its middle.
    Middle,
    /// At its last letter.
    End,
}

impl Drawing {
    /// An empty figure; `title` is what a screen reader says.
    #[must_use]
    pub fn new(title: &str, height: f64) -> Self {
        Self {
            height,
            title: title.to_owned(),
            body: String::new(),
        }
    }

    /// The figure as an `svg` element.
    #[must_use]
    pub fn finish(self) -> String {
        format!(
            "<svg viewBox=\"0 0 {WIDTH} {:.0}\" role=\"img\"><title>{}</title>{}</svg>\n",
            self.height,
            text(&self.title),
            self.body
        )
    }

    /// The figure as a file of its own, with its style (CSS): any browser shows it.
    #[must_use]
    pub fn finish_alone(self, style: &str) -> String {
        let alone = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"900\" ";
        let styled = format!("<style>{style}</style></svg>");
        let figure = self.finish();
        figure
            .replacen("<svg ", alone, 1)
            .replacen("</svg>", &styled, 1)
    }

    /// Frame, grid and ticks of a panel; labels of ticks only where asked for.
    pub fn panel(&mut self, panel: &Panel, label_x: bool, label_y: bool) {
        let (left, right, top, bottom) = (panel.left, panel.right(), panel.top, panel.bottom());
        let mut grid = String::new();
        for (place, label) in panel.x.ticks() {
            let x = left + place * panel.width;
            let _ = write!(grid, "M{x:.1} {top:.1}V{bottom:.1}");
            if label_x {
                self.text(x, bottom + 15.0, Anchor::Middle, "tick", &label);
            }
        }
        for (place, label) in panel.y.ticks() {
            let y = bottom - place * panel.height;
            let _ = write!(grid, "M{left:.1} {y:.1}H{right:.1}");
            if label_y {
                self.text(left - 6.0, y + 4.0, Anchor::End, "tick", &label);
            }
        }
        let _ = write!(
            self.body,
            "<path class=\"grid\" d=\"{grid}\"/><path class=\"frame\" d=\"M{left:.1} {top:.1}V{bottom:.1}H{right:.1}\"/>"
        );
    }

    /// A line of text.
    pub fn text(&mut self, x: f64, y: f64, anchor: Anchor, class: &str, content: &str) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let _ = write!(
            self.body,
            "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\"{anchor}>{}</text>",
            text(content)
        );
    }

    /// The name of a panel, above it.
    pub fn name(&mut self, panel: &Panel, name: &str) {
        self.text(panel.left, panel.top - 7.0, Anchor::Start, "name", name);
    }

    /// What a panel's y axis is, written upwards `distance` pixels left of it.
    pub fn y_title(&mut self, panel: &Panel, distance: f64, content: &str) {
        let (x, y) = (panel.left - distance, panel.top + panel.height / 2.0);
        let _ = write!(
            self.body,
            "<text class=\"axis\" text-anchor=\"middle\" transform=\"translate({x:.1} {y:.1}) rotate(-90)\">{}</text>",
            text(content)
        );
    }

    /// What a panel's x axis is, under its ticks.
    pub fn x_title(&mut self, panel: &Panel, content: &str) {
        let middle = panel.left + panel.width / 2.0;
        self.text(
            middle,
            panel.bottom() + 31.0,
            Anchor::Middle,
            "axis",
            content,
        );
    }

    /// A curve through `points`.
    pub fn line(&mut self, panel: &Panel, class: &str, points: &[Point]) {
        let path = path(points.iter().map(|point| panel.at(*point)));
        self.tenths(&format!("line {class}"), &path);
    }

    /// A filled band.
    pub fn band(&mut self, panel: &Panel, class: &str, stretches: &[Stretch]) {
        let upper = stretches.iter().map(|(x, _, high)| panel.at((*x, *high)));
        let lower = stretches.iter().map(|(x, low, _)| panel.at((*x, *low)));
        let path = path(upper.chain(lower.rev()));
        self.tenths(&format!("band {class}"), &path);
    }

    fn tenths(&mut self, class: &str, path: &str) {
        let _ = write!(
            self.body,
            "<path class=\"tenths {class}\" transform=\"scale(.1)\" d=\"{path}\"/>"
        );
    }

    /// A straight line across the panel at `y`.
    pub fn level(&mut self, panel: &Panel, class: &str, y: f64) {
        let (_, y) = panel.at((0.0, y));
        let (left, right) = (panel.left, panel.right());
        let _ = write!(
            self.body,
            "<path class=\"level {class}\" d=\"M{left:.1} {y:.1}H{right:.1}\"/>"
        );
    }

    /// A dot at each point: round, or square where `square`.
    pub fn dots(&mut self, panel: &Panel, class: &str, square: bool, points: &[Point]) {
        for point in points {
            let (x, y) = panel.at(*point);
            self.dot(x, y, class, square);
        }
    }

    /// A dot at a place of the figure.
    pub fn dot(&mut self, x: f64, y: f64, class: &str, square: bool) {
        let _ = if square {
            let (left, top) = (x - 3.0, y - 3.0);
            write!(
                self.body,
                "<rect class=\"dot {class}\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"6\" height=\"6\"/>"
            )
        } else {
            write!(
                self.body,
                "<circle class=\"dot {class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.3\"/>"
            )
        };
    }

    /// A straight line between two places of the figure.
    pub fn segment(&mut self, class: &str, from: Point, to: Point) {
        let _ = write!(
            self.body,
            "<path class=\"{class}\" d=\"M{:.1} {:.1}L{:.1} {:.1}\"/>",
            from.0, from.1, to.0, to.1
        );
    }

    /// A bar from the panel's foot up to `point`, `width` pixels wide.
    pub fn bar(&mut self, panel: &Panel, class: &str, width: f64, point: Point) {
        let (x, y) = panel.at(point);
        let (left, height) = (x - width / 2.0, panel.bottom() - y);
        let _ = write!(
            self.body,
            "<rect class=\"bar {class}\" x=\"{left:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
        );
    }

    /// Samples of classes with what they stand for, side by side from `left` on.
    pub fn legend(&mut self, left: f64, y: f64, entries: &[(Sample, &str, &str)]) {
        let mut x = left;
        for (sample, class, label) in entries {
            let (end, middle, top) = (x + 24.0, y - 4.0, y - 8.5);
            let _ = match sample {
                Sample::Line => write!(
                    self.body,
                    "<path class=\"sample {class}\" d=\"M{x:.1} {middle:.1}H{end:.1}\"/>"
                ),
                Sample::Band => write!(
                    self.body,
                    "<rect class=\"band {class}\" x=\"{x:.1}\" y=\"{top:.1}\" width=\"24\" height=\"9\"/>"
                ),
                Sample::Dot | Sample::Square => {
                    self.dot(x + 18.0, middle, class, *sample == Sample::Square);
                    Ok(())
                }
            };
            self.text(end + 6.0, y, Anchor::Start, "key", label);
            x = end + 28.0 + label.chars().map(letter_width).sum::<f64>();
        }
    }
}

/// Width of a letter of the legend, pixels: Helvetica at 12 pixels, rounded up.
fn letter_width(letter: char) -> f64 {
    match letter {
        'i' | 'j' | 'l' | 't' | 'f' | 'r' | ' ' | ',' | '.' | '(' | ')' => 3.7,
        'm' | 'w' | 'M' | 'W' => 10.0,
        _ => 6.7,
    }
}

/// What stands before an entry of a legend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sample {
    /// A line.
    Line,
    /// A band.
    Band,
    /// A round dot.
    Dot,
    /// A square dot.
    Square,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_title_of_an_axis_stands_left_of_the_middle_of_its_panel() {
        let scale = Scale::between(0.0, 1.0, 3);
        let panel = Panel {
            left: 80.0,
            top: 30.0,
            width: 400.0,
            height: 200.0,
            x: &scale,
            y: &scale,
        };
        let mut drawing = Drawing::new("figure", 300.0);
        drawing.y_title(&panel, 50.0, "m/s²");
        let middle = "transform=\"translate(30.0 130.0) rotate(-90)\">m/s²</text>";
        assert!(drawing.body.ends_with(middle), "{}", drawing.body);
    }

    #[test]
    fn entries_of_a_legend_stand_side_by_side_with_room_for_their_letters() {
        let mut drawing = Drawing::new("figure", 300.0);
        let entries = [
            (Sample::Line, "a", "milliwatt"),
            (Sample::Band, "b", "xyz"),
            (Sample::Line, "c", ""),
        ];
        drawing.legend(10.0, 14.0, &entries);
        // m and w are 10 pixels wide, i, l and t 3.7, a and the others 6.7; 52 pixels are beside the letters.
        let second = 10.0 + 52.0 + 2.0 * 10.0 + 6.0 * 3.7 + 6.7;
        let third = second + 52.0 + 3.0 * 6.7;
        for place in [
            "M10.0 10.0H34.0".to_owned(),
            format!("<rect class=\"band b\" x=\"{second:.1}\""),
            format!("M{third:.1} 10.0"),
        ] {
            assert!(drawing.body.contains(&place), "{place}: {}", drawing.body);
        }
    }
}
