//! RM0440 chapter 26. Core clock 150 MHz, generator clock 48 MHz.

use virtual_board::injection::Defect;
use virtual_board::peripherals::rng::Rng;

const CR: u32 = 0x00;
const SR: u32 = 0x04;
const DR: u32 = 0x08;
/// 412 clocks of 48 MHz.
const FIRST: u64 = 1287;

fn running() -> Rng {
    let mut rng = Rng::new(super::noise(), 150_000_000);
    rng.write(CR, 1 << 2, 0).unwrap();
    rng
}

#[test]
fn words_come_in_fours_and_zero_without_them() {
    let mut rng = running();
    assert_eq!(rng.read(SR, FIRST - 1, true), Ok(0));
    assert_eq!(rng.read(DR, FIRST - 1, true), Ok(0));
    let words: Vec<u32> = (0..4).map(|_| rng.read(DR, FIRST, true).unwrap()).collect();
    assert!(words.windows(2).all(|pair| pair[0] != pair[1]));
    assert_eq!(rng.read(SR, FIRST, true), Ok(0), "the block is used up");
    assert_eq!(rng.read(SR, FIRST + 150, true), Ok(1));
}

#[test]
fn it_needs_its_oscillator() {
    let mut rng = running();
    assert_eq!(rng.read(SR, 10_000, false), Ok(0));
}

#[test]
fn the_seed_decides() {
    let (mut one, mut same) = (running(), running());
    assert_eq!(one.read(DR, FIRST, true), same.read(DR, FIRST, true));
}

#[test]
fn errors_of_noise_and_clock_raise_flags_that_a_zero_clears_when_they_are_over() {
    for (defect, present, flag) in [
        (Defect::Seed, 1 << 2, 1 << 6),
        (Defect::Clock, 1 << 1, 1 << 5),
    ] {
        let mut rng = running();
        rng.break_down(defect, 5_000);
        assert_eq!(rng.read(SR, 2_000, true), Ok(present | flag));
        rng.write(SR, 0, 2_000).unwrap();
        assert_eq!(
            rng.read(SR, 2_001, true),
            Ok(present | flag),
            "it is still so"
        );
        assert_eq!(rng.read(DR, 2_002, true), Ok(0));
        assert_eq!(
            rng.read(SR, 6_000, true),
            Ok(flag),
            "no words before the flag is cleared"
        );
        rng.write(SR, 0, 6_000).unwrap();
        assert_eq!(rng.read(SR, 6_001, true), Ok(1));
    }
}

#[test]
fn a_generator_that_is_held_back_is_ready_afterwards() {
    let mut rng = running();
    rng.break_down(Defect::NotReady, 5_000);
    assert_eq!(rng.read(SR, 4_999, true), Ok(0));
    assert_eq!(rng.read(SR, 5_000, true), Ok(1));
}
