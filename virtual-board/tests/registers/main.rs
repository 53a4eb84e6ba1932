//! Each peripheral model against the reference manual (RM0440) and the data sheet, register by register, without any
//! firmware.

mod adc;
mod crc;
mod debug;
mod dma;
mod flash;
mod gpio;
mod iwdg;
mod lpuart;
mod nvic;
mod rcc;
mod rng;
mod systick;
mod timer;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// A seeded source of noise.
fn noise() -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(7)
}
