//! What the board is connected to: the twin at its analog pins, and the host at its serial port
//! (`docs/virtual-bench.md`).

pub mod cable;
mod door;
pub mod link;
pub mod lockstep;
pub mod pinout;
pub mod pins;
