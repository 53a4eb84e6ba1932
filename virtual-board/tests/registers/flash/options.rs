//! Option registers: bank mode and write protection (RM0440 3.3.1, 3.5.4, 3.7.8, 3.7.11).

use super::{BKER, Bench, CR, OPTR, PAGE_ERASE, PER, SR, STRT};
use virtual_board::memory::FLASH_SIZE;

const WRP1AR: u32 = 0x2C;
const WRP2AR: u32 = 0x4C;
const WRPERR: u32 = 1 << 4;
/// Factory setting, but DBANK = 0.
const SINGLE_BANK: &str = "OPTR=0xffaff8aa";

/// An open flash without an erased word, with these options.
fn full(options: &[&str]) -> Bench {
    let mut bench = Bench::unlocked();
    bench.memory.write(0, &vec![0; FLASH_SIZE]).unwrap();
    for option in options {
        bench.flash.options_mut().set(&option.parse().unwrap());
    }
    bench
}

/// Erases a page; the range that is erased afterwards.
fn erased_by(bench: &mut Bench, control: u32, page: u32) -> Option<(usize, usize)> {
    let control = PER | control | page << 3;
    bench.flash.write(CR, control, 0).unwrap();
    bench.flash.write(CR, control | STRT, 0).unwrap();
    bench.advance(PAGE_ERASE);
    let file = bench.file();
    let first = file.iter().position(|byte| *byte == 0xFF)?;
    let last = file.iter().rposition(|byte| *byte == 0xFF)?;
    assert!(file[first..=last].iter().all(|byte| *byte == 0xFF));
    Some((first, last + 1))
}

#[test]
fn a_page_of_two_banks_has_2_kb_and_lies_in_the_bank_that_bker_names() {
    assert_eq!(erased_by(&mut full(&[]), BKER, 9), Some((0x44800, 0x45000)));
    assert_eq!(erased_by(&mut full(&[]), 0, 9), Some((0x4800, 0x5000)));
}

#[test]
fn a_page_of_a_single_bank_has_4_kb_from_the_begin_of_the_flash_whatever_bker_says() {
    for control in [0, BKER] {
        let mut bench = full(&[SINGLE_BANK]);
        assert_eq!(bench.flash.read(OPTR), Ok(0xFFAF_F8AA));
        assert_eq!(erased_by(&mut bench, control, 9), Some((0x9000, 0xA000)));
    }
}

#[test]
fn an_operation_of_a_single_bank_keeps_all_of_it_busy() {
    let mut bench = full(&[SINGLE_BANK]);
    bench.flash.write(CR, PER, 0).unwrap();
    bench.flash.write(CR, PER | STRT, 0).unwrap();
    assert!(bench.flash.is_busy(0) && bench.flash.is_busy(1));
}

#[test]
fn protected_pages_are_neither_erased_nor_programmed_and_others_are() {
    // Pages 3 to 9 of bank 2.
    let options = ["WRP2AR=0x00090003"];
    for page in [3, 9] {
        let mut bench = full(&options);
        assert_eq!(erased_by(&mut bench, BKER, page), None, "page {page}");
        assert_eq!(bench.status() & WRPERR, WRPERR);
    }
    for (control, page) in [(BKER, 2), (BKER, 10), (0, 3)] {
        let mut bench = full(&options);
        assert!(erased_by(&mut bench, control, page).is_some());
        assert_eq!(bench.status() & WRPERR, 0);
    }
    let mut bench = Bench::unlocked();
    bench.flash.options_mut().set(&options[0].parse().unwrap());
    bench.program(0x41800, 7, 0);
    assert_eq!(bench.flash.read(SR).unwrap() & WRPERR, WRPERR);
    assert_eq!(bench.memory.double_word(0x41800), u64::MAX);
}

#[test]
fn a_mass_erasure_spares_a_bank_with_a_protected_page() {
    const MER1: u32 = 1 << 2;
    const MER2: u32 = 1 << 15;
    for (mass, spared) in [(MER1, false), (MER2, true), (MER1 | MER2, true)] {
        let mut bench = full(&["WRP2AR=0x00090003"]);
        bench.flash.write(CR, mass | STRT, 0).unwrap();
        assert_eq!(bench.status() & WRPERR != 0, spared, "{mass:#x}");
    }
}

#[test]
fn options_can_be_read_and_stay_over_a_reset() {
    let mut bench = full(&["WRP1AR=0x00110007", "WRP2AR=0x007f0000"]);
    bench.flash.reset(&mut bench.memory).unwrap();
    assert_eq!(bench.flash.read(WRP1AR), Ok(0x0011_0007));
    assert_eq!(bench.flash.read(WRP2AR), Ok(0x007F_0000));
}
