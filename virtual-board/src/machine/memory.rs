//! The chip's memories on the host: blocks that the emulated core and the peripheral models share, and the flash
//! memory with the file that keeps it.
//!
//! | address | size | what |
//! |---|---|---|
//! | 0x0000_0000 | 512 KB | flash, as the boot pin maps it |
//! | 0x0800_0000 | 512 KB | flash, bank 1 and bank 2 |
//! | 0x1000_0000 | 32 KB | CCM SRAM |
//! | 0x1FFF_0000 | 32 KB | system memory: factory words |
//! | 0x2000_0000 | 128 KB | SRAM1, SRAM2, and the CCM SRAM once more |

use std::alloc::{Layout, alloc_zeroed, dealloc, handle_alloc_error};
use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::ptr::NonNull;

use thiserror::Error;

use super::ecc::{Flaw, Flaws};
use crate::peripherals::flash;

/// Where the flash memory begins.
pub const FLASH_BASE: u32 = 0x0800_0000;
/// Where the system memory begins.
pub const SYSTEM_BASE: u32 = 0x1FFF_0000;
/// Size of the mapped part of the system memory, bytes.
pub const SYSTEM_SIZE: usize = 0x8000;
/// Where the SRAM begins.
pub const RAM_BASE: u32 = 0x2000_0000;
/// Size of all SRAM, bytes.
pub const RAM_SIZE: usize = 128 * 1024;
/// Where the CCM SRAM begins on the instruction bus.
pub const CCM_BASE: u32 = 0x1000_0000;
/// Size of the CCM SRAM, bytes: the last part of the SRAM.
pub const CCM_SIZE: usize = 32 * 1024;

const HOST_PAGE: usize = 4096;

/// A block of zeroed host memory, aligned to a page, whose address never changes.
///
/// It is shared with the emulator, which writes to it while the core runs; so it is only ever reached through copies,
/// never through references.
#[derive(Debug)]
pub struct Block {
    start: NonNull<u8>,
    layout: Layout,
}

impl Block {
    /// A block of `size` bytes, a multiple of the page size.
    ///
    /// # Panics
    /// If `size` is zero or no multiple of 4096: sizes are constants of the chip.
    pub fn new(size: usize) -> Self {
        assert!(
            size > 0 && size.is_multiple_of(HOST_PAGE),
            "memory of {size} bytes"
        );
        let layout = Layout::from_size_align(size, HOST_PAGE).expect("a constant size");
        // SAFETY: the layout's size is not zero.
        let start = unsafe { alloc_zeroed(layout) };
        let start = NonNull::new(start).unwrap_or_else(|| handle_alloc_error(layout));
        Self { start, layout }
    }

    /// Size in bytes.
    pub fn size(&self) -> usize {
        self.layout.size()
    }

    /// Address of the byte at `offset`, for mapping into the emulator.
    ///
    /// # Panics
    /// If `offset` is outside of the block.
    pub fn address(&self, offset: usize) -> *mut u8 {
        assert!(offset < self.size());
        // SAFETY: the offset is inside of the allocation.
        unsafe { self.start.as_ptr().add(offset) }
    }

    /// Copies bytes out of the block; false (and nothing copied) if they are not all inside of it.
    #[must_use]
    pub fn read(&self, offset: usize, into: &mut [u8]) -> bool {
        let inside = offset
            .checked_add(into.len())
            .is_some_and(|end| end <= self.size());
        if inside {
            // SAFETY: the range is inside of the allocation, and `into` is memory of its own: no reference to the
            // block's bytes exists.
            unsafe {
                self.start
                    .as_ptr()
                    .add(offset)
                    .copy_to_nonoverlapping(into.as_mut_ptr(), into.len())
            };
        }
        inside
    }

    /// Copies bytes into the block; false (and nothing copied) if they do not all fit.
    #[must_use]
    pub fn write(&mut self, offset: usize, bytes: &[u8]) -> bool {
        let inside = offset
            .checked_add(bytes.len())
            .is_some_and(|end| end <= self.size());
        if inside {
            // SAFETY: as in `read`.
            unsafe {
                self.start
                    .as_ptr()
                    .add(offset)
                    .copy_from_nonoverlapping(bytes.as_ptr(), bytes.len())
            };
        }
        inside
    }

    /// A little-endian word, if it is inside of the block.
    pub fn word(&self, offset: usize) -> Option<u32> {
        let mut bytes = [0; 4];
        self.read(offset, &mut bytes)
            .then(|| u32::from_le_bytes(bytes))
    }
}

impl Drop for Block {
    fn drop(&mut self) {
        // SAFETY: allocated in `new` with this very layout.
        unsafe { dealloc(self.start.as_ptr(), self.layout) };
    }
}

/// Why the file of the flash memory cannot be used.
#[derive(Debug, Error)]
pub enum FlashFileError {
    /// It could not be opened, created, read or written.
    #[error("flash file {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// It is not the image of this chip's flash memory.
    #[error(
        "flash file {path} has {found} bytes, but the chip's flash memory has {expected}: give another file, or \
         remove it to begin with an erased chip",
        expected = flash::SIZE
    )]
    Size {
        /// The file.
        path: PathBuf,
        /// Its size in bytes.
        found: u64,
    },
}

/// The flash memory: what the core reads, and the file to which every change is written at once.
#[derive(Debug)]
pub struct FlashMemory {
    block: Block,
    file: File,
    flaws: Flaws,
}

impl FlashMemory {
    /// Opens the file of the flash memory, or creates it erased.
    pub fn open(path: &Path) -> Result<Self, FlashFileError> {
        let io = |source| FlashFileError::Io {
            path: path.to_owned(),
            source,
        };
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(io)?;
        let found = file.metadata().map_err(io)?.len();
        let mut content = vec![0xFF; flash::SIZE];
        let mut flaws = Flaws::beside(path).map_err(io)?;
        match found as usize {
            0 => {
                file.write_all_at(&content, 0).map_err(io)?;
                flaws.mend(0..flash::SIZE).map_err(io)?;
            }
            flash::SIZE => file.read_exact_at(&mut content, 0).map_err(io)?,
            _ => {
                return Err(FlashFileError::Size {
                    path: path.to_owned(),
                    found,
                });
            }
        }
        let mut block = Block::new(flash::SIZE);
        assert!(block.write(0, &content), "sizes agree");
        Ok(Self { block, file, flaws })
    }

    /// The memory that the core reads.
    pub fn block(&self) -> &Block {
        &self.block
    }

    /// The eight bytes at `offset`, which must be a multiple of eight within the memory.
    ///
    /// # Panics
    /// If it is not within the memory.
    pub fn double_word(&self, offset: usize) -> u64 {
        let mut bytes = [0; 8];
        assert!(self.block.read(offset, &mut bytes), "offset {offset:#x}");
        u64::from_le_bytes(bytes)
    }

    /// The value of `size` bytes, at most eight, at `offset`, which must be within the memory.
    ///
    /// # Panics
    /// If they are not.
    pub fn value(&self, offset: usize, size: usize) -> u64 {
        let mut bytes = [0; 8];
        let inside = self.block.read(offset, &mut bytes[..size]);
        assert!(inside, "offset {offset:#x}");
        u64::from_le_bytes(bytes)
    }

    /// Changes the memory, and the file with it; the error codes fit afterwards.
    ///
    /// # Panics
    /// If the range is not within the memory.
    pub fn write(&mut self, offset: usize, bytes: &[u8]) -> io::Result<()> {
        assert!(self.block.write(offset, bytes), "offset {offset:#x}");
        self.file.write_all_at(bytes, offset as u64)?;
        self.flaws.mend(offset..offset + bytes.len())
    }

    /// Leaves a double word whose error code does not fit.
    ///
    /// # Panics
    /// If it is not within the memory.
    pub fn tear(&mut self, offset: usize, left: u64) -> io::Result<()> {
        self.write(offset, &left.to_le_bytes())?;
        self.flaws.set(offset, Flaw::Torn)
    }

    /// Gives the double word at `offset` a flaw of its error code.
    pub fn damage(&mut self, offset: usize, flaw: Flaw) -> io::Result<()> {
        self.flaws.set(offset & !7, flaw)
    }

    /// Double words whose error code does not fit.
    pub fn flaws(&self) -> &Flaws {
        &self.flaws
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_refuses_what_is_not_inside_of_it() {
        let mut block = Block::new(4096);
        assert!(block.write(4092, &[1, 2, 3, 4]));
        assert_eq!(block.word(4092), Some(0x0403_0201));
        assert!(!block.write(4093, &[0; 4]));
        assert_eq!(block.word(4093), None);
        assert_eq!(block.word(usize::MAX), None);
    }
}
