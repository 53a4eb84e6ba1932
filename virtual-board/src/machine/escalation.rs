//! The handling of a fault (ARMv7-M B1.5.14, B1.5.15): its own handler, HardFault, or lockup.

use unicorn_engine::{RegisterARM, uc_error};

use super::context::Sleep;
use super::core::Machine;
use super::faults::{Fault, Halt, exception_name};
use super::stop::Stop;
use crate::peripherals::nvic::{HARD_FAULT, NMI};

/// HFSR: a fault was escalated; a debug event without debugger.
const FORCED: u32 = 1 << 30;
const DEBUG_EVENT: u32 = 1 << 31;
/// Thumb bit of xPSR.
const THUMB: u32 = 1 << 24;

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

    /// Handles a fault of the instruction at `pc`: enters its handler or HardFault's, or the core locks up.
    pub(super) fn fault(&mut self, fault: Fault, pc: u32) -> Result<(), Stop> {
        match self.record_fault(fault, pc) {
            Some(handler) => self.enter(handler, pc),
            None => self.lock_up(fault),
        }
    }

    /// The frame of `exception` could not be stacked; returns the exception to enter instead, on the present stack.
    pub(super) fn stacking_failed(&mut self, exception: usize, pc: u32) -> usize {
        if exception == HARD_FAULT || exception == NMI {
            let (_, bits, _) = Fault::Stacking.status();
            self.context_mut().bus.nvic.note_fault(bits, None);
            return exception;
        }
        self.record_fault(Fault::Stacking, pc).unwrap_or(HARD_FAULT)
    }

    /// Sets the status bits and returns the exception to enter; `None`: the core locks up.
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

    /// The core locks up and stops the machine; if the watchdog runs, it rests until the watchdog resets the chip.
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

    /// The core spins, no interrupt can reach it, and no watchdog runs.
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
