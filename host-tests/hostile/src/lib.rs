//! Hostile input: what a broken line, a hostile host or worn-out flash can give to the board, and a lying board to the host.
//!
//! Each target is a plain function of some bytes, which it turns into an attack; it panics when a promise is broken.
//! Fuzzers call the targets (`cargo xtask fuzz`), and so do ordinary tests, with a kept corpus and with random bytes.
//!
//! - [`frames`]: bytes on the line, and frames damaged on it.
//! - [`messages`]: the payload of any frame.
//! - [`storage`]: commands of any kind in any order, with and without the key, with the power cut.
//! - [`records`]: bytes that may be a coefficient set, and flash with anything in it.
//! - [`host`]: the host's commands and its recorder, on the line to a board that says anything.
//!
//! [`liar`] is that board, also for tests of the host tool. The others share [`input`], the starting points in [`bases`],
//! a [`key_holder`], [`nor_flash`], a flash memory whose power can be cut at any operation, and the [`sets`] that are
//! stored in it.

pub mod bases;
pub mod frames;
pub mod host;
pub mod input;
pub mod key_holder;
pub mod liar;
pub mod messages;
pub mod nor_flash;
pub mod records;
pub mod sets;
pub mod storage;

/// A target: it takes any bytes.
pub type Target = fn(&[u8]);

/// The targets by name.
pub const TARGETS: [(&str, Target); 5] = [
    ("frames", frames::run),
    ("messages", messages::run),
    ("storage", storage::run),
    ("records", records::run),
    ("host", host::run),
];
