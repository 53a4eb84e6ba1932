//! The key of the fake board.

use std::path::Path;

use hexsense_core::wire::change::Key;
use hexsense_probe::{files, key_file};

/// The key that a fake board is provisioned with.
pub const KEY: Key = {
    let mut key = [0x5E; 32];
    key[0] = 0x1E;
    Key(key)
};

/// Writes it where the commands look for the key of this board in `folder`.
pub fn save(folder: &Path, board: &[u8; 12]) {
    let text = format!("{}\n", files::hex(&KEY.0));
    let path = folder.join(key_file::default_of(board));
    write(&path, &text);
}

/// Writes a key file as only its owner can read it.
pub fn write(path: &Path, text: &str) {
    std::fs::write(path, text).unwrap();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o600)).unwrap();
    }
}
