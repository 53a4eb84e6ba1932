//! The stack is large enough.

use hexsense::sampling::BlockSize;
use hexsense::wire::Request;

use crate::bench::Board;
use crate::set::upload;

/// Largest share of the stack that may be in use, the worst nesting of interrupts not among it by luck.
const LIMIT: f64 = 0.75;

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
    }
    let stack = board.status().stack;
    println!("stack: {stack:?}");
    assert_eq!(stack.size, 28 * 1024);
    // Tasks alone need more than nothing: the paint is there and is looked for where the stack is.
    assert!(stack.deepest > 1_000, "{stack:?}");
    let share = f64::from(stack.deepest) / f64::from(stack.size);
    assert!(share <= LIMIT, "{stack:?}");
}
