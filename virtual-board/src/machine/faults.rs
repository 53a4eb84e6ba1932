//! The faults of the core (ARMv7-M B1.5.14, B1.5.15), with their status bits.

use thiserror::Error;
use unicorn_engine::MemType;

use crate::peripherals::nvic::{BUS_FAULT, HARD_FAULT, INTERRUPTS, MEM_MANAGE, NMI, USAGE_FAULT};

/// An access that the memory map does not allow.
#[derive(Debug, Clone, Copy)]
pub struct BadAccess {
    /// Kind of access.
    pub kind: MemType,
    /// Its address.
    pub address: u32,
}

/// A fault of the core.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum Fault {
    /// An instruction that the core does not know.
    #[error("undefined instruction")]
    UndefinedInstruction,
    /// A jump to an even address, or a vector that is even.
    #[error("jump to an address without the Thumb bit")]
    InvalidState,
    /// A coprocessor or the FPU was used while it is off.
    #[error("use of a coprocessor that is off")]
    NoCoprocessor,
    /// An unaligned access by an instruction that needs alignment.
    #[error("unaligned access")]
    Unaligned,
    /// An instruction fetch where there is no code.
    #[error("instruction fetch from {0:#010x}, where there is no code")]
    Fetch(u32),
    /// A read or write where there is no memory.
    #[error("access to {0:#010x}, where there is nothing")]
    Access(u32),
    /// A store to read-only memory.
    #[error("store to {0:#010x}, which is read-only")]
    ReadOnly(u32),
    /// The frame of an exception could not be written.
    #[error("the stack ran out while an exception was entered")]
    Stacking,
    /// The frame of an exception could not be read.
    #[error("the stack ran out while an exception was returned from")]
    Unstacking,
    /// The link register of a handler does not hold a valid return code.
    #[error("exception return with {0:#010x}, which is impossible here")]
    BadReturn(u32),
    /// BKPT without a debugger.
    #[error("breakpoint without a debugger")]
    Breakpoint,
    /// SVC where it cannot be taken.
    #[error("supervisor call while it is masked")]
    SupervisorCallMasked,
    /// The vector of HardFault is not a function.
    #[error("the vector table has no HardFault handler")]
    BadVector,
    /// The core spins with all interrupts masked.
    #[error("endless loop that nothing can interrupt")]
    Spinning,
    /// An unknown exception of the emulator.
    #[error("exception {0} of the emulator")]
    Unknown(u32),
}

impl Fault {
    /// The exception that handles the fault, its bits in CFSR, and the faulty address.
    pub(super) fn status(self) -> (usize, u32, Option<u32>) {
        match self {
            Self::UndefinedInstruction | Self::Unknown(_) => (USAGE_FAULT, 1 << 16, None),
            Self::InvalidState => (USAGE_FAULT, 1 << 17, None),
            Self::BadReturn(_) => (USAGE_FAULT, 1 << 18, None),
            Self::NoCoprocessor => (USAGE_FAULT, 1 << 19, None),
            Self::Unaligned => (USAGE_FAULT, 1 << 24, None),
            Self::Fetch(_) => (BUS_FAULT, 1 << 8, None),
            Self::Access(address) => (BUS_FAULT, 1 << 9 | 1 << 15, Some(address)),
            Self::ReadOnly(address) => (MEM_MANAGE, 1 << 1 | 1 << 7, Some(address)),
            Self::Unstacking => (BUS_FAULT, 1 << 11, None),
            Self::Stacking => (BUS_FAULT, 1 << 12, None),
            Self::Breakpoint | Self::SupervisorCallMasked | Self::BadVector | Self::Spinning => {
                (HARD_FAULT, 0, None)
            }
        }
    }
}

/// The firmware has halted for ever.
#[derive(Debug, Error)]
#[error(
    "the firmware has faulted for good at {at_s:.6} s: {reason}, at PC {pc:#010x} in {handler}{history}\n\
     r0 {r0:#010x}  r1 {r1:#010x}  r2 {r2:#010x}  r3 {r3:#010x}  lr {lr:#010x}  sp {sp:#010x}"
)]
pub struct Halt {
    /// True time, s.
    pub at_s: f64,
    /// The last fault.
    pub reason: Fault,
    /// Its address.
    pub pc: u32,
    /// The running code: thread mode or an exception.
    pub handler: String,
    /// The fault before it, which led to a HardFault handler that spins.
    pub history: String,
    /// Register r0.
    pub r0: u32,
    /// Register r1.
    pub r1: u32,
    /// Register r2.
    pub r2: u32,
    /// Register r3.
    pub r3: u32,
    /// Link register.
    pub lr: u32,
    /// Stack pointer.
    pub sp: u32,
}

/// Name of an exception by its number.
pub fn exception_name(exception: usize) -> String {
    match exception {
        0 => "thread mode".to_owned(),
        NMI => "NMI".to_owned(),
        HARD_FAULT => "HardFault".to_owned(),
        MEM_MANAGE => "MemManage".to_owned(),
        BUS_FAULT => "BusFault".to_owned(),
        USAGE_FAULT => "UsageFault".to_owned(),
        16.. if exception < 16 + INTERRUPTS => format!("interrupt {}", exception - 16),
        _ => format!("exception {exception}"),
    }
}
