//! What touches the chip.
pub mod acquisition;
pub mod clock;
pub mod panic;
pub mod pins;
pub mod sampling;
pub mod timing;
pub mod trigger;
