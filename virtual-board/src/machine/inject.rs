//! Carries out the faults of the timeline, between two basic blocks.

use unicorn_engine::RegisterARM;

use super::context::Sleep;
use super::core::Machine;
use super::stop::Stop;
use super::stub::LOOP_AT;
use crate::firmware::variables::Place;
use crate::injection::Fault;
use crate::injection::timeline::Timeline;
use crate::memory::FLASH_BASE;
use crate::memory::ecc::Flaw;
use crate::peripherals::rcc::ResetCause;

/// Interval at which a fault looks for its active exception, s, and the longest search.
const LOOK_S: f64 = 0.5e-6;
const PATIENCE_S: f64 = 1.0;
/// Thumb bit of xPSR, and the number of the exception in it.
const THUMB: u32 = 1 << 24;
const EXCEPTION: u32 = 0x1FF;
const THREAD_MODE: usize = 0;

impl Machine {
    /// Injects these faults from now on.
    pub fn inject(&mut self, timeline: Timeline) {
        self.timeline = timeline;
        self.set_trap();
    }

    /// Carries out the next fault that has a time.
    pub(super) fn inject_timed(&mut self) -> Result<(), Stop> {
        match self.timeline.take_timed() {
            Some(fault) => self.carry_out(fault),
            None => Ok(()),
        }
    }

    /// Carries out the fault of the flash operation that is trapped.
    pub(super) fn inject_at_operation(&mut self) -> Result<(), Stop> {
        let fault = self.timeline.take_by_operation();
        self.set_trap();
        fault.map_or(Ok(()), |fault| self.carry_out(fault))
    }

    fn set_trap(&mut self) {
        let trap = self.timeline.next_operation();
        self.bus_mut().flash.set_trap(trap);
    }

    fn carry_out(&mut self, fault: Fault) -> Result<(), Stop> {
        self.note(&format!("injected: {fault:?}"));
        match fault {
            Fault::PowerCut => {
                self.bus_mut().cut_power().map_err(Stop::FlashFile)?;
                return Err(Stop::PowerCut {
                    at_s: self.bus().now_s(),
                });
            }
            Fault::PinReset => self.reset(ResetCause::Pin),
            Fault::BrownOut { ram_kept } => {
                if !ram_kept {
                    self.bus_mut().lose_ram();
                }
                self.reset(ResetCause::BrownOut);
            }
            Fault::Hang { exception: None } => {
                self.context_mut().sleep = Some(Sleep::LockedUp);
            }
            Fault::Hang {
                exception: Some(exception),
            } => return self.divert(exception, LOOP_AT),
            Fault::Jump { address } => return self.divert(THREAD_MODE, address),
            Fault::StackPointer { address } => {
                if self.reach(THREAD_MODE)? {
                    self.set_register(RegisterARM::MSP, address);
                }
            }
            Fault::Crystal { drift, returns } => {
                if self.bus_mut().stop_crystal(drift, returns) {
                    self.context_mut().sleep = Some(Sleep::LockedUp);
                }
            }
            Fault::Halt { duration_us } => return self.debugger_halts(duration_us),
            Fault::LogUnread => self.context_mut().stop_reading_the_log(),
            Fault::BitError { address, bits } => {
                let offset = (address - FLASH_BASE) as usize;
                let flaw = if bits == 1 { Flaw::OneBit } else { Flaw::Torn };
                self.bus_mut()
                    .flash_memory
                    .damage(offset, flaw)
                    .map_err(Stop::FlashFile)?;
            }
            Fault::DmaStall { of, duration_us } => self.bus_mut().stall_dma(of, duration_us),
            Fault::DmaSlip { adc, result } => self.bus_mut().slip_dma(adc, result),
            Fault::FlashStall { duration_us } => self.bus_mut().stall_flash(duration_us),
            Fault::TriggerStall { duration_us } => self.bus_mut().stall_triggers(duration_us),
            Fault::Hsi48 => self.bus_mut().stop_hsi48(),
            Fault::Random {
                defect,
                duration_us,
            } => self.bus_mut().break_random(defect, duration_us),
            Fault::Reference { share, duration_us } => {
                self.bus_mut().disturb_reference(share, duration_us);
            }
            Fault::RamBits { address, mask } => {
                if !self.bus_mut().flip_ram(address, mask) {
                    self.note(&format!("no RAM at {address:#010x}"));
                }
            }
            Fault::RamWord { holds, skip, mask } => {
                let found = self.bus().find_in_ram(holds, skip);
                match found {
                    Some(address) => {
                        self.note(&format!("{holds:#010x} is at {address:#010x}"));
                        self.bus_mut().flip_ram(address, mask);
                    }
                    None => self.note(&format!(
                        "{holds:#010x} is not in RAM {skip} times and once more"
                    )),
                }
            }
            Fault::Line {
                towards,
                effect,
                characters,
            } => self.bus_mut().lpuart.disturb(towards, effect, characters),
            Fault::Preset { place, value, .. } => {
                if let Some(Place { address, size }) = place {
                    let bytes = &value.to_le_bytes()[..size as usize];
                    // The symbol of a static lies in RAM, which is there.
                    let _ = self.uc.mem_write(u64::from(address), bytes);
                }
            }
        }
        Ok(())
    }

    /// Goes on at `address` as soon as `exception` is active.
    fn divert(&mut self, exception: usize, address: u32) -> Result<(), Stop> {
        if self.reach(exception)? {
            let state = self.register(RegisterARM::XPSR) & EXCEPTION | THUMB;
            self.set_register(RegisterARM::XPSR, state);
            self.context_mut().sleep = None;
            self.jump_clearing_monitor(address);
        }
        Ok(())
    }

    /// The core stands still for so long, while a debugger has it; a reset ends that.
    fn debugger_halts(&mut self, duration_us: u64) -> Result<(), Stop> {
        self.bus_mut().halt_core(duration_us);
        let until_s = self.bus().now_s() + duration_us as f64 * 1e-6;
        let most_sent = self.context_mut().most_sent.take();
        let sleep = self.context_mut().sleep.replace(Sleep::LockedUp);
        let result = self.run_on(until_s);
        let context = self.context_mut();
        context.most_sent = most_sent;
        if context.sleep == Some(Sleep::LockedUp) {
            context.sleep = sleep;
        }
        result
    }

    /// Runs until `exception` is active; false if that does not happen in time.
    fn reach(&mut self, exception: usize) -> Result<bool, Stop> {
        let most_sent = self.context_mut().most_sent.take();
        let end_s = self.bus().now_s() + PATIENCE_S;
        let mut result = Ok(());
        while self.active() != exception && self.bus().now_s() < end_s && result.is_ok() {
            let until_s = self.bus().now_s() + LOOK_S;
            result = self.run_on(until_s);
        }
        self.context_mut().most_sent = most_sent;
        result?;
        let reached = self.active() == exception;
        if !reached {
            self.note(&format!("exception {exception} was never active"));
        }
        Ok(reached)
    }

    fn active(&self) -> usize {
        self.bus().nvic.vect_active() as usize
    }
}
