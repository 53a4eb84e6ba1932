//! RM0440 chapter 15, against the check values of the CRC catalogue: the CRC of the ASCII digits "123456789".

use virtual_board::peripherals::crc::Crc;

const DR: u32 = 0x00;
const CR: u32 = 0x08;
const INIT: u32 = 0x10;
const POL: u32 = 0x14;
const RESET: u32 = 1;

fn crc_of_digits(polynomial: u32, init: u32, cr: u32) -> u32 {
    let mut crc = Crc::default();
    crc.write(POL, polynomial, 4).unwrap();
    crc.write(INIT, init, 4).unwrap();
    crc.write(CR, cr | RESET, 4).unwrap();
    for digit in b"123456789" {
        crc.write(DR, u32::from(*digit), 1).unwrap();
    }
    crc.read(DR).unwrap()
}

#[test]
fn crc_32_with_both_reversals() {
    // Reversal by byte in, and out: CRC-32 of Ethernet, but for the final inversion.
    assert_eq!(
        !crc_of_digits(0x04C1_1DB7, u32::MAX, 1 << 7 | 1 << 5),
        0xCBF4_3926
    );
}

#[test]
fn crc_32_as_after_reset_is_that_of_mpeg() {
    assert_eq!(crc_of_digits(0x04C1_1DB7, u32::MAX, 0), 0x0376_E6E7);
}

#[test]
fn crc_16_and_crc_8() {
    assert_eq!(crc_of_digits(0x1021, 0xFFFF, 1 << 3), 0x29B1);
    assert_eq!(crc_of_digits(0x07, 0, 2 << 3), 0xF4);
}

#[test]
fn words_and_bytes_give_the_same() {
    let mut by_word = Crc::default();
    by_word.write(DR, 0x3132_3334, 4).unwrap();
    let mut by_byte = Crc::default();
    for digit in b"1234" {
        by_byte.write(DR, u32::from(*digit), 1).unwrap();
    }
    assert_eq!(by_word.read(DR), by_byte.read(DR));
}
