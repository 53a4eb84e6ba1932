//! Entry, nesting, masks and return.

use super::Chip;
use super::code::Code;

#[test]
fn interrupts_nest_by_priority_and_return_in_order() {
    // Thread pends 20; its handler pends 21 (more urgent: nests) and 22 (less urgent: waits).
    let main = Code::new()
        .store(0x2000_0100, 0)
        .enable(20, 0x40)
        .enable(21, 0x20)
        .enable(22, 0x60);
    let main = main.trace(1).pend(20).trace(5).spin();
    let handlers = [
        (
            36,
            Code::function(|code| code.trace(2).pend(22).pend(21).trace(4)),
        ),
        (37, Code::function(|code| code.trace(3))),
        (38, Code::function(|code| code.trace(6))),
    ];
    let chip = Chip::ran(main, &handlers);
    assert_eq!(chip.result(0), 0x123465);
}

#[test]
fn registers_and_flags_survive_an_interrupt() {
    let clobber = Code::new()
        .load(0, 0)
        .load(1, 0)
        .load(2, 0)
        .load(3, 0)
        .raw(&[0x2800])
        .ret(); // cmp r0, #0: sets Z
    let main = Code::new()
        .enable(20, 0x40)
        .load(0, 10)
        .load(1, 11)
        .load(2, 12)
        .load(3, 13)
        .load(6, 0xE000_EF00)
        .load(7, 20)
        .raw(&[0x2805]) // cmp r0, #5: clears Z
        .raw(&[0x6037, 0xF3BF, 0x8F6F]) // str r7, [r6]; isb
        .raw(&[0xD003]) // beq: over the next two saves' first half, into nowhere good
        .save(0, 0)
        .save(1, 1)
        .save(2, 2)
        .save(3, 3)
        .spin();
    let chip = Chip::ran(main, &[(36, clobber)]);
    assert_eq!(
        [0, 1, 2, 3].map(|index| chip.result(index)),
        [10, 11, 12, 13]
    );
}

#[test]
fn a_handler_sees_its_number_and_the_return_code() {
    // mrs r0, ipsr; result[0] = r0; result[1] = lr
    let handler = Code::new()
        .raw(&[0xF3EF, 0x8005])
        .save(0, 0)
        .raw(&[0x4670])
        .save(1, 0)
        .ret();
    let main = Code::new()
        .enable(20, 0x40)
        .pend(20)
        .raw(&[0xF3EF, 0x8005])
        .save(2, 0)
        .spin();
    let chip = Chip::ran(main, &[(36, handler)]);
    assert_eq!(
        (chip.result(0), chip.result(1), chip.result(2)),
        (36, 0xFFFF_FFF9, 0)
    );
}

#[test]
fn primask_and_basepri_hold_interrupts_back_until_they_are_lifted() {
    for (raise, lower) in [
        (vec![0xB672], vec![0xB662]), // cpsid i, cpsie i
        (vec![0x2040, 0xF380, 0x8811], vec![0x2000, 0xF380, 0x8811]), // msr basepri, 0x40 and 0
    ] {
        let main = Code::new().store(0x2000_0100, 0).enable(20, 0x40);
        let main = main
            .raw(&raise)
            .pend(20)
            .trace(1)
            .raw(&lower)
            .raw(&[0xBF00])
            .trace(3)
            .spin();
        let chip = Chip::ran(main, &[(36, Code::function(|code| code.trace(2)))]);
        assert_eq!(chip.result(0), 0x123);
    }
}

/// The FPU on, interrupt 20 enabled, and a number in s0.
fn with_s0(number: f32) -> Code {
    Code::new()
        .store(0xE000_ED88, 0xF << 20)
        .enable(20, 0x40)
        .load(0, number.to_bits())
        .raw(&[0xEE00, 0x0A10]) // vmov s0, r0
}

#[test]
fn floating_point_registers_survive_an_interrupt() {
    // Handler: s0 = r0 = 7.0 as bits, and its return code.
    let handler = Code::new()
        .load(0, 7.0_f32.to_bits())
        .raw(&[0xEE00, 0x0A10])
        .raw(&[0x4670])
        .save(1, 0)
        .ret();
    let main = with_s0(2.5)
        .pend(20)
        .raw(&[0xEE10, 0x0A10]) // vmov r0, s0
        .save(0, 0)
        .spin();
    let chip = Chip::ran(main, &[(36, handler)]);
    assert_eq!(f32::from_bits(chip.result(0)), 2.5);
    assert_eq!(
        chip.result(1),
        0xFFFF_FFE9,
        "the frame has the floating-point part"
    );
}

#[test]
fn a_floating_point_comparison_survives_an_interrupt() {
    // Handler: its own comparison, 0.0 with zero: equal.
    let handler = Code::new()
        .load(0, 0)
        .raw(&[0xEE00, 0x0A10, 0xEEB5, 0x0A40])
        .ret();
    let main = with_s0(2.5)
        .raw(&[0xEEB5, 0x0A40]) // vcmp.f32 s0, #0
        .pend(20)
        .raw(&[0xEEF1, 0x0A10]) // vmrs r0, fpscr
        .save(0, 0)
        .spin();
    let chip = Chip::ran(main, &[(36, handler)]);
    assert_eq!(chip.result(0) >> 28, 0b0010, "greater: carry alone");
}

#[test]
fn frames_are_aligned_to_eight_bytes() {
    // sub sp, #4; the handler saves its stack pointer; afterwards the old one is back.
    let handler = Code::new().raw(&[0x4668]).save(0, 0).ret();
    let main = Code::new()
        .enable(20, 0x40)
        .raw(&[0xB081])
        .pend(20)
        .raw(&[0x4668])
        .save(1, 0)
        .spin();
    let chip = Chip::ran(main, &[(36, handler)]);
    assert_eq!(chip.result(0) % 8, 0);
    assert_eq!(chip.result(1), super::STACK - 4);
}

#[test]
fn an_interrupt_between_load_and_store_exclusive_makes_the_store_fail() {
    let exclusive = |between: Code| {
        Code::new()
            .enable(20, 0x40)
            .load(0, 0x2000_0200)
            .raw(&[0xE850, 0x1F00]) // ldrex r1, [r0]
            .raw(
                &between
                    .bytes()
                    .chunks(2)
                    .map(|two| u16::from_le_bytes([two[0], two[1]]))
                    .collect::<Vec<_>>(),
            )
            .raw(&[0xE840, 0x1200]) // strex r2, r1, [r0]
            .save(0, 2)
            .spin()
    };
    let handler = Code::new().ret();
    let undisturbed = Chip::ran(exclusive(Code::new()), &[(36, handler.clone())]);
    assert_eq!(undisturbed.result(0), 0);
    let disturbed = Chip::ran(exclusive(Code::new().pend(20)), &[(36, handler)]);
    assert_eq!(disturbed.result(0), 1);
}

#[test]
fn svc_is_taken_at_once_and_returns_behind_it() {
    let main = Code::new()
        .store(0x2000_0100, 0)
        .trace(1)
        .raw(&[0xDF00])
        .trace(3)
        .spin();
    let chip = Chip::ran(main, &[(11, Code::function(|code| code.trace(2)))]);
    assert_eq!(chip.result(0), 0x123);
}

#[test]
fn the_process_stack_is_used_in_thread_mode_and_the_main_stack_in_handlers() {
    let handler = Code::new()
        .raw(&[0x4668])
        .save(0, 0)
        .raw(&[0x4670])
        .save(1, 0)
        .ret();
    let main = Code::new()
        .enable(20, 0x40)
        .load(0, 0x2000_8000)
        .raw(&[0xF380, 0x8809]) // msr psp, r0
        .load(0, 2)
        .raw(&[0xF380, 0x8814, 0xF3BF, 0x8F6F]) // msr control, r0; isb
        .pend(20)
        .raw(&[0x4668])
        .save(2, 0)
        .spin();
    let chip = Chip::ran(main, &[(36, handler)]);
    assert_eq!(chip.result(0), super::STACK);
    assert_eq!(chip.result(1), 0xFFFF_FFFD);
    assert_eq!(chip.result(2), 0x2000_8000);
}

#[test]
fn code_runs_from_ram_and_may_be_changed() {
    // Twice: write a function into RAM (movs r0, #n; bx lr), call it, save what it returns.
    let routine = |number: u32| 0x4770_2000 | number;
    let call = |code: Code| code.load(1, 0x2000_4001).raw(&[0x4788]); // blx r1
    let main = Code::new()
        .store(0x2000_4000, routine(5))
        .raw(&[0xF3BF, 0x8F6F]);
    let main = call(main)
        .save(0, 0)
        .store(0x2000_4000, routine(6))
        .raw(&[0xF3BF, 0x8F6F]);
    let main = call(main).save(1, 0).spin();
    let chip = Chip::ran(main, &[]);
    assert_eq!((chip.result(0), chip.result(1)), (5, 6));
}

#[test]
fn a_conditional_load_from_a_page_not_seen_before_leaves_no_condition_behind() {
    // The emulator looks the page up in the middle of the IT block, and the block after the next page boundary (every
    // 1 KB) must not take that for its own state: a branch in an IT block is an undefined instruction.
    let mut main = Code::new()
        .load(1, 0x2001_8000)
        .raw(&[0x2000, 0x2800, 0xBF08, 0x680A]); // it eq; ldreq r2, [r1]
    while main.bytes().len() < 0x400 {
        main = main.raw(&[0xBF00]);
    }
    let main = main.raw(&[0xD000, 0xBF00]).load(0, 1).save(0, 0).spin(); // beq over a nop
    let chip = Chip::ran(main, &[]);
    assert_eq!(chip.result(0), 1);
}
