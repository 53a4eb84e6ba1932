//! The terminal: the one way by which text reaches standard output and standard error.
//!
//! Text from outside (names in files and sets, what a board or a motion controller says) can hold control characters, which
//! a terminal obeys: they move the cursor, set colours and retitle windows. So everything that is printed is escaped here.
//! A control character becomes `\u001b`, four hexadecimal digits, which is its escape in JSON too: a document stays the
//! same document. Line feeds and tabs stay. Inside a line, [`one_line`] escapes these as well, so that a name cannot make
//! up a line of its own.
//!
//! A reader that has closed its end (`hexsense show | head`) wants no more: what is printed to it is dropped, and the
//! command goes on to its end.

use std::borrow::Cow;
use std::fmt::{self, Write as _};
use std::io::{self, ErrorKind, Write};

/// Prints a line to standard output.
macro_rules! say {
    ($($text:tt)*) => { $crate::terminal::print(&format!("{}\n", format_args!($($text)*))) };
}
/// Prints a line to standard error. When that is gone, nobody can be told.
macro_rules! tell {
    ($($text:tt)*) => { $crate::terminal::tell_text(&format!("{}\n", format_args!($($text)*))) };
}
pub(crate) use {say, tell};

/// Standard output cannot be written.
#[derive(Debug, thiserror::Error)]
#[error(
    "standard output cannot be written: {0}; the command ended there, look at what it was to do"
)]
pub struct OutputError(io::Error);

/// `text` as it is printed: without control characters, except line feeds and tabs.
#[must_use]
pub fn escaped(text: &str) -> Cow<'_, str> {
    let is_plain = |letter| !obeyed(letter) || matches!(letter, '\n' | '\t');
    if text.chars().all(is_plain) {
        return Cow::Borrowed(text);
    }
    let mut printed = String::with_capacity(text.len() + 16);
    for letter in text.chars() {
        match is_plain(letter) {
            true => printed.push(letter),
            false => escape(letter, &mut printed),
        }
    }
    Cow::Owned(printed)
}

/// Text from outside in the middle of a line.
#[must_use]
pub fn one_line(text: &str) -> OneLine<'_> {
    OneLine(text)
}

/// See [`one_line`].
#[derive(Debug, Clone, Copy)]
pub struct OneLine<'a>(&'a str);

impl fmt::Display for OneLine<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut line = String::with_capacity(self.0.len());
        for letter in self.0.chars() {
            match obeyed(letter) {
                true => escape(letter, &mut line),
                false => line.push(letter),
            }
        }
        f.pad(&line)
    }
}

/// Whether a terminal may obey a character instead of showing it: controls, line and paragraph separators, and those
/// that turn the direction of the text around.
fn obeyed(letter: char) -> bool {
    letter.is_control()
        || matches!(letter, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// All of them have four digits. Writing to a string cannot fail.
fn escape(letter: char, into: &mut String) {
    let _ = write!(into, "\\u{:04x}", u32::from(letter));
}

/// Prints text to standard output.
///
/// # Errors
/// [`OutputError`], such as a full disk behind it; a reader that has closed its end is none.
pub fn print(text: &str) -> Result<(), OutputError> {
    let mut out = io::stdout().lock();
    let printed = out.write_all(escaped(text).as_bytes());
    match printed.and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(OutputError(error)),
        _ => Ok(()),
    }
}

/// Prints text to standard error, as far as that is there.
pub fn tell_text(text: &str) {
    let _ = Screen.write_all(text.as_bytes());
}

/// Standard error, for questions to a person.
#[derive(Debug)]
pub struct Screen;

impl Write for Screen {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(bytes);
        io::stderr().write_all(escaped(&text).as_bytes())?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_would_obey_is_shown_and_everything_else_stays() {
        let told = "\u{1b}[2J\u{9b}31m\u{7f}\r\u{7}\u{202e}\u{0}";
        let shown = r"\u001b[2J\u009b31m\u007f\u000d\u0007\u202e\u0000";
        assert_eq!(escaped(told), shown);
        assert_eq!(one_line(told).to_string(), shown);
        let plain = "größe 5 µs ± 2\tm/s²\nsecond line 漢";
        assert!(matches!(escaped(plain), Cow::Borrowed(text) if text == plain));
        assert_eq!(
            one_line("a\nkey  none\t").to_string(),
            r"a\u000akey  none\u0009"
        );
        assert_eq!(
            format!("{:>8}|{:<8}|", one_line("\u{1b}"), one_line("ab")),
            r"  \u001b|ab      |"
        );
    }

    #[test]
    fn a_document_with_control_characters_stays_the_same_document() {
        let document = serde_json::json!({"name": "\u{1b}]0;x\u{7}\u{9b}2J\u{7f}\u{2028}\n\"\\u"});
        let printed = document.to_string();
        let printed = escaped(&printed);
        assert!(!printed.chars().any(obeyed), "{printed}");
        assert_eq!(
            serde_json::from_str::<serde_json::Value>(&printed).unwrap(),
            document
        );
    }
}
