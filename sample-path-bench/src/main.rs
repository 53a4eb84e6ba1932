//! The sample path and what others offer for the same task, on the board's core.
//!
//! Nothing is measured here: the virtual board counts the instructions of the functions by name, and
//! `cargo xtask bench sample-path` runs this program on it and puts the figures side by side. The amplitudes that each
//! estimator finds are printed on the log, as the bits of an `f64`.
//!
//! - `path`: the portable sample path, on random, saturated, alternating and zero input.
//! - `peers`: estimators from crates.io.
//! - `signal`: the signal that all estimate.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod path;
#[cfg(target_os = "none")]
mod peers;
#[cfg(target_os = "none")]
mod signal;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!(
        "this runs on the board's core only: `cargo xtask bench sample-path` builds and runs it"
    );
    std::process::exit(1);
}
