//! A question that only `yes` answers with yes.

use std::io::{self, BufRead, IsTerminal, Write};

use anyhow::ensure;

use crate::terminal::Screen;

/// Asks at the terminal; every answer but yes is a no. `nothing` says what was not done then, such as "nothing was erased".
///
/// # Errors
/// Another answer, and no terminal to ask at.
pub fn confirm(question: &str, nothing: &str) -> anyhow::Result<()> {
    ensure!(
        io::stdin().is_terminal(),
        "standard input is no terminal, so the question cannot be asked, and {nothing}; add --yes to go on without asking"
    );
    ask(question, nothing, io::stdin().lock(), Screen)
}

fn ask(
    question: &str,
    nothing: &str,
    mut from: impl BufRead,
    mut to: impl Write,
) -> anyhow::Result<()> {
    write!(to, "{question} Type yes: ")?;
    to.flush()?;
    let mut answer = String::new();
    from.read_line(&mut answer)?;
    ensure!(
        answer.trim() == "yes",
        "the answer was not yes, and {nothing}"
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_but_yes_is_yes() {
        let ask = |answer: &str| ask("All?", "nothing was done", answer.as_bytes(), io::sink());
        for answer in ["yes\n", "yes", " yes \r\n"] {
            ask(answer).unwrap();
        }
        for answer in ["", "\n", "y\n", "YES\n", "no\n", "yes please\n"] {
            let error = ask(answer).unwrap_err();
            assert!(error.to_string().contains("nothing was done"), "{answer:?}");
        }
    }
}
