//! The analog side of the board: voltages on the pins, temperature of the die, supply.
//!
//! They come from the twin in chunks of rows at a constant step, asked for when a conversion first needs one, and are
//! interpolated linearly at the instant of the conversion. Without a twin every pin is at half the supply.

use std::collections::HashMap;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::TcpStream;

use serde::Deserialize;
use thiserror::Error;

use super::pinout::Pin;
use crate::peripherals::adc::Imperfection;

/// The protocol that this board speaks.
pub const PROTOCOL: &str = "hexsense-pins 1";
/// Number of converters in the chip.
pub const CONVERTERS: usize = 5;

const NEXT_CHUNK: u8 = b'N';
const MAX_GREETING: u64 = 1 << 20;
const MAX_VALUES: usize = 1 << 22;

const NEUTRAL_SUPPLY_V: f64 = 3.3;
const NEUTRAL_TEMPERATURE_C: f64 = 30.0;

/// What differs from one board to another.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardParameters {
    /// Seed of noise and random numbers.
    pub seed: u64,
    /// Unique identifier of the chip.
    pub unique_id: [u8; 12],
    /// Error of the crystal, 1e-6.
    pub clock_ppm: f64,
    /// Internal reference, V.
    pub vrefint_v: f64,
    /// ADC1 to ADC5.
    pub adc: [Imperfection; CONVERTERS],
}

impl BoardParameters {
    /// A typical board: nothing is off, the converters have the noise of the data sheet.
    pub fn neutral(seed: u64) -> Self {
        let imperfection = Imperfection {
            gain_error: 0.0,
            offset_lsb: 0.0,
            noise_lsb: 1.5,
        };
        Self {
            seed,
            unique_id: *b"hexsense 474",
            clock_ppm: 0.0,
            vrefint_v: 1.212,
            adc: [imperfection; CONVERTERS],
        }
    }
}

/// Why the twin cannot be used, or no longer.
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
    /// The greeting is not JSON of the expected form.
    #[error("the greeting of the twin cannot be read: {0}")]
    Malformed(#[from] serde_json::Error),
    /// The twin speaks another version.
    #[error(
        "the twin speaks \"{found}\", this board \"{PROTOCOL}\": use twin and virtual-board of one version"
    )]
    Protocol {
        /// What it said.
        found: String,
    },
    /// A value in the greeting makes no sense.
    #[error("the greeting of the twin: {name} is {value}, but must be {limit}")]
    Value {
        /// The key.
        name: &'static str,
        /// The value found.
        value: String,
        /// What is allowed.
        limit: &'static str,
    },
    /// The connection broke.
    #[error("the twin went away at {at_s:.3} s of virtual time: {source}")]
    Lost {
        /// True time that was asked for, s.
        at_s: f64,
        /// What the system said.
        source: io::Error,
    },
}

#[derive(Deserialize)]
struct ProtocolOnly {
    protocol: String,
}

#[derive(Deserialize)]
struct Greeting {
    step_s: f64,
    chunk_steps: usize,
    columns: Vec<String>,
    board: GreetingBoard,
}

#[derive(Deserialize)]
struct GreetingBoard {
    seed: u64,
    uid: String,
    clock_ppm: f64,
    vrefint_v: f64,
    adc: Vec<GreetingAdc>,
}

#[derive(Deserialize)]
struct GreetingAdc {
    gain_error: f64,
    offset_lsb: f64,
    noise_lsb: f64,
}

/// The pins, and what is connected to them.
#[derive(Debug)]
pub enum Pins {
    /// Nothing: every pin is at half the supply.
    Neutral,
    /// The twin.
    Twin(Box<Twin>),
}

/// A connection to the twin.
#[derive(Debug)]
pub struct Twin {
    stream: BufReader<TcpStream>,
    step_s: f64,
    chunk_steps: usize,
    width: usize,
    columns: HashMap<Pin, usize>,
    temperature_column: usize,
    supply_column: usize,
    /// The chunk asked for last and the one before it; conversions end a little out of order.
    chunks: [Vec<f32>; 2],
    /// Number of chunks asked for.
    received: usize,
    failure: Option<PinsError>,
}

impl Pins {
    /// Connects to the twin and hears what is soldered where.
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
            Self::Twin(twin) => match twin.columns.get(&pin) {
                Some(&column) => twin.value(column, at_s),
                None => twin.value(twin.supply_column, at_s) / 2.0,
            },
        }
    }

    /// Temperature of the die at true time `at_s`, °C.
    pub fn temperature_c(&mut self, at_s: f64) -> f64 {
        match self {
            Self::Neutral => NEUTRAL_TEMPERATURE_C,
            Self::Twin(twin) => twin.value(twin.temperature_column, at_s),
        }
    }

    /// Supply at true time `at_s`, V.
    pub fn supply_v(&mut self, at_s: f64) -> f64 {
        match self {
            Self::Neutral => NEUTRAL_SUPPLY_V,
            Self::Twin(twin) => twin.value(twin.supply_column, at_s),
        }
    }

    /// Whether the twin is of no more use.
    pub fn failed(&self) -> bool {
        matches!(self, Self::Twin(twin) if twin.failure.is_some())
    }

    /// Collects the reason why the twin is of no more use. The voltages stay at their last values then.
    pub fn take_failure(&mut self) -> Option<PinsError> {
        match self {
            Self::Neutral => None,
            Self::Twin(twin) => twin.failure.take(),
        }
    }
}

impl Twin {
    fn new(stream: BufReader<TcpStream>, greeting: &Greeting) -> Result<Self, PinsError> {
        let width = greeting.columns.len();
        let values = greeting
            .chunk_steps
            .checked_add(1)
            .and_then(|rows| rows.checked_mul(width));
        check(
            greeting.step_s.is_finite() && greeting.step_s > 0.0,
            "step_s",
            greeting.step_s,
            "more than zero",
        )?;
        check(
            greeting.chunk_steps > 0,
            "chunk_steps",
            greeting.chunk_steps,
            "at least 1",
        )?;
        check(
            values.is_some_and(|values| values <= MAX_VALUES),
            "chunk_steps",
            greeting.chunk_steps,
            "smaller",
        )?;
        let column = |name: &'static str| {
            let found = greeting.columns.iter().position(|column| column == name);
            found.ok_or(PinsError::Value {
                name: "columns",
                value: greeting.columns.join(" "),
                limit: name,
            })
        };
        Ok(Self {
            stream,
            step_s: greeting.step_s,
            chunk_steps: greeting.chunk_steps,
            width,
            columns: greeting
                .columns
                .iter()
                .enumerate()
                .filter_map(|(index, name)| Pin::parse(name).map(|pin| (pin, index)))
                .collect(),
            temperature_column: column("temp_c")?,
            supply_column: column("vdda_v")?,
            chunks: [vec![], vec![]],
            received: 0,
            failure: None,
        })
    }

    fn value(&mut self, column: usize, at_s: f64) -> f64 {
        let position = (at_s / self.step_s).max(0.0);
        let chunk_steps = self.chunk_steps;
        let known = |received: usize| received > 0 && position <= (received * chunk_steps) as f64;
        while !known(self.received) && self.failure.is_none() {
            if let Err(source) = self.fetch() {
                self.failure = Some(PinsError::Lost { at_s, source });
            }
        }
        let row = position as usize;
        let newest = self.received.saturating_sub(1) * self.chunk_steps;
        let (chunk, first) = if row >= newest || self.chunks[1].is_empty() {
            (&self.chunks[0], newest)
        } else {
            (&self.chunks[1], newest - self.chunk_steps)
        };
        let row = row.saturating_sub(first).min(self.chunk_steps - 1);
        let at = |row: usize| {
            chunk
                .get(row * self.width + column)
                .map_or(0.0, |value| f64::from(*value))
        };
        let fraction = (position - (first + row) as f64).clamp(0.0, 1.0);
        at(row) + fraction * (at(row + 1) - at(row))
    }

    fn fetch(&mut self) -> io::Result<()> {
        self.stream.get_mut().write_all(&[NEXT_CHUNK])?;
        let mut bytes = vec![0; 4 * self.width * (self.chunk_steps + 1)];
        self.stream.read_exact(&mut bytes)?;
        self.chunks.swap(0, 1);
        self.chunks[0].clear();
        let values = bytes
            .chunks_exact(4)
            .map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]]));
        self.chunks[0].extend(values);
        self.received += 1;
        Ok(())
    }
}

fn board_parameters(board: &GreetingBoard) -> Result<BoardParameters, PinsError> {
    let unique_id = parse_hex(&board.uid).ok_or(PinsError::Value {
        name: "board.uid",
        value: board.uid.clone(),
        limit: "24 hexadecimal digits",
    })?;
    check(
        board.clock_ppm.abs() < 1e5,
        "board.clock_ppm",
        board.clock_ppm,
        "less than 1e5",
    )?;
    check(
        (0.1..3.0).contains(&board.vrefint_v),
        "board.vrefint_v",
        board.vrefint_v,
        "within 0.1 to 3 V",
    )?;
    check(
        board.adc.len() == CONVERTERS,
        "number of entries in board.adc",
        board.adc.len(),
        "5",
    )?;
    let adc = std::array::from_fn(|index| Imperfection {
        gain_error: board.adc[index].gain_error,
        offset_lsb: board.adc[index].offset_lsb,
        noise_lsb: board.adc[index].noise_lsb,
    });
    Ok(BoardParameters {
        seed: board.seed,
        unique_id,
        clock_ppm: board.clock_ppm,
        vrefint_v: board.vrefint_v,
        adc,
    })
}

fn check(
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

fn parse_hex(digits: &str) -> Option<[u8; 12]> {
    let mut bytes = [0; 12];
    if digits.len() != 24 || !digits.is_ascii() {
        return None;
    }
    for (byte, pair) in bytes.iter_mut().zip(digits.as_bytes().chunks_exact(2)) {
        *byte = u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()?;
    }
    Some(bytes)
}
