//! Analog-to-digital converters (RM0440 chapter 21): regular sequences, started by software or a timer's trigger, with
//! hardware oversampling.
//!
//! ```text
//! one conversion    = SMP + 12.5 cycles of the ADC clock (12 bits)                          (21.4.16)
//! one rank          = N conversions, added and shifted right, rounded                       (21.4.30)
//! code of one       = round(4096 · v/VREF+ · (1 + gain error) + offset + noise), clipped to 0..4095
//! ```
//!
//! Each of the N conversions is quantised by itself with its own noise; all see the voltage at the mean instant of
//! their sample-and-holds. The registers guard themselves as the manual says: bits that only set, fields that are
//! ignored while the converter is on or busy, triggers that are ignored while a sequence runs, overrun that stops DMA
//! requests until it is cleared.
//!
//! Each calibration finds a factor that scatters by one LSB around the converter's own. The imperfection is what remains with
//! the factor of the first one since power-on; with another factor every code is off by the difference. A converter that was
//! never calibrated has no further error. Not modelled: injected conversions, watchdogs, offsets, dual and differential mode,
//! discontinuous mode, auto-delay.

mod common;
mod registers;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng as _;
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;

pub use self::common::AdcCommon;
use super::{Cycles, NEVER, bit, field};

// ISR
const ADRDY: u32 = 1 << 0;
const EOSMP: u32 = 1 << 1;
const EOC: u32 = 1 << 2;
const EOS: u32 = 1 << 3;
const OVR: u32 = 1 << 4;
// CR
const ADEN: u32 = 1 << 0;
const ADDIS: u32 = 1 << 1;
const ADSTART: u32 = 1 << 2;
const ADSTP: u32 = 1 << 4;
const ADVREGEN: u32 = 1 << 28;
const DEEPPWD: u32 = 1 << 29;
const ADCALDIF: u32 = 1 << 30;
const ADCAL: u32 = 1 << 31;
// CFGR
const DMAEN: u32 = 0;
const OVRMOD: u32 = 12;
const CONT: u32 = 13;

/// Duration of a calibration and of switching on or off, in cycles of the ADC clock (data sheet, table ADC
/// characteristics).
const CALIBRATION_CLOCKS: u64 = 116;
const ENABLE_CLOCKS: u64 = 15;
const DISABLE_CLOCKS: u64 = 4;
/// Factor of a calibration, without its scatter, and the bits of one in CALFACT.
const FACTOR: u32 = 0x40;
const FACTOR_MASK: u32 = 0x7F;
/// Set in the stream of random numbers that the scatter is drawn from.
const SCATTER_STREAM: u64 = 1 << 32;
/// From trigger to the start of sampling, in half cycles of the ADC clock (same table, asynchronous clock, typical).
const TRIGGER_LATENCY_HALF_CLOCKS: u64 = 4;

/// The errors of one converter.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Imperfection {
    /// Relative error of the gain.
    pub gain_error: f64,
    /// Offset in 12-bit LSB.
    pub offset_lsb: f64,
    /// Noise of one conversion in 12-bit LSB, rms.
    pub noise_lsb: f64,
}

#[derive(Debug, Clone, Copy)]
struct Conversion {
    rank: u32,
    channel: u8,
    /// Mean instant of the sample-and-holds.
    sampled_at: Cycles,
    done_at: Cycles,
}

/// One converter.
#[derive(Debug)]
pub struct Adc {
    imperfection: Imperfection,
    noise: ChaCha8Rng,
    adc_hz: u64,
    core_hz: u64,
    isr: u32,
    ier: u32,
    cr: u32,
    cfgr: u32,
    cfgr2: u32,
    smpr: [u32; 2],
    sqr: [u32; 4],
    thresholds: [u32; 3],
    difsel: u32,
    calfact: u32,
    scatter: ChaCha8Rng,
    /// Factor of the first calibration since power-on.
    first_factor: Option<u32>,
    /// Whether the analog part uses CALFACT: since the last reset it was found or written.
    corrected: bool,
    dr: u32,
    /// End of a calibration, of switching on or of switching off.
    transition_at: Cycles,
    conversion: Option<Conversion>,
    /// The DMA is asked to fetch the data register.
    request: bool,
}

impl Adc {
    /// A converter after reset, with its imperfection and the source of its noise.
    pub fn new(imperfection: Imperfection, noise: ChaCha8Rng) -> Self {
        let mut scatter = noise.clone();
        scatter.set_stream(noise.get_stream() | SCATTER_STREAM);
        Self {
            imperfection,
            noise,
            adc_hz: 0,
            core_hz: 1,
            isr: 0,
            ier: 0,
            cr: DEEPPWD,
            cfgr: 0x8000_0000,
            cfgr2: 0,
            smpr: [0; 2],
            sqr: [0; 4],
            thresholds: [0x0FFF_0000, 0x00FF_0000, 0x00FF_0000],
            difsel: 0,
            calfact: 0,
            scatter,
            first_factor: None,
            corrected: false,
            dr: 0,
            transition_at: NEVER,
            conversion: None,
            request: false,
        }
    }

    /// Back to the state after reset; imperfection, noise, clock and the first factor stay.
    pub fn reset(&mut self) {
        let fresh = Self::new(self.imperfection, self.noise.clone());
        *self = Self {
            adc_hz: self.adc_hz,
            core_hz: self.core_hz,
            scatter: self.scatter.clone(),
            first_factor: self.first_factor,
            ..fresh
        };
    }

    /// Sets the converter's clock after its prescaler, and the core's, Hz.
    pub fn set_clock(&mut self, adc_hz: u32, core_hz: u32) {
        self.adc_hz = u64::from(adc_hz);
        self.core_hz = u64::from(core_hz);
    }

    /// Whether the converter is on; the clock may not change then.
    pub fn enabled(&self) -> bool {
        self.cr & ADEN != 0
    }

    /// A pulse on trigger input `source` (number in EXTSEL) at `now`; whether the converter waited for it.
    pub fn trigger(&mut self, source: u32, now: Cycles) -> bool {
        let listens = field(self.cfgr, 10, 2) != 0 && field(self.cfgr, 5, 5) == source;
        let begins = listens && self.cr & ADSTART != 0 && self.conversion.is_none();
        if begins {
            self.begin(1, now + self.half_clocks(TRIGGER_LATENCY_HALF_CLOCKS));
        }
        begins
    }

    /// Whether the interrupt line is high.
    pub fn interrupt(&self) -> bool {
        self.isr & self.ier != 0
    }

    /// Whether the converter asks a DMA channel to fetch the data register. Overrun silences it (21.4.27).
    pub fn dma_request(&self) -> bool {
        self.request && bit(self.cfgr, DMAEN) && self.isr & OVR == 0
    }

    /// When [`Self::advance`] must be called next.
    pub fn next_event(&self) -> Cycles {
        self.conversion
            .map_or(NEVER, |conversion| conversion.done_at)
            .min(self.transition_at)
    }

    /// Carries out what happens up to `now`. `input` gives the voltage of an input at an instant, as a fraction of
    /// the reference VREF+.
    pub fn advance(&mut self, now: Cycles, input: &mut dyn FnMut(u8, Cycles) -> f64) {
        if self.transition_at <= now {
            self.transition_at = NEVER;
            self.finish_transition();
        }
        if let Some(conversion) = self.conversion
            && conversion.done_at <= now
        {
            let fraction = input(conversion.channel, conversion.sampled_at);
            let code = self.convert(fraction);
            self.finish(conversion, code);
        }
    }

    fn start(&mut self, now: Cycles) {
        self.cr |= ADSTART;
        if field(self.cfgr, 10, 2) == 0 {
            self.begin(1, now);
        }
    }

    fn finish_transition(&mut self) {
        if self.cr & ADCAL != 0 {
            self.cr &= !ADCAL;
            let factor = FACTOR - 1 + self.scatter.next_u32() % 3;
            if self.cr & ADCALDIF != 0 {
                self.calfact = self.calfact & FACTOR_MASK | factor << 16;
            } else {
                self.calfact = self.calfact & FACTOR_MASK << 16 | factor;
                self.first_factor.get_or_insert(factor);
                self.corrected = true;
            }
        } else if self.cr & ADDIS != 0 {
            self.cr &= !(ADDIS | ADEN);
            self.isr &= !ADRDY;
        } else if self.cr & ADEN != 0 {
            self.isr |= ADRDY;
        }
    }

    /// Half cycles of the ADC clock in cycles of the core.
    fn half_clocks(&self, count: u64) -> Cycles {
        if self.adc_hz == 0 {
            NEVER / 2
        } else {
            (count * self.core_hz + self.adc_hz) / (2 * self.adc_hz)
        }
    }

    fn conversions_per_rank(&self) -> u64 {
        if bit(self.cfgr2, 0) {
            2 << field(self.cfgr2, 2, 3)
        } else {
            1
        }
    }

    /// Sampling time of an input in half cycles of the ADC clock.
    fn sampling(&self, channel: u8) -> u64 {
        const HALF_CLOCKS: [u64; 8] = [5, 13, 25, 49, 95, 185, 495, 1281];
        let (register, index) = if channel < 10 {
            (0, channel)
        } else {
            (1, channel - 10)
        };
        HALF_CLOCKS[field(self.smpr[register], 3 * u32::from(index), 3) as usize]
    }

    fn begin(&mut self, rank: u32, at: Cycles) {
        let channel = field(self.sqr[rank as usize / 5], 6 * (rank % 5), 5) as u8;
        let sampling = self.sampling(channel);
        let approximation = 25 - 4 * u64::from(field(self.cfgr, 3, 2));
        let one = sampling + approximation;
        let count = self.conversions_per_rank();
        self.conversion = Some(Conversion {
            rank,
            channel,
            sampled_at: at + self.half_clocks((count - 1) * one / 2 + sampling),
            done_at: at + self.half_clocks(count * one),
        });
    }

    /// The sum of a rank's conversions of an input at `fraction` of the reference.
    fn convert(&mut self, fraction: f64) -> u32 {
        let dropped_bits = 2 * field(self.cfgr, 3, 2);
        let ideal = fraction * 4096.0 * (1.0 + self.imperfection.gain_error)
            + self.imperfection.offset_lsb
            + self.correction_lsb();
        let sum: u32 = (0..self.conversions_per_rank())
            .map(|_| {
                let noise: f64 = StandardNormal.sample(&mut self.noise);
                // Half a code is added and the fraction dropped: rounding to the nearest code.
                let code = (ideal + self.imperfection.noise_lsb * noise + 0.5).clamp(0.0, 4095.0);
                code as u32 >> dropped_bits
            })
            .sum();
        if !bit(self.cfgr2, 0) {
            return sum;
        }
        let shift = field(self.cfgr2, 5, 4).min(8);
        let half = if shift == 0 { 0 } else { 1 << (shift - 1) };
        ((sum + half) >> shift) & 0xFFFF
    }

    /// What the factor in use adds, LSB.
    fn correction_lsb(&self) -> f64 {
        match self.first_factor {
            Some(first) if self.corrected => {
                f64::from(self.calfact & FACTOR_MASK) - f64::from(first)
            }
            _ => 0.0,
        }
    }

    fn finish(&mut self, conversion: Conversion, code: u32) {
        if self.isr & EOC != 0 {
            self.isr |= OVR;
        }
        if self.isr & OVR == 0 || bit(self.cfgr, OVRMOD) {
            self.dr = code;
            self.request = true;
        }
        self.isr |= EOC | EOSMP;
        if conversion.rank <= field(self.sqr[0], 0, 4) {
            self.begin(conversion.rank + 1, conversion.done_at);
            return;
        }
        self.isr |= EOS;
        self.conversion = None;
        if bit(self.cfgr, CONT) {
            self.begin(1, conversion.done_at);
        } else if field(self.cfgr, 10, 2) == 0 {
            self.cr &= !ADSTART;
        }
    }
}
