//! The client of the board's serial protocol.
//!
//! From the bytes up:
//!
//! - [`transport`]: what a way to the board can do, and what goes wrong on it. The ways are a serial device (`serial`), a
//!   socket (`tcp`, over `stream`) and a virtual board in lockstep (`lockstep`); [`port`] opens one by its name, and
//!   [`users`] finds the process that uses it already.
//! - [`line`](mod@line): frames with their time of arrival. Tests of the board stand on it too.
//! - `conversation`: which answer belongs to which request, and what happens when one is lost.
//! - [`bounds`]: which numbers a board can say.
//! - [`client`]: one function for each request.
//! - [`change`], [`upload`]: changes that the board makes only for the holder of its key.
//! - [`proof`]: the board proves to the holder of its key that it has the key, too.
//!
//! Three kinds of failure are three types: what the line did ([`TransportError`]), what the board refused
//! ([`hexsense_core::wire::Refusal`]), and what the host could not make sense of ([`ProtocolError`]).
//!
//! A connection changes nothing on the board: it only greets. A stream that another process started goes on.

#![forbid(unsafe_code)]

pub mod bounds;
pub mod change;
pub mod client;
mod conversation;
mod error;
pub mod line;
mod lockstep;
mod missing;
pub mod port;
pub mod proof;
mod request_name;
mod serial;
mod stream;
mod tcp;
pub mod transport;
pub mod upload;
pub mod users;

pub use change::ChangeError;
pub use client::Client;
pub use conversation::Contact;
pub use error::{LinkError, ProtocolError};
pub use proof::ProofError;
pub use transport::{Transport, TransportError};
pub use upload::UploadError;
