//! The rooms of the house: no circle of imports between the files and folders of a crate, and no arrow between crates
//! that the architecture forbids.
//!
//! | file | what |
//! |---|---|
//! | [`source`] | reads the `use` lines and paths of a file with a Rust lexer |
//! | [`modules`] | finds the file behind a path, through re-exports |
//! | [`circles`] | circles between the files and folders of one folder, one folder at a time |
//! | [`workspace`] | the arrows between crates, and the packages that the core stands on |
//! | [`made_up`] | small sources in memory on which each check must fail |
//!
//! What is not an arrow: `mod` declarations, a `pub use` that the file itself does not use (a facade depends on
//! nothing), doc comments, attributes, and what stands under `#[cfg(test)]`.

mod circles;
mod made_up;
mod modules;
mod source;
mod workspace;

use std::fs;
use std::path::{Path, PathBuf};

use circles::Halves;
use source::Source;

/// Pairs of files of one folder that may import each other: two halves of one type. The text of one of the two modules
/// says so too.
const HALVES: &[(&str, Halves)] = &[
    (
        "core/src",
        Halves {
            files: ["storage/mod.rs", "storage/upload.rs"],
            reason: "the storage keeps the upload under way, and an upload is a series of its commands",
        },
    ),
    (
        "core/src",
        Halves {
            files: ["storage/mod.rs", "storage/key.rs"],
            reason: "the storage keeps what is known of the key, and finds and replaces the key by its flash and its log",
        },
    ),
    (
        "virtual-board/src",
        Halves {
            files: ["bus/mod.rs", "bus/events.rs"],
            reason: "the bus keeps the peripherals, and its events are theirs in time",
        },
    ),
    (
        "virtual-board/src",
        Halves {
            files: ["bus/mod.rs", "bus/injected.rs"],
            reason: "the bus keeps the injected stalls, which act on its peripherals",
        },
    ),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every Rust file below `folder`, by its path from there.
fn read(folder: &Path) -> Vec<Source> {
    let mut sources = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(inside) = folders.pop() {
        for entry in fs::read_dir(&inside).unwrap_or_else(|error| panic!("{inside:?}: {error}")) {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let name = path.strip_prefix(folder).unwrap().to_str().unwrap();
                let text = fs::read_to_string(&path).unwrap();
                sources.push(Source::new(name, &text));
            }
        }
    }
    sources.sort_by(|a, b| a.path.cmp(&b.path));
    sources
}

/// `folder` is the crate's `src`, `library` the name under which its binary imports it.
fn without_circle(folder: &str, library: &str) {
    let halves: Vec<Halves> = HALVES
        .iter()
        .filter(|(of, _)| *of == folder)
        .map(|(_, halves)| *halves)
        .collect();
    let found = circles::find(&read(&root().join(folder)), library, &halves);
    assert!(found.is_empty(), "{folder}:\n{}", found.join("\n"));
}

#[test]
fn the_firmware_has_no_circle() {
    without_circle("src", "hexsense");
}

#[test]
fn the_core_has_no_circle() {
    without_circle("core/src", "hexsense_core");
}

#[test]
fn the_client_has_no_circle() {
    without_circle("client/src", "hexsense_client");
}

#[test]
fn the_host_tool_has_no_circle() {
    without_circle("probe/src", "hexsense_probe");
}

#[test]
fn the_reader_of_tables_has_no_circle() {
    without_circle("tables/src", "tables");
}

#[test]
fn the_twin_has_no_circle() {
    without_circle("twin/src", "twin");
}

#[test]
fn the_virtual_board_has_no_circle() {
    without_circle("virtual-board/src", "virtual_board");
}

#[test]
fn the_tests_on_the_board_have_no_circle() {
    without_circle("board-tests/src", "board_tests");
}

#[test]
fn the_tasks_have_no_circle() {
    without_circle("xtask/src", "xtask");
}

#[test]
fn crates_depend_on_each_other_as_the_architecture_says() {
    let wrong = workspace::forbidden(&workspace::metadata());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_core_stands_on_no_chip_and_no_executor() {
    let wrong = workspace::below_the_core(&workspace::core_tree());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
