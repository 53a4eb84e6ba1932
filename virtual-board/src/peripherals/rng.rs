//! True random number generator (RM0440 chapter 26), whose noise source is a seeded generator.
//!
//! Words come in fours: a block takes 412 clocks of the 48 MHz oscillator after the generator is switched on, and 48
//! after the last block was used up. A fault can hold the generator back, or make it report an error of its noise or its
//! clock (26.3.5); then it gives no words until the flag is cleared.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng as _;

use super::{Cycles, NO_SUCH_REGISTER, Read, Write, bit};
use crate::injection::Defect;

// CR
const RNGEN: u32 = 2;
const IE: u32 = 3;
// SR
const SECS: u32 = 1 << 2;
const CECS: u32 = 1 << 1;
const CEIS: u32 = 1 << 5;
const SEIS: u32 = 1 << 6;
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
    /// What is wrong with it, and until when.
    defect: Option<(Defect, Cycles)>,
    /// Interrupt flags of errors: noise, clock.
    errors: u32,
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
            defect: None,
            errors: 0,
        }
    }

    /// It has this defect until `end`, or a reset of the power.
    pub fn break_down(&mut self, defect: Defect, end: Cycles) {
        self.defect = Some((defect, end));
    }

    /// Back to the state after reset; the noise goes on.
    pub fn reset(&mut self) {
        self.cr = 0;
        self.words_left = 0;
        self.errors = 0;
    }

    /// Sets the frequency of the core.
    pub fn set_core_clock(&mut self, core_hz: u64) {
        self.core_hz = core_hz;
    }

    /// Reads a register. `clocked` says whether the 48 MHz oscillator runs.
    pub fn read(&mut self, offset: u32, now: Cycles, clocked: bool) -> Read {
        self.look(now);
        Ok(match offset {
            0x00 => self.cr,
            0x04 => self.status(now, clocked),
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
            // The flags are cleared by a zero (rc_w0).
            0x04 => self.errors &= value,
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

    fn status(&self, now: Cycles, clocked: bool) -> u32 {
        let present = match self.defect(now) {
            Some(Defect::Seed) => SECS,
            Some(Defect::Clock) => CECS,
            _ => 0,
        };
        u32::from(self.ready(now, clocked)) | present | self.errors
    }

    /// Raises the flag of a defect that the generator notices.
    fn look(&mut self, now: Cycles) {
        if bit(self.cr, RNGEN) {
            self.errors |= match self.defect(now) {
                Some(Defect::Seed) => SEIS,
                Some(Defect::Clock) => CEIS,
                _ => 0,
            };
        }
    }

    fn defect(&self, now: Cycles) -> Option<Defect> {
        let (defect, end) = self.defect?;
        (now < end).then_some(defect)
    }

    fn ready(&self, now: Cycles, clocked: bool) -> bool {
        let works = matches!(
            self.defect(now),
            None | Some(Defect::Zeros | Defect::SameWord)
        );
        clocked && works && self.errors == 0 && bit(self.cr, RNGEN) && now >= self.ready_at
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
        match self.defect(now) {
            Some(Defect::Zeros) => 0,
            Some(Defect::SameWord) => 0x5A5A_5A5A,
            _ => self.noise.next_u32(),
        }
    }
}
