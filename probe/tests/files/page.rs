//! The tables of `docs/files.md`.

use crate::template::Template;

/// The page.
pub const PAGE: &str = include_str!("../../../docs/files.md");

/// The three tables of the sensors, for which the page writes `TRIAD`.
const TRIADS: [&str; 3] = [
    "linear_acceleration",
    "angular_acceleration",
    "angular_rate",
];
/// The three keys of a measured value, for which the page writes `*`.
const MEASURED: [&str; 3] = ["estimate", "expanded_uncertainty", "interval_95"];

/// A row: a key and what the page says of it.
#[derive(Debug, Clone)]
pub struct Row {
    /// The key with its tables.
    pub key: String,
    range: String,
    /// What stands for it where the file does not have it.
    pub default: String,
}

/// The rows of the table that is marked with `name`, each with its key written out.
pub fn rows(name: &str) -> Vec<Row> {
    let mark = format!("<!-- keys: {name} -->\n\n");
    let (_, table) = PAGE
        .split_once(&mark)
        .unwrap_or_else(|| panic!("no table {name}"));
    let table = table.split("\n\n").next().unwrap();
    let mut lines = table.lines().map(cells);
    let head = lines.next().unwrap();
    let rows: Vec<Row> = lines
        .skip(1)
        .flat_map(|cells| written_out(&head, &cells))
        .collect();
    assert!(!rows.is_empty(), "{name}");
    rows
}

fn cells(line: &str) -> Vec<String> {
    let inside = line.trim().trim_matches('|');
    inside
        .split('|')
        .map(|cell| cell.trim().to_owned())
        .collect()
}

fn written_out(head: &[String], cells: &[String]) -> Vec<Row> {
    assert_eq!(cells.len(), head.len(), "{cells:?}");
    let cell = |name: &str| {
        let place = head.iter().position(|head| head == name);
        place.map_or(String::new(), |place| cells[place].clone())
    };
    assert!(!cell("meaning").is_empty(), "{cells:?}");
    let key = cell("key").trim_matches('`').to_owned();
    let keys: Vec<String> = if let Some(rest) = key.strip_prefix("TRIAD.") {
        TRIADS.map(|triad| format!("{triad}.{rest}")).to_vec()
    } else if let Some(measured) = key.strip_suffix(".*") {
        MEASURED.map(|part| format!("{measured}.{part}")).to_vec()
    } else {
        vec![key]
    };
    let row = |key| Row {
        key,
        range: cell("range"),
        default: cell("default"),
    };
    keys.into_iter().map(row).collect()
}

impl Row {
    /// The range, where it is two numbers or the names of keys that hold them in the template.
    pub fn range(&self, template: &Template) -> Option<[f64; 2]> {
        let range = self.range.strip_prefix("each ").unwrap_or(&self.range);
        let (low, high) = range.split_once(" to ")?;
        let end = |text: &str| {
            let beside = self.key.rsplit_once('.').map_or("", |(table, _)| table);
            let number = text.parse().ok();
            let number = number.or_else(|| template.number(&format!("{beside}.{text}")));
            number.or_else(|| template.number(text))
        };
        Some([end(low)?, end(high)?])
    }
}
