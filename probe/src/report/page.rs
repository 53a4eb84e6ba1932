//! The page: numbered sections, tables and figures, and the frame that makes one file of them.
//!
//! The page is HTML and well-formed XML at once: every element is closed, every character that means something is
//! escaped by [`text`], nothing is loaded from anywhere.

use std::fmt::Write as _;

use crate::figure::markup::text;

const STYLE: &str = include_str!("style.css");

/// A page that grows section by section. What it takes as `html` is markup; text in it has passed [`text`].
#[derive(Debug, Default)]
pub struct Page {
    body: String,
    contents: Vec<String>,
    tables: usize,
    figures: usize,
}

impl Page {
    /// Starts a section.
    pub fn section(&mut self, title: &str) {
        self.contents.push(title.to_owned());
        let number = self.contents.len();
        let _ = writeln!(
            self.body,
            "<h2 id=\"section-{number}\"><span class=\"number\">{number}</span>{}</h2>",
            text(title)
        );
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, html: &str) {
        let _ = writeln!(self.body, "<p>{html}</p>");
    }

    /// Adds markup as it is.
    pub fn markup(&mut self, html: &str) {
        self.body.push_str(html);
    }

    /// Adds a table: rows of its head and of its body, and a caption above them.
    pub fn table(&mut self, caption: &str, head: &str, body: &str) {
        self.tables += 1;
        let _ = writeln!(
            self.body,
            "<div class=\"table\"><table><caption><b>Table {}.</b> {caption}</caption>\n\
             <thead>{head}</thead>\n<tbody>{body}</tbody></table></div>",
            self.tables
        );
    }

    /// Adds a figure with its caption below.
    pub fn figure(&mut self, caption: &str, svg: &str) {
        self.figures += 1;
        let _ = writeln!(
            self.body,
            "<figure>{svg}<figcaption><b>Figure {}.</b> {caption}</figcaption></figure>",
            self.figures
        );
    }

    /// The whole file. `head` is markup above the table of contents.
    #[must_use]
    pub fn finish(self, title: &str, head: &str) -> String {
        let contents: String = (1..)
            .zip(&self.contents)
            .map(|(number, title)| {
                format!(
                    "<li><a href=\"#section-{number}\">{}</a></li>\n",
                    text(title)
                )
            })
            .collect();
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
             <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
             <header>{head}</header>\n<nav><ol>\n{contents}</ol></nav>\n<main>\n{body}</main>\n</body>\n</html>\n",
            title = text(title),
            body = self.body,
        )
    }
}

/// A row of cells, each with its class and markup; an empty class is left out.
#[must_use]
pub fn row<'a>(cells: impl IntoIterator<Item = (&'a str, String)>) -> String {
    let mut row = String::from("<tr>");
    for (class, html) in cells {
        let _ = if class.is_empty() {
            write!(row, "<td>{html}</td>")
        } else {
            write!(row, "<td class=\"{class}\">{html}</td>")
        };
    }
    row + "</tr>\n"
}

/// Digits that are read one by one.
pub(super) fn code(content: &str) -> String {
    format!("<code>{}</code>", text(content))
}
