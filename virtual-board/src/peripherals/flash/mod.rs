//! Flash interface (RM0440 chapter 3): 512 KB in two banks of 128 pages of 2 KB.
//!
//! - Double words are programmed through a latch: a word to the lower address, then a word to the upper one. 85 µs.
//! - Pages are erased in 22 ms. The operation takes effect when it ends.
//! - While a bank is busy the other can be read and executed; an access to the busy bank, and a store to either,
//!   stalls the core until the operation ends (3.3.1, 3.3.5). The processor model asks [`Flash::is_busy`].
//! - An operation that a reset or the end of the power cuts short leaves a torn double word or page: some bits are
//!   done, and the error code does not match. A read of it sets ECCD and raises the NMI. An interrupted erasure leaves
//!   old, torn and erased words in its page.
//! - A double word with one wrong bit reads correctly, sets ECCC, and raises the interrupt if ECCCIE is set.
//!
//! Reads of data find errors, instruction fetches do not. Not modelled: fast programming, programming of option bytes,
//! areas protected from reading.
//!
//! [`options`] has the option bytes; with a single bank (DBANK = 0) pages have other places.

mod operations;
pub mod options;
mod registers;

use rand_chacha::ChaCha8Rng;

use self::options::Options;
use super::{Cycles, bit};
use crate::injection::Progress;
use crate::memory::BANK_SIZE;
use crate::memory::ecc::Flaw;
use crate::memory::flash::FlashMemory;

// SR
const EOP: u32 = 1 << 0;
const OPERR: u32 = 1 << 1;
const WRPERR: u32 = 1 << 4;
const PGAERR: u32 = 1 << 5;
const SIZERR: u32 = 1 << 6;
const PGSERR: u32 = 1 << 7;
const ERRORS: u32 = 0xC3FA;
const BSY: u32 = 1 << 16;
// CR
const PG: u32 = 0;
const STRT: u32 = 16;
const EOPIE: u32 = 24;
const ERRIE: u32 = 25;
const OPTLOCK: u32 = 30;
const LOCK: u32 = 31;
// ECCR
const BK_ECC: u32 = 21;
const ECCCIE: u32 = 24;
const ECCC: u32 = 30;
const ECCD: u32 = 31;

/// State of a sequence of two keys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Keyhole {
    Locked,
    FirstKey,
    Open,
    /// A wrong key came: closed until the next reset.
    Jammed,
}

#[derive(Debug, Clone, Copy)]
enum Operation {
    Program { offset: usize, data: u64 },
    Erase { offset: usize, length: usize },
}

/// The flash interface.
#[derive(Debug)]
pub struct Flash {
    core_hz: f64,
    acr: u32,
    sr: u32,
    cr: u32,
    eccr: u32,
    options: Options,
    keyhole: Keyhole,
    option_keyhole: Keyhole,
    /// Lower half of a double word that waits for its upper half.
    latch: Option<(usize, u32)>,
    running: Option<(Operation, Cycles)>,
    /// Earliest end of any operation.
    held_until: Cycles,
    tearing: ChaCha8Rng,
    /// Program and erase operations begun since power-on.
    operations: u64,
    /// Operation at which a fault is due, and its progress then.
    trap: Option<(u64, Progress)>,
    trapped: bool,
    /// A wrong key has raised a bus error that is not collected yet.
    bus_error: bool,
}

impl Flash {
    /// The interface after reset; `tearing` decides about the remains of an interrupted operation.
    pub fn new(tearing: ChaCha8Rng, core_hz: f64) -> Self {
        Self {
            core_hz,
            acr: 0x0004_0600,
            sr: 0,
            cr: 1 << LOCK | 1 << OPTLOCK,
            eccr: 0,
            options: Options::default(),
            keyhole: Keyhole::Locked,
            option_keyhole: Keyhole::Locked,
            latch: None,
            running: None,
            held_until: 0,
            tearing,
            operations: 0,
            trap: None,
            trapped: false,
            bus_error: false,
        }
    }

    /// A reset, or the end of the power, cuts an operation under way short.
    pub fn reset(&mut self, memory: &mut FlashMemory) -> std::io::Result<()> {
        if let Some((operation, _)) = self.running.take() {
            self.tear(operation, memory)?;
        }
        let fresh = Self::new(self.tearing.clone(), self.core_hz);
        *self = Self {
            operations: self.operations,
            trap: self.trap,
            options: self.options.clone(),
            ..fresh
        };
        Ok(())
    }

    /// The option registers; a change is one that a debug probe makes before the reset.
    pub fn options_mut(&mut self) -> &mut Options {
        &mut self.options
    }

    /// Sets the frequency of the core.
    pub fn set_core_clock(&mut self, core_hz: f64) {
        self.core_hz = core_hz;
    }

    /// The core stores `size` bytes at `offset` from the start of the memory. The memory must not be busy.
    pub fn store(
        &mut self,
        offset: usize,
        value: u32,
        size: usize,
        memory: &FlashMemory,
        now: Cycles,
    ) {
        let failure = if !bit(self.cr, PG)
            || self.sr & ERRORS & !OPERR != 0
            || self.running.is_some()
        {
            Some(PGSERR)
        } else if size != 4 {
            Some(SIZERR)
        } else {
            match self.latch.take() {
                None if offset.is_multiple_of(8) => {
                    self.latch = Some((offset, value));
                    None
                }
                Some((lower, word)) if offset == lower + 4 => {
                    self.begin_program(lower, u64::from(value) << 32 | u64::from(word), memory, now)
                }
                _ => Some(PGAERR),
            }
        };
        if let Some(flag) = failure {
            self.fail(flag);
        }
    }

    /// Program and erase operations begun since power-on.
    pub fn operations(&self) -> u64 {
        self.operations
    }

    /// Sets the point at which [`Self::trapped`] becomes true: this progress of the operation with this number, counted
    /// from power-on. An operation with the trap [`Progress::NotBegun`] never begins.
    pub fn set_trap(&mut self, trap: Option<(u64, Progress)>) {
        (self.trap, self.trapped) = (trap, false);
    }

    /// Whether the trapped operation has reached that point.
    pub fn trapped(&self) -> bool {
        self.trapped
    }

    /// Notes the progress of the latest operation; true if the trap is there.
    fn reaches(&mut self, progress: Progress) -> bool {
        let here = self.trap == Some((self.operations, progress));
        self.trapped |= here;
        here
    }

    /// Whether an operation is under way.
    pub fn is_at_work(&self) -> bool {
        self.running.is_some()
    }

    /// Whether an operation keeps bank 0 or 1 busy; without two banks it keeps both.
    pub fn is_busy(&self, bank: usize) -> bool {
        self.running.is_some_and(|(operation, _)| match operation {
            Operation::Program { offset, .. } | Operation::Erase { offset, .. } => {
                offset / BANK_SIZE == bank || !self.options.dual_bank()
            }
        })
    }

    /// Whether reads of a bank must be looked at: it is busy, or holds a double word whose error code does not fit.
    pub fn watched(&self, bank: usize, memory: &FlashMemory) -> bool {
        let start = bank * BANK_SIZE;
        self.is_busy(bank) || memory.flaws().any_in(start..start + BANK_SIZE)
    }

    /// Notes a read at `offset`; true if the double word there is torn, which raises the NMI.
    pub fn check_read(&mut self, offset: usize, memory: &FlashMemory) -> bool {
        let flaw = memory.flaws().get(offset & !7);
        if let Some(flaw) = flaw {
            let flag = if flaw == Flaw::Torn { ECCD } else { ECCC };
            let (bank, in_bank) = match self.options.dual_bank() {
                true => (offset / BANK_SIZE, offset % BANK_SIZE),
                false => (0, offset),
            };
            let (bank, in_bank) = (bank as u32, (in_bank / 8) as u32);
            let kept = self.eccr & (1 << ECCCIE | 1 << ECCC | 1 << ECCD);
            self.eccr = kept | 1 << flag | bank << BK_ECC | in_bank;
        }
        flaw == Some(Flaw::Torn)
    }

    fn fail(&mut self, flag: u32) {
        self.latch = None;
        self.sr |= flag;
        if bit(self.cr, ERRIE) {
            self.sr |= OPERR;
        }
    }
}
