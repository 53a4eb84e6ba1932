//! The checks of the small campaign.

use crate::page::{captioned, elements, parsed, words};
use crate::small::SMALL_PAGE;

#[test]
fn every_check_has_its_verdict_figure_limit_unit_and_names() {
    let table = captioned(&parsed(&SMALL_PAGE), 3);
    assert_eq!(
        table.caption,
        "Table 3. Checks of the bench: the figure that comes closest to its limit or goes farthest beyond, and whose it is."
    );
    assert_eq!(
        table.head,
        "Check | Verdict | Figure | Limit | Unit | Closest or beyond"
    );
    assert_eq!(
        table.rows,
        [
            "jack gain | pass | 1.23e-3 | 1.00e-2 | relative | jack4",
            "sensor noise | fail, accepted | 4.56e0 | 3.00e0 | of the data sheet | wy, ax",
            "home | not observable | – | – | m | ",
        ]
    );
}

#[test]
fn an_accepted_failure_is_told_with_its_meaning_and_its_reason() {
    let document = parsed(&SMALL_PAGE);
    let told: Vec<String> = elements(&document, "p").into_iter().map(words).collect();
    let accepted = told
        .iter()
        .filter(|text| text.starts_with("Accepted failure"));
    assert_eq!(
        accepted.collect::<Vec<_>>(),
        [
            "Accepted failure: sensor noise: meaning of sensor noise & more. Reason given: a fan <nearby>."
        ]
    );
}
