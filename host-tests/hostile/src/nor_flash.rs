//! Flash of the STM32G474, with a switch that cuts its power.
//!
//! Pages of 2 KiB are erased whole; double words of 8 bytes are programmed once after each erasure, except that a word
//! may always be programmed to zero (RM0440, 3.3.7). One operation is one erased page or one programmed word. [`Torn`]
//! gives the result of the operation under way at a power cut.

use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use hexsense_core::facts::FlashLayout;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Bytes that are programmed at once.
pub const WORD: usize = 8;
/// Bytes that are erased at once.
pub const PAGE: usize = 2_048;

/// The layout of a memory of so many pages.
#[must_use]
pub const fn layout(pages: usize) -> FlashLayout {
    FlashLayout {
        page_bytes: PAGE as u32,
        pages: pages as u32,
    }
}
const ERASED: u8 = 0xFF;

/// The result of the operation under way at a power cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Torn {
    /// The content from before.
    Nothing,
    /// The complete new content.
    Everything,
    /// Bits that had to change may have changed or not, each by itself.
    SomeBits,
    /// A programmed word holds anything. Of a page, the start is erased, one word holds anything, the rest is as
    /// before.
    Garbage,
    /// Each word of a page is as before, erased, or holds anything.
    Patchwork,
}

impl Torn {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Nothing,
        Self::Everything,
        Self::SomeBits,
        Self::Garbage,
        Self::Patchwork,
    ];
}

/// Why the memory refuses an operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The power is off.
    PowerLost,
    /// Not a multiple of the unit of programming or erasing.
    Unaligned,
    /// Not in the memory.
    OutOfRange,
    /// A word was programmed that was not erased.
    NotErased,
}

impl NorFlashError for Fault {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Unaligned => NorFlashErrorKind::NotAligned,
            Self::OutOfRange => NorFlashErrorKind::OutOfBounds,
            Self::PowerLost | Self::NotErased => NorFlashErrorKind::Other,
        }
    }
}

/// The memory.
#[derive(Clone)]
pub struct Nor {
    bytes: Vec<u8>,
    /// Operations begun since the flash was made.
    pub operations: u32,
    /// Reads since then.
    pub reads: u32,
    /// Erasures of each page.
    pub erasures: Vec<u32>,
    /// Number of operations that still complete before the power goes.
    cut: Option<(u32, Torn)>,
    powered: bool,
    /// Whether a word that cannot be programmed is reported. The driver's asynchronous form loses that error.
    pub reports: bool,
    /// The range where programming and erasing have no effect and report no error.
    pub worn_out: std::ops::Range<u32>,
    random: ChaCha8Rng,
}

impl Nor {
    /// Erased memory of so many pages.
    #[must_use]
    pub fn new(pages: usize) -> Self {
        Self {
            bytes: vec![ERASED; pages * PAGE],
            operations: 0,
            reads: 0,
            erasures: vec![0; pages],
            cut: None,
            powered: true,
            reports: true,
            worn_out: 0..0,
            random: ChaCha8Rng::seed_from_u64(1),
        }
    }

    /// All of it.
    #[must_use]
    pub fn range(&self) -> std::ops::Range<u32> {
        0..self.bytes.len() as u32
    }

    /// Completes `operations` more operations and cuts the power in the next one.
    pub fn cut_after(&mut self, operations: u32, torn: Torn, seed: u64) {
        self.cut = Some((operations, torn));
        self.random = ChaCha8Rng::seed_from_u64(seed);
    }

    /// Switches the power on again, and cancels a cut that has not come. Returns whether the power was off.
    pub fn power_on(&mut self) -> bool {
        self.cut = None;
        !std::mem::replace(&mut self.powered, true)
    }

    /// Whether the power is on.
    #[must_use]
    pub fn is_powered(&self) -> bool {
        self.powered
    }

    /// Its content.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Changes bytes directly, as no flash could.
    ///
    /// # Panics
    /// When the place is not in the memory.
    pub fn overwrite(&mut self, place: usize, bytes: &[u8]) {
        self.bytes[place..place + bytes.len()].copy_from_slice(bytes);
    }

    /// Carries out the change of `bytes` to `target`, unless the power goes.
    fn operate(&mut self, start: usize, target: &[u8]) -> Result<(), Fault> {
        self.operations += 1;
        if self.worn_out.contains(&(start as u32)) {
            return Ok(());
        }
        let place = start..start + target.len();
        match self.cut.as_mut() {
            None => {}
            Some((left @ 1.., _)) => *left -= 1,
            Some((0, torn)) => {
                let left = torn_bytes(&self.bytes[place.clone()], target, *torn, &mut self.random);
                self.bytes[place].copy_from_slice(&left);
                self.powered = false;
                return Err(Fault::PowerLost);
            }
        }
        self.bytes[place].copy_from_slice(target);
        Ok(())
    }

    fn check(&self, start: u32, length: usize, unit: usize) -> Result<usize, Fault> {
        let start = start as usize;
        if !self.powered {
            Err(Fault::PowerLost)
        } else if !start.is_multiple_of(unit) || !length.is_multiple_of(unit) {
            Err(Fault::Unaligned)
        } else if start + length > self.bytes.len() {
            Err(Fault::OutOfRange)
        } else {
            Ok(start)
        }
    }
}

fn torn_bytes(before: &[u8], target: &[u8], torn: Torn, random: &mut ChaCha8Rng) -> Vec<u8> {
    let edge = random.random_range(0..before.len() / WORD);
    let words = before.chunks(WORD).zip(target.chunks(WORD)).enumerate();
    words
        .flat_map(|(index, (before, target))| {
            let anything: [u8; WORD] = random.random();
            let pick: [u8; WORD] = random.random();
            let choice = random.random_range(0..3);
            (0..WORD).map(move |byte| match (torn, index.cmp(&edge), choice) {
                (Torn::Nothing, _, _) => before[byte],
                (Torn::Everything, _, _) => target[byte],
                (Torn::SomeBits, _, _) => {
                    (before[byte] & pick[byte]) | (target[byte] & !pick[byte])
                }
                (Torn::Garbage, std::cmp::Ordering::Less, _) => target[byte],
                (Torn::Garbage, std::cmp::Ordering::Equal, _) => anything[byte],
                (Torn::Garbage, std::cmp::Ordering::Greater, _) => before[byte],
                (Torn::Patchwork, _, 0) => before[byte],
                (Torn::Patchwork, _, 1) => target[byte],
                (Torn::Patchwork, _, _) => anything[byte],
            })
        })
        .collect()
}

impl ErrorType for Nor {
    type Error = Fault;
}

impl ReadNorFlash for Nor {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Fault> {
        let start = self.check(offset, bytes.len(), Self::READ_SIZE)?;
        self.reads += 1;
        bytes.copy_from_slice(&self.bytes[start..start + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Nor {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Fault> {
        let length = to.checked_sub(from).ok_or(Fault::OutOfRange)? as usize;
        let start = self.check(from, length, PAGE)?;
        for page in (start..start + length).step_by(PAGE) {
            self.erasures[page / PAGE] += 1;
            self.operate(page, &[ERASED; PAGE])?;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Fault> {
        let mut start = self.check(offset, bytes.len(), WORD)?;
        for word in bytes.chunks(WORD) {
            let erased = self.bytes[start..start + WORD] == [ERASED; WORD];
            if erased || word == [0; WORD] {
                self.operate(start, word)?;
            } else if self.reports {
                return Err(Fault::NotErased);
            }
            start += WORD;
        }
        Ok(())
    }
}
