//! The serial link's language, spoken by the board and by the host.
//!
//! The host asks, the board answers each request once with the request's sequence number, and between answers the
//! board sends telemetry by itself. Every message travels in one frame ([`frame`]):
//!
//! ```text
//! COBS( | kind u8 | sequence u16 LE | payload | CRC-32 u32 LE | ) 00
//! ```
//!
//! | kind | direction | payload |
//! |---|---|---|
//! | hello | host → board | none; its shape never changes |
//! | greeting | board → host | [`hello::Greeting`]; its shape never changes |
//! | request | host → board | postcard of [`Request`] |
//! | response | board → host | postcard of [`Response`] |
//! | block | board → host | [`telemetry`] |
//! | pose | board → host | postcard of [`pose::PoseReport`] |
//!
//! Everything but hello and greeting may change; a change raises [`VERSION`].

pub mod change;
pub mod frame;
pub mod hello;
pub mod log;
pub mod message;
pub mod pose;
pub mod refusal;
pub mod status;
pub mod telemetry;

pub use crate::harmonics::{AnalyserState, Drive};
pub use frame::{Frame, FrameError, Kind, MAX_FRAME, MAX_PAYLOAD};
pub use message::{Identity, Request, Response, StreamContent};
pub use pose::{BoardPose, PoseRefusal, PoseReport};
pub use refusal::Refusal;
pub use status::Status;

/// Version of everything on the wire but hello and greeting.
pub const VERSION: u16 = 6;
