//! Folders for what is written: flash memories, logs, captures.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;

/// An empty folder of this name, in the target folder.
pub fn emptied(name: &str) -> anyhow::Result<PathBuf> {
    let folder = workspace().join("target/board-tests").join(name);
    empty(&folder)?;
    Ok(folder.canonicalize()?)
}

/// Makes a folder, or empties it where it is.
pub fn empty(folder: &Path) -> anyhow::Result<()> {
    let what = || format!("cannot make room in {}", folder.display());
    if folder.exists() {
        fs::remove_dir_all(folder).with_context(what)?;
    }
    fs::create_dir_all(folder).with_context(what)
}

/// Root of the workspace.
#[must_use]
pub fn workspace() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}
