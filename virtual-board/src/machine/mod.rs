//! The machine: the processor (Unicorn), its exceptions, and the loop that runs it on the bus.
//!
//! Time is counted in core cycles since power-on. One instruction is one cycle; a sleeping core jumps to the next event
//! of a peripheral. Events are carried out at their own instants, so that timers and converters are exact whatever
//! the core does; interrupts are taken at the next boundary of a basic block.

mod accesses;
mod context;
pub mod core;
pub mod counting;
mod escalation;
pub mod exceptions;
pub mod faults;
mod hooks;
mod inject;
pub mod instructions;
mod mapping;
pub mod masking;
mod rest;
pub mod stop;
mod stub;

pub use self::core::Machine;
pub use self::stop::Stop;
