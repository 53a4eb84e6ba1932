//! ARMv7-M B1.5 and B3.2 to B3.4; four priority bits as on the chip.

use virtual_board::peripherals::nvic::{
    HARD_FAULT, Masks, Nvic, PEND_SV, SYS_TICK, THREAD_PRIORITY,
};

const ISER: u32 = 0x100;
const ICER: u32 = 0x180;
const ISPR: u32 = 0x200;
const ICPR: u32 = 0x280;
const IABR: u32 = 0x300;
const IPR: u32 = 0x400;
const ICSR: u32 = 0xD04;
const AIRCR: u32 = 0xD0C;
const SHPR3: u32 = 0xD20;
const STIR: u32 = 0xF00;

const OPEN: Masks = Masks {
    primask: false,
    faultmask: false,
    basepri: 0,
};

/// Interrupts 3 and 40 enabled, at these priorities.
fn two(third: u32, fortieth: u32) -> Nvic {
    let mut nvic = Nvic::default();
    nvic.write(ISER, 1 << 3, 4).unwrap();
    nvic.write(ISER + 4, 1 << 8, 4).unwrap();
    nvic.write(IPR + 3, third, 1).unwrap();
    nvic.write(IPR + 40, fortieth, 1).unwrap();
    nvic
}

#[test]
fn registers_are_write_one_to_set_and_to_clear() {
    let mut nvic = Nvic::default();
    nvic.write(ISER + 8, 0x8000_0001, 4).unwrap();
    nvic.write(ISER + 8, 0x0000_0100, 4).unwrap();
    nvic.write(ICER + 8, 0x0000_0001, 4).unwrap();
    assert_eq!(nvic.read(ISER + 8, 4), Ok(0x8000_0100));
    assert_eq!(nvic.read(ICER + 8, 4), Ok(0x8000_0100));
    nvic.write(ISER + 12, u32::MAX, 4).unwrap();
    assert_eq!(
        nvic.read(ISER + 12, 4),
        Ok(0x3F),
        "the chip has 102 interrupts"
    );
}

#[test]
fn priorities_keep_their_upper_four_bits() {
    let mut nvic = Nvic::default();
    nvic.write(IPR + 5, 0x7F, 1).unwrap();
    assert_eq!(nvic.read(IPR + 5, 1), Ok(0x70));
    assert_eq!(nvic.read(IPR + 4, 4), Ok(0x7000));
    nvic.write(SHPR3 + 3, 0xF0, 1).unwrap();
    assert_eq!(nvic.read(SHPR3, 4), Ok(0xF000_0000));
}

#[test]
fn the_more_urgent_is_taken_first_and_then_the_lower_number() {
    let mut nvic = two(0x50, 0x40);
    nvic.pend(16 + 3);
    nvic.pend(16 + 40);
    assert_eq!(nvic.to_take(OPEN), Some(16 + 40));
    let mut equal = two(0x40, 0x40);
    equal.pend(16 + 40);
    equal.pend(16 + 3);
    assert_eq!(equal.to_take(OPEN), Some(16 + 3));
}

#[test]
fn only_a_more_urgent_group_preempts() {
    let mut nvic = two(0x50, 0x40);
    nvic.pend(16 + 3);
    nvic.activate(16 + 3);
    nvic.pend(16 + 40);
    assert_eq!(nvic.to_take(OPEN), Some(16 + 40));
    // PRIGROUP 6: one bit of pre-emption, 0x40 and 0x50 are in one group.
    nvic.write(AIRCR, 0x05FA_0000 | 6 << 8, 4).unwrap();
    assert_eq!(nvic.to_take(OPEN), None);
    nvic.deactivate(16 + 3);
    assert_eq!(nvic.to_take(OPEN), Some(16 + 40));
    assert_eq!(nvic.running_priority(), THREAD_PRIORITY);
}

#[test]
fn masks_hold_back_what_they_should() {
    let mut nvic = two(0x50, 0x40);
    nvic.pend(16 + 3);
    assert_eq!(
        nvic.to_take(Masks {
            basepri: 0x50,
            ..OPEN
        }),
        None
    );
    assert_eq!(
        nvic.to_take(Masks {
            basepri: 0x60,
            ..OPEN
        }),
        Some(16 + 3)
    );
    assert_eq!(
        nvic.to_take(Masks {
            primask: true,
            ..OPEN
        }),
        None
    );
    nvic.pend(HARD_FAULT);
    assert_eq!(
        nvic.to_take(Masks {
            primask: true,
            ..OPEN
        }),
        Some(HARD_FAULT)
    );
    assert_eq!(
        nvic.to_take(Masks {
            faultmask: true,
            ..OPEN
        }),
        None
    );
}

#[test]
fn a_pending_interrupt_that_is_not_enabled_waits() {
    let mut nvic = Nvic::default();
    nvic.write(STIR, 3, 4).unwrap();
    assert_eq!(nvic.read(ISPR, 4), Ok(1 << 3));
    assert_eq!(nvic.to_take(OPEN), None);
    nvic.write(ISER, 1 << 3, 4).unwrap();
    assert_eq!(nvic.to_take(OPEN), Some(16 + 3));
    nvic.write(ICPR, 1 << 3, 4).unwrap();
    assert_eq!(nvic.to_take(OPEN), None);
}

#[test]
fn a_line_that_stays_high_makes_its_interrupt_pending_again() {
    let mut nvic = two(0x50, 0x40);
    nvic.set_line(3, true);
    nvic.activate(16 + 3);
    assert_eq!(nvic.read(IABR, 4), Ok(1 << 3));
    nvic.set_line(3, true);
    assert_eq!(nvic.to_take(OPEN), None, "not while it is being served");
    nvic.deactivate(16 + 3);
    assert_eq!(nvic.to_take(OPEN), Some(16 + 3));
    nvic.activate(16 + 3);
    nvic.set_line(3, false);
    nvic.deactivate(16 + 3);
    assert_eq!(nvic.to_take(OPEN), None);
}

#[test]
fn icsr_pends_and_shows() {
    let mut nvic = Nvic::default();
    nvic.write(ICSR, 1 << 28 | 1 << 26, 4).unwrap();
    assert_eq!(nvic.to_take(OPEN), Some(PEND_SV));
    nvic.write(ICSR, 1 << 27, 4).unwrap();
    assert_eq!(nvic.to_take(OPEN), Some(SYS_TICK));
    nvic.activate(SYS_TICK);
    let icsr = nvic.read(ICSR, 4).unwrap();
    assert_eq!(
        (icsr & 0x1FF, icsr >> 11 & 1),
        (15, 1),
        "VECTACTIVE, RETTOBASE"
    );
}

#[test]
fn a_reset_request_needs_the_key() {
    let mut nvic = Nvic::default();
    nvic.write(AIRCR, 0x1234_0004, 4).unwrap();
    assert!(!nvic.take_reset_request());
    nvic.write(AIRCR, 0x05FA_0004, 4).unwrap();
    assert!(nvic.take_reset_request());
}

#[test]
fn the_core_is_a_cortex_m4() {
    assert_eq!(Nvic::default().read(0xD00, 4).unwrap() >> 4 & 0xFFF, 0xC24);
}
