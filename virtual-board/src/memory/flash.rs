//! The flash memory, and the file that keeps it.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::FLASH_SIZE;
use super::block::Block;
use super::ecc::{Flaw, Flaws};

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
    /// Its size is not that of this chip's flash memory.
    #[error(
        "flash file {path} has {found} bytes, but the chip's flash memory has {expected}: give another file, or \
         remove it to begin with an erased chip",
        expected = FLASH_SIZE
    )]
    Size {
        /// The file.
        path: PathBuf,
        /// Its size in bytes.
        found: u64,
    },
}

/// The flash memory: the block that the core reads, and the file, which every change is written to at once.
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
        let mut content = vec![0xFF; FLASH_SIZE];
        let mut flaws = Flaws::beside(path).map_err(io)?;
        match found as usize {
            0 => {
                file.write_all_at(&content, 0).map_err(io)?;
                flaws.mend(0..FLASH_SIZE).map_err(io)?;
            }
            FLASH_SIZE => file.read_exact_at(&mut content, 0).map_err(io)?,
            _ => {
                return Err(FlashFileError::Size {
                    path: path.to_owned(),
                    found,
                });
            }
        }
        let mut block = Block::new(FLASH_SIZE);
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

    /// Changes the memory and the file; the error codes match afterwards.
    ///
    /// # Panics
    /// If the range is not within the memory.
    pub fn write(&mut self, offset: usize, bytes: &[u8]) -> io::Result<()> {
        assert!(self.block.write(offset, bytes), "offset {offset:#x}");
        self.file.write_all_at(bytes, offset as u64)?;
        self.flaws.mend(offset..offset + bytes.len())
    }

    /// Leaves a double word whose error code does not match.
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

    /// Double words whose error code does not match.
    pub fn flaws(&self) -> &Flaws {
        &self.flaws
    }
}
