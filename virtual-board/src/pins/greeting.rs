//! The greeting of the twin: the parameters of the board, and the shape of the chunks.

use serde::Deserialize;

use super::error::{PinsError, check};
use crate::peripherals::adc::Imperfection;

pub use super::error::PROTOCOL;

/// Number of converters in the chip.
pub const CONVERTERS: usize = 5;
pub(super) const MAX_GREETING: u64 = 1 << 20;

/// Properties in which boards differ.
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
    /// A typical board: it has no errors, and the converters have the noise of the data sheet.
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

#[derive(Deserialize)]
pub(super) struct ProtocolOnly {
    pub(super) protocol: String,
}

#[derive(Deserialize)]
pub(super) struct Greeting {
    pub(super) step_s: f64,
    pub(super) chunk_steps: usize,
    pub(super) columns: Vec<String>,
    pub(super) board: GreetingBoard,
}

#[derive(Deserialize)]
pub(super) struct GreetingBoard {
    seed: u64,
    uid: String,
    clock_ppm: f64,
    vrefint_v: f64,
    adc: Vec<GreetingAdc>,
}

#[derive(Deserialize)]
pub(super) struct GreetingAdc {
    gain_error: f64,
    offset_lsb: f64,
    noise_lsb: f64,
}

pub(super) fn board_parameters(board: &GreetingBoard) -> Result<BoardParameters, PinsError> {
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
