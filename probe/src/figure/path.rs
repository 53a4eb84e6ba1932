//! Curves as SVG paths.
//!
//! Paths are written in tenths of a pixel, each point relative to the one before, which makes curves small;
//! `class="tenths"` scales them back.

use std::fmt::Write as _;

use super::curve::Point;

/// Path data in tenths of a pixel; points that fall on the one before are left out.
#[must_use]
pub fn path(points: impl Iterator<Item = Point>) -> String {
    let tenths = points.map(|(x, y)| ((x * 10.0).round() as i32, (y * 10.0).round() as i32));
    let mut path = String::new();
    let mut last: Option<(i32, i32)> = None;
    for (x, y) in tenths {
        let _ = match last {
            None => write!(path, "M{x} {y}l"),
            Some(last) if last == (x, y) => continue,
            // A minus sign separates by itself.
            Some((last_x, last_y)) => {
                let (dx, dy) = (x - last_x, y - last_y);
                let before = if dx < 0 || path.ends_with('l') {
                    ""
                } else {
                    " "
                };
                let between = if dy < 0 { "" } else { " " };
                write!(path, "{before}{dx}{between}{dy}")
            }
        };
        last = Some((x, y));
    }
    if path.ends_with('l') {
        path.push_str("0 0");
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_names_every_point_relative_to_the_one_before() {
        let places = [(0, 10), (10, 5), (5, 5), (5, 5), (5, 9), (20, 20)];
        let points = places.map(|(x, y)| (f64::from(x) / 10.0, f64::from(y) / 10.0));
        assert_eq!(path(points.into_iter()), "M0 10l10-5-5 0 0 4 15 11");
        assert_eq!(path([(1.0, 1.0)].into_iter()), "M10 10l0 0");
        assert_eq!(path(std::iter::empty()), "");
    }
}
