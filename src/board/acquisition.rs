//! The converters: fifteen channels in step with the trigger, into two DMA rings.
//!
//! ```text
//! TIM6 update ─┬─▶ ADC1: nine inertial channels × 16 conversions ─DMA─▶ ring of two blocks
//!              └─▶ ADC2: six jack channels × 16 conversions     ─DMA─▶ ring of two blocks
//! ```
//!
//! Everything up to the rings is hardware: no software delay can move a sampling instant. While DMA fills one half
//! of a ring, the other half (a block of [`BLOCK`] scans) is read.
//!
//! A converter whose result was not fetched in time (*overrun*) stops without a sign. So a block that does not come
//! in time, or that comes with an overrun flag set, is a [`Fault`]; the caller then builds the converters anew,
//! which is the only way to put both rings back in step.

use embassy_futures::join::join;
use embassy_futures::select::{Either, select};
use embassy_stm32::adc::{Adc, AdcConfig, Exten, RingBufferedAdc, Rovsm, Trovs};
use embassy_stm32::pac;
use embassy_stm32::peripherals::{ADC1, ADC2};
use embassy_stm32::triggers::TIM6_TRGO;
use embassy_time::{Instant, Timer};
use hexsense::channel::{CHANNELS, INERTIAL, JACKS, Scan};
use hexsense::sampling::BLOCK;
use static_cell::ConstStaticCell;

use super::pins::{self, Irqs};
use super::timing::{OVERSAMPLING_CODE, SAMPLE_TIME, block_timeout};
use super::trigger::Trigger;

const INERTIAL_BLOCK: usize = INERTIAL * BLOCK;
const JACK_BLOCK: usize = JACKS * BLOCK;

/// Why the converters must be built anew.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum Fault {
    /// A result was not fetched before the next came, or the ring was read too late.
    Overrun,
    /// No block in three times the time that one takes.
    Stuck,
}

/// Memory that outlives every run: rings for DMA, and the halves copied out of them.
pub struct Buffers {
    inertial_ring: &'static mut [u16; 2 * INERTIAL_BLOCK],
    jack_ring: &'static mut [u16; 2 * JACK_BLOCK],
    inertial: [u16; INERTIAL_BLOCK],
    jacks: [u16; JACK_BLOCK],
}

impl Buffers {
    /// Takes the memory of the rings; there is one.
    pub fn take() -> Self {
        static INERTIAL_RING: ConstStaticCell<[u16; 2 * INERTIAL_BLOCK]> =
            ConstStaticCell::new([0; 2 * INERTIAL_BLOCK]);
        static JACK_RING: ConstStaticCell<[u16; 2 * JACK_BLOCK]> =
            ConstStaticCell::new([0; 2 * JACK_BLOCK]);
        Self {
            inertial_ring: INERTIAL_RING.take(),
            jack_ring: JACK_RING.take(),
            inertial: [0; INERTIAL_BLOCK],
            jacks: [0; JACK_BLOCK],
        }
    }
}

/// Both converters running in step at one rate, until dropped.
pub struct Run<'d> {
    inertial_adc: RingBufferedAdc<'d, ADC1>,
    jack_adc: RingBufferedAdc<'d, ADC2>,
    inertial: &'d mut [u16; INERTIAL_BLOCK],
    jacks: &'d mut [u16; JACK_BLOCK],
    rate_hz: u32,
    started: Instant,
    _trigger: Trigger<'d>,
}

impl<'d> Run<'d> {
    /// Builds and calibrates the converters, then starts them and the trigger at `rate_hz`, one of `RATES_HZ`.
    pub fn start(parts: &'d mut pins::Acquisition, buffers: &'d mut Buffers, rate_hz: u32) -> Self {
        let trigger = Trigger::new(parts.timer.reborrow(), rate_hz);
        let inertial_adc = Adc::new(parts.inertial_adc.reborrow(), converter());
        let jack_adc = Adc::new(parts.jack_adc.reborrow(), converter());
        let mut inertial_adc = inertial_adc.into_ring_buffered(
            parts.inertial_dma.reborrow(),
            buffers.inertial_ring,
            Irqs,
            parts
                .inertial
                .sequence()
                .map(|channel| (channel, SAMPLE_TIME))
                .into_iter(),
            TIM6_TRGO,
            Exten::RISING_EDGE,
        );
        let mut jack_adc = jack_adc.into_ring_buffered(
            parts.jack_dma.reborrow(),
            buffers.jack_ring,
            Irqs,
            parts
                .jacks
                .sequence()
                .map(|channel| (channel, SAMPLE_TIME))
                .into_iter(),
            TIM6_TRGO,
            Exten::RISING_EDGE,
        );
        inertial_adc.start();
        jack_adc.start();
        trigger.start();
        Self {
            inertial_adc,
            jack_adc,
            inertial: &mut buffers.inertial,
            jacks: &mut buffers.jacks,
            rate_hz,
            started: Instant::now(),
            _trigger: trigger,
        }
    }

    /// When the trigger was started; scan n begins (n + 1) periods later.
    pub fn started(&self) -> Instant {
        self.started
    }

    /// Waits for the next block and puts it into `block`.
    ///
    /// # Errors
    /// [`Fault`]: this run is over, start another.
    pub async fn next(&mut self, block: &mut [Scan; BLOCK]) -> Result<(), Fault> {
        let both = join(
            self.inertial_adc.read(self.inertial),
            self.jack_adc.read(self.jacks),
        );
        match select(both, Timer::after(block_timeout(self.rate_hz))).await {
            Either::First((Ok(_), Ok(_))) => {}
            Either::First(_) => return Err(Fault::Overrun),
            Either::Second(()) => return Err(Fault::Stuck),
        }
        if [pac::ADC1, pac::ADC2]
            .iter()
            .any(|adc| adc.isr().read().ovr())
        {
            return Err(Fault::Overrun);
        }
        let inertial = self.inertial.as_chunks::<INERTIAL>().0;
        let jacks = self.jacks.as_chunks::<JACKS>().0;
        for ((scan, inertial), jacks) in block.iter_mut().zip(inertial).zip(jacks) {
            scan[..INERTIAL].copy_from_slice(inertial);
            scan[INERTIAL..CHANNELS].copy_from_slice(jacks);
        }
        Ok(())
    }
}

/// Sixteen conversions in a row for each trigger and channel, added up and not shifted.
fn converter() -> AdcConfig {
    AdcConfig {
        oversampling_ratio: Some(OVERSAMPLING_CODE),
        oversampling_shift: Some(0),
        oversampling_mode: Some((Rovsm::RESUMED, Trovs::AUTOMATIC, true)),
        ..AdcConfig::default()
    }
}
