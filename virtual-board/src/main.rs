//! virtual-board
fn main() {}
