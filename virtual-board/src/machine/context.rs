//! State that the hooks of the emulator share with the loop that runs it: the bus, the core's time, and the reason of
//! the last pause.

use std::collections::HashSet;

use super::counting::Counting;
use super::faults::{BadAccess, Fault};
use super::instructions::BlockTable;
use crate::bus::Bus;
use crate::firmware::log::FirmwareLog;
use crate::memory::{CCM_BASE, CCM_SIZE, FLASH_BASE, FLASH_SIZE, RAM_BASE, RAM_SIZE};
use crate::peripherals::nvic::Masks;
use crate::peripherals::rcc::ResetCause;
use crate::peripherals::{Cycles, NEVER};

/// The areas of code: base and size of each block table.
const CODE_AREAS: [(u32, usize); 4] = [
    (FLASH_BASE, FLASH_SIZE),
    (0, FLASH_SIZE),
    (RAM_BASE, RAM_SIZE),
    (CCM_BASE, CCM_SIZE),
];
/// Interval at which the log of a busy core is read, cycles.
const LOG_INTERVAL: Cycles = 150_000;
const BRANCH_TO_SELF: u16 = 0xE7FE;

/// How the core rests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sleep {
    /// Until an interrupt or an event (WFE).
    ForEvent,
    /// Until an interrupt, even a masked one (WFI).
    ForInterrupt,
    /// Locked up: until the watchdog resets the chip.
    LockedUp,
}

/// Why the hook stopped the emulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pause {
    /// The hook did not stop it; the emulator itself stopped.
    None,
    /// The run's time is over.
    TimeOver,
    /// This exception is to be taken.
    Take(usize),
    /// The chip is to be reset.
    Reset(ResetCause),
    /// The watch on a bank of flash must be switched on or off.
    Watch,
    /// A flash operation has reached the point at which a fault is due.
    Trapped,
    /// The core spins for ever and nothing can interrupt it.
    Dead,
    /// The twin or the flash file failed.
    Failure,
}

/// Everything that the hooks can reach.
pub(super) struct Context {
    pub(super) bus: Bus,
    /// The core's time, cycles since power-on.
    pub(super) cycles: Cycles,
    /// From this time on the start of a block needs a closer look.
    pub(super) attention: Cycles,
    /// Latest end of the run: true time, and the same in cycles at the present clock.
    stop_s: f64,
    stop_at: Cycles,
    /// Number of waiting characters that ends the run; silence after a character ends it too.
    pub(super) most_sent: Option<usize>,
    /// Decoded blocks of each of [`CODE_AREAS`].
    pub(super) blocks: [BlockTable; CODE_AREAS.len()],
    /// Address behind the last block that ran.
    pub(super) block_end: u32,
    /// Pages of RAM from which code has run.
    pub(super) code_in_ram: HashSet<u64>,
    /// The event register.
    pub(super) event: bool,
    pub(super) sleep: Option<Sleep>,
    pub(super) pause: Pause,
    /// Number of the exception that the emulator met.
    pub(super) raised: Option<u32>,
    pub(super) bad_access: Option<BadAccess>,
    /// The last fault that became a HardFault, and its address.
    pub(super) last_hard_fault: Option<(Fault, u32)>,
    /// Banks whose reads come to the hook.
    pub(super) watched: [bool; 2],
    /// Every single read of bank 2 comes to this program.
    pub(super) sees_all: bool,
    /// Counts of instructions, if any were asked for.
    pub(super) counting: Option<Counting>,
    log: FirmwareLog,
    log_due: Cycles,
}

impl Context {
    pub(super) fn new(bus: Bus, log: FirmwareLog) -> Self {
        Self {
            bus,
            cycles: 0,
            attention: 0,
            stop_s: 0.0,
            stop_at: 0,
            most_sent: None,
            blocks: CODE_AREAS.map(|(base, size)| BlockTable::new(base, size)),
            block_end: 0,
            code_in_ram: HashSet::new(),
            event: false,
            sleep: None,
            pause: Pause::None,
            raised: None,
            bad_access: None,
            last_hard_fault: None,
            watched: [false; 2],
            sees_all: false,
            counting: None,
            log,
            log_due: 0,
        }
    }

    /// The block table for code at `address`.
    #[inline]
    pub(super) fn area_of(address: u32) -> usize {
        match address >> 24 {
            0x08 => 0,
            0x00 => 1,
            0x20 => 2,
            _ => 3,
        }
    }

    /// A run begins that ends at true time `until_s`.
    pub(super) fn begin_run(&mut self, until_s: f64) {
        self.stop_s = until_s;
        self.stop_at = self.bus.timebase.cycles(until_s);
    }

    /// Carries out everything that is due at the core's time.
    pub(super) fn catch_up(&mut self) {
        self.bus.run_events(self.cycles);
        if self.bus.clock_changed {
            self.bus.clock_changed = false;
            self.stop_at = self.bus.timebase.cycles(self.stop_s);
        }
        if self.cycles >= self.log_due {
            self.poll_log();
        }
    }

    /// Carries out everything that is due before the block at `address`.
    pub(super) fn catch_up_for_block(&mut self, address: u32) {
        self.bus.near_pc = address;
        self.catch_up();
        self.stall_on_busy_bank(address);
    }

    /// Whether the core's masks matter for the next decision.
    pub(super) fn masks_matter(&self, address: u32) -> bool {
        self.bus.nvic.may_preempt() || self.spins_at(address)
    }

    /// The reason to pause before the block at `address`, if any.
    pub(super) fn reason_to_pause(
        &mut self,
        address: u32,
        masks: Masks,
        in_it_block: bool,
    ) -> Pause {
        if let Some(cause) = self.bus.reset_request.take() {
            return Pause::Reset(cause);
        }
        if self.failed() {
            return Pause::Failure;
        }
        if self.bus.flash.trapped() {
            return Pause::Trapped;
        }
        if self.must_see_all() != self.sees_all
            || (0..2).any(|bank| self.bus.is_watched(bank) != self.watched[bank])
        {
            return Pause::Watch;
        }
        if let Some(exception) = self.bus.nvic.to_take(masks).filter(|_| !in_it_block) {
            return Pause::Take(exception);
        }
        if self.spins_at(address) && self.bus.nvic.masked_priority(masks) <= 0 {
            if !self.bus.iwdg.running() {
                return Pause::Dead;
            }
            // Only the watchdog ends this loop, so its turns need not be counted.
            self.cycles = self.cycles.max(self.bus.next_event().min(self.end()));
        }
        if self.cycles >= self.end() {
            Pause::TimeOver
        } else {
            Pause::None
        }
    }

    /// The time of the next closer look.
    pub(super) fn next_attention(&self) -> Cycles {
        if self.bus.nvic.may_preempt() {
            0
        } else {
            self.bus.next_event().min(self.end())
        }
    }

    /// The end of the run, as it is known now.
    pub(super) fn end(&self) -> Cycles {
        let Some(most) = self.most_sent else {
            return self.stop_at;
        };
        match self.bus.lpuart.sent_len() {
            0 => self.stop_at,
            sent if sent >= most => 0,
            _ => self
                .bus
                .lpuart
                .silent_at()
                .unwrap_or(NEVER)
                .min(self.stop_at),
        }
    }

    /// Whether a resting core must wake.
    pub(super) fn wakes(&self, masks: Masks) -> bool {
        let nvic = &self.bus.nvic;
        match self.sleep {
            None => true,
            // PRIMASK does not keep the core from waking (ARMv7-M B1.5.19).
            Some(Sleep::ForInterrupt) => nvic
                .to_take(Masks {
                    primask: false,
                    ..masks
                })
                .is_some(),
            Some(Sleep::ForEvent) => {
                nvic.to_take(masks).is_some() || (nvic.event_on_pend() && nvic.any_pending())
            }
            Some(Sleep::LockedUp) => false,
        }
    }

    /// Whether the twin or the flash file failed.
    pub(super) fn failed(&self) -> bool {
        self.bus.flash_file_failure.is_some() || self.bus.pins.failed()
    }

    pub(super) fn poll_log(&mut self) {
        self.log_due = self.cycles + LOG_INTERVAL;
        let now_s = self.bus.timebase.seconds(self.cycles);
        self.log.poll(&mut self.bus.ram, now_s);
    }

    /// The log is never read again, and a full one blocks.
    pub(super) fn stop_reading_the_log(&mut self) {
        self.log.stop_reading(&mut self.bus.ram);
    }

    /// The core starts from reset.
    pub(super) fn restart(&mut self) {
        self.event = false;
        self.sleep = None;
        self.attention = 0;
        self.last_hard_fault = None;
        if let Some(counting) = &mut self.counting {
            counting.reset();
        }
        self.log.restart();
    }

    fn spins_at(&self, address: u32) -> bool {
        let mut bytes = [0; 2];
        let found = match address {
            FLASH_BASE..=0x0807_FFFF => self
                .bus
                .flash_memory
                .block()
                .read((address - FLASH_BASE) as usize, &mut bytes),
            RAM_BASE..=0x2001_FFFF => self.bus.ram.read((address - RAM_BASE) as usize, &mut bytes),
            _ => false,
        };
        found && u16::from_le_bytes(bytes) == BRANCH_TO_SELF
    }
}
