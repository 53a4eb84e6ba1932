//! The coefficients on the board: the record, and its place in flash.
//!
//! - [`record`]: a [`CoefficientSet`], its identity and its bytes with a checksum.
//! - [`base`]: the motion base and its jack transducers in a set.
//! - [`flash`]: the last eight sets in flash; the newest valid one is active.
//! - [`log`]: every change, appended and never erased.
//! - [`build`]: the identity of the firmware, which sets and log entries name.
//! - [`key`]: the secret that every change needs.

pub mod base;
pub mod build;
pub mod flash;
pub mod key;
pub mod log;
mod reading;
pub mod record;

pub use base::{BaseError, JackCoefficients, MotionBase};
pub use build::BuildId;
pub use flash::{Archive, ArchiveError, History, Stored};
pub use log::Entry;
pub use record::{CoefficientSet, MAX_ENCODED, MAX_VALUE, RecordError, SetId, TriadCoefficients};
