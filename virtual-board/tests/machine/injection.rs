//! Faults that are made on purpose, with programs of a few instructions.

use virtual_board::injection::timeline::Timeline;
use virtual_board::machine::Stop;

use super::Chip;
use super::code::Code;

const RCC_CSR: u32 = 0x4002_1094;
const KEPT: u32 = 0x2000_0300;
const MARK: u32 = 0x5EED_0003;
const BANK_2: u32 = 0x0804_0000;

fn with_faults(main: Code, handlers: &[(u32, Code)], lines: &[&str]) -> Chip {
    let mut chip = Chip::new(main, handlers);
    chip.machine
        .inject(Timeline::parse(&lines.join("\n")).unwrap());
    chip
}

/// Saves the reset cause and what RAM kept of the start before, then marks the RAM.
fn says_why_it_started() -> Code {
    Code::new()
        .fetch(0, RCC_CSR)
        .save(0, 0)
        .fetch(0, KEPT)
        .save(1, 0)
        .store(KEPT, MARK)
        .store(RCC_CSR, 1 << 23)
}

/// Counts in `result[index]` for ever.
fn counts(code: Code, index: u32) -> Code {
    // adds r3, #1; then to r6, which `save` has loaded: str r3, [r6]; b back
    code.load(3, 0)
        .save(index, 3)
        .raw(&[0x3301, 0x6033, 0xE7FC])
}

#[test]
fn a_pin_reset_and_brown_outs_say_so_and_keep_or_lose_the_ram() {
    let mut chip = with_faults(
        says_why_it_started().spin(),
        &[],
        &[
            r#"{"at_s":0.001,"fault":"pin_reset"}"#,
            r#"{"at_s":0.002,"fault":"brown_out","ram_kept":true}"#,
            r#"{"at_s":0.003,"fault":"brown_out","ram_kept":false}"#,
        ],
    );
    // A program that spins for ever ends the run; so it runs up to just after each fault.
    let mut seen = Vec::new();
    for until_s in [0.0011, 0.0021, 0.0031] {
        let _ = chip.machine.run(until_s);
        seen.push((chip.result(0) >> 26, chip.result(1) == MARK));
    }
    assert_eq!(seen, [(0b01, true), (0b11, true), (0b11, false)]);
}

#[test]
fn a_core_that_hangs_is_reset_by_the_watchdog_and_by_nothing_else() {
    // 10 ms; see the test of the watchdog.
    let watchdog = |code: Code| {
        code.store(0x4000_3000, 0xCCCC)
            .store(0x4000_3000, 0x5555)
            .store(0x4000_3008, 79)
            .store(0x4000_3000, 0xAAAA)
    };
    let feeds = |code: Code| {
        // str r7, [r6]; b back
        code.load(6, 0x4000_3000)
            .load(7, 0xAAAA)
            .raw(&[0x6037, 0xE7FD])
    };
    let main = feeds(watchdog(says_why_it_started()));
    let mut chip = with_faults(main.clone(), &[], &[r#"{"at_s":0.05,"fault":"hang"}"#]);
    chip.run(0.055).unwrap();
    assert_eq!(chip.result(0) >> 29 & 1, 0);
    chip.run(0.02).unwrap();
    assert_eq!(chip.result(0) >> 29 & 1, 1, "IWDGRSTF");
    let mut chip = with_faults(main, &[], &[]);
    chip.run(0.1).unwrap();
    assert_eq!(chip.result(0) >> 29 & 1, 0);
}

#[test]
fn a_hang_in_thread_mode_leaves_interrupts_running() {
    // SysTick every 1000 cycles counts in result 0; the main program counts in result 1.
    let main = Code::new()
        .store(0x2000_0100, 0)
        .store(0xE000_E014, 999)
        .store(0xE000_E018, 0)
        .store(0xE000_E010, 7);
    let main = counts(main, 1).spin();
    let handler = Code::new()
        .fetch(0, 0x2000_0100)
        .raw(&[0x3001])
        .save(0, 0)
        .ret();
    let mut chip = with_faults(
        main,
        &[(15, handler)],
        &[r#"{"at_s":0.01,"fault":"hang","exception":0}"#],
    );
    chip.run(0.02).unwrap();
    let before = (chip.result(0), chip.result(1));
    chip.run(0.01).unwrap();
    let after = (chip.result(0), chip.result(1));
    assert!(after.0 > before.0 + 100, "{before:?} {after:?}");
    assert_eq!(after.1, before.1);
}

#[test]
fn a_power_cut_at_a_flash_operation_ends_everything_with_the_word_torn_for_good() {
    let words = |code: Code, index: u32| {
        let at = BANK_2 + 8 * index;
        code.store(at, 0x5555_5555)
            .store(at + 4, 0x5555_5555)
            .raw(&[0xF3BF, 0x8F6F])
            .fetch(0, at) // waits for the end
    };
    let main = Code::new()
        .store(0x4002_2008, 0x4567_0123)
        .store(0x4002_2008, 0xCDEF_89AB)
        .store(0x4002_2014, 1);
    let main = words(words(words(main, 0), 1), 2).spin();
    let cut = r#"{"flash_operation":2,"progress":"half","fault":"power_cut"}"#;
    let mut chip = with_faults(main, &[], &[cut]);
    assert!(matches!(chip.run(1.0), Err(Stop::PowerCut { .. })));
    let memory = &chip.machine.bus().flash_memory;
    assert_eq!(memory.double_word(0x40000), 0x5555_5555_5555_5555);
    assert!(memory.flaws().any_in(0x40008..0x40010));
    assert_eq!(memory.double_word(0x40010), u64::MAX);
    let kept = std::fs::read_to_string(chip.folder.path().join("flash.bin.ecc")).unwrap();
    assert_eq!(kept, "0x040008 torn\n");
}

#[test]
fn a_stack_pointer_at_the_end_of_the_ram_faults_with_the_next_push() {
    // push {r4-r7, lr}; pop {r4-r7, pc} in a loop: movs r0, #0; bl +4 would do, but a push alone is enough.
    let main = counts(Code::new(), 0).spin();
    let handler = Code::new().store(0x2000_0104, MARK).spin();
    let tick = Code::function(|body| body);
    let main = Code::new()
        .store(0xE000_E014, 999)
        .store(0xE000_E018, 0)
        .store(0xE000_E010, 7)
        .raw(
            &main
                .bytes()
                .chunks(2)
                .map(|two| u16::from_le_bytes([two[0], two[1]]))
                .collect::<Vec<_>>(),
        );
    let mut chip = with_faults(
        main,
        &[(3, handler), (15, tick)],
        &[r#"{"at_s":0.01,"fault":"stack_pointer","address":"0x20000008"}"#],
    );
    let _ = chip.run(0.02);
    assert_eq!(chip.result(1), MARK, "HardFault was entered");
}

#[test]
fn a_torn_word_is_noticed_right_after_others_of_its_page_were_read() {
    // ldr r0..r2 of three double words; the last is torn. No block ends in between.
    let main = Code::new()
        .store(0x2000_0100, 0)
        .load(6, BANK_2)
        .raw(&[0x6830, 0x68B1, 0x6932, 0xF3BF, 0x8F6F])
        .spin();
    let nmi = Code::new()
        .fetch(0, 0x4002_2018)
        .save(0, 0)
        .store(0x4002_2018, 1 << 31)
        .ret();
    let bits = r#"{"at_s":0,"fault":"bit_error","address":"0x08040010","bits":2}"#;
    let mut chip = with_faults(main, &[(2, nmi)], &[bits]);
    let _ = chip.run(1e-3);
    assert_eq!(chip.result(0), 1 << 31 | 1 << 21 | 2, "ECCD");
}

#[test]
fn a_halt_stops_the_core_and_the_watchdog_only_if_the_firmware_asks_for_that() {
    const APB1FZR1: u32 = 0xE004_2008;
    for (freeze, bites) in [(0, 1), (1 << 12, 0)] {
        // The watchdog of 10 ms is fed in a loop that also counts in result 2.
        let main = says_why_it_started()
            .store(APB1FZR1, freeze)
            .store(0x4000_3000, 0xCCCC)
            .store(0x4000_3000, 0x5555)
            .store(0x4000_3008, 79)
            .load(3, 0)
            .load(4, 0x4000_3000)
            .load(7, 0xAAAA)
            .save(2, 3)
            // str r7, [r4]; adds r3, #1; str r3, [r6]; b back
            .raw(&[0x6027, 0x3301, 0x6033, 0xE7FB]);
        let halt = r#"{"at_s":0.05,"fault":"halt","duration_us":30000}"#;
        let mut chip = with_faults(main, &[], &[halt]);
        chip.run(0.0499).unwrap();
        let before = chip.result(2);
        chip.run(0.0301).unwrap();
        assert_eq!(chip.result(0) >> 29 & 1, bites, "IWDGRSTF");
        if bites == 0 {
            let most = before + before / 400;
            assert!((before..most).contains(&chip.result(2)), "it ran on");
            chip.run(0.01).unwrap();
            assert!(chip.result(2) > most, "it does not go on");
        }
    }
}

#[test]
fn a_watched_crystal_that_stops_raises_the_non_maskable_interrupt() {
    const RCC_CR: u32 = 0x4002_1000;
    const RCC_CIFR: u32 = 0x4002_101C;
    let main = counts(Code::new().store(RCC_CR, 1 << 8 | 1 << 16 | 1 << 19), 0).spin();
    let handler = Code::new().fetch(0, RCC_CIFR).save(1, 0).spin();
    let dies = r#"{"at_s":0.004,"fault":"crystal"}"#;
    let mut chip = with_faults(main, &[(2, handler)], &[dies]);
    chip.run(0.003).unwrap();
    assert_ne!(chip.result(1), 1 << 8);
    assert!(chip.run(0.002).is_err(), "the handler spins for ever");
    assert_eq!(chip.result(1), 1 << 8, "CSSF");
}

#[test]
fn bits_of_a_word_of_ram_flip_by_its_address_and_by_its_content() {
    let main = Code::new().store(KEPT, MARK).store(KEPT + 4, MARK).spin();
    let flips = [
        r#"{"at_s":0.001,"fault":"ram_bits","address":"0x20000300","mask":"0x00000005"}"#,
        r#"{"at_s":0.002,"fault":"ram_word","holds":"0x5eed0006","skip":0,"mask":"0x80000000"}"#,
        r#"{"at_s":0.003,"fault":"ram_word","holds":"0x5eed0003","skip":1,"mask":"0xffffffff"}"#,
    ];
    let mut chip = with_faults(main, &[], &flips);
    let _ = chip.machine.run(0.004);
    // Results begin at 0x20000100. Of the words with the mark none was left to pass over.
    assert_eq!(
        (chip.result(128), chip.result(129)),
        (MARK ^ 0x8000_0005, MARK)
    );
}
