//! Injected faults of the bus: stalls, the end of the power, a crystal that stops, a debugger that halts the core. This file
//! and `mod.rs` are two halves of [`Bus`].

use super::map::Unit;
use super::{Bus, fill};
use crate::injection::{Defect, Served, Slip};
use crate::memory::{RAM_BASE, RAM_SIZE};
use crate::peripherals::nvic::NMI;
use crate::peripherals::{Cycles, dmamux::request};

/// Index of the converter that measures supply and temperature.
const SUPPLY_ADC: usize = 4;

/// The end of each stall.
#[derive(Debug, Default)]
pub(super) struct Stalls {
    converter_dma: Cycles,
    receiver_dma: Cycles,
    transmitter_dma: Cycles,
    supply_dma: Cycles,
    pub(super) triggers: Cycles,
    /// What happens to the next result of each converter.
    slips: [Option<Slip>; 5],
    /// The disturbed reference, as a share of the supply, and its end.
    reference: Option<(f64, Cycles)>,
}

impl Stalls {
    /// Whether a stall holds back a DMA request at `now`.
    pub(super) fn hold(&self, number: u8, now: Cycles) -> bool {
        let until = match number {
            request::LPUART1_RX => self.receiver_dma,
            request::LPUART1_TX => self.transmitter_dma,
            _ if number == request::ADC[SUPPLY_ADC] => self.supply_dma.max(self.converter_dma),
            _ if request::ADC.contains(&number) => self.converter_dma,
            _ => 0,
        };
        now < until
    }

    /// To how many places the item of this DMA request goes: one, unless DMA slips.
    pub(super) fn places(&mut self, number: u8) -> u32 {
        let converter = request::ADC.iter().position(|adc| *adc == number);
        match converter.and_then(|index| self.slips[index].take()) {
            None => 1,
            Some(Slip::Lost) => 0,
            Some(Slip::Twice) => 2,
        }
    }

    /// What the input of the reference has in place of it at `at`, as a share of the supply.
    pub(super) fn reference(&self, at: Cycles) -> Option<f64> {
        let (share, end) = self.reference?;
        (at < end).then_some(share)
    }
}

impl Bus {
    /// DMA does not serve `of` for this duration, µs.
    pub fn stall_dma(&mut self, of: Served, duration_us: u64) {
        let end = self.later(duration_us);
        match of {
            Served::Converters => self.stalls.converter_dma = end,
            Served::Receiver => self.stalls.receiver_dma = end,
            Served::Transmitter => self.stalls.transmitter_dma = end,
            Served::Supply => self.stalls.supply_dma = end,
        }
        self.expect_end_of_stall(end);
    }

    /// DMA slips at the next result of this converter, 1 to 5.
    pub fn slip_dma(&mut self, adc: u8, result: Slip) {
        self.stalls.slips[usize::from(adc) - 1] = Some(result);
    }

    /// No flash operation ends within this duration, µs.
    pub fn stall_flash(&mut self, duration_us: u64) {
        let end = self.later(duration_us);
        self.flash.hold_up(end);
        self.refresh(Unit::Flash);
    }

    /// The converters miss all triggers for this duration, µs.
    pub fn stall_triggers(&mut self, duration_us: u64) {
        self.stalls.triggers = self.later(duration_us);
    }

    /// The crystal stops, for good or until the next reset, and a PLL that it drives drifts to `1 / drift` of its
    /// frequency; true if the core stands still.
    pub fn stop_crystal(&mut self, drift: u32, returns: bool) -> bool {
        let watched = self.rcc.stop_crystal(drift, returns, self.now);
        self.change_clocks();
        if watched {
            self.nvic.pend(NMI);
        }
        self.rcc.runs_on_crystal_itself()
    }

    /// A debugger halts the core for this duration, µs.
    pub fn halt_core(&mut self, duration_us: u64) {
        if self.debug.watchdog_stops_in_halt() {
            let duration = self.later(duration_us) - self.now;
            self.iwdg.stand_still(duration);
            self.refresh(Unit::Iwdg);
        }
    }

    /// The 48 MHz oscillator never starts again.
    pub fn stop_hsi48(&mut self) {
        self.rcc.stop_hsi48();
        self.refresh(Unit::Rng);
    }

    /// The generator of random numbers has a defect for this duration, µs.
    pub fn break_random(&mut self, defect: Defect, duration_us: u64) {
        let end = self.later(duration_us);
        self.rng.break_down(defect, end);
        self.refresh(Unit::Rng);
    }

    /// The input of the reference is at this share of the supply for this duration, µs.
    pub fn disturb_reference(&mut self, share: f64, duration_us: u64) {
        self.stalls.reference = Some((share, self.later(duration_us)));
    }

    /// Flips bits of a word of the SRAM; false when there is none at this address.
    pub fn flip_ram(&mut self, address: u32, mask: u32) -> bool {
        let Some(offset) = address.checked_sub(RAM_BASE) else {
            return false;
        };
        let mut word = [0; 4];
        let offset = offset as usize;
        self.ram.read(offset, &mut word)
            && self
                .ram
                .write(offset, &(u32::from_le_bytes(word) ^ mask).to_le_bytes())
    }

    /// Address of a word of the SRAM with this content, after passing over `skip` of them.
    pub fn find_in_ram(&self, holds: u32, skip: usize) -> Option<u32> {
        let addresses = (0..RAM_SIZE).step_by(4).filter(|offset| {
            let mut word = [0; 4];
            self.ram.read(*offset, &mut word) && u32::from_le_bytes(word) == holds
        });
        addresses.map(|offset| RAM_BASE + offset as u32).nth(skip)
    }

    /// The power goes: a flash operation under way is cut short.
    pub fn cut_power(&mut self) -> std::io::Result<()> {
        self.flash.reset(&mut self.flash_memory)
    }

    /// The SRAM was without power.
    pub fn lose_ram(&mut self) {
        fill(&mut self.ram, &mut self.ram_noise);
    }

    fn later(&self, duration_us: u64) -> Cycles {
        let end_s = self.now_s() + duration_us as f64 * 1e-6;
        self.timebase.cycles(end_s)
    }
}
