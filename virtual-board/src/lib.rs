//! The virtual board: a NUCLEO-G474RE whose chip is emulated, which runs an unmodified firmware ELF in virtual time.
//!
//! A module imports only modules above it in this list:
//!
//! - [`injection`]: faults that are made on purpose;
//! - [`memory`]: the chip's memories, and the file of the flash memory;
//! - [`peripherals`]: the chip's peripherals, from the reference manual;
//! - [`pins`]: the twin at the analog pins (`docs/virtual-bench.md`);
//! - [`mod@bus`]: memories, peripherals and pins, wired together;
//! - [`firmware`]: the ELF file and its log;
//! - [`machine`]: the core and its exceptions;
//! - [`link`]: the host at the serial port.

pub mod bus;
pub mod firmware;
pub mod injection;
pub mod link;
pub mod machine;
pub mod memory;
pub mod peripherals;
pub mod pins;
