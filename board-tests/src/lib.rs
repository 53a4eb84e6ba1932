//! The firmware's own ELF on the virtual board: how large it is, how long it takes, and what it withstands.
//!
//! Measurements, each a subcommand of the program `board-tests`:
//!
//! - [`size`]: flash and RAM by module.
//! - [`timing`]: instructions of the firmware while it is busy, and its share of the core.
//! - [`sample_path`]: instructions of the sample path for every size of block, beside what others offer.
//! - [`fixed_time`]: the sample path has no instruction whose time depends on its operands.
//! - [`faults`]: faults are injected, and every promise of `docs/guarantees.md` is judged.
//! - [`demo`]: a whole calibration with twin, board and host tool.
//!
//! The board, for these and for the tests:
//!
//! - [`programs`]: where the built programs are; [`process`] runs them.
//! - [`power`]: one way to switch the virtual board on. On it stand [`mod@bench`], a board that is spoken to frame by frame,
//!   and [`virtual_bench`], a board with twin and host tool. [`pins`] gives it voltages without a twin.
//! - [`line`](mod@line): the serial line to the board, over the frames of [`hexsense_client`].
//! - [`key_holder`]: changes of what the board keeps; [`trial_set`] draws coefficients.
//! - [`symbols`]: where the firmware keeps what.
//! - [`counts`]: instructions that the virtual board counted.
//! - [`figures`]: figures printed as a table or as JSON, and judged.
#![forbid(unsafe_code)]

pub mod bench;
pub mod counts;
#[cfg(feature = "host-tool")]
pub mod demo;
#[cfg(feature = "host-tool")]
pub mod faults;
pub mod figures;
pub mod fixed_time;
pub mod folders;
pub mod key_holder;
pub mod line;
pub mod pins;
pub mod power;
pub mod process;
pub mod programs;
pub mod sample_path;
pub mod size;
pub mod symbols;
pub mod timing;
pub mod trial_set;
#[cfg(feature = "host-tool")]
pub mod virtual_bench;
