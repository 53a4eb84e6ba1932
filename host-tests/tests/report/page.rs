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
