//! Reads the firmware's ELF file: the content of the flash, the RTT control block, and the addresses of functions.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use object::elf::{EM_ARM, PT_LOAD};
use object::read::elf::{ElfFile32, FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSymbol, SymbolKind};
use rustc_demangle::demangle;
use thiserror::Error;

use crate::memory::FLASH_BASE;
use crate::memory::flash::FlashMemory;
use crate::memory::{FLASH_SIZE, PAGE_SIZE};

/// Symbol of the RTT control block.
const RTT_SYMBOL: &str = "_SEGGER_RTT";
const DOUBLE_WORD: usize = 8;

/// Why a file is not firmware for this chip.
#[derive(Debug, Error)]
pub enum ElfError {
    /// It cannot be read.
    #[error("firmware {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// It is not a 32-bit ELF file.
    #[error(
        "firmware {path} is not a 32-bit ELF file ({source}): give the file that `cargo build` made, not a .bin"
    )]
    NotElf {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: object::Error,
    },
    /// It is for another machine.
    #[error("firmware {path} is for ELF machine {machine}, the chip needs {arm} (ARM): build it for thumbv7em-none-eabihf", arm = EM_ARM.0)]
    Machine {
        /// The file.
        path: PathBuf,
        /// Its machine number.
        machine: u16,
    },
    /// A segment lies outside of the flash memory.
    #[error(
        "firmware {path}: the segment at {address:#010x} of {size} bytes is not within the flash memory \
         ({FLASH_BASE:#010x}, {FLASH_SIZE} bytes): check memory.x"
    )]
    Segment {
        /// The file.
        path: PathBuf,
        /// Load address of the segment.
        address: u64,
        /// Its size in bytes.
        size: u64,
    },
    /// It has no content.
    #[error(
        "firmware {path} has nothing to load into flash: it was probably linked without a linker script (link.x)"
    )]
    Empty {
        /// The file.
        path: PathBuf,
    },
}

/// The firmware.
#[derive(Debug)]
pub struct Firmware {
    /// The whole file, for the log's decoder.
    pub file: Vec<u8>,
    /// Pieces of the image: offset in flash and bytes.
    segments: Vec<(usize, Vec<u8>)>,
    /// Address of the RTT control block, if the firmware has a log.
    pub rtt: Option<u32>,
}

impl Firmware {
    /// Reads the file.
    pub fn read(path: &Path) -> Result<Self, ElfError> {
        let path_buf = || path.to_owned();
        let file = fs::read(path).map_err(|source| ElfError::Io {
            path: path_buf(),
            source,
        })?;
        let not_elf = |source| ElfError::NotElf {
            path: path_buf(),
            source,
        };
        let elf = ElfFile32::<Endianness>::parse(file.as_slice()).map_err(not_elf)?;
        let endian = elf.endian();
        let machine = elf.elf_header().e_machine(endian);
        if machine != EM_ARM {
            return Err(ElfError::Machine {
                path: path_buf(),
                machine: machine.0,
            });
        }
        let mut segments = Vec::new();
        for header in elf.elf_program_headers() {
            let content = header.data(endian, file.as_slice()).unwrap_or_default();
            if header.p_type(endian) != PT_LOAD || content.is_empty() {
                continue;
            }
            let address = u64::from(header.p_paddr(endian));
            let offset = address
                .checked_sub(u64::from(FLASH_BASE))
                .map(|offset| offset as usize);
            let offset = offset
                .filter(|offset| offset + content.len() <= FLASH_SIZE)
                .ok_or_else(|| ElfError::Segment {
                    path: path_buf(),
                    address,
                    size: content.len() as u64,
                })?;
            segments.push((offset, content.to_vec()));
        }
        if segments.is_empty() {
            return Err(ElfError::Empty { path: path_buf() });
        }
        let rtt = elf
            .symbols()
            .find(|symbol| symbol.name() == Ok(RTT_SYMBOL))
            .map(|symbol| symbol.address() as u32);
        Ok(Self {
            segments,
            rtt,
            file,
        })
    }

    /// Symbols and first addresses of the functions called `name`: the symbol itself, or the path that it stands for,
    /// without hash. One path can stand for several functions.
    pub fn functions(&self, name: &str) -> Vec<(String, u32)> {
        let Ok(elf) = ElfFile32::<Endianness>::parse(self.file.as_slice()) else {
            return Vec::new();
        };
        let mut found: Vec<_> = elf
            .symbols()
            .filter(|symbol| symbol.kind() == SymbolKind::Text)
            .filter_map(|symbol| Some((symbol.name().ok()?, symbol.address() as u32 & !1)))
            .filter(|(symbol, _)| *symbol == name || format!("{:#}", demangle(symbol)) == name)
            .map(|(symbol, address)| (symbol.to_owned(), address))
            .collect();
        found.sort_by_key(|(_, address)| *address);
        found.dedup_by_key(|(_, address)| *address);
        found
    }

    /// Every function: its first address and its path without hash, in the order of addresses.
    pub fn all_functions(&self) -> Vec<(u32, String)> {
        let Ok(elf) = ElfFile32::<Endianness>::parse(self.file.as_slice()) else {
            return Vec::new();
        };
        let mut found: Vec<_> = elf
            .symbols()
            .filter(|symbol| symbol.kind() == SymbolKind::Text)
            .filter_map(|symbol| Some((symbol.address() as u32 & !1, symbol.name().ok()?)))
            .map(|(address, symbol)| (address, format!("{:#}", demangle(symbol))))
            .collect();
        found.sort();
        found
    }

    /// Programs the image as a debug probe would: it erases and writes the pages that the image needs, and no others.
    /// Pages with the right content already are left alone.
    pub fn program(&self, memory: &mut FlashMemory) -> io::Result<()> {
        let mut image = vec![None; FLASH_SIZE / PAGE_SIZE];
        for (offset, content) in &self.segments {
            for (index, byte) in content.iter().enumerate() {
                let at = offset + index;
                let page: &mut Vec<u8> =
                    image[at / PAGE_SIZE].get_or_insert_with(|| vec![0xFF; PAGE_SIZE]);
                page[at % PAGE_SIZE] = *byte;
            }
        }
        for (number, page) in image.iter().enumerate() {
            let Some(page) = page else { continue };
            let start = number * PAGE_SIZE;
            let differs = page
                .chunks_exact(DOUBLE_WORD)
                .enumerate()
                .any(|(index, word)| {
                    memory
                        .double_word(start + DOUBLE_WORD * index)
                        .to_le_bytes()
                        != word
                });
            if differs {
                memory.write(start, page)?;
            }
        }
        Ok(())
    }
}
