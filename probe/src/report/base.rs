//! The motion base at home, seen from above and from the right, with the numbers of the jacks.

use nalgebra::Vector3;

use crate::figure::curve::Point;
use crate::figure::drawing::{Anchor, Drawing, WIDTH};
use crate::geometry_file::GeometryFile;

/// Room of one view, pixels.
const ROOM: (f64, f64) = (380.0, 220.0);
const TOP: f64 = 36.0;

/// Hinges as one view shows them: m to the right and m upwards.
struct View {
    title: &'static str,
    lower: [Point; 6],
    upper: [Point; 6],
    numbered: bool,
}

/// Least and greatest of one coordinate.
type Range = (f64, f64);

/// The two views, both to one scale.
#[must_use]
pub fn figure(base: &GeometryFile) -> String {
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
            numbered: true,
        },
        View {
            title: "from the right: X to the right, Y up",
            lower: lower.map(right),
            upper: upper.map(right),
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
    let mut drawing = Drawing::new("The motion base at home", TOP + ROOM.1 + 12.0);
    for (view, middle) in views.iter().zip([0.27 * WIDTH, 0.73 * WIDTH]) {
        view.draw(&mut drawing, middle, scale);
    }
    drawing.finish()
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
                let (x, y) = (
                    foot.0 + 0.35 * (head.0 - foot.0),
                    foot.1 + 0.35 * (head.1 - foot.1),
                );
                drawing.text(x, y + 4.0, Anchor::Middle, "name", &number.to_string());
            }
        }
    }
}
