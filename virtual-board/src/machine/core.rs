//! The processor: Unicorn's Cortex-M4 with the chip's memories mapped into it, and the loop that runs it.
//!
//! Unicorn executes instructions and nothing else: it has no interrupts, no sleep and no time. So a hook at the start
//! of every basic block adds the block's instructions to the time. When the time has come for an event, it lets the
//! peripherals carry it out, and stops the emulation if an exception is to be taken. Entry, return, sleep and faults
//! are then done here, between two runs of the emulation.

use std::collections::HashSet;
use std::ops::RangeInclusive;

use thiserror::Error;
use unicorn_engine::{
    Arch, ArmCpuModel, HookType, MemType, Mode, Prot, RegisterARM, TlbEntry, TlbType, Unicorn, uc_error,
};

use super::bus::{Bus, FLASH_SIZE};
use super::faults::{BadAccess, Fault, Halt};
use super::instructions::{self, BlockTable};
use super::memory::{
    Block, CCM_BASE, CCM_SIZE, FLASH_BASE, FlashFileError, RAM_BASE, RAM_SIZE, SYSTEM_BASE,
    SYSTEM_SIZE,
};
use crate::bench::pins::PinsError;
use crate::firmware::log::FirmwareLog;
use crate::peripherals::flash::BANK_SIZE;
use crate::peripherals::nvic::Masks;
use crate::peripherals::rcc::ResetCause;
use crate::peripherals::{Cycles, NEVER};

/// Registers of the buses AHB1/APB1/APB2, AHB2, and of the core itself.
const REGISTER_AREAS: [RangeInclusive<u32>; 4] = [
    0x4000_0000..=0x4002_FFFF,
    0x4800_0000..=0x4800_1FFF,
    0x5000_0000..=0x5006_0FFF,
    0xE000_0000..=0xE00F_FFFF,
];
/// A page of the code area that does not exist on the chip, with a few instructions of the model's own ([`CLEAR_MONITOR`]).
const STUB_BASE: u32 = 0x1E00_0000;
/// `clrex; ldr.w pc, [pc, #0]; .word target`: clears the exclusive monitor, then jumps. The emulator offers no other
/// way to clear it, and an exception must.
const CLEAR_MONITOR: [u8; 8] = [0xBF, 0xF3, 0x2F, 0x8F, 0xDF, 0xF8, 0x00, 0xF0];
const STUB_TARGET: usize = CLEAR_MONITOR.len();
/// Everything but RAM. A hook that covers RAM would make every store to it slow.
const BESIDE_RAM: [RangeInclusive<u32>; 3] =
    [0..=CCM_BASE - 1, CCM_BASE + CCM_SIZE as u32..=RAM_BASE - 1, RAM_BASE + RAM_SIZE as u32..=u32::MAX];
/// Where flash, RAM and CCM code is found in the block tables.
const CODE_AREAS: [(u32, usize); 4] = [
    (FLASH_BASE, FLASH_SIZE),
    (0, FLASH_SIZE),
    (RAM_BASE, RAM_SIZE),
    (CCM_BASE, CCM_SIZE),
];
/// How often a busy core's log is looked at, cycles.
const LOG_INTERVAL: Cycles = 150_000;
const WFE: u16 = 0xBF20;
const WFI: u16 = 0xBF30;
const YIELD: u16 = 0xBF10;
const BRANCH_TO_SELF: u16 = 0xE7FE;

/// Why the machine cannot go on.
#[derive(Debug, Error)]
pub enum Stop {
    /// The firmware has faulted and will never do anything again.
    #[error(transparent)]
    Halted(#[from] Box<Halt>),
    /// The twin is gone.
    #[error(transparent)]
    Pins(#[from] PinsError),
    /// The flash file cannot be written.
    #[error("the flash file cannot be written: {0}")]
    FlashFile(std::io::Error),
    /// The emulator reports something that it never should.
    #[error("the emulator stopped with {0:?} at PC {1:#010x}")]
    Emulator(uc_error, u32),
}

/// Why the machine cannot be built.
#[derive(Debug, Error)]
pub enum BuildError {
    /// The flash file is unusable.
    #[error(transparent)]
    FlashFile(#[from] FlashFileError),
    /// The emulator refuses.
    #[error("the emulator cannot be set up: {0:?}")]
    Emulator(uc_error),
}

impl From<uc_error> for BuildError {
    fn from(error: uc_error) -> Self {
        Self::Emulator(error)
    }
}

/// How the core sleeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sleep {
    /// Until an interrupt or an event.
    ForEvent,
    /// Until an interrupt, even a masked one.
    ForInterrupt,
}

/// Why the hook stopped the emulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Pause {
    /// Nothing is pending, or it was the emulator itself that stopped.
    None,
    /// The run's time is over.
    TimeOver,
    /// This exception is to be taken.
    Take(usize),
    /// The chip is to be reset.
    Reset(ResetCause),
    /// A bank of flash must be watched, or no longer.
    Watch,
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
    /// From when on a block's start needs a closer look.
    attention: Cycles,
    /// When the run ends at the latest: true time, and what that is in cycles as the clock runs now.
    stop_s: f64,
    stop_at: Cycles,
    /// The run also ends when so many characters wait, or none follows.
    most_sent: Option<usize>,
    blocks: [BlockTable; CODE_AREAS.len()],
    /// Where the block that ran last ends.
    block_end: u32,
    /// Pages of RAM that code has been run from.
    code_in_ram: HashSet<u64>,
    /// The event register.
    pub(super) event: bool,
    pub(super) sleep: Option<Sleep>,
    pause: Pause,
    /// Number of the exception that the emulator met.
    raised: Option<u32>,
    pub(super) bad_access: Option<BadAccess>,
    /// The last fault that became a HardFault, and where.
    pub(super) last_hard_fault: Option<(Fault, u32)>,
    watched: [bool; 2],
    log: FirmwareLog,
    log_due: Cycles,
}

/// The chip with its firmware.
pub struct Machine {
    pub(super) uc: Unicorn<'static, Context>,
    stub: Block,
}

impl Machine {
    /// A powered machine that is about to begin at the reset vector.
    pub fn new(bus: Bus, log: FirmwareLog) -> Result<Self, BuildError> {
        let context = Context {
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
            log,
            log_due: 0,
        };
        let mut uc = Unicorn::new_with_data(Arch::ARM, Mode::THUMB | Mode::MCLASS, context)?;
        uc.ctl_set_cpu_model(ArmCpuModel::CORTEX_M4 as i32)?;
        let mut stub = Block::new(4096);
        assert!(stub.write(0, &CLEAR_MONITOR), "it fits");
        map_memories(&mut uc, &stub)?;
        map_registers(&mut uc)?;
        add_hooks(&mut uc)?;
        let mut machine = Self { uc, stub };
        machine.start_core();
        Ok(machine)
    }

    /// The serial port's side of the machine, and the time.
    pub fn bus(&self) -> &Bus {
        &self.context().bus
    }

    /// As [`Self::bus`], to be changed; what changes is noticed when the machine runs on.
    pub fn bus_mut(&mut self) -> &mut Bus {
        &mut self.context_mut().bus
    }

    /// Runs until true time `until_s` since power-on, or a little beyond: to the end of a basic block.
    pub fn run(&mut self, until_s: f64) -> Result<(), Stop> {
        let context = self.context_mut();
        context.stop_s = until_s;
        context.stop_at = context.bus.timebase.cycles(until_s);
        loop {
            let context = self.context_mut();
            let now = context.cycles;
            context.bus.run_events(now);
            context.attention = 0;
            if context.cycles >= context.end() {
                self.poll_log();
                return Ok(());
            }
            if self.context().sleep.is_some() && !self.sleep_on()? {
                self.poll_log();
                return Ok(());
            }
            let result = self.emulate();
            self.after_emulation(result)?;
        }
    }

    /// As [`Self::run`], but also stops when the transmitter has been silent for two character times after at least
    /// one character, or `most` characters wait to be collected.
    pub fn run_until_silent(&mut self, until_s: f64, most: usize) -> Result<(), Stop> {
        self.context_mut().most_sent = Some(most);
        let result = self.run(until_s);
        self.context_mut().most_sent = None;
        result
    }

    pub(super) fn context(&self) -> &Context {
        self.uc.get_data()
    }

    pub(super) fn context_mut(&mut self) -> &mut Context {
        self.uc.get_data_mut()
    }

    pub(super) fn register(&self, register: RegisterARM) -> u32 {
        register_of(&self.uc, register)
    }

    pub(super) fn set_register(&mut self, register: RegisterARM, value: u32) {
        // The registers are constants that exist on this core.
        let _ = self.uc.reg_write(register, u64::from(value));
    }

    pub(super) fn masks(&self) -> Masks {
        masks_of(&self.uc)
    }

    /// Goes on at `address` with the exclusive monitor cleared.
    pub(super) fn jump_clearing_monitor(&mut self, address: u32) {
        let thumb_address = address | 1;
        assert!(
            self.stub.write(STUB_TARGET, &thumb_address.to_le_bytes()),
            "it fits"
        );
        self.set_register(RegisterARM::PC, STUB_BASE | 1);
    }

    /// A half-word of memory as the core sees it, if there is any.
    pub(super) fn half_word(&self, address: u32) -> Option<u16> {
        let mut bytes = [0; 2];
        self.uc
            .mem_read(u64::from(address), &mut bytes)
            .ok()
            .map(|()| u16::from_le_bytes(bytes))
    }

    pub(super) fn word(&self, address: u32) -> Option<u32> {
        let mut bytes = [0; 4];
        self.uc
            .mem_read(u64::from(address), &mut bytes)
            .ok()
            .map(|()| u32::from_le_bytes(bytes))
    }

    fn emulate(&mut self) -> Result<(), uc_error> {
        let context = self.context_mut();
        context.pause = Pause::None;
        context.raised = None;
        context.bad_access = None;
        let pc = u64::from(self.register(RegisterARM::PC) | 1);
        // The end address is one that is never reached.
        self.uc.emu_start(pc, u64::from(STUB_BASE + 0xFFE), 0, 0)
    }

    fn after_emulation(&mut self, result: Result<(), uc_error>) -> Result<(), Stop> {
        let context = self.context_mut();
        if let Some(raised) = context.raised.take() {
            return self.raised(raised);
        }
        match (context.pause, result) {
            (Pause::TimeOver, _) => Ok(()),
            (Pause::Take(exception), _) => self.enter(exception, self.register(RegisterARM::PC)),
            (Pause::Reset(cause), _) => {
                self.reset(cause);
                Ok(())
            }
            (Pause::Watch, _) => self.watch_banks(),
            (Pause::Dead, _) => Err(self.dead()),
            (Pause::Failure, _) => Err(self.failure()),
            (Pause::None, Err(error)) => self.emulator_error(error),
            (Pause::None, Ok(())) => self.halted_by_itself(),
        }
    }

    /// The emulator ends a run at WFI, with the program counter behind it.
    fn halted_by_itself(&mut self) -> Result<(), Stop> {
        let pc = self.register(RegisterARM::PC);
        if self.half_word(pc.wrapping_sub(2)) == Some(WFI) {
            self.context_mut().sleep = Some(Sleep::ForInterrupt);
            return Ok(());
        }
        Err(Stop::Emulator(uc_error::OK, pc))
    }

    fn emulator_error(&mut self, error: uc_error) -> Result<(), Stop> {
        let pc = self.register(RegisterARM::PC);
        // WFE and YIELD end a run as invalid instructions too, but end their block, and leave the counter behind it.
        if error == uc_error::INSN_INVALID && pc == self.context().block_end {
            match self.half_word(pc.wrapping_sub(2)) {
                Some(WFE) => {
                    self.wait_for_event();
                    return Ok(());
                }
                Some(YIELD) => return Ok(()),
                _ => {}
            }
        }
        self.fault_of_error(error, pc)
    }

    fn wait_for_event(&mut self) {
        let context = self.context_mut();
        if !std::mem::take(&mut context.event) {
            context.sleep = Some(Sleep::ForEvent);
        }
    }

    /// Sleeps until something wakes the core (true) or the run's time is over (false).
    fn sleep_on(&mut self) -> Result<bool, Stop> {
        self.poll_log();
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
            if context.wakes(masks) {
                context.sleep = None;
                context.attention = 0;
                return Ok(true);
            }
            let next = context.bus.next_event().min(context.end());
            if next == NEVER {
                // No event will ever come; time passes all the same.
                return Ok(false);
            }
            let slept = next.saturating_sub(context.cycles);
            context.bus.slept(slept);
            context.cycles += slept;
            let now = context.cycles;
            context.bus.run_events(now);
            if context.cycles >= context.end() && !context.wakes(masks) {
                return Ok(false);
            }
        }
    }

    fn poll_log(&mut self) {
        self.context_mut().poll_log();
    }

    fn failure(&mut self) -> Stop {
        let bus = &mut self.context_mut().bus;
        if let Some(error) = bus.flash_file_failure.take() {
            return Stop::FlashFile(error);
        }
        match bus.pins.take_failure() {
            Some(error) => Stop::Pins(error),
            None => Stop::Emulator(uc_error::OK, bus.near_pc),
        }
    }

    /// Makes banks of flash unreadable that need watching: every read of them then comes to the hook.
    fn watch_banks(&mut self) -> Result<(), Stop> {
        for bank in 0..2 {
            let watch = self.context().bus.flash.watched(bank);
            if watch == self.context().watched[bank] {
                continue;
            }
            let rights = if watch {
                Prot::EXEC
            } else {
                Prot::READ | Prot::EXEC
            };
            for base in [FLASH_BASE, 0] {
                let start = u64::from(base) + (bank * BANK_SIZE) as u64;
                self.uc
                    .mem_protect(start, BANK_SIZE as u64, rights)
                    .map_err(|error| Stop::Emulator(error, start as u32))?;
            }
            self.context_mut().watched[bank] = watch;
        }
        Ok(())
    }

    fn reset(&mut self, cause: ResetCause) {
        self.poll_log();
        let now_s = self.bus().now_s();
        eprintln!("[{now_s:12.6}] board: reset: {cause:?}");
        self.context_mut().bus.reset(cause);
        self.start_core();
    }

    /// The core's state after reset (ARMv7-M B1.5.5): stack pointer and program counter from the vector table.
    fn start_core(&mut self) {
        let context = self.context_mut();
        context.event = false;
        context.sleep = None;
        context.attention = 0;
        context.log.restart();
        self.set_register(RegisterARM::XPSR, 0x0100_0000);
        for register in [
            RegisterARM::PRIMASK,
            RegisterARM::BASEPRI,
            RegisterARM::FAULTMASK,
            RegisterARM::CONTROL,
        ] {
            self.set_register(register, 0);
        }
        self.set_register(RegisterARM::FPSCR, 0);
        self.set_register(RegisterARM::LR, 0xFFFF_FFFF);
        self.set_register(RegisterARM::MSP, self.word(0).unwrap_or(0) & !3);
        self.refresh_mode();
        let entry = self.word(4).unwrap_or(0);
        self.jump_clearing_monitor(entry);
    }

    /// The emulator derives translation flags from the mode; writing the condition flags makes it do so again.
    pub(super) fn refresh_mode(&mut self) {
        let flags = self.register(RegisterARM::XPSR) & 0xF000_0000;
        self.set_register(RegisterARM::APSR_NZCV, flags);
    }
}

impl Context {
    /// Brings everything up to the start of the block at `address`.
    fn catch_up(&mut self, address: u32) {
        self.bus.near_pc = address;
        self.bus.run_events(self.cycles);
        if self.bus.clock_changed {
            self.bus.clock_changed = false;
            self.stop_at = self.bus.timebase.cycles(self.stop_s);
        }
        self.stall_on_busy_bank(address);
        if self.cycles >= self.log_due {
            self.poll_log();
        }
    }

    /// Whether the core's masks matter for what comes next.
    fn masks_matter(&self, address: u32) -> bool {
        self.bus.nvic.may_preempt() || self.spins_at(address)
    }

    /// Why the block at `address` must not run now, if so.
    fn reason_to_pause(&mut self, address: u32, masks: Masks, in_it_block: bool) -> Pause {
        if let Some(cause) = self.bus.reset_request.take() {
            return Pause::Reset(cause);
        }
        if self.failed() {
            return Pause::Failure;
        }
        if (0..2).any(|bank| self.bus.flash.watched(bank) != self.watched[bank]) {
            return Pause::Watch;
        }
        if let Some(exception) = self.bus.nvic.to_take(masks).filter(|_| !in_it_block) {
            return Pause::Take(exception);
        }
        if self.spins_at(address) && self.bus.nvic.masked_priority(masks) <= 0 {
            if !self.bus.iwdg.running() {
                return Pause::Dead;
            }
            // Nothing but the watchdog ends this; there is no use in counting every turn.
            self.cycles = self.cycles.max(self.bus.next_event().min(self.end()));
        }
        if self.cycles >= self.end() {
            Pause::TimeOver
        } else {
            Pause::None
        }
    }

    /// When the run ends, as far as can be said now.
    fn end(&self) -> Cycles {
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

    /// The core cannot fetch from a bank that is being programmed or erased: it waits.
    fn stall_on_busy_bank(&mut self, address: u32) {
        let Some(busy) = self.bus.flash.busy_bank() else {
            return;
        };
        let offset = if address < FLASH_SIZE as u32 {
            address
        } else {
            address.wrapping_sub(FLASH_BASE)
        };
        if offset as usize / BANK_SIZE == busy {
            self.wait_for_flash();
        }
    }

    fn wait_for_flash(&mut self) {
        if self.bus.flash.busy_bank().is_some() {
            self.cycles = self.cycles.max(self.bus.flash.next_event());
            self.bus.run_events(self.cycles);
        }
    }

    fn wakes(&self, masks: Masks) -> bool {
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
        }
    }

    fn failed(&mut self) -> bool {
        self.bus.flash_file_failure.is_some() || self.bus.pins.failed()
    }

    fn poll_log(&mut self) {
        self.log_due = self.cycles + LOG_INTERVAL;
        let now_s = self.bus.timebase.seconds(self.cycles);
        self.log.poll(&mut self.bus.ram, now_s);
    }

    /// A register access needs all events up to now done, and may have any consequence.
    fn before_access(&mut self) {
        self.bus.run_events(self.cycles);
        self.attention = 0;
    }
}

fn register_of(uc: &Unicorn<'_, Context>, register: RegisterARM) -> u32 {
    uc.reg_read(register).unwrap_or(0) as u32
}

fn masks_of(uc: &Unicorn<'_, Context>) -> Masks {
    Masks {
        primask: register_of(uc, RegisterARM::PRIMASK) & 1 != 0,
        faultmask: register_of(uc, RegisterARM::FAULTMASK) & 1 != 0,
        basepri: register_of(uc, RegisterARM::BASEPRI) as u8,
    }
}

fn map_memories(uc: &mut Unicorn<'static, Context>, stub: &Block) -> Result<(), uc_error> {
    let code = Prot::READ | Prot::EXEC;
    let bus = &uc.get_data().bus;
    let flash = bus.flash_memory.block();
    let regions = [
        (FLASH_BASE, BANK_SIZE, code, flash.address(0)),
        (
            FLASH_BASE + BANK_SIZE as u32,
            BANK_SIZE,
            code,
            flash.address(BANK_SIZE),
        ),
        (0, BANK_SIZE, code, flash.address(0)),
        (BANK_SIZE as u32, BANK_SIZE, code, flash.address(BANK_SIZE)),
        (RAM_BASE, RAM_SIZE, Prot::ALL, bus.ram.address(0)),
        (
            CCM_BASE,
            CCM_SIZE,
            Prot::ALL,
            bus.ram.address(RAM_SIZE - CCM_SIZE),
        ),
        (SYSTEM_BASE, SYSTEM_SIZE, Prot::READ, bus.system.address(0)),
        (STUB_BASE, 4096, code, stub.address(0)),
    ];
    for (base, size, rights, memory) in regions {
        // SAFETY: the memory belongs to blocks that live as long as the emulator: they are its data, or stand beside
        // it in `Machine`, declared after it and so dropped later. They are only ever accessed through raw copies.
        unsafe { uc.mem_map_ptr(u64::from(base), size as u64, rights, memory.cast())? };
    }
    Ok(())
}

fn map_registers(uc: &mut Unicorn<'static, Context>) -> Result<(), uc_error> {
    for area in REGISTER_AREAS {
        let base = *area.start();
        let size = u64::from(area.end() - base) + 1;
        uc.mmio_map(
            u64::from(base),
            size,
            Some(
                move |uc: &mut Unicorn<'_, Context>, offset: u64, size: usize| {
                    let context = uc.get_data_mut();
                    context.before_access();
                    u64::from(context.bus.read(base + offset as u32, size as u32))
                },
            ),
            Some(
                move |uc: &mut Unicorn<'_, Context>, offset: u64, size: usize, value: u64| {
                    let context = uc.get_data_mut();
                    context.before_access();
                    context
                        .bus
                        .write(base + offset as u32, value as u32, size as u32);
                },
            ),
        )?;
    }
    Ok(())
}

fn add_hooks(uc: &mut Unicorn<'static, Context>) -> Result<(), uc_error> {
    uc.add_block_hook(1, 0, on_block)?;
    uc.add_intr_hook(|uc, number| {
        uc.get_data_mut().raised = Some(number);
        let _ = uc.emu_stop();
    })?;
    uc.ctl_set_tlb_type(TlbType::VIRTUAL)?;
    uc.add_tlb_hook(1, 0, translate)?;
    for area in BESIDE_RAM {
        let (begin, end) = (u64::from(*area.start()), u64::from(*area.end()));
        uc.add_mem_hook(HookType::MEM_UNMAPPED, begin, end, |uc, kind, address, _, _| {
            uc.get_data_mut().bad_access = Some(BadAccess { kind, address: address as u32 });
            false
        })?;
        uc.add_mem_hook(HookType::MEM_PROT, begin, end, on_protected)?;
    }
    Ok(())
}

/// Every address is itself. The emulator watches stores to pages that may be executed, which makes them slow; so a page
/// of RAM may be executed only once it has been.
fn translate(uc: &mut Unicorn<'_, Context>, address: u64, kind: MemType) -> Option<TlbEntry> {
    let in_ram = |base: u32, size: usize| (u64::from(base)..u64::from(base) + size as u64).contains(&address);
    let code_in_ram = &mut uc.get_data_mut().code_in_ram;
    if kind == MemType::FETCH {
        code_in_ram.insert(address);
    }
    let data = (in_ram(RAM_BASE, RAM_SIZE) || in_ram(CCM_BASE, CCM_SIZE)) && !code_in_ram.contains(&address);
    let perms = if data { Prot::READ | Prot::WRITE } else { Prot::ALL };
    Some(TlbEntry { paddr: address, perms })
}

fn on_block(uc: &mut Unicorn<'_, Context>, address: u64, size: u32) {
    let address = address as u32;
    let context = uc.get_data_mut();
    if context.cycles >= context.attention
        && address & 0xFFFF_F000 != STUB_BASE
        && !may_run(uc, address)
    {
        let _ = uc.emu_stop();
        return;
    }
    let context = uc.get_data_mut();
    let area = area_of(address);
    let info = match context.blocks[area].get(address, size) {
        Some(info) => info,
        None => decode_block(uc, area, address, size),
    };
    let context = uc.get_data_mut();
    context.block_end = address + size;
    context.cycles += Cycles::from(info.instructions);
    context.event |= info.sends_event;
}

/// A closer look at what is due before the block at `address`.
fn may_run(uc: &mut Unicorn<'_, Context>, address: u32) -> bool {
    let context = uc.get_data_mut();
    context.catch_up(address);
    let (masks, in_it_block) = if context.masks_matter(address) {
        (
            masks_of(uc),
            register_of(uc, RegisterARM::XPSR) & 0x0600_FC00 != 0,
        )
    } else {
        (Masks::default(), false)
    };
    let context = uc.get_data_mut();
    context.pause = context.reason_to_pause(address, masks, in_it_block);
    let bus = &context.bus;
    context.attention = if bus.nvic.may_preempt() {
        0
    } else {
        bus.next_event().min(context.end())
    };
    context.pause == Pause::None
}

#[inline]
fn area_of(address: u32) -> usize {
    match address >> 24 {
        0x08 => 0,
        0x00 => 1,
        0x20 => 2,
        _ => 3,
    }
}

#[cold]
fn decode_block(
    uc: &mut Unicorn<'_, Context>,
    area: usize,
    address: u32,
    size: u32,
) -> instructions::BlockInfo {
    if address & 0xFFFF_F000 == STUB_BASE {
        return instructions::BlockInfo {
            instructions: 0,
            sends_event: false,
        };
    }
    let mut code = vec![0; size as usize];
    if uc.mem_read(u64::from(address), &mut code).is_err() {
        return instructions::BlockInfo {
            instructions: 1,
            sends_event: false,
        };
    }
    let info = instructions::decode(&code);
    uc.get_data_mut().blocks[area].insert(address, size, info);
    info
}

/// A store into flash is for the flash interface to judge; a read of a watched bank may have to wait, or find a torn
/// word. Anything else is a fault.
fn on_protected(
    uc: &mut Unicorn<'_, Context>,
    kind: MemType,
    address: u64,
    size: usize,
    value: i64,
) -> bool {
    let context = uc.get_data_mut();
    let address = address as u32;
    let offset = match address {
        FLASH_BASE..=0x0807_FFFF => (address - FLASH_BASE) as usize,
        _ if (address as usize) < FLASH_SIZE => address as usize,
        _ => {
            context.bad_access = Some(BadAccess { kind, address });
            return false;
        }
    };
    context.before_access();
    match kind {
        MemType::WRITE_PROT => {
            context.wait_for_flash();
            context.bus.store_to_flash(offset, value as u32, size);
        }
        MemType::READ_PROT => {
            if context.bus.flash.busy_bank() == Some(offset / BANK_SIZE) {
                context.wait_for_flash();
            }
            context.bus.check_flash_read(offset);
        }
        _ => {
            context.bad_access = Some(BadAccess { kind, address });
            return false;
        }
    }
    true
}
