//! The connection to the twin: chunks of rows, and the voltages between them.

use std::collections::HashMap;
use std::io::{self, BufReader, Read, Write};
use std::net::TcpStream;

use super::error::{PinsError, check};
use super::greeting::Greeting;
use super::pinout::Pin;

const NEXT_CHUNK: u8 = b'N';
const MAX_VALUES: usize = 1 << 22;

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
    /// The latest chunk and the one before it; conversions end a little out of order.
    chunks: [Vec<f32>; 2],
    /// Number of chunks received.
    received: usize,
    pub(super) failure: Option<PinsError>,
}

impl Twin {
    pub(super) fn new(
        stream: BufReader<TcpStream>,
        greeting: &Greeting,
    ) -> Result<Self, PinsError> {
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

    /// Voltage on a pin at true time `at_s`, V; `None` if the twin has no such column.
    pub(super) fn voltage(&mut self, pin: Pin, at_s: f64) -> Option<f64> {
        let column = *self.columns.get(&pin)?;
        Some(self.value(column, at_s))
    }

    /// Temperature of the die at true time `at_s`, °C.
    pub(super) fn temperature_c(&mut self, at_s: f64) -> f64 {
        self.value(self.temperature_column, at_s)
    }

    /// Supply at true time `at_s`, V.
    pub(super) fn supply_v(&mut self, at_s: f64) -> f64 {
        self.value(self.supply_column, at_s)
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
