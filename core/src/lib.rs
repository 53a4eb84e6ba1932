//! The portable core of hexsense: everything about calibrating inertial sensors on a six-degree-of-freedom motion
//! base that needs no chip, no file and no clock.
//!
//! The house, in the order in which data flows through it:
//!
//! | room | what happens there |
//! |---|---|
//! | [`kinematics`] | jack lengths ↔ pose of the platform |
//! | [`excitation`] | program signals, turned into six jack programs |
//! | [`facts`] | what differs from board to board |
//! | [`channel`] | the fifteen channels of a scan and their order |
//! | [`sampling`] | counts → calibrated values, in fixed time |
//! | [`transducers`] | jack counts → jack lengths |
//! | [`live_pose`] | jack counts → the board's own pose |
//! | [`live_motion`] | harmonics of the jacks → amplitude of the pose, and calibration factors |
//! | [`harmonics`] | amplitude and phase at the drive frequency |
//! | [`least_squares`] | the linear fit behind harmonics and calibration |
//! | [`calibration`] | zero, static holds, heave and sine runs → offsets, matrices, uncertainties |
//! | [`records`] | the coefficient record, the log of changes and the key, each with its place in flash |
//! | [`authority`] | who may change them |
//! | [`storage`] | changes of them, whole or not at all, each with its entry in the log |
//! | [`sample_path`] | a block of scans → values, sums, and the queue of the link |
//! | [`server`] | the answer to each request, and the stream |
//! | `bytes` | arrays of bytes in messages and records |
//! | [`checksum`](mod@checksum) | CRC-32 of records and frames, SHA-256 |
//! | [`wire`] | the serial link's messages and frames, used by both sides |
//!
//! Frames, angles and words are those of GOST 20058-80: X forward, Y up, Z right; see [`kinematics`].
#![no_std]
#![forbid(unsafe_code)]

pub mod authority;
mod bytes;
pub mod calibration;
pub mod channel;
pub mod checksum;
pub mod excitation;
pub mod facts;
pub mod harmonics;
pub mod kinematics;
pub mod least_squares;
pub mod live_motion;
pub mod live_pose;
pub mod records;
pub mod sample_path;
pub mod sampling;
pub mod server;
pub mod storage;
pub mod transducers;
pub mod wire;
