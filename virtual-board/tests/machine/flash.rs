//! The flash memory as the core sees it: read-while-write, stalls, torn words.

use virtual_board::injection::timeline::Timeline;

use super::Chip;
use super::code::Code;

const KEYR: u32 = 0x4002_2008;
const SR: u32 = 0x4002_2010;
const CR: u32 = 0x4002_2014;
const ECCR: u32 = 0x4002_2018;
const BANK_2: u32 = 0x0804_0000;
const CYCCNT: u32 = 0xE000_1004;
/// Ends a basic block: stalls and the cycle counter are exact from one block to the next.
const ISB: [u16; 2] = [0xF3BF, 0x8F6F];
/// 22 ms at 16 MHz (off by up to 1 %).
const ERASE_CYCLES: std::ops::Range<u32> = 340_000..365_000;

fn unlocked() -> Code {
    Code::new()
        .store(0xE000_EDFC, 1 << 24)
        .store(0xE000_1000, 1)
        .store(KEYR, 0x4567_0123)
        .store(KEYR, 0xCDEF_89AB)
}

/// Starts erasing page 0 of a bank, then reads the cycle counter, a word, and the counter again.
fn erase_then_read(bank_select: u32, address: u32) -> u32 {
    let main = unlocked()
        .store(CR, 1 << 1 | bank_select)
        .fetch(0, CYCCNT)
        .store(CR, 1 << 1 | bank_select | 1 << 16)
        .raw(&ISB)
        .fetch(2, address)
        .raw(&ISB)
        .fetch(1, CYCCNT)
        .raw(&[0x1A08]) // subs r0, r1, r0
        .save(0, 0)
        .spin();
    let mut chip = Chip::new(main, &[]);
    chip.run(50e-3).unwrap();
    chip.result(0)
}

#[test]
fn code_in_bank_1_goes_on_while_bank_2_is_erased() {
    let cycles = erase_then_read(1 << 11, 0x0800_0000);
    assert!(cycles < 100, "{cycles}");
}

#[test]
fn a_read_of_the_busy_bank_waits_for_its_end() {
    let cycles = erase_then_read(1 << 11, BANK_2 + 0x8000);
    assert!(ERASE_CYCLES.contains(&cycles), "{cycles}");
}

#[test]
fn code_stalls_while_its_own_bank_is_erased() {
    // Page 100 of bank 1 holds nothing.
    let main = unlocked()
        .store(CR, 1 << 1 | 100 << 3)
        .fetch(0, CYCCNT)
        .store(CR, 1 << 1 | 100 << 3 | 1 << 16)
        .raw(&ISB)
        .fetch(1, CYCCNT)
        .raw(&[0x1A08])
        .save(0, 0)
        .spin();
    let mut chip = Chip::new(main, &[]);
    chip.run(50e-3).unwrap();
    let cycles = chip.result(0);
    assert!(ERASE_CYCLES.contains(&cycles), "{cycles}");
}

#[test]
fn an_operation_that_is_held_up_ends_later() {
    let main = unlocked()
        .store(CR, 1)
        .store(BANK_2 + 8, 0x1234_5678)
        .store(BANK_2 + 12, 0x9ABC_DEF0)
        .spin();
    let mut chip = Chip::new(main, &[]);
    let fault = r#"{"at_s":0,"fault":"flash_stall","duration_us":2000}"#;
    chip.machine.inject(Timeline::parse(fault).unwrap());
    let mut busy_after = |seconds| {
        chip.run(seconds).unwrap();
        chip.machine.bus_mut().read(SR, 4) >> 16 & 1 == 1
    };
    assert!(busy_after(1.9e-3));
    assert!(!busy_after(0.2e-3));
}

#[test]
fn a_program_of_the_core_writes_the_flash() {
    let main = unlocked()
        .store(CR, 1)
        .store(BANK_2 + 8, 0x1234_5678)
        .store(BANK_2 + 12, 0x9ABC_DEF0)
        .raw(&ISB)
        .fetch(0, BANK_2 + 8) // waits for the end
        .save(0, 0)
        .spin();
    let chip = Chip::ran(main, &[]);
    assert_eq!(chip.result(0), 0x1234_5678);
    let file = std::fs::read(chip.folder.path().join("flash.bin")).unwrap();
    assert_eq!(
        file[0x40008..0x40010],
        [0x78, 0x56, 0x34, 0x12, 0xF0, 0xDE, 0xBC, 0x9A]
    );
}

#[test]
fn a_store_without_preparation_changes_nothing() {
    let main = Code::new()
        .store(BANK_2, 0)
        .store(BANK_2 + 4, 0)
        .fetch(0, BANK_2)
        .save(0, 0)
        .fetch(0, 0x4002_2010);
    let chip = Chip::ran(main.save(1, 0).spin(), &[]);
    assert_eq!(
        (chip.result(0), chip.result(1)),
        (u32::MAX, 1 << 7),
        "PGSERR"
    );
}

#[test]
fn reading_a_torn_word_raises_the_nmi() {
    // First start: programs a double word and resets in the middle. Second start: reads it.
    let marker = 0x5EED_0002;
    let first = unlocked()
        .store(0x2000_0300, marker)
        .store(CR, 1)
        .store(BANK_2, 0)
        .store(BANK_2 + 4, 1)
        .store(0xE000_ED0C, 0x05FA_0004)
        .spin();
    let halves: Vec<u16> = first
        .bytes()
        .chunks(2)
        .map(|two| u16::from_le_bytes([two[0], two[1]]))
        .collect();
    let main = Code::new()
        .fetch(0, 0x2000_0300)
        .load(1, marker)
        .raw(&[0x4288, 0xD000 | (halves.len() as u16 - 1)])
        .raw(&halves)
        .store(0x2000_0100, 0)
        .fetch(0, BANK_2)
        .raw(&ISB)
        .spin();
    let nmi = Code::new()
        .fetch(0, ECCR)
        .save(0, 0)
        .store(ECCR, 1 << 31)
        .ret();
    let chip = Chip::ran(main, &[(2, nmi)]);
    assert_eq!(chip.result(0) >> 31, 1, "ECCD");
}
