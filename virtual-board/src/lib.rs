//! The virtual board: a NUCLEO-G474RE whose chip is emulated, which runs an unmodified firmware ELF in virtual time.
//!
//! - [`machine`]: the core, its exceptions and memories, and the bus;
//! - [`peripherals`]: the chip's peripherals, from the reference manual;
//! - [`mod@bench`]: the twin at the analog pins, the host at the serial port;
//! - [`firmware`]: the ELF file and its log;
//! - [`injection`]: faults that are made on purpose.

pub mod bench;
pub mod firmware;
pub mod injection;
pub mod machine;
pub mod peripherals;
