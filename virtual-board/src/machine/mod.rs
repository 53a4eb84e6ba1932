//! The machine: the processor (Unicorn), its exceptions, its memories, and the bus with the peripherals on it.
//!
//! Time is counted in core cycles since power-on. One instruction is one cycle; a sleeping core jumps to the next event
//! of a peripheral. Events are carried out at their own instants, so that timers and converters are exact whatever
//! the core does; interrupts are taken at the next boundary of a basic block.

pub mod bus;
pub mod clock;
mod context;
pub mod core;
pub mod counting;
pub mod ecc;
pub mod exceptions;
pub mod faults;
mod hooks;
mod inject;
pub mod instructions;
pub mod memory;
pub mod system_memory;

pub use self::core::{Machine, Stop};
