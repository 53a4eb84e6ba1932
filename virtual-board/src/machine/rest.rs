//! The work between two runs of the emulation: sleep, the watch on banks of flash, and failures outside of the core.

use unicorn_engine::{Prot, RegisterARM, uc_error};

use super::core::Machine;
use super::mapping::map_bank_2;
use super::stop::Stop;
use crate::memory::{BANK_SIZE, FLASH_BASE};

impl Machine {
    /// Rests until an event wakes the core (true) or the run's time is over (false).
    pub(super) fn sleep_on(&mut self) -> Result<bool, Stop> {
        self.context_mut().poll_log();
        let masks = self.masks();
        loop {
            let context = self.uc.get_data_mut();
            if let Some(cause) = context.bus.reset_request.take() {
                self.reset(cause);
                return Ok(true);
            }
            if context.failed() {
                return Err(self.failure());
            }
            if context.bus.flash.trapped() {
                self.inject_at_operation()?;
                continue;
            }
            if context.wakes(masks) {
                context.sleep = None;
                return Ok(true);
            }
            let end = context.end();
            if context.cycles >= end {
                return Ok(false);
            }
            let slept = context
                .bus
                .next_event()
                .min(end)
                .saturating_sub(context.cycles);
            context.bus.slept(slept);
            context.cycles += slept;
            context.catch_up();
        }
    }

    pub(super) fn failure(&mut self) -> Stop {
        let bus = &mut self.context_mut().bus;
        if let Some(error) = bus.flash_file_failure.take() {
            return Stop::FlashFile(error);
        }
        match bus.pins.take_failure() {
            Some(error) => Stop::Pins(error),
            None => Stop::Emulator(uc_error::OK, bus.near_pc),
        }
    }

    /// Makes watched banks of flash unreadable, so that reads of them come to the hook.
    pub(super) fn watch_banks(&mut self) -> Result<(), Stop> {
        let see_all = self.context().must_see_all();
        if see_all != self.context().sees_all {
            map_bank_2(&mut self.uc, !see_all)
                .map_err(|error| Stop::Emulator(error, FLASH_BASE))?;
            self.context_mut().sees_all = see_all;
            self.context_mut().watched[1] = false;
        }
        for bank in 0..2 {
            let watch = self.context().bus.is_watched(bank);
            if watch == self.context().watched[bank] {
                continue;
            }
            if bank == 1 && see_all {
                self.context_mut().watched[bank] = watch;
                continue;
            }
            let rights = if watch {
                Prot::EXEC
            } else {
                Prot::READ | Prot::EXEC
            };
            for base in [FLASH_BASE, 0] {
                let start = base + (bank * BANK_SIZE) as u32;
                self.uc
                    .mem_protect(u64::from(start), BANK_SIZE as u64, rights)
                    .map_err(|error| Stop::Emulator(error, start))?;
            }
            self.context_mut().watched[bank] = watch;
        }
        // The emulator's cached rights of the pages are out of date.
        let pc = self.register(RegisterARM::PC);
        self.uc
            .ctl_flush_tlb()
            .map_err(|error| Stop::Emulator(error, pc))
    }
}
