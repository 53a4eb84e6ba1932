//! The errors of the connection to the twin.

use std::io;

use thiserror::Error;

/// The protocol that this board speaks.
pub const PROTOCOL: &str = "hexsense-pins 1";

/// Why the twin cannot be used.
#[derive(Debug, Error)]
pub enum PinsError {
    /// The address cannot be connected to.
    #[error(
        "no twin at {address}: {source} (is it running, and is --pins the address that it printed?)"
    )]
    Connect {
        /// The address.
        address: String,
        /// What the system said.
        source: io::Error,
    },
    /// The greeting did not come.
    #[error("the twin at {address} sent no greeting: {source}")]
    Greeting {
        /// The address.
        address: String,
        /// What the system said.
        source: io::Error,
    },
    /// The greeting is not JSON of the expected shape.
    #[error("the greeting of the twin cannot be read: {0}")]
    Malformed(#[from] serde_json::Error),
    /// The twin speaks another version.
    #[error(
        "the twin speaks \"{found}\", this board \"{PROTOCOL}\": use twin and virtual-board of one version"
    )]
    Protocol {
        /// The protocol in its greeting.
        found: String,
    },
    /// A value in the greeting is out of range.
    #[error("the greeting of the twin: {name} is {value}, but must be {limit}")]
    Value {
        /// The key.
        name: &'static str,
        /// The value found.
        value: String,
        /// The allowed values.
        limit: &'static str,
    },
    /// The connection broke.
    #[error("the twin went away at {at_s:.3} s of virtual time: {source}")]
    Lost {
        /// True time of the request, s.
        at_s: f64,
        /// What the system said.
        source: io::Error,
    },
}

/// Makes an error of an invalid value of the greeting.
pub(super) fn check(
    valid: bool,
    name: &'static str,
    value: impl ToString,
    limit: &'static str,
) -> Result<(), PinsError> {
    if valid {
        Ok(())
    } else {
        Err(PinsError::Value {
            name,
            value: value.to_string(),
            limit,
        })
    }
}
