//! Torn words in flash: what happens when one is read, and why that is no catastrophe.
//!
//! A double word whose programming was cut short by a loss of power does not match its error correction code.
//! Reading it raises the non-maskable interrupt (RM0440, 3.3.4). In bank 2, that is the archive looking at what an
//! interrupted write left: the word reads as garbage, the archive's own checksum rejects it, and all goes on. In
//! bank 1 it is the code that is damaged, and nothing can be trusted.

use cortex_m_rt::exception;
use embassy_stm32::pac;

#[exception]
unsafe fn NonMaskableInt() {
    let eccr = pac::FLASH.eccr().read();
    if !eccr.eccd() {
        panic!("non-maskable interrupt, not from the flash");
    }
    if !eccr.bk_ecc() {
        panic!("the code is damaged at {:#x} of bank 1", eccr.addr_ecc());
    }
    // Written back as read, the flags clear themselves.
    pac::FLASH.eccr().write_value(eccr);
}
