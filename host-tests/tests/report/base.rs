//! The drawing of the small campaign's base.

use crate::page::{elements, parsed, words};
use crate::small::SMALL_PAGE;

/// Lower and upper hinge of each jack, X and Z by the geometry file, m.
const HINGES: [[(f64, f64); 2]; 6] = [
    [(1.3545, -1.7336), (1.5, 0.0)],
    [(1.3545, 1.7336), (1.5, 0.0)],
    [(0.8241, 2.0398), (-0.75, 1.2990)],
    [(-2.1786, 0.3062), (-0.75, 1.2990)],
    [(-2.1786, -0.3062), (-0.75, -1.2990)],
    [(0.8241, -2.0398), (-0.75, -1.2990)],
];
/// The number stands so far outside the lower hinge, in the direction of the jack, pixels.
const OUTSIDE: f64 = 14.0;

/// From a lower hinge to its number, pixels to the right (Z) and upwards (X).
fn outside([lower, upper]: [(f64, f64); 2]) -> [f64; 2] {
    let (x, z) = (lower.0 - upper.0, lower.1 - upper.1);
    [z, x].map(|part| OUTSIDE * part / x.hypot(z))
}

#[test]
fn the_numbers_of_the_jacks_stand_at_their_lower_hinges_seen_from_above() {
    let document = parsed(&SMALL_PAGE);
    let figures = elements(&document, "figure").into_iter();
    let mut figures =
        figures.filter(|figure| words(*figure).contains("with the numbers of its jacks"));
    let figure = figures.next().unwrap();
    let at = |number: usize| {
        let mut texts = figure
            .descendants()
            .filter(|node| node.has_tag_name("text"));
        let text = texts
            .find(|text| words(*text) == number.to_string())
            .unwrap();
        ["x", "y"].map(|key| text.attribute(key).unwrap().parse::<f64>().unwrap())
    };
    let [first, second] = [at(1), at(2)];
    let [[(x, z), _], [(_, other_z), _]] = [HINGES[0], HINGES[1]];
    // X is up and Z to the right, both to one scale; the numbers of jacks 1 and 2 stand outside on either side.
    let apart = second[0] - first[0] - outside(HINGES[1])[0] + outside(HINGES[0])[0];
    let scale = apart / (other_z - z);
    assert!(scale > 10.0, "{scale}");
    let [right, up] = outside(HINGES[0]);
    let origin = [first[0] - right - scale * z, first[1] + up + scale * x];
    for (number, hinges) in (1..).zip(HINGES) {
        let ((x, z), [right, up]) = (hinges[0], outside(hinges));
        let expected = [origin[0] + scale * z + right, origin[1] - scale * x - up];
        for (found, expected) in at(number).into_iter().zip(expected) {
            assert!(
                (found - expected).abs() < 0.3,
                "{number}: {found} for {expected}"
            );
        }
    }
}
