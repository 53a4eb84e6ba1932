//! Accesses of the core that the emulator leaves to this program: to registers, and to flash memory that is busy or torn.

use super::context::Context;
use crate::memory::{BANK_SIZE, FLASH_BASE, FLASH_SIZE};

impl Context {
    /// An operation on the flash memory keeps the core waiting until it ends.
    pub(super) fn wait_for_flash(&mut self) {
        if self.bus.flash.is_at_work() {
            self.cycles = self.cycles.max(self.bus.flash.next_event());
            self.bus.run_events(self.cycles);
        }
    }

    /// The core stores into the flash memory.
    pub(super) fn store_to_flash(&mut self, offset: usize, value: u32, size: usize) {
        self.before_access();
        self.wait_for_flash();
        self.bus.store_to_flash(offset, value, size);
    }

    /// The core is about to read from a bank that is watched.
    pub(super) fn look_at_flash(&mut self, offset: usize) {
        self.before_access();
        if self.bus.flash.is_busy(offset / BANK_SIZE) {
            self.wait_for_flash();
        }
        self.bus.check_flash_read(offset);
    }

    /// Whether every single read of bank 2 must be looked at.
    pub(super) fn must_see_all(&self) -> bool {
        let flaws = self.bus.flash_memory.flaws();
        flaws.any_in(BANK_SIZE..FLASH_SIZE)
    }

    /// The core cannot fetch from a bank that is being programmed or erased.
    pub(super) fn stall_on_busy_bank(&mut self, address: u32) {
        if !self.bus.flash.is_at_work() {
            return;
        }
        let offset = if address < FLASH_SIZE as u32 {
            address
        } else {
            address.wrapping_sub(FLASH_BASE)
        };
        if self.bus.flash.is_busy(offset as usize / BANK_SIZE) {
            self.wait_for_flash();
        }
    }

    /// Before a register access all events up to now are carried out; the access may have any effect, so the next block
    /// gets a closer look.
    pub(super) fn before_access(&mut self) {
        self.bus.run_events(self.cycles);
        self.attention = 0;
    }
}
