//! The motion base at home, seen from above and from the right: which jack is number 1, how the numbers run, and where
//! the axes point. A part of the report, and a page of its own with the numbers.

use hexsense_core::kinematics::inverse;
use nalgebra::Vector3;

use crate::figure::curve::Point;
use crate::figure::drawing::{Anchor, Drawing, WIDTH};
use crate::figure::number::fixed;
use crate::geometry_file::GeometryFile;

const STYLE: &str = include_str!("base_figure.css");
/// Room of one view, pixels.
const ROOM: (f64, f64) = (370.0, 260.0);
const TOP: f64 = 44.0;
/// Where the views end.
const END: f64 = TOP + ROOM.1 + 26.0;
/// From a hinge to its number, and length of an axis, pixels.
const NUMBER: f64 = 14.0;
const AXIS: f64 = 38.0;
/// A line of the page, pixels.
const LINE: f64 = 18.0;

/// The base as one view shows it: m to the right and m upwards.
struct View {
    title: &'static str,
    lower: [Point; 6],
    upper: [Point; 6],
    origin: Point,
    /// Names of the axes to the right and upwards.
    axes: [&'static str; 2],
    numbered: bool,
}

/// Least and greatest of one coordinate.
type Range = (f64, f64);

/// The two views, both to one scale.
#[must_use]
pub fn figure(base: &GeometryFile) -> String {
    let mut drawing = Drawing::new("The motion base at home", END);
    draw(&mut drawing, base);
    drawing.finish()
}

/// The views and the hinges as numbers, as the text of an SVG file.
#[must_use]
pub fn page(base: &GeometryFile) -> String {
    let title = format!("{} at home", base.name);
    let mut drawing = Drawing::new(&title, END + 12.0 * LINE);
    draw(&mut drawing, base);
    let mut line = |number: u8, cells: &[(f64, String)]| {
        for (x, text) in cells {
            let y = END + LINE * (f64::from(number) + 1.0);
            drawing.text(*x, y, Anchor::Start, "key", text);
        }
    };
    let columns = [40.0, 100.0, 340.0, 580.0];
    let heads = [
        "jack",
        "lower hinge X, Y, Z, m",
        "upper hinge X, Y, Z, m",
        "length at home, m",
    ];
    line(
        0,
        &[0, 1, 2, 3].map(|column| (columns[column], heads[column].to_owned())),
    );
    let geometry = &base.geometry;
    let lengths = inverse(geometry, &geometry.home());
    let place = |hinge: Vector3<f64>| {
        let [x, y, z] = [hinge.x, hinge.y, hinge.z].map(|coordinate| fixed(coordinate + 0.0, 4));
        format!("{x}, {y}, {z}")
    };
    for (number, jack) in (1_u8..).zip(0..6) {
        let cells = [
            number.to_string(),
            place(geometry.lower()[jack]),
            place(geometry.upper()[jack]),
            fixed(lengths[jack], 4),
        ];
        line(
            number,
            &[0, 1, 2, 3].map(|column| (columns[column], cells[column].clone())),
        );
    }
    let notes = [
        "Jack k runs from lower hinge k (square, fixed to the earth) to upper hinge k (dot, fixed to the platform).",
        "X points forward, Y up, Z to the right; O is the origin of the upper hinges, on the vertical through that of the lower ones.",
        "A file with axes \"z-up\" has x = X, y = \u{2212}Z, z = Y; one with \"z-down\" has x = X, y = Z, z = \u{2212}Y.",
    ];
    for (number, note) in (8..).zip(notes) {
        line(number, &[(columns[0], note.to_owned())]);
    }
    drawing.finish_alone(STYLE)
}

fn draw(drawing: &mut Drawing, base: &GeometryFile) {
    let geometry = &base.geometry;
    let home = geometry.home().position;
    let upper = geometry.upper().map(|hinge| hinge + home);
    let lower = *geometry.lower();
    let above = |hinge: Vector3<f64>| (hinge.z, hinge.x);
    let right = |hinge: Vector3<f64>| (hinge.x, hinge.y);
    let views = [
        View {
            title: "from above: X up, Z to the right",
            lower: lower.map(above),
            upper: upper.map(above),
            origin: above(home),
            axes: ["Z", "X"],
            numbered: true,
        },
        View {
            title: "from the right: X to the right, Y up",
            lower: lower.map(right),
            upper: upper.map(right),
            origin: right(home),
            axes: ["X", "Y"],
            numbered: false,
        },
    ];
    let scales = views.iter().flat_map(|view| {
        let [(left, right), (low, high)] = view.ranges();
        [
            ROOM.0 / (right - left).max(1e-3),
            ROOM.1 / (high - low).max(1e-3),
        ]
    });
    let scale = scales.fold(f64::INFINITY, f64::min);
    for (view, middle) in views.iter().zip([0.27 * WIDTH, 0.73 * WIDTH]) {
        view.draw(drawing, middle, scale);
    }
}

impl View {
    fn ranges(&self) -> [Range; 2] {
        let range = |part: fn(&Point) -> f64| {
            let values = self.lower.iter().chain(&self.upper).map(part);
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            })
        };
        [range(|point| point.0), range(|point| point.1)]
    }

    fn draw(&self, drawing: &mut Drawing, middle: f64, scale: f64) {
        let centre = self.ranges().map(|(low, high)| (low + high) / 2.0);
        let at = |(right, up): Point| {
            (
                middle + scale * (right - centre[0]),
                TOP + ROOM.1 / 2.0 - scale * (up - centre[1]),
            )
        };
        let (lower, upper) = (self.lower.map(at), self.upper.map(at));
        drawing.text(middle, 14.0, Anchor::Middle, "axis", self.title);
        for jack in 0..6 {
            drawing.segment("ring", lower[jack], lower[(jack + 1) % 6]);
            drawing.segment("ring", upper[jack], upper[(jack + 1) % 6]);
        }
        for (number, (foot, head)) in (1..).zip(lower.into_iter().zip(upper)) {
            drawing.segment("jack", foot, head);
            drawing.dot(foot.0, foot.1, "second", true);
            drawing.dot(head.0, head.1, "first", false);
            if self.numbered {
                let (across, along) = (foot.0 - head.0, foot.1 - head.1);
                let length = across.hypot(along).max(1e-9);
                let (across, along) = (across / length * NUMBER, along / length * NUMBER);
                // Outside the lower hinge, and on the jack beside the upper one, which two jacks may share.
                let places = [
                    (foot.0 + across, foot.1 + along),
                    (head.0 + 1.6 * across, head.1 + 1.6 * along),
                ];
                for (x, y) in places {
                    drawing.text(x, y + 4.0, Anchor::Middle, "name", &number.to_string());
                }
            }
        }
        self.draw_axes(drawing, at(self.origin));
    }

    /// The body's axes at O.
    fn draw_axes(&self, drawing: &mut Drawing, (x, y): Point) {
        let (right, top) = (x + AXIS, y - AXIS);
        drawing.segment("axes", (x, y), (right, y));
        drawing.segment("axes", (x, y), (x, top));
        for side in [-3.0, 3.0] {
            drawing.segment("axes", (right, y), (right - 6.0, y + side));
            drawing.segment("axes", (x, top), (x + side, top + 6.0));
        }
        drawing.text(right + 4.0, y + 4.0, Anchor::Start, "name", self.axes[0]);
        drawing.text(x, top - 4.0, Anchor::Middle, "name", self.axes[1]);
        drawing.text(x - 4.0, y + 13.0, Anchor::End, "name", "O");
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Where the first text of this content stands: the number at a lower hinge.
    fn place(figure: &str, content: &str) -> Point {
        let end = figure.find(&format!(">{content}</text>")).unwrap();
        let element = &figure[figure[..end].rfind("<text").unwrap()..end];
        let number = |name: &str| -> f64 {
            let value = element.split_once(&format!(" {name}=\"")).unwrap().1;
            value.split('"').next().unwrap().parse().unwrap()
        };
        (number("x"), number("y"))
    }

    /// Hinge 1 of this base is at X 1.60 m, Z −2.05 m: ahead on the left; hinge 2 is ahead on the right.
    #[test]
    fn jack_one_is_ahead_on_the_left_and_the_numbers_run_clockwise_from_above() {
        let figure = figure(&GeometryFile::load("il-96-300").unwrap());
        let (x, y) = place(&figure, "O");
        let angles = [1, 2, 3, 4, 5, 6].map(|jack| {
            let (right, down) = place(&figure, &jack.to_string());
            (right - x).atan2(y - down)
        });
        assert!(angles[0] < 0.0 && angles[0] > -TAU / 4.0, "{angles:?}");
        let steps = (0..6).map(|jack| (angles[(jack + 1) % 6] - angles[jack]).rem_euclid(TAU));
        let round: f64 = steps.sum();
        assert!((round - TAU).abs() < 1e-6, "once round: {angles:?}");
    }

    #[test]
    fn the_figure_of_the_documentation_is_what_the_command_prints() {
        let page = page(&GeometryFile::load("il-96-300").unwrap());
        assert!(
            page == include_str!("../../docs/jacks.svg"),
            "run: cargo hexsense kinematics figure --geometry il-96-300 --out docs/jacks.svg"
        );
    }
}
