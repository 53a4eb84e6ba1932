//! The stack is large enough.

use hexsense_core::channel::CHANNELS;
use hexsense_core::harmonics::increment;
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::{Drive, Request, Response};

use crate::bench::Board;
use crate::set::upload;

/// Largest share of the stack that may be in use, the worst nesting of interrupts not among it by luck.
const MAX_SHARE: f64 = 0.75;

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_quarter_of_the_stack_is_never_used() {
    let mut board = Board::on("stack");
    board.order(&Request::Rate(1_000));
    for block in [BlockSize::ThirtyTwo, BlockSize::Sixteen] {
        board.order(&Request::Block(block));
        for unix_s in 0..13 {
            upload(&mut board, unix_s);
            board.stream(true, true);
            board.run_s(0.3);
            board.status();
        }
        solve(&mut board, block);
    }
    let stack = board.status().stack;
    println!("stack: {stack:?}");
    assert_eq!(stack.size, 28 * 1024);
    // Tasks alone need more than nothing: the paint is there and is looked for where the stack is.
    assert!(stack.deepest > 1_000, "{stack:?}");
    let share = f64::from(stack.deepest) / f64::from(stack.size);
    assert!(share <= MAX_SHARE, "{stack:?}");
}

/// Has the board solve the harmonics of every channel, and the base's motion from its poses, while it streams.
fn solve(board: &mut Board, block: BlockSize) {
    let blocks = 1_000 / block.scans() as u32;
    let drive = Drive {
        increment: increment(1.0, 1_000).unwrap(),
        block,
        settle_blocks: 0,
        blocks,
    };
    board.order(&Request::Drive { analyser: 0, drive });
    board.run_s(1.1);
    for channel in 0..CHANNELS as u8 {
        let request = Request::Harmonics {
            analyser: 0,
            channel,
        };
        let fit = board.ask(&request);
        assert!(matches!(fit, Response::Harmonics { .. }), "{fit:?}");
    }
    for _ in 0..10 {
        let motion = board.ask(&Request::Motion { analyser: 0 });
        let moved = matches!(motion, Response::Motion { motion: Ok(_), .. });
        assert!(moved, "{motion:?}");
    }
}
