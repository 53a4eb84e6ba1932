//! The keys that a reader of TOML knows.
//!
//! A reader refuses a key that it does not know and says which it expects. Asked for such a key at the top and then in
//! each table that it knows, it lists them all: no list of keys stands here that could go stale.

use std::collections::BTreeSet;

use crate::Reader;

/// A key that no file has.
const UNKNOWN: &str = "zzz";

/// All keys, those of tables behind the table's name.
pub fn known(reader: Reader) -> BTreeSet<String> {
    let mut keys = BTreeSet::new();
    // Tables with the lines that lead to them; the file itself is the first.
    let mut tables = vec![(String::new(), String::new())];
    while let Some((table, head)) = tables.pop() {
        let text = format!("{head}{UNKNOWN} = 1\n");
        for name in expected(reader, &text).into_iter().flatten() {
            let key = format!("{table}{name}");
            // A table, or a list of tables; a key that is neither expects nothing.
            for line in [format!("[{key}]\n"), format!("[[{key}]]\n")] {
                tables.push((format!("{key}."), format!("{head}{line}")));
            }
            keys.insert(key);
        }
    }
    assert!(!keys.is_empty(), "the reader takes unknown keys");
    keys
}

/// The keys that the reader expects where it meets [`UNKNOWN`]; `None` when it stops at something else.
fn expected(reader: Reader, text: &str) -> Option<Vec<String>> {
    let error = reader(text).err()?;
    let (_, names) = error.split_once(&format!("unknown field `{UNKNOWN}`, expected "))?;
    let names = names.split('`').skip(1).step_by(2);
    Some(names.map(str::to_owned).collect())
}
