//! Models of the chip's peripherals, one file each, written from the reference manual (RM0440) and tested against it.
//!
//! A model knows its registers and the passing of time, and no other model. Every call gives it the time in core
//! cycles. It tells when it needs the next call ([`NEVER`] if it does not), and shows its interrupt line and DMA
//! requests as levels. [`crate::bus`] wires the models together.

pub mod adc;
pub mod crc;
pub mod debug;
pub mod dma;
pub mod dmamux;
pub mod exti;
pub mod flash;
pub mod gpio;
pub mod iwdg;
pub mod lpuart;
pub mod nvic;
pub mod pwr;
pub mod rcc;
pub mod rng;
pub mod syscfg;
pub mod systick;
pub mod timer;

/// A point in virtual time, or a duration: cycles of the core since power-on.
pub type Cycles = u64;

/// The deadline of a peripheral that waits for nothing.
pub const NEVER: Cycles = Cycles::MAX;

/// A feature that a register access needs and the model lacks. It is reported once, with address and program counter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unmodelled(pub &'static str);

/// The answer to a register read: the value, or why the model has none (it then reads as zero).
pub type Read = Result<u32, Unmodelled>;

/// The answer to a register write: done, or the part that the model leaves out.
pub type Write = Result<(), Unmodelled>;

/// The register is not part of the model.
pub const NO_SUCH_REGISTER: Unmodelled = Unmodelled("no such register in the model");

/// Bits `low..low + width` of a register.
pub fn field(register: u32, low: u32, width: u32) -> u32 {
    (register >> low) & ((1 << width) - 1)
}

/// Whether bit `index` of a register is set.
pub fn bit(register: u32, index: u32) -> bool {
    register & (1 << index) != 0
}
