//! The sample path in the firmware's own ELF, on the virtual board: what it streams, sums up and loses.
//!
//! Needs both built, and says where by `HEXSENSE_VIRTUAL_BOARD` and `HEXSENSE_FIRMWARE`; run with `-- --ignored`, or by
//! `cargo xtask test`.

mod bench;
mod counted;
mod latency;
mod recovery;
mod set;
mod stack;
mod stream;
mod sums;
mod triggers;
mod writes;
