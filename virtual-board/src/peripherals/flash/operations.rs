//! Programming and erasing: how an operation begins, ends, or is cut short.

use rand_chacha::rand_core::Rng as _;

use super::{EOP, EOPIE, ERRORS, Flash, OPERR, Operation, PG, PGSERR, STRT, WRPERR};
use crate::injection::Progress;
use crate::memory::flash::FlashMemory;
use crate::memory::{BANK_SIZE, FLASH_SIZE};
use crate::peripherals::{Cycles, NEVER, bit, field};

/// Duration of an operation, s (data sheet DS12288, table "Flash memory characteristics", typical).
const PROGRAM_S: f64 = 85.0e-6;
const PAGE_ERASE_S: f64 = 22.02e-3;
const MASS_ERASE_S: f64 = 22.13e-3;

const PROGERR: u32 = 1 << 3;
const PER: u32 = 1;
const MER1: u32 = 2;
const MER2: u32 = 15;

impl Flash {
    /// No operation, under way or to come, ends before `until`.
    pub fn hold_up(&mut self, until: Cycles) {
        self.held_until = until;
        if let Some((_, end)) = &mut self.running {
            *end = until.max(*end);
        }
    }

    /// When [`Self::advance`] must be called next: the end of the operation under way.
    pub fn next_event(&self) -> Cycles {
        self.running.map_or(NEVER, |(_, at)| at)
    }

    /// Ends an operation whose time has come.
    pub fn advance(&mut self, now: Cycles, memory: &mut FlashMemory) -> std::io::Result<()> {
        let Some((operation, at)) = self.running else {
            return Ok(());
        };
        if at > now {
            return Ok(());
        }
        self.running = None;
        self.reaches(Progress::Done);
        self.cr &= !(1 << STRT);
        if bit(self.cr, EOPIE) {
            self.sr |= EOP;
        }
        match operation {
            Operation::Program { offset, data } => memory.write(offset, &data.to_le_bytes()),
            Operation::Erase { offset, length } => memory.write(offset, &vec![0xFF; length]),
        }
    }

    pub(super) fn begin_program(
        &mut self,
        offset: usize,
        data: u64,
        memory: &FlashMemory,
        now: Cycles,
    ) -> Option<u32> {
        // A double word is written once; only all zeros may be written over anything (3.7.5, PROGERR).
        if memory.double_word(offset) != u64::MAX && data != 0 {
            return Some(PROGERR);
        }
        if self.options.protects(&(offset..offset + 8)) {
            return Some(WRPERR);
        }
        let end = now + (PROGRAM_S * self.core_hz) as Cycles;
        self.begin(Operation::Program { offset, data }, end);
        None
    }

    fn begin(&mut self, operation: Operation, end: Cycles) {
        self.operations += 1;
        if self.reaches(Progress::NotBegun) {
            return;
        }
        self.running = Some((operation, end.max(self.held_until)));
        self.reaches(Progress::Half);
    }

    pub(super) fn begin_erase(&mut self, now: Cycles) {
        let page = bit(self.cr, PER);
        let (mer1, mer2) = (bit(self.cr, MER1), bit(self.cr, MER2));
        if bit(self.cr, PG) || self.sr & ERRORS & !OPERR != 0 || page == (mer1 || mer2) {
            self.cr &= !(1 << STRT);
            self.fail(PGSERR);
            return;
        }
        let (range, duration_s) = match (page, mer1, mer2) {
            (true, ..) => {
                let number = field(self.cr, 3, 7) as usize;
                (self.options.page(number, bit(self.cr, 11)), PAGE_ERASE_S)
            }
            (false, true, true) => (0..FLASH_SIZE, MASS_ERASE_S),
            (false, true, false) => (0..BANK_SIZE, MASS_ERASE_S),
            (false, false, _) => (BANK_SIZE..FLASH_SIZE, MASS_ERASE_S),
        };
        if self.options.protects(&range) {
            self.cr &= !(1 << STRT);
            self.fail(WRPERR);
            return;
        }
        let end = now + (duration_s * self.core_hz) as Cycles;
        let (offset, length) = (range.start, range.len());
        self.begin(Operation::Erase { offset, length }, end);
    }

    pub(super) fn tear(
        &mut self,
        operation: Operation,
        memory: &mut FlashMemory,
    ) -> std::io::Result<()> {
        match operation {
            Operation::Program { offset, data } => {
                let left = memory.double_word(offset) & (data | self.tearing.next_u64());
                memory.tear(offset, left)
            }
            Operation::Erase { offset, length } => {
                for word in (offset..offset + length).step_by(8) {
                    let before = memory.double_word(word);
                    match self.tearing.next_u32() % 3 {
                        0 => {}
                        1 => memory.tear(word, before | self.tearing.next_u64())?,
                        _ => memory.write(word, &u64::MAX.to_le_bytes())?,
                    }
                }
                Ok(())
            }
        }
    }
}
