//! The option bytes of the chip (RM0440, 3.4): settings of the flash that only a debug probe changes.
//!
//! The firmware is built for two banks: it runs from the first while the second is erased and written. With a single bank
//! the same number of a page means another place, that of the code. So the board reads its option bytes at the start, says
//! them in its status, and writes nothing where they do not allow it.

use embassy_stm32::pac::FLASH;
use hexsense_core::wire::status::OptionBytes;

/// The option bytes as they were loaded at the last reset.
pub fn read() -> OptionBytes {
    let options = FLASH.optr().read();
    let areas = [
        FLASH.wrp1ar().read().0,
        FLASH.wrp1br().read().0,
        FLASH.wrp2ar().read().0,
        FLASH.wrp2br().read().0,
    ];
    OptionBytes {
        dual_bank: options.dbank(),
        readout_protection: match options.rdp().to_bits() {
            0xAA => 0,
            0xCC => 2,
            _ => 1,
        },
        brown_out_level: options.bor_lev(),
        write_protected: areas.map(area),
    }
}

/// First and last page of an area; an area that ends before it begins is none.
fn area(register: u32) -> Option<(u8, u8)> {
    let (first, last) = (register as u8 & 0x7F, (register >> 16) as u8 & 0x7F);
    (first <= last).then_some((first, last))
}
