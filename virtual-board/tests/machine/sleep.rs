//! WFE, WFI, events, and time while the core sleeps.

use super::Chip;
use super::code::Code;

const WFE: u16 = 0xBF20;
const WFI: u16 = 0xBF30;
const SEV: u16 = 0xBF40;
const RCC_APB1ENR1: u32 = 0x4002_1058;
const TIM6: u32 = 0x4000_1000;
const TIM6_INTERRUPT: u32 = 54;

/// TIM6 updates every 16 000 cycles, which is 1 ms at 16 MHz, with its interrupt on.
fn with_tim6() -> Code {
    Code::new()
        .store(RCC_APB1ENR1, 1 << 4)
        .store(TIM6 + 0x2C, 15_999)
        .store(TIM6 + 0x0C, 1)
        .store(TIM6, 1)
        .enable(TIM6_INTERRUPT, 0x40)
}

/// Counts in `result[0]` and clears the timer's flag.
fn tim6_handler() -> Code {
    Code::new()
        .fetch(0, 0x2000_0100)
        .raw(&[0x3001]) // adds r0, #1
        .save(0, 0)
        .store(TIM6 + 0x10, 0)
        .ret()
}

#[test]
fn wfe_sleeps_and_an_interrupt_wakes_it() {
    // Counts its turns in result[1]; a turn has two WFE, since the return from the handler leaves an event.
    let main = with_tim6()
        .store(0x2000_0100, 0)
        .load(1, 0)
        .raw(&[WFE, WFE, 0x3101])
        .save(1, 1);
    // adds r1; save is movw, movt, str: ten bytes and the branch back over sixteen.
    let main = main.raw(&[0xE7F5]);
    let mut chip = Chip::new(main, &[(16 + TIM6_INTERRUPT, tim6_handler())]);
    chip.run(50.5e-3).unwrap();
    let ticks = chip.result(0);
    assert!(
        (49..=51).contains(&ticks),
        "{ticks} ticks in 50 ms of an oscillator good to 1 %"
    );
    assert!(
        chip.result(1).abs_diff(ticks) <= 1,
        "{} turns",
        chip.result(1)
    );
}

#[test]
fn sev_makes_the_next_wfe_fall_through() {
    let main = Code::new()
        .raw(&[SEV, WFE])
        .load(0, 1)
        .save(0, 0)
        .raw(&[WFE])
        .load(0, 1)
        .save(1, 0)
        .spin();
    let mut chip = Chip::new(main, &[]);
    chip.machine
        .bus_mut()
        .ram
        .write(0x100, &[0; 8])
        .then_some(())
        .unwrap();
    chip.run(1e-3).unwrap();
    assert_eq!((chip.result(0), chip.result(1)), (1, 0), "only once");
}

#[test]
fn wfi_wakes_on_a_masked_interrupt_and_wfe_does_not() {
    for (hint, woken) in [(WFI, 1), (WFE, 0)] {
        let main = with_tim6()
            .store(0x2000_0104, 0)
            .raw(&[0xB672, hint])
            .load(0, 1)
            .save(1, 0)
            .raw(&[0xB672]);
        let main = main.raw(&[0xE7FD]);
        let mut chip = Chip::new(main, &[(16 + TIM6_INTERRUPT, tim6_handler())]);
        chip.run(5e-3).unwrap();
        assert_eq!(chip.result(1), woken, "{hint:#x}");
    }
}

#[test]
fn an_idle_chip_lets_time_pass() {
    let mut chip = Chip::new(Code::new().raw(&[WFE, WFE, 0xE7FC]), &[]);
    chip.run(1000.0).unwrap();
    assert!((chip.machine.bus().now_s() - 1000.0).abs() < 1e-6);
}

#[test]
fn the_cycle_counter_stands_still_in_sleep() {
    let main = with_tim6()
        .store(0xE000_EDFC, 1 << 24)
        .store(0xE000_1004, 0)
        .store(0xE000_1000, 1)
        .raw(&[WFI])
        .fetch(0, 0xE000_1004)
        .save(1, 0)
        .spin();
    let mut chip = Chip::new(main, &[(16 + TIM6_INTERRUPT, tim6_handler())]);
    chip.run(5e-3).unwrap();
    let awake = chip.result(1);
    assert!(
        (10..200).contains(&awake),
        "{awake} of the 16000 cycles of a period"
    );
}

#[test]
fn one_instruction_is_one_cycle() {
    // 1000 turns of subs, bne between two readings of CYCCNT.
    let main = Code::new()
        .store(0xE000_EDFC, 1 << 24)
        .store(0xE000_1000, 1)
        .load(2, 1000)
        .fetch(0, 0xE000_1004)
        .raw(&[0x3A01, 0xD1FD])
        .fetch(1, 0xE000_1004)
        .raw(&[0x1A08]) // subs r0, r1, r0
        .save(0, 0)
        .spin();
    let chip = Chip::ran(main, &[]);
    let cycles = chip.result(0);
    assert!((2000..=2010).contains(&cycles), "{cycles}");
}
