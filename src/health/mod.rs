//! Whether the board is well: what counts, watches and remembers.

pub mod counters;
pub mod flash_errors;
pub mod panic;
pub mod resets;
pub mod stack;
pub mod watchdog;
