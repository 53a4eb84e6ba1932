//! The analog side of the board: voltages on the pins, temperature of the die, supply.
//!
//! They come from the twin in chunks of rows at a constant step. The board asks for a chunk when a conversion first
//! needs it, and interpolates linearly at the instant of the conversion. Without a twin every pin is at half the
//! supply.

pub mod error;
mod greeting;
pub mod pinout;
mod twin;

use std::io::{self, BufRead, BufReader, Read};
use std::net::TcpStream;

pub use self::error::PinsError;
pub use self::greeting::{BoardParameters, PROTOCOL};
pub use self::twin::Twin;

use self::greeting::{Greeting, MAX_GREETING, ProtocolOnly, board_parameters};
use self::pinout::Pin;

const NEUTRAL_SUPPLY_V: f64 = 3.3;
const NEUTRAL_TEMPERATURE_C: f64 = 30.0;

/// The pins, and their connection.
#[derive(Debug)]
pub enum Pins {
    /// Nothing: every pin is at half the supply.
    Neutral,
    /// The twin.
    Twin(Box<Twin>),
}

impl Pins {
    /// Connects to the twin and reads its greeting.
    pub fn connect(address: &str) -> Result<(Self, BoardParameters), PinsError> {
        let connect = |source| PinsError::Connect {
            address: address.to_owned(),
            source,
        };
        let stream = TcpStream::connect(address).map_err(connect)?;
        stream.set_nodelay(true).map_err(connect)?;
        let mut stream = BufReader::with_capacity(1 << 16, stream);
        let mut line = String::new();
        let greeting = |source| PinsError::Greeting {
            address: address.to_owned(),
            source,
        };
        stream
            .by_ref()
            .take(MAX_GREETING)
            .read_line(&mut line)
            .map_err(greeting)?;
        if !line.ends_with('\n') {
            return Err(greeting(io::ErrorKind::UnexpectedEof.into()));
        }
        let ProtocolOnly { protocol } = serde_json::from_str(&line)?;
        if protocol != PROTOCOL {
            return Err(PinsError::Protocol { found: protocol });
        }
        let greeting: Greeting = serde_json::from_str(&line)?;
        let parameters = board_parameters(&greeting.board)?;
        Ok((
            Self::Twin(Box::new(Twin::new(stream, &greeting)?)),
            parameters,
        ))
    }

    /// Voltage on a pin at true time `at_s`, V.
    pub fn voltage(&mut self, pin: Pin, at_s: f64) -> f64 {
        match self {
            Self::Neutral => NEUTRAL_SUPPLY_V / 2.0,
            Self::Twin(twin) => twin
                .voltage(pin, at_s)
                .unwrap_or_else(|| twin.supply_v(at_s) / 2.0),
        }
    }

    /// Temperature of the die at true time `at_s`, °C.
    pub fn temperature_c(&mut self, at_s: f64) -> f64 {
        match self {
            Self::Neutral => NEUTRAL_TEMPERATURE_C,
            Self::Twin(twin) => twin.temperature_c(at_s),
        }
    }

    /// Supply at true time `at_s`, V.
    pub fn supply_v(&mut self, at_s: f64) -> f64 {
        match self {
            Self::Neutral => NEUTRAL_SUPPLY_V,
            Self::Twin(twin) => twin.supply_v(at_s),
        }
    }

    /// Whether the twin has failed.
    pub fn failed(&self) -> bool {
        matches!(self, Self::Twin(twin) if twin.failure.is_some())
    }

    /// Returns the reason why the twin has failed. The voltages then stay at their last values.
    pub fn take_failure(&mut self) -> Option<PinsError> {
        match self {
            Self::Neutral => None,
            Self::Twin(twin) => twin.failure.take(),
        }
    }
}
