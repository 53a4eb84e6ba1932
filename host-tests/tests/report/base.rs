//! The drawing of the small campaign's base.

use crate::page::{elements, parsed, words};
use crate::small::SMALL_PAGE;

/// Where the number of each jack stands, m: a third of the way up, 0.65·lower + 0.35·upper, X and Z by the geometry file.
const NUMBERS: [(f64, f64); 6] = [
    (1.4054, -1.1269),
    (1.4054, 1.1269),
    (0.2732, 1.7805),
    (-1.6786, 0.6537),
    (-1.6786, -0.6537),
    (0.2732, -1.7805),
];

#[test]
fn the_numbers_of_the_jacks_stand_at_their_jacks_seen_from_above() {
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
    // X is up and Z to the right, both to one scale.
    let scale = (second[0] - first[0]) / (NUMBERS[1].1 - NUMBERS[0].1);
    assert!(scale > 10.0, "{scale}");
    for (number, (x, z)) in (1..).zip(NUMBERS) {
        let [right, down] = at(number);
        let expected = [scale * (z - NUMBERS[0].1), -scale * (x - NUMBERS[0].0)];
        let found = [right - first[0], down - first[1]];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!(
                (found - expected).abs() < 0.3,
                "{number}: {found} for {expected}"
            );
        }
    }
}
