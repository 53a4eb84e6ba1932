//! The chip: its clock, which part belongs to what, and who it says it is.

pub mod clock;
pub mod identity;
pub mod option_bytes;
pub mod pins;
pub mod random;
pub mod timing;
pub mod trigger;
