//! RM0440 chapters 29 to 31.

use virtual_board::peripherals::NEVER;
use virtual_board::peripherals::timer::{Shape, Timer};

const CR1: u32 = 0x00;
const CR2: u32 = 0x04;
const DIER: u32 = 0x0C;
const SR: u32 = 0x10;
const EGR: u32 = 0x14;
const CNT: u32 = 0x24;
const PSC: u32 = 0x28;
const ARR: u32 = 0x2C;
const CCR1: u32 = 0x34;
const CCR2: u32 = 0x38;

fn set(timer: &mut Timer, registers: &[(u32, u32)], now: u64) {
    for &(offset, value) in registers {
        timer.write(offset, value, now).unwrap();
    }
}

#[test]
fn counts_to_arr_and_wraps_with_an_update_event() {
    let mut timer = Timer::new(Shape::BASIC);
    set(
        &mut timer,
        &[(ARR, 9), (PSC, 2), (EGR, 1), (SR, 0), (DIER, 1), (CR1, 1)],
        100,
    );
    assert_eq!(timer.read(CNT, 100 + 3 * 9), Ok(9));
    assert_eq!(timer.next_event(), 100 + 30);
    assert!(!timer.interrupt());
    timer.advance(130);
    assert_eq!(timer.read(CNT, 130), Ok(0));
    assert!(timer.interrupt());
    assert_eq!(timer.next_event(), 160);
    timer.write(SR, !1, 131).unwrap();
    assert!(!timer.interrupt(), "UIF is cleared by writing zero");
}

#[test]
fn prescaler_is_preloaded_and_arr_only_with_arpe() {
    let mut timer = Timer::new(Shape::BASIC);
    set(&mut timer, &[(ARR, 99), (EGR, 1), (CR1, 1)], 0);
    timer.write(PSC, 9, 10).unwrap();
    assert_eq!(
        timer.read(CNT, 50),
        Ok(50),
        "PSC waits for the update event"
    );
    timer.advance(100);
    assert_eq!(timer.read(CNT, 120), Ok(2), "then it divides");

    let mut timer = Timer::new(Shape::BASIC);
    set(&mut timer, &[(ARR, 99), (EGR, 1), (CR1, 1 | 1 << 7)], 0);
    timer.write(ARR, 49, 10).unwrap();
    timer.advance(60);
    assert_eq!(
        timer.read(CNT, 60),
        Ok(60),
        "with ARPE the old ARR holds until the update event"
    );
    timer.advance(170);
    assert_eq!(timer.read(CNT, 170), Ok(20));
}

#[test]
fn lowering_arr_beneath_the_counter_lets_it_run_to_its_end() {
    let mut timer = Timer::new(Shape::BASIC);
    set(&mut timer, &[(ARR, 999), (EGR, 1), (CR1, 1)], 0);
    timer.advance(500);
    timer.write(ARR, 99, 500).unwrap();
    timer.advance(65_535);
    assert_eq!(timer.read(CNT, 65_535), Ok(65_535));
    timer.advance(65_536);
    assert_eq!(timer.read(CNT, 65_536), Ok(0));
}

#[test]
fn ug_loads_the_prescaler_restarts_and_flags_unless_urs() {
    let mut timer = Timer::new(Shape::GENERAL_16);
    set(&mut timer, &[(PSC, 149), (EGR, 1)], 0);
    assert_eq!(timer.read(SR, 0), Ok(1), "UG sets UIF");
    set(&mut timer, &[(SR, 0), (CR1, 1 << 2), (EGR, 1)], 0);
    assert_eq!(timer.read(SR, 0), Ok(0), "but not with URS");
    set(&mut timer, &[(CR1, 1)], 0);
    assert_eq!(timer.read(CNT, 1500), Ok(10));
}

#[test]
fn trigger_output_follows_mms() {
    let mut update = Timer::new(Shape::BASIC);
    set(
        &mut update,
        &[(ARR, 9), (CR2, 2 << 4), (CR1, 1 | 1 << 2)],
        0,
    );
    assert_eq!(
        update.next_event(),
        10,
        "the update is an event although no interrupt is enabled"
    );
    update.advance(10);
    assert!(update.take_trigger());
    assert!(!update.take_trigger());

    let mut reset = Timer::new(Shape::BASIC);
    set(&mut reset, &[(CR2, 0), (EGR, 1)], 0);
    assert!(reset.take_trigger());

    let mut enable = Timer::new(Shape::BASIC);
    set(&mut enable, &[(CR2, 1 << 4), (CR1, 1)], 0);
    assert!(enable.take_trigger());
}

#[test]
fn compare_flags_are_set_when_the_counter_comes_by_once_a_period() {
    let mut timer = Timer::new(Shape::TWO_CHANNELS);
    set(
        &mut timer,
        &[
            (ARR, 99),
            (CCR1, 30),
            (CCR2, 200),
            (DIER, 1 << 1 | 1 << 2),
            (CR1, 1),
        ],
        0,
    );
    assert_eq!(timer.next_event(), 30);
    timer.advance(30);
    assert_eq!(
        timer.read(SR, 30),
        Ok(1 << 1),
        "a compare value beyond ARR never matches"
    );
    timer.write(SR, 0, 31).unwrap();
    timer.advance(31);
    assert_eq!(timer.next_event(), 130);
    timer.advance(130);
    assert_eq!(timer.read(SR, 130).unwrap() & 2, 2);
}

#[test]
fn compare_match_is_seen_even_by_a_late_look() {
    let mut timer = Timer::new(Shape::TWO_CHANNELS);
    set(&mut timer, &[(ARR, 99), (CCR1, 30), (CR1, 1)], 0);
    timer.advance(250);
    assert_eq!(timer.read(SR, 250).unwrap() & 3, 3);
}

#[test]
fn one_pulse_mode_stops_at_the_update() {
    let mut timer = Timer::new(Shape::BASIC);
    set(&mut timer, &[(ARR, 9), (CR1, 1 | 1 << 3)], 0);
    timer.advance(25);
    assert_eq!(timer.read(CR1, 25).unwrap() & 1, 0);
    assert_eq!(timer.read(CNT, 25), Ok(0));
    assert_eq!(timer.next_event(), NEVER);
}

#[test]
fn a_32_bit_timer_counts_beyond_16_bits_and_a_16_bit_timer_does_not() {
    let mut wide = Timer::new(Shape::GENERAL_32);
    set(&mut wide, &[(CR1, 1)], 0);
    assert_eq!(wide.read(CNT, 70_000), Ok(70_000));
    let mut narrow = Timer::new(Shape::GENERAL_16);
    set(&mut narrow, &[(CR1, 1)], 0);
    narrow.advance(70_000);
    assert_eq!(narrow.read(CNT, 70_000), Ok(70_000 - 65_536));
}

#[test]
fn a_basic_timer_has_no_compare_channels() {
    let mut timer = Timer::new(Shape::BASIC);
    assert!(timer.read(CCR1, 0).is_err());
    assert!(timer.write(CCR1, 5, 0).is_err());
}
