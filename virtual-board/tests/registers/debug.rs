//! ARMv7-M C1.8 (DWT) and RM0440 chapter 47 (DBGMCU).

use virtual_board::peripherals::debug::Debug;

const CTRL: u32 = 0x00;
const CYCCNT: u32 = 0x04;
const TRCENA: u32 = 1 << 24;

fn counting() -> Debug {
    let mut debug = Debug::default();
    debug.write_demcr(TRCENA, 0);
    debug.write_dwt(CYCCNT, 0, 100).unwrap();
    debug.write_dwt(CTRL, 1, 100).unwrap();
    debug
}

#[test]
fn counts_cycles_once_it_is_enabled() {
    let mut idle = Debug::default();
    idle.write_dwt(CTRL, 1, 0).unwrap();
    assert_eq!(idle.read_dwt(CYCCNT, 500), Ok(0), "TRCENA is off");
    let debug = counting();
    assert_eq!(debug.read_dwt(CTRL, 100).unwrap() & 1, 1);
    assert_eq!(debug.read_dwt(CYCCNT, 600), Ok(500));
}

#[test]
fn stands_still_in_sleep_unless_debugging_keeps_the_clock() {
    let mut debug = counting();
    debug.slept(300);
    assert_eq!(debug.read_dwt(CYCCNT, 600), Ok(200));
    debug.write_dbgmcu(0x04, 1).unwrap();
    debug.slept(100);
    assert_eq!(debug.read_dwt(CYCCNT, 600), Ok(200));
}

#[test]
fn the_device_is_a_g47x() {
    assert_eq!(Debug::default().read_dbgmcu(0).unwrap() & 0xFFF, 0x469);
}
