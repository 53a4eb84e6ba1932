//! The chip's memories on the host: blocks that the emulated core and the peripheral models share, and the flash
//! memory with the file that keeps it.
//!
//! | address | size | content |
//! |---|---|---|
//! | 0x0000_0000 | 512 KB | flash, as the boot pin maps it |
//! | 0x0800_0000 | 512 KB | flash, bank 1 and bank 2 |
//! | 0x1000_0000 | 32 KB | CCM SRAM |
//! | 0x1FFF_0000 | 32 KB | system memory: factory words |
//! | 0x2000_0000 | 128 KB | SRAM1, SRAM2, and the CCM SRAM once more |

pub mod block;
pub mod ecc;
pub mod flash;
pub mod system;

/// Where the flash memory begins.
pub const FLASH_BASE: u32 = 0x0800_0000;
/// Size of a bank of flash memory, bytes.
pub const BANK_SIZE: usize = 256 * 1024;
/// Size of the flash memory, bytes.
pub const FLASH_SIZE: usize = 2 * BANK_SIZE;
/// Size of a page of flash memory, bytes: the unit of erasing.
pub const PAGE_SIZE: usize = 2048;
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
