//! RM0440 chapter 42. Core clock 150 MHz.

use virtual_board::peripherals::NEVER;
use virtual_board::peripherals::iwdg::Iwdg;

const KR: u32 = 0x00;
const PR: u32 = 0x04;
const RLR: u32 = 0x08;
const SR: u32 = 0x0C;
const WINR: u32 = 0x10;

fn started(prescaler: u32, reload: u32) -> Iwdg {
    let mut watchdog = Iwdg::new(150e6);
    watchdog.write(KR, 0xCCCC, 0).unwrap();
    watchdog.write(KR, 0x5555, 0).unwrap();
    watchdog.write(PR, prescaler, 0).unwrap();
    watchdog.write(RLR, reload, 0).unwrap();
    watchdog.write(KR, 0xAAAA, 0).unwrap();
    watchdog
}

#[test]
fn does_nothing_until_it_is_started() {
    let watchdog = Iwdg::new(150e6);
    assert!(!watchdog.running());
    assert_eq!(watchdog.next_event(), NEVER);
}

#[test]
fn bites_after_reload_and_prescaler() {
    // (3999 + 1) · 8 / 32 kHz = 1 s
    let watchdog = started(1, 3999);
    assert_eq!(watchdog.next_event(), 150_000_000);
    assert!(!watchdog.bites(149_999_999) && watchdog.bites(150_000_000));
}

#[test]
fn the_prescaler_ends_at_256() {
    assert_eq!(started(6, 0).next_event(), started(7, 0).next_event());
    assert_eq!(started(6, 0).next_event(), 1_200_000); // 256 / 32 kHz
}

#[test]
fn a_refresh_starts_over() {
    let mut watchdog = started(1, 3999);
    watchdog.write(KR, 0xAAAA, 100_000_000).unwrap();
    assert_eq!(watchdog.next_event(), 250_000_000);
}

#[test]
fn registers_are_protected_until_the_key() {
    let mut watchdog = Iwdg::new(150e6);
    watchdog.write(RLR, 5, 0).unwrap();
    assert_eq!(watchdog.read(RLR, 0), Ok(0xFFF));
    watchdog.write(KR, 0x5555, 0).unwrap();
    watchdog.write(RLR, 5, 0).unwrap();
    assert_eq!(watchdog.read(RLR, 0), Ok(5));
    assert_eq!(watchdog.read(SR, 0), Ok(2), "RVU while the value travels");
    assert_eq!(
        watchdog.read(SR, 30_000),
        Ok(0),
        "five cycles of 32 kHz later it has arrived"
    );
    watchdog.write(KR, 0xAAAA, 0).unwrap();
    watchdog.write(RLR, 6, 0).unwrap();
    assert_eq!(
        watchdog.read(RLR, 0),
        Ok(5),
        "any other key closes the protection"
    );
}

#[test]
fn a_refresh_outside_of_the_window_bites() {
    let mut watchdog = started(1, 3999);
    watchdog.write(KR, 0x5555, 0).unwrap();
    watchdog.write(WINR, 1000, 0).unwrap();
    let mut early = watchdog;
    early.write(KR, 0xAAAA, 75_000_000).unwrap();
    assert!(early.bites(75_000_000), "the counter is at 2000");
    let mut in_time = started(1, 3999);
    in_time.write(KR, 0x5555, 0).unwrap();
    in_time.write(WINR, 1000, 0).unwrap();
    in_time.write(KR, 0xAAAA, 120_000_000).unwrap();
    assert!(!in_time.bites(120_000_000), "the counter is at 800");
}

#[test]
fn a_change_of_core_clock_keeps_the_time_that_is_left() {
    let mut watchdog = started(1, 3999);
    watchdog.set_core_clock(15e6, 75_000_000);
    assert_eq!(watchdog.next_event(), 75_000_000 + 7_500_000);
}
