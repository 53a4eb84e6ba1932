//! The firmware: takes the chip's parts, gives them to the tasks, and starts those in the order of urgency.
//!
//! | runs in | tasks |
//! |---|---|
//! | an interrupt of priority 4 | sample path |
//! | an interrupt of priority 8 | link |
//! | thread mode | pose, storage, supply, supervisor |
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod board;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("the firmware runs on the board only: build it with `cargo firmware`");
    std::process::exit(1);
}
