//! Counts of instructions, against programs whose instructions can be counted by hand.

use virtual_board::machine::counting::{Counting, Range, Target};

use super::code::Code;
use super::{Chip, HANDLER_SPACE, HANDLERS, MAIN};

/// Exception whose handler's place holds a function that is called.
const FUNCTION: u32 = 60;

fn address() -> u32 {
    HANDLERS + FUNCTION * HANDLER_SPACE
}

/// Calls the function with each of these values in r1.
fn calls(values: &[u32]) -> Code {
    let main = Code::new().enable(20, 0x40);
    let call = |code: Code, value: &u32| code.load(1, *value).load(0, address() | 1).raw(&[0x4780]);
    values.iter().fold(main, call).spin()
}

fn counted(main: Code, handlers: &[(u32, Code)], target: Target) -> (u64, Range, Range) {
    let mut chip = Chip::new(main, handlers);
    let mut counting = Counting::default();
    counting.add(target, "target", "target");
    chip.machine.count(counting);
    chip.run(1e-3).unwrap();
    let count = &chip.machine.counts().unwrap()[0];
    (count.calls, count.instructions, count.with_interruptions)
}

#[test]
fn a_call_is_counted_from_its_first_instruction_to_its_return() {
    // back: subs r1, #1; bne back; bx lr. The loop goes back to the first instruction, which is no call.
    let function = Code::new().raw(&[0x3901, 0xD1FD]).ret();
    let found = counted(
        calls(&[5, 1, 9]),
        &[(FUNCTION, function)],
        Target::Function(address()),
    );
    let range = Range { min: 3, max: 19 };
    assert_eq!(found, (3, range, range));
}

#[test]
fn what_interrupts_a_call_is_counted_apart() {
    // The function: two MOVW, two MOVT, STR, ISB, BX: seven. The handler: two and a return.
    let function = Code::new().pend(20).ret();
    let handler = Code::new().raw(&[0xBF00, 0xBF00]).ret();
    let handlers = [(FUNCTION, function), (36, handler)];
    let main = calls(&[0, 0]);
    let found = counted(main.clone(), &handlers, Target::Function(address()));
    let range = |instructions| Range {
        min: instructions,
        max: instructions,
    };
    assert_eq!(found, (2, range(7), range(10)));
    let found = counted(main, &handlers, Target::Exception(36));
    assert_eq!(found, (2, range(3), range(3)));
}

#[test]
fn a_function_is_counted_with_those_that_it_calls_and_a_handler_with_those_that_it_calls() {
    // push {r4-r7, lr}; movw, movt r0; blx r0; pop: five, and three in the function.
    let callee = Code::new().raw(&[0xBF00, 0xBF00]).ret();
    let caller = Code::function(|code| code.load(0, address() | 1).raw(&[0x4780]));
    let main = Code::new().enable(20, 0x40).pend(20).pend(20).spin();
    let handlers = [(FUNCTION, callee), (36, caller)];
    let handler = counted(main.clone(), &handlers, Target::Exception(36));
    assert_eq!((handler.0, handler.1), (2, Range { min: 8, max: 8 }));
    let callee = counted(main, &handlers, Target::Function(address()));
    assert_eq!((callee.0, callee.1), (2, Range { min: 3, max: 3 }));
}

/// Interrupts masked, `nops` instructions, and unmasked (CPSID, NOP, CPSIE).
fn masked(nops: usize) -> Code {
    Code::new()
        .raw(&[0xB672])
        .raw(&vec![0xBF00; nops])
        .raw(&[0xB662])
}

/// The longest stretch with masked interrupts: its cycles, and where it began.
fn stretch(main: Code, handlers: &[(u32, Code)]) -> (u64, String) {
    let mut chip = Chip::new(main, handlers);
    let functions = vec![
        (MAIN, "main".to_owned()),
        (HANDLERS, "a handler".to_owned()),
    ];
    chip.machine.count(Counting::new(functions));
    chip.run(1e-3).unwrap();
    let longest = chip.machine.masked().unwrap();
    (longest.cycles, longest.function.clone())
}

#[test]
fn the_longest_stretch_with_masked_interrupts_is_found_and_where_it_began() {
    // The instructions behind CPSID up to CPSIE.
    let main = masked(3).raw(&masked(9).halves()).raw(&masked(5).halves());
    let begins = MAIN + 2 * (1 + 3 + 1 + 1);
    let expected = (10, format!("main at {begins:#010x}"));
    assert_eq!(stretch(main.spin(), &[]), expected);
    // A mask by priority (MOV r0, #0x80; MSR basepri, r0) lasts as long as it raises the priority.
    let raised = Code::new().raw(&[0xF04F, 0x0080, 0xF380, 0x8811]);
    let lowered = raised
        .raw(&[0xBF00; 4])
        .raw(&[0xF04F, 0x0000, 0xF380, 0x8811]);
    assert_eq!(stretch(lowered.spin(), &[]).0, 6);
}

#[test]
fn a_mask_in_a_handler_of_the_highest_priority_keeps_nothing_waiting() {
    let handler = masked(9).ret();
    for (priority, cycles) in [(0x00, 0), (0x40, 10)] {
        let main = Code::new().enable(20, priority).pend(20).spin();
        assert_eq!(stretch(main, &[(36, handler.clone())]).0, cycles);
    }
}
