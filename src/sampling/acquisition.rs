//! The converters: fifteen channels in step with the trigger, into two DMA rings.
//!
//! ```text
//! TIM6 update ─┬─▶ ADC1: nine inertial channels × 16 conversions ─DMA─▶ ring of two blocks ─▶ interrupt
//!              └─▶ ADC2: six jack channels × 16 conversions     ─DMA─▶ ring of two blocks
//! ```
//!
//! Everything up to the rings is hardware: no software delay can move a sampling instant. While DMA fills one half
//! of a ring, the other half, a block of scans, is read where it lies. ADC1 ends last, so that its interrupt finds
//! the jacks' half filled too; the drivers of embassy own converters and DMA channels, and the rings are not read
//! through them.
//!
//! A converter whose result was not fetched in time (*overrun*) stops without a sign, and a half that is read too late
//! is overwritten. Both are found and are a [`Fault`]; the caller then builds the converters anew, which is the only
//! way to put both rings back in step.
//!
//! If DMA loses a result or takes one twice, every count from then on has the place of its neighbour. So each block must
//! end where a scan ends. When the interrupt finds DMA at the end of a half, the trigger timer must be between the end of a
//! scan and that of the first rank of the next one, and the ring of the jacks must end there too:
//!
//! ```text
//! TIM6        │ trigger                                  end of scan │         │ trigger
//! ADC1        │ 1 │ 2 │ 3 │ 4 │ 5 │ 6 │ 7 │ 8 │ 9 │                            │ 1 │ 2 │ …
//! interrupt                                       ▲ in step: from here … to here ▲   ▲ a result was lost
//!                                             ▲ a result was taken twice
//! ```
//!
//! An interrupt that comes so late that DMA has gone on says nothing about that; the next one does.

use core::cell::UnsafeCell;
use core::ptr;
use core::slice;
use core::sync::atomic::{Ordering, compiler_fence};

use embassy_stm32::adc::{Adc, AdcConfig, Exten, RingBufferedAdc, Rovsm, Trovs};
use embassy_stm32::interrupt::typelevel::Binding;
use embassy_stm32::pac;
use embassy_stm32::peripherals::{ADC1, ADC2, DMA1_CH1, DMA1_CH2};
use embassy_stm32::triggers::TIM6_TRGO;
use embassy_stm32::{bind_interrupts, dma, interrupt};
use hexsense_core::channel::{INERTIAL, JACKS};
use hexsense_core::sampling::BlockSize;

use super::self_calibration::{self, Converter};
use crate::chip::pins::{self, INERTIAL_DMA, JACK_DMA};
use crate::chip::timing::{OVERSAMPLING_CODE, SAMPLE_TIME};
use crate::chip::trigger::{Trigger, is_amid_scan};

bind_interrupts!(
    /// The interrupts of the converters' DMA but the first, which is the sample interrupt.
    struct Irqs {
        DMA1_CHANNEL2 => dma::InterruptHandler<DMA1_CH2>;
    }
);

// SAFETY: the driver's handler would count rounds of the ring and wake the task that reads it through the driver, which
// no task does. It is left out because it panics on an error; the sample interrupt acknowledges everything.
unsafe impl Binding<interrupt::typelevel::DMA1_CHANNEL1, dma::InterruptHandler<DMA1_CH1>> for Irqs {}

/// Scans that a ring holds: two of the largest blocks.
const RING: usize = 2 * BlockSize::MAX_SCANS;

/// Why the converters must be built anew. None of them is zero, so that no fault is: the path's state begins as zeros.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum Fault {
    /// A result was not fetched before the next came.
    Overrun = 1,
    /// A block was not read before it was overwritten.
    Late,
    /// No block in three times the time that one takes, and no overrun.
    Stuck,
    /// A result was lost or taken twice, and the scans of the rings do not begin with their first rank.
    Slipped,
}

/// Memory that DMA writes, in scans of `N` counts.
struct Ring<const N: usize>(UnsafeCell<[[u16; N]; RING]>);

// SAFETY: DMA writes one half while the other is read, by the sample interrupt alone.
unsafe impl<const N: usize> Sync for Ring<N> {}

impl<const N: usize> Ring<N> {
    const fn new() -> Self {
        Self(UnsafeCell::new([[0; N]; RING]))
    }

    /// The counts of two blocks, for the driver that sets DMA up.
    fn for_dma(&'static self, block: BlockSize) -> *mut [u16] {
        ptr::slice_from_raw_parts_mut(self.0.get().cast(), 2 * block.scans() * N)
    }

    /// The block in the first (0) or second (1) half.
    fn half(&'static self, block: BlockSize, half: usize) -> &'static [[u16; N]] {
        let scans = block.scans();
        // SAFETY: `half` is 0 or 1, so the block lies in the ring. DMA is at work in the other half; whether it came
        // back too soon is checked after the last read, and then nothing that was read is used.
        unsafe { slice::from_raw_parts(self.0.get().cast::<[u16; N]>().add(half * scans), scans) }
    }
}

static INERTIAL_RING: Ring<INERTIAL> = Ring::new();
static JACK_RING: Ring<JACKS> = Ring::new();

/// Why no block came: a converter that had an overrun makes no more results, and so no interrupt either.
pub fn why_no_block() -> Fault {
    if overrun() {
        Fault::Overrun
    } else {
        Fault::Stuck
    }
}

#[inline(always)]
fn overrun() -> bool {
    pac::ADC1.isr().read().ovr() | pac::ADC2.isr().read().ovr()
}

/// A block that lies complete in the rings.
pub struct Filled {
    /// Counts of the inertial channels, scan by scan.
    pub inertial: &'static [[u16; INERTIAL]],
    /// Counts of the jacks.
    pub jacks: &'static [[u16; JACKS]],
    half: usize,
}

impl Filled {
    /// The block whose interrupt this is, if it is one; acknowledges the interrupt. A transfer error has switched the
    /// channel off, and as after an overrun no block comes: the sampling task finds out. The flags are cleared by
    /// themselves: clearing the global flag can lose an event that comes at the same time (ES0430).
    ///
    /// # Errors
    /// [`Fault`] when the block is not whole, or another is complete already.
    #[inline(always)]
    pub fn take(block: BlockSize) -> Option<Result<Self, Fault>> {
        let flags = pac::DMA1.isr().read();
        let (first, second) = (flags.htif(INERTIAL_DMA), flags.tcif(INERTIAL_DMA));
        if !first && !second {
            pac::DMA1
                .ifcr()
                .write(|clear| clear.set_teif(INERTIAL_DMA, true));
            return None;
        }
        pac::DMA1.ifcr().write(|clear| {
            clear.set_htif(INERTIAL_DMA, true);
            clear.set_tcif(INERTIAL_DMA, true);
        });
        let half = usize::from(second);
        let scans = block.scans();
        let (inertial, jacks) = (scans * INERTIAL, scans * JACKS);
        // What is left of the round: in the second half of the ring when the first is complete.
        let left = |channel: usize| usize::from(pac::DMA1.ch(channel).ndtr().read().ndt());
        let amid_scan = is_amid_scan();
        let (inertial_left, jacks_left) = (left(INERTIAL_DMA), left(JACK_DMA));
        let elsewhere = ((inertial_left > inertial) == second) & ((jacks_left > jacks) == second);
        let at_end = inertial_left == inertial << half;
        let slipped = at_end & (amid_scan | (jacks_left != jacks << half));
        Some(if overrun() {
            Err(Fault::Overrun)
        } else if slipped {
            Err(Fault::Slipped)
        } else if (first & second) | !elsewhere {
            Err(Fault::Late)
        } else {
            compiler_fence(Ordering::SeqCst);
            Ok(Self {
                inertial: INERTIAL_RING.half(block, half),
                jacks: JACK_RING.half(block, half),
                half,
            })
        })
    }

    /// Whether DMA stayed in the other half until now, so that what was read is whole.
    #[inline(always)]
    pub fn is_whole(&self) -> bool {
        compiler_fence(Ordering::SeqCst);
        let flags = pac::DMA1.isr().read();
        let (first, second) = (flags.htif(INERTIAL_DMA), flags.tcif(INERTIAL_DMA));
        !(if self.half == 0 { second } else { first })
    }
}

/// Both converters in step at one rate, until dropped.
pub struct Run<'d> {
    inertial: RingBufferedAdc<'d, ADC1>,
    jacks: RingBufferedAdc<'d, ADC2>,
    trigger: Trigger<'d>,
}

impl<'d> Run<'d> {
    /// Builds the converters for blocks of this size, and the trigger for `rate_hz`, one of those in
    /// [`hexsense::FACTS`].
    ///
    /// The first conversion of a converter after a pause of 1 ms may be wrong (ES0430), so each makes one here that is
    /// thrown away; the first trigger follows soon enough.
    pub fn prepare(parts: &'d mut pins::Acquisition, rate_hz: u32, block: BlockSize) -> Self {
        let trigger = Trigger::new(parts.timer.reborrow(), rate_hz);
        let mut inertial_adc = Adc::new(parts.inertial_adc.reborrow(), converter());
        let mut jack_adc = Adc::new(parts.jack_adc.reborrow(), converter());
        self_calibration::settle(Converter::Inertial);
        self_calibration::settle(Converter::Jacks);
        let mut inertial_pins = parts.inertial.sequence();
        let mut jack_pins = parts.jacks.sequence();
        inertial_adc.blocking_read(&mut inertial_pins[0], SAMPLE_TIME);
        jack_adc.blocking_read(&mut jack_pins[0], SAMPLE_TIME);
        // SAFETY: the rings have room for two of the largest blocks. The drivers, which are never asked to read, hand
        // them to DMA and leave them alone, and exclusive access to the parts makes these drivers the only ones.
        let (inertial_ring, jack_ring) = unsafe {
            (
                &mut *INERTIAL_RING.for_dma(block),
                &mut *JACK_RING.for_dma(block),
            )
        };
        let inertial = inertial_adc.into_ring_buffered(
            parts.inertial_dma.reborrow(),
            inertial_ring,
            Irqs,
            inertial_pins.map(|pin| (pin, SAMPLE_TIME)).into_iter(),
            TIM6_TRGO,
            Exten::RISING_EDGE,
        );
        let jacks = jack_adc.into_ring_buffered(
            parts.jack_dma.reborrow(),
            jack_ring,
            Irqs,
            jack_pins.map(|pin| (pin, SAMPLE_TIME)).into_iter(),
            TIM6_TRGO,
            Exten::RISING_EDGE,
        );
        // Only the converter that ends last interrupts.
        pac::DMA1.ch(JACK_DMA).cr().modify(|control| {
            control.set_htie(false);
            control.set_tcie(false);
        });
        Self {
            inertial,
            jacks,
            trigger,
        }
    }

    /// Starts converters and trigger.
    pub fn start(&mut self) {
        self.inertial.start();
        self.jacks.start();
        self.trigger.start();
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
