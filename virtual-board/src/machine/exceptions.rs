//! Entry into exceptions and return from them (ARMv7-M B1.5.6 to B1.5.8).
//!
//! ```text
//! basic frame, 8 words:      r0 r1 r2 r3 r12 lr return-address xPSR
//! extended frame, 26 words:  the same, then s0 to s15, FPSCR, one word reserved
//! ```
//!
//! The extended frame is written at once, where the core would write it lazily; the handler sees the same.

use unicorn_engine::RegisterARM;

use super::context::Sleep;
use super::core::Machine;
use super::faults::{Fault, exception_name};
use super::hooks::IT_STATE;
use super::stop::Stop;
use crate::peripherals::nvic::{HARD_FAULT, SV_CALL};

/// Cycles from the acceptance of an exception to the first instruction of its handler, and back (Cortex-M4 TRM).
const ENTRY_CYCLES: u64 = 12;
const RETURN_CYCLES: u64 = 10;

const CORE_FRAME: [RegisterARM; 6] = [
    RegisterARM::R0,
    RegisterARM::R1,
    RegisterARM::R2,
    RegisterARM::R3,
    RegisterARM::R12,
    RegisterARM::LR,
];
const BASIC_WORDS: usize = 8;
const EXTENDED_WORDS: usize = 26;
const FRAME_ALIGNED: u32 = 1 << 9;
const FPCA: u32 = 1 << 2;
/// A bit of the emulator beside FPCA, set while a floating-point context is active. Without it the next floating-point
/// instruction begins a new context with the default FPSCR: the result of a comparison before an interrupt would be
/// lost.
const SFPA: u32 = 1 << 3;
const FP_CONTEXT: u32 = FPCA | SFPA;
const SPSEL: u32 = 1 << 1;

// The emulator's numbers of its exceptions.
const RAISED_UNDEFINED: u32 = 1;
const RAISED_SVC: u32 = 2;
const RAISED_PREFETCH_ABORT: u32 = 3;
const RAISED_DATA_ABORT: u32 = 4;
const RAISED_BREAKPOINT: u32 = 7;
const RAISED_EXCEPTION_EXIT: u32 = 8;
const RAISED_NO_COPROCESSOR: u32 = 17;
const RAISED_INVALID_STATE: u32 = 18;
const RAISED_UNALIGNED: u32 = 22;

impl Machine {
    /// The emulator raised an exception of the instruction stream.
    pub(super) fn raised(&mut self, number: u32) -> Result<(), Stop> {
        let pc = self.register(RegisterARM::PC);
        match number {
            RAISED_EXCEPTION_EXIT => self.leave(pc | 1),
            RAISED_SVC => {
                // The supervisor call is behind the program counter already.
                self.context_mut().bus.nvic.pend(SV_CALL);
                let masks = self.masks();
                if self.context().bus.nvic.to_take(masks) == Some(SV_CALL) {
                    self.enter(SV_CALL, pc)
                } else {
                    self.fault(Fault::SupervisorCallMasked, pc)
                }
            }
            RAISED_BREAKPOINT => self.fault(Fault::Breakpoint, pc),
            RAISED_NO_COPROCESSOR => self.fault(Fault::NoCoprocessor, pc),
            RAISED_INVALID_STATE => self.fault(Fault::InvalidState, pc),
            RAISED_PREFETCH_ABORT => self.fault(Fault::Fetch(pc), pc),
            RAISED_UNALIGNED | RAISED_DATA_ABORT => self.fault(Fault::Unaligned, pc),
            RAISED_UNDEFINED => self.fault(Fault::UndefinedInstruction, pc),
            _ => self.fault(Fault::Unknown(number), pc),
        }
    }

    /// Enters an exception: stacks a frame, switches to handler mode, goes to the vector.
    pub(super) fn enter(&mut self, exception: usize, return_address: u32) -> Result<(), Stop> {
        let control = self.register(RegisterARM::CONTROL);
        let handler_mode = !self.context().bus.nvic.idle();
        let extended = control & FPCA != 0 && self.context().bus.nvic.saves_fp_context();
        if control & FPCA != 0 && !self.context().bus.nvic.fpu_on() {
            let now_s = self.bus().now_s();
            let detail = format!("before {return_address:#010x}: the chip would have faulted");
            self.context_mut().bus.remarks.state(
                now_s,
                "the FPU was used while it is off (CPACR)",
                &detail,
            );
        }
        // If stacking fails, the handler of that fault runs instead, without a frame (ARMv7-M B1.5.11).
        let stacked = self.push_frame(return_address, extended);
        let exception = if stacked {
            exception
        } else {
            self.stacking_failed(exception, return_address)
        };
        let link = match (handler_mode, control & SPSEL != 0) {
            (true, _) => 0xFFFF_FFF1,
            (false, false) => 0xFFFF_FFF9,
            (false, true) => 0xFFFF_FFFD,
        };
        self.set_register(RegisterARM::LR, if extended { link & !0x10 } else { link });
        self.go_to_handler(exception)
    }

    fn go_to_handler(&mut self, exception: usize) -> Result<(), Stop> {
        let context = self.context_mut();
        context.bus.nvic.activate(exception);
        if let Some(counting) = &mut context.counting {
            counting.enter(exception);
        }
        context.cycles += ENTRY_CYCLES;
        context.event = true;
        context.sleep = None;
        let vector = context.bus.nvic.vector_table() + 4 * exception as u32;
        let flags = self.register(RegisterARM::XPSR) & 0xF80F_0000;
        self.set_register(RegisterARM::XPSR, flags | 0x0100_0000 | exception as u32);
        // In handler mode the main stack is in use, and no floating-point context is active.
        let control = self.register(RegisterARM::CONTROL);
        self.set_register(RegisterARM::CONTROL, control & !FP_CONTEXT);
        self.refresh_mode();
        let handler = self.word(vector).unwrap_or(0);
        if handler & 1 == 0 {
            self.note(&format!(
                "the vector of {} is {handler:#010x}",
                exception_name(exception)
            ));
            if exception == HARD_FAULT {
                return self.lock_up(Fault::BadVector);
            }
        }
        self.jump_clearing_monitor(handler);
        Ok(())
    }

    /// Returns from an exception to the place in `exc_return`.
    fn leave(&mut self, exc_return: u32) -> Result<(), Stop> {
        let exception = (self.register(RegisterARM::XPSR) & 0x1FF) as usize;
        let to_thread = exc_return & 0x8 != 0;
        let nested = self.context().bus.nvic.nested();
        if to_thread == nested || exc_return & 0xFFFF_FFE0 != 0xFFFF_FFE0 {
            return self.fault(Fault::BadReturn(exc_return), exc_return);
        }
        let context = self.context_mut();
        context.bus.nvic.deactivate(exception);
        if let Some(counting) = &mut context.counting {
            counting.leave();
        }
        context.cycles += RETURN_CYCLES;
        context.event = true;
        if exception != crate::peripherals::nvic::NMI {
            self.set_register(RegisterARM::FAULTMASK, 0);
        }
        let from_process_stack = exc_return & 0x4 != 0;
        let Some(return_address) = self.pop_frame(from_process_stack, exc_return & 0x10 == 0)
        else {
            return self.fault(Fault::Unstacking, exc_return);
        };
        if to_thread && self.context().bus.nvic.sleeps_on_exit() {
            self.context_mut().sleep = Some(Sleep::ForInterrupt);
        }
        if self.register(RegisterARM::XPSR) & IT_STATE != 0 {
            self.set_register(RegisterARM::PC, return_address | 1);
        } else {
            self.jump_clearing_monitor(return_address);
        }
        Ok(())
    }

    /// Pushes a frame onto the stack in use; false if there is no memory.
    fn push_frame(&mut self, return_address: u32, extended: bool) -> bool {
        let words = if extended {
            EXTENDED_WORDS
        } else {
            BASIC_WORDS
        };
        let sp = self.register(RegisterARM::SP);
        let align = self.context().bus.nvic.aligns_frames();
        let realigned = align && sp & 4 != 0;
        let frame = (sp.wrapping_sub(4 * words as u32)) & if align { !7 } else { !3 };
        let mut content = [0; EXTENDED_WORDS];
        for (word, register) in content.iter_mut().zip(CORE_FRAME) {
            *word = self.register(register);
        }
        content[6] = return_address & !1;
        let xpsr = self.register(RegisterARM::XPSR) & !FRAME_ALIGNED;
        content[7] = xpsr | 0x0100_0000 | if realigned { FRAME_ALIGNED } else { 0 };
        if extended {
            for (index, word) in content[BASIC_WORDS..BASIC_WORDS + 16]
                .iter_mut()
                .enumerate()
            {
                *word = self.register_by_number(RegisterARM::S0 as i32 + index as i32);
            }
            content[24] = self.register(RegisterARM::FPSCR);
        }
        let bytes: Vec<u8> = content[..words]
            .iter()
            .flat_map(|word| word.to_le_bytes())
            .collect();
        self.set_register(RegisterARM::SP, frame);
        if extended {
            let default = self.context().bus.nvic.default_fpscr();
            self.set_register(RegisterARM::FPSCR, default);
        }
        self.uc.mem_write(u64::from(frame), &bytes).is_ok()
    }

    /// Pops a frame and restores its registers; returns the return address, `None` if there is no memory.
    fn pop_frame(&mut self, from_process_stack: bool, extended: bool) -> Option<u32> {
        let words = if extended {
            EXTENDED_WORDS
        } else {
            BASIC_WORDS
        };
        let stack = if from_process_stack {
            RegisterARM::PSP
        } else {
            RegisterARM::MSP
        };
        let frame = self.register(stack);
        let mut bytes = [0; 4 * EXTENDED_WORDS];
        self.uc
            .mem_read(u64::from(frame), &mut bytes[..4 * words])
            .ok()?;
        let word = |index: usize| {
            u32::from_le_bytes([
                bytes[4 * index],
                bytes[4 * index + 1],
                bytes[4 * index + 2],
                bytes[4 * index + 3],
            ])
        };
        let xpsr = word(7);
        let padding = if xpsr & FRAME_ALIGNED != 0 { 4 } else { 0 };
        self.set_register(stack, frame.wrapping_add(4 * words as u32 + padding));
        for (index, register) in CORE_FRAME.into_iter().enumerate() {
            self.set_register(register, word(index));
        }
        if extended {
            for index in 0..16 {
                self.set_register_by_number(
                    RegisterARM::S0 as i32 + index,
                    word(BASIC_WORDS + index as usize),
                );
            }
            self.set_register(RegisterARM::FPSCR, word(24));
        }
        self.restore_mode(xpsr & !FRAME_ALIGNED, from_process_stack, extended);
        Some(word(6))
    }

    fn restore_mode(&mut self, xpsr: u32, process_stack: bool, fp_context: bool) {
        self.set_register(RegisterARM::XPSR_NZCVQG, xpsr);
        if xpsr & 0x1FF == 0 {
            let privilege = self.register(RegisterARM::CONTROL) & 1;
            let stack = if process_stack { SPSEL } else { 0 };
            self.set_register(
                RegisterARM::CONTROL,
                privilege | stack | if fp_context { FP_CONTEXT } else { 0 },
            );
        } else {
            let control = self.register(RegisterARM::CONTROL) & !FP_CONTEXT;
            self.set_register(
                RegisterARM::CONTROL,
                control | if fp_context { FP_CONTEXT } else { 0 },
            );
        }
        self.refresh_mode();
    }

    fn register_by_number(&self, number: i32) -> u32 {
        self.uc.reg_read(number).unwrap_or(0) as u32
    }

    fn set_register_by_number(&mut self, number: i32, value: u32) {
        // The caller's registers exist on this core.
        let _ = self.uc.reg_write(number, u64::from(value));
    }
}
