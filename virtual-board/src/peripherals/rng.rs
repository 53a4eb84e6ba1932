//! True random number generator (RM0440 chapter 26), whose noise source is a seeded generator.
//!
//! Words come in fours: a block takes 412 clocks of the 48 MHz oscillator after the generator is switched on, and 48
//! after the last block was used up.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng as _;

use super::{Cycles, NO_SUCH_REGISTER, Read, Write, bit};

const RNGEN: u32 = 2;
const IE: u32 = 3;
const FIRST_BLOCK_CLOCKS: u64 = 412;
const BLOCK_CLOCKS: u64 = 48;
const CLOCK_HZ: u64 = 48_000_000;
const WORDS_PER_BLOCK: u32 = 4;

/// The generator.
#[derive(Debug)]
pub struct Rng {
    noise: ChaCha8Rng,
    core_hz: u64,
    cr: u32,
    ready_at: Cycles,
    words_left: u32,
}

impl Rng {
    /// The generator after reset, with its source of noise.
    pub fn new(noise: ChaCha8Rng, core_hz: u64) -> Self {
        Self {
            noise,
            core_hz,
            cr: 0,
            ready_at: 0,
            words_left: 0,
        }
    }

    /// Back to the state after reset; the noise goes on.
    pub fn reset(&mut self) {
        self.cr = 0;
        self.words_left = 0;
    }

    /// Sets the frequency of the core.
    pub fn set_core_clock(&mut self, core_hz: u64) {
        self.core_hz = core_hz;
    }

    /// Reads a register. `clocked` says whether the 48 MHz oscillator runs.
    pub fn read(&mut self, offset: u32, now: Cycles, clocked: bool) -> Read {
        Ok(match offset {
            0x00 => self.cr,
            0x04 => u32::from(self.ready(now, clocked)),
            0x08 if self.ready(now, clocked) => self.take(now),
            0x08 => 0,
            _ => return Err(NO_SUCH_REGISTER),
        })
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32, now: Cycles) -> Write {
        match offset {
            0x00 => {
                let starts = bit(value & !self.cr, RNGEN);
                self.cr = value;
                if starts {
                    self.begin(FIRST_BLOCK_CLOCKS, now);
                }
            }
            0x04 => {}
            _ => return Err(NO_SUCH_REGISTER),
        }
        Ok(())
    }

    /// Whether the interrupt line is high.
    pub fn interrupt(&self, now: Cycles, clocked: bool) -> bool {
        bit(self.cr, IE) && self.ready(now, clocked)
    }

    /// When the next block is ready, for the interrupt.
    pub fn next_event(&self, now: Cycles) -> Cycles {
        if bit(self.cr, RNGEN) && bit(self.cr, IE) && self.ready_at > now {
            self.ready_at
        } else {
            super::NEVER
        }
    }

    fn ready(&self, now: Cycles, clocked: bool) -> bool {
        clocked && bit(self.cr, RNGEN) && now >= self.ready_at
    }

    fn begin(&mut self, clocks: u64, now: Cycles) {
        self.ready_at = now + clocks * self.core_hz / CLOCK_HZ;
        self.words_left = WORDS_PER_BLOCK;
    }

    fn take(&mut self, now: Cycles) -> u32 {
        self.words_left -= 1;
        if self.words_left == 0 {
            self.begin(BLOCK_CLOCKS, now);
        }
        self.noise.next_u32()
    }
}
