//! ARMv7-M B3.3.

use virtual_board::peripherals::NEVER;
use virtual_board::peripherals::systick::SysTick;

const CSR: u32 = 0x00;
const RVR: u32 = 0x04;
const CVR: u32 = 0x08;

fn every_hundred() -> SysTick {
    let mut systick = SysTick::default();
    systick.write(RVR, 99, 0).unwrap();
    systick.write(CVR, 0, 0).unwrap();
    systick.write(CSR, 0b111, 1000).unwrap();
    systick
}

#[test]
fn ticks_every_reload_plus_one() {
    let mut systick = every_hundred();
    assert_eq!(systick.next_event(), 1100);
    systick.advance(1100);
    assert!(systick.take_tick());
    assert_eq!(systick.next_event(), 1200);
}

#[test]
fn counts_down_and_the_count_flag_clears_on_read() {
    let mut systick = every_hundred();
    assert_eq!(systick.read(CVR, 1010), Ok(90));
    systick.advance(1100);
    assert_eq!(systick.read(CSR, 1100), Ok(0b111 | 1 << 16));
    assert_eq!(systick.read(CSR, 1100), Ok(0b111));
}

#[test]
fn is_silent_without_tickint_and_still_without_enable() {
    let mut systick = every_hundred();
    systick.write(CSR, 0b101, 1010).unwrap();
    systick.advance(1100);
    assert!(!systick.take_tick());
    systick.write(CSR, 0, 1110).unwrap();
    assert_eq!(systick.next_event(), NEVER);
}
