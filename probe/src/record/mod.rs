//! Recording: from the board's stream to files.
//!
//! ```text
//! board ── recorder ─┬─ sinks: the CSV file
//!                    └─ run: rest, onset, end of a run │ timed: a recording of a given length
//! ```
//!
//! - [`recorder`]: the one owner of the stream, which finds the gaps in it.
//! - [`sink`]: the interface of what takes a recording. [`csv`] is the one that writes a [capture](crate::capture).
//! - [`timed`]: a recording of a given length, outside of campaigns.
//! - [`run`]: one run of a campaign. [`drives`] chooses what the board estimates in it, [`jacks`] averages the jacks,
//!   [`rest`] sees the base at rest, and [`onset`] sees it move.
//! - [`sequence`]: the runs of a campaign, one after another.
//! - [`board`]: the board as a recording needs it. [`reconnect`] waits for one that went away.
//! - [`event`]: what happens during a recording, for the program that shows it.
//! - `error`: why a recording breaks off.

pub mod board;
pub mod csv;
pub mod drives;
mod error;
pub mod event;
pub mod jacks;
pub mod onset;
pub mod reconnect;
pub mod recorder;
pub mod rest;
pub mod run;
pub mod sequence;
pub mod sink;
pub mod timed;

pub use error::RecordError;
