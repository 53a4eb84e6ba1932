//! The firmware under test: its ELF file, and the log that it writes into RAM.

pub mod elf;
pub mod log;
