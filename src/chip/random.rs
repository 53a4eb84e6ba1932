//! Random numbers for challenges, from the chip's generator. Every wait here ends, because a board whose generator is dead
//! still measures: it only takes no change.
//!
//! The generator is switched on anew for each challenge, which also clears the errors of the last (RM0440, 26.3.5). The
//! first number is not used, and no number may be that before it or zero: a generator that stands still gives itself away.

use embassy_stm32::Peri;
use embassy_stm32::pac;
use embassy_stm32::peripherals::RNG;
use embassy_stm32::rcc;
use embassy_time::Timer;

use super::timing::{RANDOM_LOOK, RANDOM_LOOKS};

/// The generator.
pub struct Random {
    _owned: Peri<'static, RNG>,
}

impl Random {
    /// Takes the generator and starts its oscillator, without waiting for it.
    pub fn new(rng: Peri<'static, RNG>) -> Self {
        pac::RCC.crrcr().modify(|control| control.set_hsi48on(true));
        rcc::enable_and_reset::<RNG>();
        Self { _owned: rng }
    }

    /// Fills a challenge; `false` when the generator is not ready in time or finds an error of its clock or its noise.
    pub async fn fill(&mut self, challenge: &mut [u8; 16]) -> bool {
        pac::RNG.cr().write(|control| control.set_rngen(false));
        pac::RNG.sr().write(|_| {});
        pac::RNG.cr().write(|control| control.set_rngen(true));
        let Some(mut last) = word().await else {
            return false;
        };
        for bytes in challenge.as_chunks_mut::<4>().0 {
            match word().await {
                Some(word) if word != last => {
                    *bytes = word.to_ne_bytes();
                    last = word;
                }
                _ => return false,
            }
        }
        true
    }
}

/// The next number; `None` when none comes in time, after an error, and for a zero, which the generator never makes.
async fn word() -> Option<u32> {
    for _ in 0..RANDOM_LOOKS {
        let status = pac::RNG.sr().read();
        if status.seis() | status.ceis() {
            return None;
        }
        if status.drdy() {
            return Some(pac::RNG.dr().read()).filter(|word| *word != 0);
        }
        Timer::after(RANDOM_LOOK).await;
    }
    None
}
