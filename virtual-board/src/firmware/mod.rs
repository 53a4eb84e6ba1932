//! The firmware under test: its ELF file, where its variables are, and the log that it writes into RAM.

pub mod elf;
pub mod log;
pub mod variables;
