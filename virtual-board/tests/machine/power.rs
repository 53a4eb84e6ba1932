//! Resets: what survives them, and what they say.

use super::Chip;
use super::code::Code;

const RCC_CSR: u32 = 0x4002_1094;
const KEPT: u32 = 0x2000_0300;

/// Counts its starts in RAM, saves the reset cause of the second and stays; at the first start runs `end`.
fn twice(end: Code) -> Code {
    let marker = 0x5EED_0001;
    let first = Code::new().store(KEPT, marker).raw(
        &end.bytes()
            .chunks(2)
            .map(|two| u16::from_le_bytes([two[0], two[1]]))
            .collect::<Vec<_>>(),
    );
    let skipped = (first.bytes().len() / 2) as u16;
    let forward = 0xD000 | (skipped - 1); // beq over all of `first`
    Code::new()
        .fetch(0, KEPT)
        .load(1, marker)
        .raw(&[0x4288]) // cmp r0, r1
        .raw(&[forward])
        .raw(
            &first
                .bytes()
                .chunks(2)
                .map(|two| u16::from_le_bytes([two[0], two[1]]))
                .collect::<Vec<_>>(),
        )
        .fetch(0, RCC_CSR)
        .save(0, 0)
        .fetch(0, KEPT)
        .save(1, 0)
        .spin()
}

#[test]
fn a_software_reset_keeps_ram_and_says_so() {
    let chip = Chip::ran(
        twice(Code::new().store(0xE000_ED0C, 0x05FA_0004).spin()),
        &[],
    );
    assert_eq!(chip.result(0) >> 28 & 1, 1, "SFTRSTF");
    assert_eq!(chip.result(1), 0x5EED_0001);
}

#[test]
fn the_watchdog_resets_and_says_so() {
    // Shortest period: RLR = 0 would be 125 µs; 79 is 10 ms.
    let end = Code::new()
        .store(0x4000_3000, 0xCCCC)
        .store(0x4000_3000, 0x5555)
        .store(0x4000_3008, 79)
        .store(0x4000_3000, 0xAAAA)
        .spin();
    let mut chip = Chip::new(twice(end), &[]);
    chip.run(9e-3).unwrap();
    assert_ne!(chip.result(1), 0x5EED_0001);
    chip.run(3e-3).unwrap();
    assert_eq!(chip.result(0) >> 29 & 1, 1, "IWDGRSTF");
    assert_eq!(chip.result(1), 0x5EED_0001);
}

#[test]
fn the_watchdog_ends_a_lockup() {
    let end = Code::new().store(0x4000_3000, 0xCCCC).raw(&[0xDE00]);
    let mut chip = Chip::new(twice(end), &[(3, Code::new().raw(&[0xDE00]))]);
    chip.run(0.6).unwrap();
    assert_eq!(chip.result(0) >> 29 & 1, 1, "IWDGRSTF");
}

#[test]
fn power_on_fills_ram_with_noise_of_the_seed() {
    let (one, same) = (
        Chip::new(Code::new().spin(), &[]),
        Chip::new(Code::new().spin(), &[]),
    );
    assert_eq!(one.word(KEPT), same.word(KEPT));
    assert_ne!(one.word(KEPT), one.word(KEPT + 4));
}

#[test]
fn a_peripheral_without_clock_reads_zero_and_ignores_writes() {
    let main = Code::new()
        .store(0x4000_102C, 1234) // TIM6_ARR
        .fetch(0, 0x4000_102C)
        .save(0, 0)
        .store(0x4002_1058, 1 << 4)
        .store(0x4000_102C, 1234)
        .fetch(0, 0x4000_102C)
        .save(1, 0)
        .store(0x4002_1038, 1 << 4) // APB1RSTR1: TIM6
        .store(0x4002_1038, 0)
        .fetch(0, 0x4000_102C)
        .save(2, 0)
        .spin();
    let chip = Chip::ran(main, &[]);
    assert_eq!(
        (chip.result(0), chip.result(1), chip.result(2)),
        (0, 1234, 0xFFFF)
    );
}
