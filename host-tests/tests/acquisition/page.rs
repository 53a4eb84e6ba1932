//! The tables of the page.

pub const WIRING: &str = include_str!("../../../docs/using.md");
const PAGE: &str = include_str!("../../../docs/acquisition.md");

/// The rows of a table of the page, without its head.
pub fn table(number: u32) -> Vec<Vec<&'static str>> {
    let title = format!("**Table {number}.");
    let start = PAGE.find(&title).unwrap_or_else(|| panic!("no {title}"));
    PAGE[start..]
        .lines()
        .skip_while(|line| !line.starts_with('|'))
        .take_while(|line| line.starts_with('|'))
        .skip(2)
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect()
}

/// A figure of the data sheet, as table 1 quotes it.
pub fn data_sheet(name: &str) -> f64 {
    let rows = table(1);
    let row = rows.iter().find(|row| row[0] == name);
    row.unwrap_or_else(|| panic!("table 1 has no {name}"))[1]
        .replace(' ', "")
        .parse()
        .expect("a number")
}

pub fn number(text: &str) -> f64 {
    text.replace(['_', ' '], "").parse().expect("a number")
}

/// Compares the first columns of a table with what they must be.
pub fn agree(which: u32, expected: &[Vec<String>]) {
    let found = table(which);
    assert_eq!(found.len(), expected.len(), "rows of table {which}");
    for (found, expected) in found.iter().zip(expected) {
        assert!(found.len() >= expected.len(), "table {which}: {found:?}");
        assert_eq!(
            &found[..expected.len()],
            expected,
            "table {which} of docs/acquisition.md"
        );
    }
}

/// Asserts that the text of the page has these words.
pub fn says(words: &str) {
    let text = PAGE.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        text.contains(words),
        "docs/acquisition.md does not say: {words}"
    );
}

pub fn yes(is: bool) -> String {
    if is { "yes" } else { "no" }.into()
}

/// Three significant digits, not as a power of ten.
pub fn three(value: f64) -> String {
    let rounded = format!("{value:.2e}");
    let exponent = rounded.split('e').nth(1).expect("an exponent");
    let digits = 2 - exponent.parse::<i32>().expect("an integer");
    format!("{value:.*}", digits.max(0) as usize)
}
