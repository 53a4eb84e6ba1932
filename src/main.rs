//! The firmware: takes the chip's parts, gives them to the tasks, and starts those in the order of urgency.
//!
//! | runs in | tasks |
//! |---|---|
//! | an interrupt of priority 0 | sample interrupt |
//! | an interrupt of priority 4 | sampling task |
//! | an interrupt of priority 8 | link |
//! | thread mode | pose, harmonics, storage, supply, watchdog |
//!
//! | room | what happens there |
//! |---|---|
//! | `start` | takes the parts, starts the tasks |
//! | `chip` | clock, pins, trigger, timing constants, identity |
//! | `sampling` | trigger → converters → sample interrupt; supply and temperature |
//! | `link` | the serial port, and the board behind the core's server |
//! | `storage` | coefficients, key and log in flash bank 2 |
//! | `pose`, `harmonics` | the board's own pose; harmonics and calibration factors |
//! | `health` | watchdog, resets, panic, stack, flash errors, counters |
//! | `shared` | what passes between the tasks |
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod chip;
#[cfg(target_os = "none")]
mod harmonics;
#[cfg(target_os = "none")]
mod health;
#[cfg(target_os = "none")]
mod link;
#[cfg(target_os = "none")]
mod pose;
#[cfg(target_os = "none")]
mod sampling;
#[cfg(target_os = "none")]
mod shared;
#[cfg(target_os = "none")]
mod start;
#[cfg(target_os = "none")]
mod storage;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("the firmware runs on the board only: build it with `cargo firmware`");
    std::process::exit(1);
}
