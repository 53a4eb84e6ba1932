//! Support of several host tests: whole campaigns without a chip, and figures.
//!
//! - [`accuracy`] measures the accuracy of the harmonic estimator.
//! - [`mod@bench`] lets the twin move and reads its voltages the way the board does, so that a campaign takes a second and
//!   a statistic over many seeds is possible. The firmware itself is tested on the virtual board.
//! - [`coverage`] is that statistic: are the stated uncertainties right?
//! - [`nor_flash`] is a flash memory whose power can be cut at any operation, and [`sets`] are stored in it; both come
//!   from the crate `hostile`, which the fuzz targets share.
//! - [`mod@reference`]: a base and a rotation matrix written out by hand.
//! - [`speed`] measures the time that kinematics takes, and [`scipy`] the time of scipy for the same poses.

pub mod accuracy;
pub mod bench;
pub mod coverage;
pub mod reference;
pub mod scipy;
pub mod speed;

pub use hostile::{nor_flash, sets};
