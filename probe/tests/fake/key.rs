//! The key of the fake board.

use std::path::Path;

use hexsense_core::wire::change::Key;
use hexsense_probe::{files, key_file};

/// The key that a fake board is provisioned with.
pub const KEY: Key = Key([0x5E; 32]);

/// Writes it where the commands look for it in `folder`.
pub fn save(folder: &Path) {
    let text = format!("{}\n", files::hex(&KEY.0));
    std::fs::write(folder.join(key_file::DEFAULT), text).unwrap();
}
