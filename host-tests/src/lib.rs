//! What several host tests need: whole campaigns without a chip.
//!
//! [`bench`] lets the twin move and read its voltages the way the board does, so that a campaign takes a fraction of
//! a second and a statistic over many seeds is possible. The firmware itself is tested on the virtual board.

pub mod bench;
