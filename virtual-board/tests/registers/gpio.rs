//! RM0440 chapter 9.

use virtual_board::peripherals::gpio::Gpio;

const MODER: u32 = 0x00;
const PUPDR: u32 = 0x0C;
const IDR: u32 = 0x10;
const ODR: u32 = 0x14;
const BSRR: u32 = 0x18;
const BRR: u32 = 0x28;

#[test]
fn comes_up_analog_but_for_the_debug_pins() {
    assert_eq!(Gpio::new(0).read(MODER), Ok(0xABFF_FFFF));
    assert_eq!(Gpio::new(1).read(MODER), Ok(0xFFFF_FEBF));
    assert_eq!(Gpio::new(2).read(MODER), Ok(0xFFFF_FFFF));
}

#[test]
fn bits_are_set_and_reset_and_set_wins() {
    let mut port = Gpio::new(2);
    port.write(BSRR, 1 << 5 | 1 << 3).unwrap();
    port.write(BSRR, 1 << (16 + 3) | 1 << (16 + 5) | 1 << 5)
        .unwrap();
    assert_eq!(port.read(ODR), Ok(1 << 5));
    port.write(BRR, 1 << 5).unwrap();
    assert_eq!(port.read(ODR), Ok(0));
}

#[test]
fn outputs_read_back_and_inputs_read_their_pull() {
    let mut port = Gpio::new(2);
    port.write(MODER, 0b01).unwrap(); // pin 0 output, pin 1 input, the rest input
    port.write(PUPDR, 0b01 << 2 | 0b10 << 4).unwrap();
    port.write(ODR, 0b1).unwrap();
    assert_eq!(port.read(IDR), Ok(0b011));
}
