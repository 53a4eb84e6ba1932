//! The report as a page: its elements, rows and captions.

/// The report as XML, which it is too; panics where it is not well-formed.
pub fn parsed(html: &str) -> roxmltree::Document<'_> {
    let options = roxmltree::ParsingOptions {
        allow_dtd: true,
        ..Default::default()
    };
    roxmltree::Document::parse_with_options(html, options).unwrap_or_else(|error| panic!("{error}"))
}

pub fn elements<'a>(
    document: &'a roxmltree::Document,
    name: &'a str,
) -> Vec<roxmltree::Node<'a, 'a>> {
    document
        .descendants()
        .filter(|node| node.has_tag_name(name))
        .collect()
}

pub fn words(node: roxmltree::Node) -> String {
    node.descendants()
        .filter(|node| node.is_text())
        .filter_map(|node| node.text())
        .collect()
}

/// Cells of all rows that begin with `name`, table by table.
pub fn rows(document: &roxmltree::Document, name: &str) -> Vec<Vec<String>> {
    let rows = elements(document, "tr").into_iter().map(|row| {
        row.children()
            .filter(|cell| cell.has_tag_name("td"))
            .map(words)
            .collect::<Vec<_>>()
    });
    rows.filter(|cells| cells.first().is_some_and(|first| first == name))
        .collect()
}

pub fn number(cell: &str) -> f64 {
    let plain: String = cell.chars().filter(|c| !c.is_whitespace()).collect();
    plain
        .replace('−', "-")
        .parse()
        .unwrap_or_else(|_| panic!("{cell:?} is no number"))
}

/// The numbers between `before` and `after` in the caption that begins with `start`.
pub fn in_caption(captions: &[String], start: &str, before: &str, after: &str) -> Vec<f64> {
    let caption = captions
        .iter()
        .find(|caption| caption.contains(start))
        .expect(start);
    let part = caption
        .split_once(before)
        .expect(before)
        .1
        .split_once(after)
        .expect(after)
        .0;
    part.split(',').map(number).collect()
}

/// A table as a reader sees it.
#[derive(Debug)]
pub struct Table {
    pub caption: String,
    /// Cells of the head, a unit below them in brackets, and the columns that a cell spans where it is not one.
    pub head: String,
    /// Cells of each row, separated by bars.
    pub rows: Vec<String>,
}

/// All tables in the order of the page.
pub fn tables(document: &roxmltree::Document) -> Vec<Table> {
    elements(document, "table")
        .into_iter()
        .map(Table::read)
        .collect()
}

impl Table {
    fn read(table: roxmltree::Node) -> Self {
        let mut of_body = Vec::new();
        let mut head = String::new();
        for row in table.descendants().filter(|node| node.has_tag_name("tr")) {
            if row
                .parent()
                .is_some_and(|parent| parent.has_tag_name("thead"))
            {
                head += &cells(row);
            } else {
                of_body.push(cells(row));
            }
        }
        let caption = table.children().find(|node| node.has_tag_name("caption"));
        Self {
            caption: caption.map(words).unwrap_or_default(),
            head,
            rows: of_body,
        }
    }
}

fn cells(row: roxmltree::Node) -> String {
    let cells = row.children().filter(|node| node.is_element());
    cells.map(cell).collect::<Vec<_>>().join(" | ")
}

/// What a cell says, without the spaces that align it.
fn cell(cell: roxmltree::Node) -> String {
    let unit = cell.children().find(|node| node.has_tag_name("small"));
    let all = words(cell);
    let mut text = match unit.map(words) {
        Some(unit) => format!("{} [{unit}]", all.trim_end_matches(unit.as_str())),
        None => all,
    };
    text.retain(|c| !matches!(c, '\u{2007}' | '\u{2008}'));
    match cell.attribute("colspan") {
        Some(columns) => format!("{text} ({columns} columns)"),
        None => text,
    }
}

/// The table of this number.
pub fn captioned(document: &roxmltree::Document, number: usize) -> Table {
    let start = format!("Table {number}. ");
    let mut tables = tables(document).into_iter();
    tables
        .find(|table| table.caption.starts_with(&start))
        .expect(&start)
}

/// Everything that is said in the section of this title.
pub fn of_section(html: &str, title: &str) -> String {
    let document = parsed(html);
    let mut headings = elements(&document, "h2").into_iter();
    let heading = headings
        .find(|heading| words(*heading).ends_with(title))
        .expect(title);
    let after = heading
        .next_siblings()
        .skip(1)
        .take_while(|node| !node.has_tag_name("h2"));
    after.map(words).collect()
}

/// Lengths of the bars in the budgets.
pub fn widths(document: &roxmltree::Document) -> Vec<String> {
    let spans = elements(document, "span").into_iter();
    let styles = spans.filter_map(|span| span.attribute("style"));
    styles
        .map(|style| style.trim_start_matches("width:").to_owned())
        .collect()
}
