//! What touches the chip. The rest of the firmware is the portable core, `hexsense`.
//!
//! | room | what happens there |
//! |---|---|
//! | [`start`] | takes the parts, starts the tasks |
//! | [`clock`] | crystal → 150 MHz |
//! | [`timing`] | every timing constant, with its reason, checked while building |
//! | [`pins`] | which pin, converter, DMA channel and interrupt belongs to what |
//! | [`trigger`], [`acquisition`] | timer → converters → DMA rings → blocks of scans |
//! | [`supply`] | supply voltage and temperature, slowly |
//! | [`path`] | the sample path, in an interrupt: calibrated values, sums, blocks for the link |
//! | [`queue`] | blocks on their way to the link |
//! | [`sampling`] | the task above it: starts, rates, blocks, faults |
//! | [`link`], [`desk`], [`telemetry`] | the serial port, what each request gets for an answer, and the stream |
//! | [`pose`] | the board's own pose, from the jacks |
//! | [`harmonics`] | harmonics and calibration factors, from the path's sums |
//! | [`storage`], [`ecc`] | coefficients in flash bank 2, and what power cuts leave there |
//! | [`tallies`] | what went wrong, how often and when last |
//! | [`exchange`] | what passes between those tasks |
//! | [`supervisor`] | the watchdog |
//! | [`identity`], [`resets`], [`mod@panic`] | who the board is, why it last started and how often |
//! | [`stack`] | how much of it is used, and what an overflow ends in |
//! | [`quick_look`] | the approximate tilt |

pub mod acquisition;
pub mod clock;
pub mod desk;
pub mod ecc;
pub mod exchange;
pub mod harmonics;
pub mod identity;
pub mod link;
pub mod panic;
pub mod path;
pub mod pins;
pub mod pose;
pub mod queue;
pub mod quick_look;
pub mod resets;
pub mod sampling;
pub mod stack;
pub mod start;
pub mod storage;
pub mod supervisor;
pub mod supply;
pub mod tallies;
pub mod telemetry;
pub mod timing;
pub mod trigger;
