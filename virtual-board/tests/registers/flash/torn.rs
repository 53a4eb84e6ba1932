//! Torn and damaged words, and operations that are cut short.

use super::*;

#[test]
fn a_reset_in_mid_program_tears_the_double_word() {
    let mut bench = Bench::unlocked();
    bench.flash.write(CR, PG, 0).unwrap();
    bench.store(0x40010, 0, 0);
    bench.store(0x40014, 0x5555_5555, 0);
    bench.flash.reset(&mut bench.memory).unwrap();
    let left = bench.memory.double_word(0x40010);
    assert_eq!(
        left & 0x5555_5555_0000_0000,
        0x5555_5555_0000_0000,
        "bits only fall"
    );
    assert!(left != u64::MAX && left != 0x5555_5555_0000_0000);
    assert!(bench.watched(1));
    assert!(bench.check_read(0x40014));
    assert_eq!(
        bench.flash.read(0x18),
        Ok(1 << 31 | 1 << 21 | 2),
        "ECCD, bank 2, double word 2"
    );
    bench.flash.write(0x18, 1 << 31, 0).unwrap();
    assert_eq!(bench.flash.read(0x18).unwrap() >> 31, 0);
    assert!(!bench.check_read(0x40018));
}

#[test]
fn an_operation_that_power_cuts_short_has_not_happened() {
    let mut bench = Bench::unlocked();
    bench.memory.write(BANK_SIZE, &[0; 2048]).unwrap();
    bench.flash.write(CR, PER | BKER | STRT, 0).unwrap();
    bench.advance(PAGE_ERASE / 2);
    assert!(
        bench.file()[BANK_SIZE..BANK_SIZE + 2048]
            .iter()
            .all(|byte| *byte == 0)
    );
}

#[test]
fn a_torn_word_is_torn_after_power_on_too_until_its_page_is_erased() {
    let mut bench = Bench::unlocked();
    bench.flash.write(CR, PG, 0).unwrap();
    bench.store(0x40010, 0, 0);
    bench.store(0x40014, 0x5555_5555, 0);
    bench.flash.reset(&mut bench.memory).unwrap();
    let left = bench.memory.double_word(0x40010);
    bench.power_on();
    assert_eq!(bench.memory.double_word(0x40010), left);
    assert!(bench.watched(1) && bench.check_read(0x40010));
    bench.flash.write(KEYR, 0x4567_0123, 0).unwrap();
    bench.flash.write(KEYR, 0xCDEF_89AB, 0).unwrap();
    bench.flash.write(CR, PER | BKER | STRT, 0).unwrap();
    bench.advance(PAGE_ERASE);
    assert!(!bench.check_read(0x40010) && !bench.watched(1));
    bench.power_on();
    assert!(!bench.check_read(0x40010));
}

#[test]
fn one_wrong_bit_is_corrected_flagged_and_interrupts_if_enabled() {
    let mut bench = Bench::unlocked();
    bench.program(0x40018, 0x1234_5678, 0);
    bench.memory.damage(0x4001C, Flaw::OneBit).unwrap();
    assert!(bench.watched(1) && !bench.watched(0));
    assert!(!bench.check_read(0x40018), "no NMI");
    assert_eq!(bench.memory.double_word(0x40018), 0x1234_5678_1234_5678);
    assert_eq!(bench.flash.read(ECCR), Ok(ECCC | 1 << 21 | 3));
    assert!(!bench.flash.interrupt());
    bench.flash.write(ECCR, ECCCIE, 0).unwrap();
    assert!(bench.flash.interrupt());
    bench.flash.write(ECCR, ECCC | ECCCIE, 0).unwrap();
    assert_eq!(bench.flash.read(ECCR).unwrap() & (ECCC | ECCD), 0);
    assert!(!bench.flash.interrupt());
}

#[test]
fn an_erasure_that_is_cut_short_leaves_old_torn_and_erased_words() {
    let mut bench = Bench::unlocked();
    bench.memory.write(BANK_SIZE, &[0; 2048]).unwrap();
    bench.flash.write(CR, PER | BKER | STRT, 0).unwrap();
    bench.flash.reset(&mut bench.memory).unwrap();
    let words = (BANK_SIZE..BANK_SIZE + 2048).step_by(8);
    let mut seen = [0; 3];
    for word in words {
        let kind = match (bench.check_read(word), bench.memory.double_word(word)) {
            (true, _) => 0,
            (false, 0) => 1,
            (false, u64::MAX) => 2,
            (false, left) => panic!("{left:#x}"),
        };
        seen[kind] += 1;
    }
    assert!(seen.iter().all(|count| *count > 50), "{seen:?}");
}

#[test]
fn a_trap_stops_its_operation_before_within_or_after() {
    for (progress, left) in [
        (Progress::NotBegun, u64::MAX),
        (Progress::Done, 0x5555_5555_5555_5555),
    ] {
        let mut bench = Bench::unlocked();
        bench.flash.set_trap(Some((2, progress)));
        bench.program(0x40000, 0x1111_1111, 0);
        assert!(!bench.flash.trapped());
        bench.program(0x40008, 0x5555_5555, 100_000);
        assert!(bench.flash.trapped());
        bench.flash.reset(&mut bench.memory).unwrap();
        assert_eq!(bench.memory.double_word(0x40000), 0x1111_1111_1111_1111);
        assert_eq!(bench.memory.double_word(0x40008), left, "{progress:?}");
        assert!(!bench.watched(1));
    }
    let mut bench = Bench::unlocked();
    bench.flash.set_trap(Some((1, Progress::Half)));
    bench.flash.write(CR, PG, 0).unwrap();
    bench.store(0x40000, 0x5555_5555, 0);
    assert!(!bench.flash.trapped());
    bench.store(0x40004, 0x5555_5555, 0);
    assert!(bench.flash.trapped());
    bench.flash.reset(&mut bench.memory).unwrap();
    assert!(bench.check_read(0x40000), "torn");
}
