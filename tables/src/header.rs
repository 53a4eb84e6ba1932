//! The names of the columns.

use crate::{Format, Problem};

/// The names in a header line, without empty cells behind the last.
#[must_use]
pub fn names(format: Format, line: &str) -> Vec<&str> {
    let mut names: Vec<&str> = format.cells(line).map(|cell| cell.text).collect();
    while names.last().is_some_and(|name| name.is_empty()) {
        names.pop();
    }
    names
}

/// Whether the header `line` has the columns of `wanted`, names with commas between them, in this order.
///
/// # Errors
/// [`Problem::NoHeader`], [`Problem::Twice`], [`Problem::Header`].
pub fn expect(format: Format, line: &str, wanted: &str) -> Result<(), Problem> {
    let names = names(format, line);
    if names.iter().any(|name| name.parse::<f64>().is_ok()) {
        let wanted = wanted.to_owned();
        return Err(Problem::NoHeader { wanted });
    }
    let columns: Vec<&str> = wanted.split(',').collect();
    for column in 0..names.len().max(columns.len()) {
        let found = names.get(column).copied().unwrap_or_default();
        let name = columns.get(column).copied().unwrap_or_default();
        if found == name {
            continue;
        }
        if let Some(first) = names[..column.min(names.len())]
            .iter()
            .position(|earlier| *earlier == found)
        {
            return Err(Problem::Twice {
                name: found.to_owned(),
                first: first + 1,
                second: column + 1,
            });
        }
        return Err(Problem::Header {
            column: column + 1,
            found: found.to_owned(),
            name: name.to_owned(),
            wanted: wanted.to_owned(),
        });
    }
    Ok(())
}
