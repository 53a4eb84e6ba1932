//! Text that cannot become markup.

use std::fmt::{self, Write as _};

/// `content` as text of an element or as value of an attribute in double quotes.
#[must_use]
pub fn text(content: &str) -> Text<'_> {
    Text(content)
}

/// See [`text`].
#[derive(Debug, Clone, Copy)]
pub struct Text<'a>(&'a str);

impl fmt::Display for Text<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for letter in self.0.chars() {
            match letter {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                '\'' => f.write_str("&#39;")?,
                // XML has no place for control characters, escaped or not.
                letter if letter.is_control() && !letter.is_ascii_whitespace() => {
                    f.write_char('\u{fffd}')?;
                }
                '\u{fffe}' | '\u{ffff}' | '\u{c}' => f.write_char('\u{fffd}')?,
                letter => f.write_char(letter)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_become_markup() {
        let name = "<b>\"A&B\"</b>'\u{0}\u{b}";
        assert_eq!(
            text(name).to_string(),
            "&lt;b&gt;&quot;A&amp;B&quot;&lt;/b&gt;&#39;\u{fffd}\u{fffd}"
        );
    }
}
