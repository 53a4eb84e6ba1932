//! A line split into cells.

/// A cell without the blanks and quotes around it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cell<'a> {
    /// Its text.
    pub text: &'a str,
    /// Whether it stood in quotes.
    pub quoted: bool,
}

/// The cells of a line, from left to right.
#[derive(Debug, Clone)]
pub struct Cells<'a> {
    rest: Option<&'a str>,
    separator: u8,
}

impl<'a> Cells<'a> {
    pub(crate) fn new(line: &'a str, separator: u8) -> Self {
        Self {
            rest: Some(line),
            separator,
        }
    }

    /// The text in front of the next separator, which is taken away.
    fn cut(&mut self, rest: &'a str) -> &'a str {
        match rest.bytes().position(|byte| byte == self.separator) {
            Some(end) => {
                self.rest = Some(&rest[end + 1..]);
                &rest[..end]
            }
            None => {
                self.rest = None;
                rest
            }
        }
    }

    /// A cell that begins with a quote, when it also ends with one.
    fn quoted(&mut self, rest: &'a str) -> Option<Cell<'a>> {
        let inside = rest.trim_start().strip_prefix('"')?;
        let mut end = inside.find('"')?;
        while inside[end + 1..].starts_with('"') {
            end += 2 + inside[end + 2..].find('"')?;
        }
        let behind = &inside[end + 1..];
        let before = self.rest;
        if self.cut(behind).trim().is_empty() {
            let text = inside[..end].trim();
            return Some(Cell { text, quoted: true });
        }
        self.rest = before;
        None
    }
}

impl<'a> Iterator for Cells<'a> {
    type Item = Cell<'a>;

    #[inline]
    fn next(&mut self) -> Option<Cell<'a>> {
        let rest = self.rest?;
        if matches!(rest.as_bytes().first(), Some(b'"' | b' '))
            && let Some(cell) = self.quoted(rest)
        {
            return Some(cell);
        }
        Some(Cell {
            text: self.cut(rest).trim(),
            quoted: false,
        })
    }
}
