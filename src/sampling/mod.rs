//! Sampling: trigger → converters → rings → sample interrupt, and the tasks around it.
//!
//! | file | what happens there |
//! |---|---|
//! | [`acquisition`] | timer → converters → DMA rings → blocks of scans |
//! | [`path`] | the sample interrupt: calibrated values, sums, blocks for the link |
//! | [`task`] | the task above it: starts, rates, blocks, faults |
//! | [`self_calibration`] | one factor of each converter for each power-up |
//! | [`supply`] | supply voltage and temperature, slowly |

pub mod acquisition;
pub mod path;
mod self_calibration;
pub mod supply;
pub mod task;
