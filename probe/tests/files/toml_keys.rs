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
    let top =
        expected(reader, &format!("{UNKNOWN} = 1\n")).expect("the reader refuses unknown keys");
    let mut keys = BTreeSet::new();
    let mut tables = Vec::new();
    let mut found = |table: &str, names: Vec<String>, tables: &mut Vec<String>| {
        for name in names {
            let key = if table.is_empty() {
                name
            } else {
                format!("{table}.{name}")
            };
            tables.push(key.clone());
            keys.insert(key);
        }
    };
    found("", top, &mut tables);
    while let Some(table) = tables.pop() {
        // One table, or a list of tables whose outer tables are lists or not.
        let texts = heads(&table).map(|head| format!("{head}{UNKNOWN} = 1\n"));
        if let Some(names) = texts.iter().find_map(|text| expected(reader, text)) {
            found(&table, names, &mut tables);
        }
    }
    keys
}

/// Lines that begin a table: as a list or not, in a table that is a list.
fn heads(table: &str) -> [String; 3] {
    let outer = table
        .rsplit_once('.')
        .map_or(String::new(), |(outer, _)| format!("[[{outer}]]\n"));
    [
        format!("[{table}]\n"),
        format!("{outer}[[{table}]]\n"),
        format!("{outer}[{table}]\n"),
    ]
}

/// The keys that the reader expects where it meets [`UNKNOWN`]; `None` when it stops at something else.
fn expected(reader: Reader, text: &str) -> Option<Vec<String>> {
    let error = reader(text).err()?;
    let (_, names) = error.split_once(&format!("unknown field `{UNKNOWN}`, expected "))?;
    let names = names.split('`').skip(1).step_by(2);
    Some(names.map(str::to_owned).collect())
}
