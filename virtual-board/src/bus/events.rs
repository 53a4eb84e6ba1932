//! Events in order of time, and their effects: triggers, DMA transfers, interrupt lines.
//!
//! Every peripheral with a sense of time has a deadline. The bus carries out the earliest event at its own instant,
//! then the next, until no event is due. This file and `mod.rs` are two halves of [`Bus`].

use super::map::{ADC_INTERRUPTS, DMA_INTERRUPTS, EXTI_INTERRUPTS, TIMERS, Unit};
use super::{Bus, map};
use crate::memory::system::sensor_voltage;
use crate::peripherals::dmamux::request;
use crate::peripherals::nvic::SYS_TICK;
use crate::peripherals::rcc::ResetCause;
use crate::peripherals::{Cycles, NEVER, dma};
use crate::pins::pinout::{self, Input};

const FIRST_TIMER: usize = 0;
const FIRST_ADC: usize = FIRST_TIMER + TIMERS.len();
const LPUART: usize = FIRST_ADC + 5;
const FLASH: usize = LPUART + 1;
const IWDG: usize = FLASH + 1;
const RNG: usize = IWDG + 1;
const SYSTICK: usize = RNG + 1;
const STALL: usize = SYSTICK + 1;
/// Most transfers in a row: a channel that does not satisfy its request would be served for ever.
const MAX_TRANSFERS: u32 = 64;
/// Number of peripherals with deadlines.
pub const SOURCES: usize = STALL + 1;

impl Bus {
    /// Instant of the next event.
    #[inline]
    pub fn next_event(&self) -> Cycles {
        self.next_deadline
    }

    /// Carries out all events up to and including `until`.
    pub fn run_events(&mut self, until: Cycles) {
        while self.next_deadline <= until {
            let at = self.next_deadline;
            self.now = self.now.max(at);
            if let Some(source) = self.deadlines.iter().position(|deadline| *deadline == at) {
                self.happen(source, at);
                self.settle();
            }
        }
        self.now = self.now.max(until);
    }

    /// Puts characters on the line towards the receiver.
    pub fn line_in(&mut self, bytes: &[u8]) {
        self.lpuart.line_in(bytes, self.now);
        self.refresh(Unit::Lpuart1);
        self.settle();
    }

    fn happen(&mut self, source: usize, at: Cycles) {
        match source {
            FIRST_TIMER..FIRST_ADC => {
                self.timers[source].advance(at);
                self.refresh(Unit::Timer(source));
            }
            FIRST_ADC..LPUART => {
                self.advance_converter(source - FIRST_ADC, at);
                self.refresh(Unit::Adc(source - FIRST_ADC));
            }
            LPUART => {
                self.lpuart.advance(at);
                self.refresh(Unit::Lpuart1);
            }
            FLASH => {
                if let Err(error) = self.flash.advance(at, &mut self.flash_memory) {
                    self.flash_file_failure = Some(error);
                }
                self.refresh(Unit::Flash);
            }
            IWDG => {
                self.reset_request = Some(ResetCause::IndependentWatchdog);
                self.set_deadline(IWDG, NEVER);
            }
            RNG => self.refresh(Unit::Rng),
            // The requests that waited are served afterwards, see `settle`.
            STALL => self.set_deadline(STALL, NEVER),
            _ => {
                self.systick.advance(at);
                if self.systick.take_tick() {
                    self.nvic.pend(SYS_TICK);
                }
                self.refresh_systick();
            }
        }
    }

    fn advance_converter(&mut self, index: usize, at: Cycles) {
        let Self {
            adc,
            adc_common,
            pins,
            timebase,
            parameters,
            stalls,
            ..
        } = self;
        let common = &adc_common[usize::from(index > 1)];
        let vrefint_v = parameters.vrefint_v;
        adc[index].advance(at, &mut |channel, sampled_at| {
            let at_s = timebase.seconds(sampled_at);
            let supply_v = pins.supply_v(at_s);
            let input = pinout::input(index, channel);
            if let (Input::Reference, Some(share)) = (&input, stalls.reference(sampled_at)) {
                return share;
            }
            let volt = match input {
                Input::Pin(pin) => pins.voltage(pin, at_s),
                Input::Temperature if common.temperature_on() => {
                    sensor_voltage(pins.temperature_c(at_s))
                }
                Input::Reference if common.vrefint_on() => vrefint_v,
                Input::BackupThird if common.vbat_on() => supply_v / 3.0,
                _ => 0.0,
            };
            volt / supply_v
        });
    }

    /// Updates what depends on a unit's state: deadline, interrupt lines, triggers, DMA listeners.
    pub(super) fn refresh(&mut self, unit: Unit) {
        match unit {
            Unit::Timer(index) => {
                if self.timers[index].take_trigger() {
                    self.trigger_converters(index);
                }
                self.set_deadline(FIRST_TIMER + index, self.timers[index].next_event());
                self.nvic
                    .set_line(TIMERS[index].interrupt, self.timers[index].interrupt());
            }
            Unit::Adc(index) => {
                self.set_deadline(FIRST_ADC + index, self.adc[index].next_event());
                let line = ADC_INTERRUPTS[index];
                let high = (0..5)
                    .any(|other| ADC_INTERRUPTS[other] == line && self.adc[other].interrupt());
                self.nvic.set_line(line, high);
            }
            Unit::Lpuart1 => {
                self.set_deadline(LPUART, self.lpuart.next_event());
                self.nvic
                    .set_line(map::LPUART1_INTERRUPT, self.lpuart.interrupt());
            }
            Unit::Flash => {
                self.set_deadline(FLASH, self.flash.next_event());
                self.nvic
                    .set_line(map::FLASH_INTERRUPT, self.flash.interrupt());
            }
            Unit::Iwdg => {
                self.set_deadline(IWDG, self.iwdg.next_event());
                if self.iwdg.bites(self.now) {
                    self.reset_request = Some(ResetCause::IndependentWatchdog);
                }
            }
            Unit::Rng => {
                self.set_deadline(RNG, self.rng.next_event(self.now));
                let clocked = self.rcc.hsi48_ready(self.now);
                self.nvic
                    .set_line(map::RNG_INTERRUPT, self.rng.interrupt(self.now, clocked));
            }
            Unit::Dma(_) | Unit::Dmamux => self.refresh_dma(),
            Unit::Exti => {
                let pending = self.exti.pending();
                for (lines, interrupt) in EXTI_INTERRUPTS {
                    self.nvic.set_line(interrupt, pending & lines != 0);
                }
            }
            Unit::Pwr
            | Unit::Syscfg
            | Unit::Rcc
            | Unit::Crc
            | Unit::Gpio(_)
            | Unit::AdcCommon(_) => {}
        }
    }

    /// Sets the instant at which the requests that a stall holds back must be served.
    pub(super) fn expect_end_of_stall(&mut self, end: Cycles) {
        self.set_deadline(STALL, end);
    }

    pub(super) fn refresh_systick(&mut self) {
        self.set_deadline(SYSTICK, self.systick.next_event());
    }

    pub(super) fn refresh_all(&mut self) {
        (0..TIMERS.len()).for_each(|index| self.refresh(Unit::Timer(index)));
        (0..5).for_each(|index| self.refresh(Unit::Adc(index)));
        for unit in [
            Unit::Lpuart1,
            Unit::Flash,
            Unit::Iwdg,
            Unit::Rng,
            Unit::Dmamux,
            Unit::Exti,
        ] {
            self.refresh(unit);
        }
        self.refresh_systick();
    }

    /// Serves DMA requests until no request is left.
    pub(super) fn settle(&mut self) {
        let mut index = 0;
        let mut moved = 0;
        while index < self.listening.len() && moved < MAX_TRANSFERS {
            let (controller, channel, number) = self.listening[index];
            if self.requested(number) && self.dma[controller].ready(channel) {
                self.transfer(controller, channel, number);
                moved += 1;
                index = 0; // a transfer may raise another request, of a channel that comes first
            } else {
                index += 1;
            }
        }
    }

    fn requested(&self, number: u8) -> bool {
        if self.stalls.hold(number, self.now) {
            return false;
        }
        match number {
            request::LPUART1_RX => self.lpuart.rx_request(),
            request::LPUART1_TX => self.lpuart.tx_request(),
            _ => request::ADC
                .iter()
                .position(|adc| *adc == number)
                .is_some_and(|adc| self.adc[adc].dma_request()),
        }
    }

    fn transfer(&mut self, controller: usize, channel: usize, number: u8) {
        let item = self.dma[controller].transfer(channel);
        let fetched = self.fetch(item.from, item.from_size);
        for _ in 0..self.stalls.places(number) {
            let item = self.dma[controller].transfer(channel);
            let moved = fetched.and_then(|value| self.deliver(item.to, value, item.to_size));
            match moved {
                Ok(()) => self.dma[controller].moved(channel),
                Err(super::NothingThere) => self.dma[controller].failed(channel),
            }
        }
        self.nvic.set_line(
            DMA_INTERRUPTS[controller][channel],
            self.dma[controller].interrupt(channel),
        );
    }

    fn refresh_dma(&mut self) {
        self.listening.clear();
        for (controller, interrupts) in DMA_INTERRUPTS.iter().enumerate() {
            for (channel, &interrupt) in interrupts.iter().enumerate() {
                let number = self.dmamux.request(controller * dma::CHANNELS + channel);
                if number != request::NONE && self.dma[controller].ready(channel) {
                    self.listening.push((controller, channel, number));
                }
                self.nvic
                    .set_line(interrupt, self.dma[controller].interrupt(channel));
            }
        }
    }

    fn trigger_converters(&mut self, timer: usize) {
        let Some(source) = TIMERS[timer].adc_trigger else {
            return;
        };
        if self.now < self.stalls.triggers {
            return;
        }
        let mut began = false;
        for index in 0..self.adc.len() {
            began |= self.adc[index].trigger(source, self.now);
            self.set_deadline(FIRST_ADC + index, self.adc[index].next_event());
        }
        if began {
            let starts = self.timers[timer].starts();
            self.triggers.note(self.now, self.now_s(), starts);
        }
    }

    fn set_deadline(&mut self, source: usize, at: Cycles) {
        self.deadlines[source] = at;
        self.next_deadline = self.deadlines.iter().copied().fold(NEVER, Cycles::min);
    }
}
