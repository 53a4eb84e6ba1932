//! The stack: how much of it is used, and what happens when it overflows.
//!
//! ```text
//! 0x2000_0000 ┬ _stack_end    nothing below it can be written: an overflow faults
//!             │ painted at the start; where the paint remains it was never used
//! 0x2000_7000 ┴ _stack_start
//! ```
//!
//! Tasks, interrupts and faults share it. After an overflow the frame of the fault cannot be stacked either. The core
//! enters the hard fault with a stack pointer at which nothing can be pushed; the first function would fault again, and
//! the core would lock up. So the hard fault begins with a few instructions that need no stack. They give it the whole
//! stack anew, whose content is lost anyway. From there on it is a panic like any other, kept for the host.

use core::arch::naked_asm;
use core::ptr::addr_of;

use cortex_m_rt::{ExceptionFrame, STACK_PAINT_VALUE};
use hexsense_core::wire::status::StackUse;

use super::panic::{self, Text};

/// Bytes that the panic needs; where fewer are left, the hard fault takes the whole stack.
const FOR_PANIC: usize = 2_048;
/// A push of many registers that does not fit leaves the stack pointer where it was: up to so many bytes, with the
/// fault's frame, still count as an overflow.
const MAX_PUSH: usize = 256;
/// Bits of CFSR: a frame could not be stacked (MSTKERR, STKERR).
const NOT_STACKED: u32 = 1 << 4 | 1 << 12;

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Most of the stack that was in use since the start.
pub fn usage() -> StackUse {
    let (bottom, top) = (addr_of!(_stack_end), addr_of!(_stack_start));
    let mut lowest = bottom;
    // SAFETY: only words of the stack's own RAM are read, volatile: they may belong to functions that are running.
    unsafe {
        while lowest < top && lowest.read_volatile() == STACK_PAINT_VALUE {
            lowest = lowest.add(1);
        }
    }
    StackUse {
        deepest: (top.addr() - lowest.addr()) as u32,
        size: (top.addr() - bottom.addr()) as u32,
    }
}

/// The vector of the hard fault.
// SAFETY: the linker script of cortex-m-rt wants this symbol, and no other has the name.
#[unsafe(export_name = "HardFault")]
#[unsafe(naked)]
unsafe extern "C" fn enter_hard_fault() -> ! {
    naked_asm!(
        "mrs r0, msp",
        "movw r1, #:lower16:_stack_end",
        "movt r1, #:upper16:_stack_end",
        "add.w r1, r1, #{for_panic}",
        "cmp r0, r1",
        "bhs 1f",
        "movw r1, #:lower16:_stack_start",
        "movt r1, #:upper16:_stack_start",
        "msr msp, r1",
        "1: b {hard_fault}",
        for_panic = const FOR_PANIC,
        hard_fault = sym hard_fault,
    )
}

/// Tells a stack overflow from another fault; `frame` is where the stack pointer was on entry.
unsafe extern "C" fn hard_fault(frame: *const ExceptionFrame) -> ! {
    // SAFETY: the register is only read.
    let status = unsafe { (*cortex_m::peripheral::SCB::PTR).cfsr.read() };
    let bottom = addr_of!(_stack_end).addr();
    if status & NOT_STACKED != 0 || frame.addr() < bottom {
        panic::stop(Text::new("stack overflow"));
    }
    // SAFETY: the core has stacked a frame there; where the stack was given anew, it lies far below what is used now.
    let frame = unsafe { &*frame };
    if core::ptr::from_ref(frame).addr() < bottom + MAX_PUSH {
        panic::stop(Text::new("stack overflow at 0x").hexadecimal(frame.pc()));
    }
    panic::stop(
        Text::new("hard fault at 0x")
            .hexadecimal(frame.pc())
            .then(", called from 0x")
            .hexadecimal(frame.lr()),
    )
}
