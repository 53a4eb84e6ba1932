//! The demo holds, and a second demo from the same seed leaves the same bytes.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::ensure;
use board_tests::virtual_bench::KEY_FILE;
use board_tests::{demo, folders};

use crate::{GEOMETRY, SEED};

#[test]
#[ignore = "needs the built programs"]
fn demo_twice_the_same() -> anyhow::Result<()> {
    let folders = ["system/first", "system/second"].map(folders::emptied);
    let [first, second] = folders.map(|folder| {
        let folder = folder?;
        let out = Some(folder.clone());
        demo::run(&demo::Arguments {
            seed: SEED,
            geometry: GEOMETRY.to_owned(),
            json: false,
            out,
        })?;
        contents(&folder)
    });
    let (first, second) = (first?, second?);
    ensure!(
        first.keys().eq(second.keys()),
        "the same seed left other files: {:?} {:?}",
        first.keys(),
        second.keys()
    );
    for (name, bytes) in &first {
        ensure!(
            second.get(name) == Some(bytes),
            "the same seed gave other bytes in {}",
            name.display()
        );
    }
    Ok(())
}

/// All files below a folder; of the demo's document the time it took is left out, and with the board's key, which is
/// new each time, its flash, which has key and time of day in it.
fn contents(folder: &Path) -> anyhow::Result<BTreeMap<PathBuf, Vec<u8>>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(place) = folders.pop() {
        for entry in fs::read_dir(&place)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            if path.ends_with(KEY_FILE) || path.ends_with("flash.bin") {
                continue;
            }
            let mut bytes = fs::read(&path)?;
            if path.ends_with("demo.json") {
                let mut document: serde_json::Value = serde_json::from_slice(&bytes)?;
                document["wall_seconds"].take();
                bytes = document.to_string().into_bytes();
            }
            files.insert(path.strip_prefix(folder)?.to_owned(), bytes);
        }
    }
    Ok(files)
}
