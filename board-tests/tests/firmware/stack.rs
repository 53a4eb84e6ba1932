//! The stack is large enough.

use board_tests::key_holder::calibrate;
use board_tests::line::Line;
use hexsense_core::channel::CHANNELS;
use hexsense_core::harmonics::increment;
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::{Drive, Request, Response};

use crate::{on, random};

/// Largest share of the stack that may be in use; the worst nesting of interrupts may not happen in this test.
const MAX_SHARE: f64 = 0.75;

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_quarter_of_the_stack_is_never_used() -> anyhow::Result<()> {
    let mut board = on("stack")?;
    let line = &mut board.line;
    let mut random = random();
    line.order(&Request::Rate(1_000))?;
    for block in [BlockSize::ThirtyTwo, BlockSize::Sixteen] {
        line.order(&Request::Block(block))?;
        for _ in 0..13 {
            calibrate(line, &mut random)?;
            line.stream(true, true)?;
            line.run_s(0.3)?;
            line.status()?;
        }
        solve(line, block)?;
    }
    let stack = line.status()?.stack;
    println!("stack: {stack:?}");
    assert_eq!(stack.size, 28 * 1024);
    // The tasks need some stack: the paint is there, and the firmware looks for it in the right place.
    assert!(stack.deepest > 1_000, "{stack:?}");
    let share = f64::from(stack.deepest) / f64::from(stack.size);
    assert!(share <= MAX_SHARE, "{stack:?}");
    Ok(())
}

/// Has the board solve the harmonics of every channel, and the base's motion from its poses, while it streams.
fn solve(line: &mut Line, block: BlockSize) -> anyhow::Result<()> {
    let blocks = 1_000 / block.scans() as u32;
    let drive = Drive {
        increment: increment(1.0, 1_000).unwrap(),
        block,
        settle_blocks: 0,
        blocks,
    };
    line.order(&Request::Drive { analyser: 0, drive })?;
    line.run_s(1.1)?;
    for channel in 0..CHANNELS as u8 {
        let request = Request::Harmonics {
            analyser: 0,
            channel,
        };
        let fit = line.ask(&request)?;
        assert!(matches!(fit, Response::Harmonics { .. }), "{fit:?}");
    }
    for _ in 0..10 {
        let motion = line.ask(&Request::Motion { analyser: 0 })?;
        let moved = matches!(motion, Response::Motion { motion: Ok(_), .. });
        assert!(moved, "{motion:?}");
    }
    Ok(())
}
