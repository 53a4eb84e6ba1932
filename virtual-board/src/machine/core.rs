//! The processor: Unicorn's Cortex-M4, and the loop that runs it.
//!
//! Unicorn executes instructions and nothing else: it has no interrupts, no sleep and no time. So a hook at the start
//! of every basic block (`hooks.rs`) adds the block's instructions to the time. When an event is due, the hook lets the
//! peripherals carry it out, and stops the emulation if the core must take an exception. Entry, return, sleep and
//! faults then happen here, between two runs of the emulation.

use unicorn_engine::{Arch, ArmCpuModel, Mode, RegisterARM, Unicorn, uc_error};

use super::context::{Context, Pause, Sleep};
use super::counting::{Count, Counting};
use super::hooks::{self, masks_of, register_of};
use super::masking::Stretch;
use super::stop::{BuildError, Stop};
use super::stub::{NOWHERE, STUB_BASE, Stub};
use crate::bus::Bus;
use crate::firmware::log::FirmwareLog;
use crate::injection::timeline::Timeline;
use crate::peripherals::nvic::Masks;
use crate::peripherals::rcc::ResetCause;

const WFE: u16 = 0xBF20;
const WFI: u16 = 0xBF30;
const YIELD: u16 = 0xBF10;

/// The chip with its firmware.
pub struct Machine {
    pub(super) uc: Unicorn<'static, Context>,
    pub(super) timeline: Timeline,
    stub: Stub,
}

impl Machine {
    /// A powered machine at its reset vector.
    pub fn new(bus: Bus, log: FirmwareLog) -> Result<Self, BuildError> {
        let context = Context::new(bus, log);
        let mut uc = Unicorn::new_with_data(Arch::ARM, Mode::THUMB | Mode::MCLASS, context)?;
        uc.ctl_set_cpu_model(ArmCpuModel::CORTEX_M4 as i32)?;
        let stub = Stub::new();
        hooks::connect(&mut uc, &stub)?;
        let mut machine = Self {
            uc,
            timeline: Timeline::default(),
            stub,
        };
        machine.start_core();
        Ok(machine)
    }

    /// Everything but the core.
    pub fn bus(&self) -> &Bus {
        &self.context().bus
    }

    /// As [`Self::bus`], for changes; the machine notices them when it runs on.
    pub fn bus_mut(&mut self) -> &mut Bus {
        &mut self.context_mut().bus
    }

    /// Counts instructions from now on.
    pub fn count(&mut self, counting: Counting) {
        self.context_mut().counting = Some(counting);
    }

    /// The counts; `None` if counting is off.
    pub fn counts(&self) -> Option<&[Count]> {
        self.context().counting.as_ref().map(Counting::counts)
    }

    /// The longest stretch with masked interrupts; `None` if counting is off.
    pub fn masked(&self) -> Option<&Stretch> {
        self.context().counting.as_ref().map(Counting::masked)
    }

    /// Sets the counts to zero.
    pub fn begin_counting(&mut self) {
        if let Some(counting) = &mut self.context_mut().counting {
            counting.begin();
        }
    }

    /// Instructions since the counts were last set to zero; `None` if counting is off.
    pub fn executed(&self) -> Option<u64> {
        self.context().counting.as_ref().map(Counting::executed)
    }

    /// Runs until true time `until_s` since power-on, or a little longer: to the end of a basic block.
    pub fn run(&mut self, until_s: f64) -> Result<(), Stop> {
        while let Some(at_s) = self.timeline.next_at(until_s) {
            self.run_on(at_s)?;
            let context = self.context();
            if context.cycles < context.bus.timebase.cycles(at_s) {
                return Ok(()); // the transmitter fell silent before
            }
            self.inject_timed()?;
        }
        self.run_on(until_s)
    }

    /// As [`Self::run`], but without timed faults.
    pub(super) fn run_on(&mut self, until_s: f64) -> Result<(), Stop> {
        self.context_mut().begin_run(until_s);
        loop {
            let context = self.context_mut();
            context.catch_up();
            context.attention = 0;
            if context.cycles >= context.end() || (context.sleep.is_some() && !self.sleep_on()?) {
                self.context_mut().poll_log();
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

    pub(super) fn register(&self, register: impl Into<i32>) -> u32 {
        register_of(&self.uc, register)
    }

    pub(super) fn set_register(&mut self, register: impl Into<i32>, value: u32) {
        // The registers are constants that exist on this core.
        let _ = self.uc.reg_write(register, u64::from(value));
    }

    pub(super) fn masks(&self) -> Masks {
        masks_of(&self.uc)
    }

    /// Goes on at `address` with the exclusive monitor cleared.
    pub(super) fn jump_clearing_monitor(&mut self, address: u32) {
        self.stub.set_target(address);
        self.set_register(RegisterARM::PC, STUB_BASE | 1);
    }

    /// A word of memory as the core sees it, if there is any.
    pub(super) fn word(&self, address: u32) -> Option<u32> {
        let mut bytes = [0; 4];
        self.uc
            .mem_read(u64::from(address), &mut bytes)
            .ok()
            .map(|()| u32::from_le_bytes(bytes))
    }

    fn half_word(&self, address: u32) -> Option<u16> {
        let mut bytes = [0; 2];
        self.uc
            .mem_read(u64::from(address), &mut bytes)
            .ok()
            .map(|()| u16::from_le_bytes(bytes))
    }

    fn emulate(&mut self) -> Result<(), uc_error> {
        let context = self.context_mut();
        context.pause = Pause::None;
        context.raised = None;
        context.bad_access = None;
        let pc = u64::from(self.register(RegisterARM::PC) | 1);
        self.uc.emu_start(pc, u64::from(NOWHERE), 0, 0)
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
            (Pause::Trapped, _) => self.inject_at_operation(),
            (Pause::Dead, _) => Err(self.dead()),
            (Pause::Failure, _) => Err(self.failure()),
            (Pause::None, result) => self.stopped_by_itself(result),
        }
    }

    /// At WFI the emulator ends a run without an error, at WFE and YIELD with one. They end their block, and the
    /// program counter is behind them; after a real error it is at the faulty instruction.
    fn stopped_by_itself(&mut self, result: Result<(), uc_error>) -> Result<(), Stop> {
        let pc = self.register(RegisterARM::PC);
        let hint = self
            .half_word(pc.wrapping_sub(2))
            .filter(|_| pc == self.context().block_end);
        let context = self.context_mut();
        match (result, hint) {
            (Ok(()), Some(WFI)) => context.sleep = Some(Sleep::ForInterrupt),
            (Err(uc_error::INSN_INVALID), Some(WFE)) => {
                if !std::mem::take(&mut context.event) {
                    context.sleep = Some(Sleep::ForEvent);
                }
            }
            (Err(uc_error::INSN_INVALID), Some(YIELD)) => {}
            (Ok(()), _) => return Err(Stop::Emulator(uc_error::OK, pc)),
            (Err(error), _) => return self.fault_of_error(error, pc),
        }
        Ok(())
    }

    pub(super) fn reset(&mut self, cause: ResetCause) {
        self.context_mut().poll_log();
        self.note(&format!("reset: {cause:?}"));
        self.context_mut().bus.reset(cause);
        self.start_core();
    }

    /// The core's state after reset (ARMv7-M B1.5.5): stack pointer and program counter from the vector table.
    fn start_core(&mut self) {
        self.context_mut().restart();
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

    /// The emulator derives translation flags from the mode; a write to the condition flags makes it do so again.
    pub(super) fn refresh_mode(&mut self) {
        let flags = self.register(RegisterARM::XPSR) & 0xF000_0000;
        self.set_register(RegisterARM::APSR_NZCV, flags);
    }
}
