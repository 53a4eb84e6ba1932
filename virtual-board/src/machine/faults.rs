//! Faults (ARMv7-M B1.5.14, B1.5.15): their status bits, their escalation to HardFault, and the end of it all, lockup.

use thiserror::Error;
use unicorn_engine::{MemType, RegisterARM, uc_error};

use super::context::Sleep;
use super::core::{Machine, Stop};
use crate::peripherals::nvic::{BUS_FAULT, HARD_FAULT, INTERRUPTS, MEM_MANAGE, NMI, USAGE_FAULT};

/// HFSR: a fault was escalated; a debug event without debugger.
const FORCED: u32 = 1 << 30;
const DEBUG_EVENT: u32 = 1 << 31;
/// Thumb bit of xPSR.
const THUMB: u32 = 1 << 24;

/// An access that the memory map does not allow.
#[derive(Debug, Clone, Copy)]
pub struct BadAccess {
    /// What kind of access.
    pub kind: MemType,
    /// Where to.
    pub address: u32,
}

/// What went wrong.
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
    /// An instruction that needs alignment got none.
    #[error("unaligned access")]
    Unaligned,
    /// There is nothing to fetch instructions from.
    #[error("instruction fetch from {0:#010x}, where there is no code")]
    Fetch(u32),
    /// There is nothing to read or write.
    #[error("access to {0:#010x}, where there is nothing")]
    Access(u32),
    /// A store to memory that cannot be stored to.
    #[error("store to {0:#010x}, which is read-only")]
    ReadOnly(u32),
    /// The frame of an exception could not be written.
    #[error("the stack ran out while an exception was entered")]
    Stacking,
    /// The frame of an exception could not be read.
    #[error("the stack ran out while an exception was returned from")]
    Unstacking,
    /// The link register of a handler does not hold what it must.
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
    /// The core spins with everything masked.
    #[error("endless loop that nothing can interrupt")]
    Spinning,
    /// The emulator has met something that it has no name for.
    #[error("exception {0} of the emulator")]
    Unknown(u32),
}

impl Fault {
    /// The exception that handles the fault, its bits in CFSR, and the address that goes with it.
    fn status(self) -> (usize, u32, Option<u32>) {
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

/// The firmware will never do anything again.
#[derive(Debug, Error)]
#[error(
    "the firmware has faulted for good at {at_s:.6} s: {reason}, at PC {pc:#010x} in {handler}{history}\n\
     r0 {r0:#010x}  r1 {r1:#010x}  r2 {r2:#010x}  r3 {r3:#010x}  lr {lr:#010x}  sp {sp:#010x}"
)]
pub struct Halt {
    /// True time, s.
    pub at_s: f64,
    /// What went wrong last.
    pub reason: Fault,
    /// Where.
    pub pc: u32,
    /// What was running: thread mode or an exception.
    pub handler: String,
    /// The fault before, that brought the core to a HardFault handler which spins.
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

impl Machine {
    /// The emulator stopped with an error at `pc`.
    pub(super) fn fault_of_error(&mut self, error: uc_error, pc: u32) -> Result<(), Stop> {
        let address = self
            .context()
            .bad_access
            .map_or(pc, |access| access.address);
        let fault = match error {
            // Without the Thumb bit any instruction is invalid.
            uc_error::INSN_INVALID if self.register(RegisterARM::XPSR) & THUMB == 0 => {
                Fault::InvalidState
            }
            uc_error::INSN_INVALID => Fault::UndefinedInstruction,
            uc_error::EXCEPTION => Fault::InvalidState,
            uc_error::FETCH_UNMAPPED | uc_error::FETCH_PROT => Fault::Fetch(address),
            uc_error::READ_UNMAPPED | uc_error::WRITE_UNMAPPED | uc_error::READ_PROT => {
                Fault::Access(address)
            }
            uc_error::WRITE_PROT => Fault::ReadOnly(address),
            other => return Err(Stop::Emulator(other, pc)),
        };
        self.fault(fault, pc)
    }

    /// A fault of the instruction at `pc`: its handler is entered, or HardFault's, or the core locks up.
    pub(super) fn fault(&mut self, fault: Fault, pc: u32) -> Result<(), Stop> {
        match self.record_fault(fault, pc) {
            Some(handler) => self.enter(handler, pc),
            None => self.lock_up(fault),
        }
    }

    /// The frame of `exception` could not be stacked; the exception to enter instead, on what stack there is.
    pub(super) fn stacking_failed(&mut self, exception: usize, pc: u32) -> usize {
        if exception == HARD_FAULT || exception == NMI {
            let (_, bits, _) = Fault::Stacking.status();
            self.context_mut().bus.nvic.note_fault(bits, None);
            return exception;
        }
        self.record_fault(Fault::Stacking, pc).unwrap_or(HARD_FAULT)
    }

    /// Sets the status bits; the exception to enter, or none: the core locks up.
    fn record_fault(&mut self, fault: Fault, pc: u32) -> Option<usize> {
        let (exception, bits, address) = fault.status();
        let masks = self.masks();
        let nvic = &mut self.context_mut().bus.nvic;
        nvic.note_fault(bits, address);
        if exception != HARD_FAULT && nvic.can_take_fault(exception, masks) {
            return Some(exception);
        }
        if nvic.masked_priority(masks) < 0 {
            return None;
        }
        nvic.note_hard_fault(if fault == Fault::Breakpoint {
            DEBUG_EVENT
        } else {
            FORCED
        });
        self.note(&format!("HardFault at PC {pc:#010x}: {fault}"));
        self.context_mut().last_hard_fault = Some((fault, pc));
        Some(HARD_FAULT)
    }

    /// The core locks up. That is the end, unless the watchdog runs: then it rests until that bites.
    pub(super) fn lock_up(&mut self, reason: Fault) -> Result<(), Stop> {
        let pc = self.register(RegisterARM::PC);
        if !self.bus().iwdg.running() {
            return Err(self.halt(reason, pc));
        }
        self.note(&format!(
            "lockup at PC {pc:#010x}: {reason}; the watchdog will reset the chip"
        ));
        self.context_mut().sleep = Some(Sleep::LockedUp);
        Ok(())
    }

    /// The core spins where nothing interrupts it and no watchdog runs.
    pub(super) fn dead(&mut self) -> Stop {
        let pc = self.register(RegisterARM::PC);
        self.halt(Fault::Spinning, pc)
    }

    fn halt(&mut self, reason: Fault, pc: u32) -> Stop {
        let exception = self.context().bus.nvic.vect_active() as usize;
        let history = match self.context().last_hard_fault {
            Some((fault, at)) if exception == HARD_FAULT => {
                format!(" (entered after: {fault}, at PC {at:#010x})")
            }
            _ => String::new(),
        };
        Stop::Halted(Box::new(Halt {
            at_s: self.bus().now_s(),
            reason,
            pc,
            handler: exception_name(exception),
            history,
            r0: self.register(RegisterARM::R0),
            r1: self.register(RegisterARM::R1),
            r2: self.register(RegisterARM::R2),
            r3: self.register(RegisterARM::R3),
            lr: self.register(RegisterARM::LR),
            sp: self.register(RegisterARM::SP),
        }))
    }

    /// Writes a line about the core to stderr.
    pub(super) fn note(&self, text: &str) {
        eprintln!("[{:12.6}] board: {text}", self.bus().now_s());
    }
}
