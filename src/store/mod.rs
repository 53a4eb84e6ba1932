//! The coefficients as the board keeps them: the record, and its place in flash.
//!
//! - [`record`]: a [`CoefficientSet`], its identity and its bytes with a checksum.
//! - [`flash`]: the last eight sets in flash; the newest valid one is active.

pub mod flash;
pub mod record;

pub use flash::{Archive, ArchiveError, Stored};
pub use record::{CoefficientSet, MAX_ENCODED, RecordError, SetId, TriadCoefficients};
