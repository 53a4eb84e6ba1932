//! Faults, their status, and the end.

use super::code::Code;
use super::{Chip, HANDLER_SPACE, HANDLERS, MAIN};
use virtual_board::machine::Stop;
use virtual_board::machine::faults::{Fault, Halt};

const HARD_FAULT: u32 = 3;
const CFSR: u32 = 0xE000_ED28;
const HFSR: u32 = 0xE000_ED2C;
const BFAR: u32 = 0xE000_ED38;

fn halt(stop: Result<(), Stop>) -> Halt {
    match stop {
        Err(Stop::Halted(halt)) => *halt,
        other => panic!("{other:?}"),
    }
}

/// A handler that saves the fault registers and stays.
fn reporter() -> Code {
    Code::new()
        .fetch(0, CFSR)
        .save(0, 0)
        .fetch(0, HFSR)
        .save(1, 0)
        .fetch(0, BFAR)
        .save(2, 0)
        .spin()
}

#[test]
fn an_undefined_instruction_escalates_and_the_end_names_where_it_was() {
    let main = Code::new().raw(&[0xBF00, 0xDE00]);
    let mut chip = Chip::new(main, &[(HARD_FAULT, reporter())]);
    let halt = halt(chip.run(1.0));
    assert_eq!(chip.result(0), 1 << 16, "UNDEFINSTR");
    assert_eq!(chip.result(1), 1 << 30, "FORCED");
    assert_eq!(halt.reason, Fault::Spinning);
    assert_eq!(halt.handler, "HardFault");
    let text = halt.to_string();
    assert!(
        text.contains("undefined instruction") && text.contains(&format!("{:#010x}", MAIN + 2)),
        "{text}"
    );
}

#[test]
fn a_usage_fault_handler_that_is_enabled_gets_the_fault() {
    let main = Code::new().store(0xE000_ED24, 1 << 18).raw(&[0xDE00]);
    let mut chip = Chip::new(main, &[(6, Code::new().load(0, 77).save(0, 0).spin())]);
    assert_eq!(halt(chip.run(1e-3)).handler, "UsageFault");
    assert_eq!(chip.result(0), 77);
}

#[test]
fn an_access_to_nothing_is_a_precise_bus_fault() {
    let main = Code::new().fetch(0, 0x6000_0010).spin();
    let mut chip = Chip::new(main, &[(HARD_FAULT, reporter())]);
    halt(chip.run(1.0));
    assert_eq!(chip.result(0), 1 << 9 | 1 << 15, "PRECISERR, BFARVALID");
    assert_eq!(chip.result(2), 0x6000_0010);
}

#[test]
fn a_stack_that_runs_out_of_ram_faults() {
    // msr msp, 0x20000004; push {r4-r7, lr}
    let main = Code::new()
        .load(0, 0x2000_0004)
        .raw(&[0xF380, 0x8808, 0xB5F0])
        .spin();
    let mut chip = Chip::new(main, &[(HARD_FAULT, reporter())]);
    halt(chip.run(1.0));
    // The push fails, and then the stacking of the HardFault itself, whose handler runs all the same.
    assert_eq!(chip.result(0) & (1 << 9 | 1 << 12), 1 << 9 | 1 << 12);
}

#[test]
fn a_jump_to_an_even_address_is_an_invalid_state() {
    let main = Code::new().load(0, MAIN).raw(&[0x4700]);
    let mut chip = Chip::new(main, &[(HARD_FAULT, reporter())]);
    halt(chip.run(1.0));
    assert_eq!(chip.result(0), 1 << 17);
}

#[test]
fn a_jump_to_nowhere_is_a_fetch_error() {
    let main = Code::new().load(0, 0x6000_0001).raw(&[0x4700]);
    let mut chip = Chip::new(main, &[(HARD_FAULT, reporter())]);
    halt(chip.run(1.0));
    assert_eq!(chip.result(0), 1 << 8);
}

#[test]
fn a_fault_within_hard_fault_locks_up() {
    let handler = Code::new().raw(&[0xDE00]);
    let mut chip = Chip::new(Code::new().raw(&[0xDE00]), &[(HARD_FAULT, handler)]);
    let halt = halt(chip.run(1.0));
    assert_eq!(halt.reason, Fault::UndefinedInstruction);
    assert_eq!(halt.pc, HANDLERS + HARD_FAULT * HANDLER_SPACE);
}

#[test]
fn spinning_with_interrupts_masked_is_the_end_and_with_them_open_is_not() {
    let mut open = Chip::new(Code::new().spin(), &[]);
    open.run(0.1).unwrap();
    let mut masked = Chip::new(Code::new().raw(&[0xB672]).spin(), &[]);
    assert_eq!(halt(masked.run(0.1)).reason, Fault::Spinning);
}

#[test]
fn a_breakpoint_without_debugger_is_a_hard_fault() {
    let mut chip = Chip::new(Code::new().raw(&[0xBE00]), &[(HARD_FAULT, reporter())]);
    halt(chip.run(1.0));
    assert_eq!(chip.result(1), 1 << 31, "DEBUGEVT");
}
