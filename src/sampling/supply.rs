//! Supply voltage and die temperature, measured slowly on ADC5.
//!
//! The converters measure against their supply: a supply that drifts is gain that drifts. The chip's own reference
//! VREFINT does not drift with it, and its code at 3.0 V was noted at the factory:
//!
//! ```text
//! VDDA = 3.0 V · VREFINT_CAL / code(VREFINT)          c = VDDA / 3.3 V
//! T = 30 °C + 100 K · (code(TS) · VDDA / 3.0 V − TS_CAL1) / (TS_CAL2 − TS_CAL1)
//! ```
//!
//! (RM0440, 21.4.31 and 21.4.33; calibration words in the data sheet DS12288, 3.18.) A count's supply error multiplies
//! half of the full scale, so c must be known far better than one conversion gives it: each reading is the sum of
//! 256 conversions; the first sixteen readings follow each other in 0.2 s and are averaged, and from then on each
//! enters by a sixteenth, a low-pass of 1.6 s. [`SupplyMean`] refuses the readings that no working board has.

use embassy_stm32::adc::{Adc, AdcChannel, AdcConfig, Rovsm, SampleTime, Trovs};
use embassy_stm32::peripherals::DMA1_CH3;
use embassy_stm32::{bind_interrupts, dma, pac};
use embassy_time::{Ticker, Timer, with_timeout};
use hexsense::{
    FACTS, SUPPLY_CONVERSIONS, SUPPLY_OVERSAMPLING, SUPPLY_READINGS, SUPPLY_SAMPLING_HALF_CYCLES,
};
use hexsense_core::sampling::SupplyMean;

use super::self_calibration::{self, Converter};
use crate::chip::pins;
use crate::chip::timing::{INTERNAL_START, SUPPLY_PERIOD, SUPPLY_WAIT};
use crate::health::counters;
use crate::shared::{Shared, Task};

bind_interrupts!(
    struct Irqs {
        DMA1_CHANNEL3 => dma::InterruptHandler<DMA1_CH3>;
    }
);

/// Sampling time of the internal channels.
const SAMPLE_TIME: SampleTime = SampleTime::CYCLES640_5;
const _: () = assert!(
    SUPPLY_SAMPLING_HALF_CYCLES == 1_281,
    "the sampling time is not that of the library"
);

/// What the factory noted about this chip: 12-bit codes at a supply of 3.0 V.
struct Factory {
    vrefint: u16,
    temperature_30c: u16,
    temperature_130c: u16,
}

impl Factory {
    const SUPPLY_V: f32 = 3.0;
    const LOW_C: f32 = 30.0;
    const SPAN_K: f32 = 100.0;

    fn read() -> Self {
        const TS_CAL1: *const u16 = 0x1FFF_75A8 as *const u16;
        const TS_CAL2: *const u16 = 0x1FFF_75CA as *const u16;
        // SAFETY: both are aligned half-words in the chip's read-only system memory.
        let (low, high) = unsafe { (TS_CAL1.read_volatile(), TS_CAL2.read_volatile()) };
        Self {
            vrefint: pac::VREFINTCAL.data().read(),
            temperature_30c: low,
            temperature_130c: high,
        }
    }

    /// Supply factor and temperature (°C) from two codes, which count 16 to one 12-bit code. Not finite when a code is 0.
    fn convert(&self, vrefint: u16, temperature: u16) -> (f32, f32) {
        const PER_CODE: f32 = 16.0;
        let vdda_v = Self::SUPPLY_V * f32::from(self.vrefint) * PER_CODE / f32::from(vrefint);
        let at_3v = f32::from(temperature) / PER_CODE * vdda_v / Self::SUPPLY_V;
        let low = f32::from(self.temperature_30c);
        let span = f32::from(self.temperature_130c) - low;
        let temperature_c = Self::LOW_C + Self::SPAN_K * (at_3v - low) / span;
        (vdda_v / FACTS.nominal_supply_v, temperature_c)
    }
}

/// Measures for ever and leaves each smoothed reading in `shared`.
#[embassy_executor::task]
pub async fn measure(mut parts: pins::Supply, shared: &'static Shared) -> ! {
    let latest = shared.supply.sender();
    // 256 conversions, shifted by 4: 16 counts for one code, as on the other converters.
    let mut adc = Adc::new(
        parts.adc,
        AdcConfig {
            oversampling_ratio: Some(SUPPLY_OVERSAMPLING.trailing_zeros() as u8 - 1),
            oversampling_shift: Some(4),
            oversampling_mode: Some((Rovsm::RESUMED, Trovs::AUTOMATIC, true)),
            ..AdcConfig::default()
        },
    );
    self_calibration::settle(Converter::Supply);
    // The first conversion after a pause of more than 1 ms may be wrong (errata ES0430), so it is thrown away.
    let mut discarded = adc.enable_vrefint().degrade_adc::<'static>();
    let mut vrefint = adc.enable_vrefint().degrade_adc::<'static>();
    let mut temperature = adc.enable_temperature().degrade_adc::<'static>();
    Timer::after(INTERNAL_START).await;
    let factory = Factory::read();
    let mut mean = SupplyMean::new();
    let mut codes = [0u16; SUPPLY_CONVERSIONS as usize];
    let mut ticker = Ticker::every(SUPPLY_PERIOD);
    loop {
        let sequence = [
            (&mut discarded, SAMPLE_TIME),
            (&mut vrefint, SAMPLE_TIME),
            (&mut temperature, SAMPLE_TIME),
        ];
        let read = adc.read(parts.dma.reborrow(), Irqs, sequence.into_iter(), &mut codes);
        let reading = match with_timeout(SUPPLY_WAIT, read).await {
            Ok(()) => Some(factory.convert(codes[1], codes[2])),
            Err(_) => None,
        };
        let taken = mean.take(reading);
        if !taken {
            counters::note(|events| &mut events.supply_refused);
        }
        latest.send(mean.reading());
        shared.alive.sign(Task::Supply);
        if !taken || mean.reading().readings == SUPPLY_READINGS {
            ticker.next().await;
        }
    }
}
