//! Faults that are made on purpose: what can go wrong on a board, to be had at a given instant or flash operation.
//!
//! - [`Fault`]: what goes wrong;
//! - [`timeline`]: the file that says when (`--faults FILE`, see docs/virtual-bench.md).
//!
//! The machine carries them out (`machine/inject.rs`).

pub mod timeline;

use serde::{Deserialize, Deserializer, de};

/// How far a flash operation has got when its fault comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Progress {
    /// Nothing of it is done, and nothing ever will be.
    NotBegun,
    /// It is under way: what cuts it short leaves a torn double word or page.
    Half,
    /// It has just ended.
    Done,
}

/// What goes wrong.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(tag = "fault", rename_all = "snake_case", deny_unknown_fields)]
pub enum Fault {
    /// The power goes, and with it this process.
    PowerCut,
    /// Somebody presses the reset button.
    PinReset,
    /// The supply dips: a brown-out reset.
    BrownOut {
        /// Whether the RAM has kept its content.
        ram_kept: bool,
    },
    /// The core goes round in circles: as soon as this exception is active (0 is thread mode, 16 + n interrupt n), in
    /// place of what it was doing there, or, if none is named, whole and at once.
    Hang {
        /// Number of the exception.
        exception: Option<usize>,
    },
    /// The core jumps to this address out of thread mode.
    Jump {
        /// Where to.
        #[serde(deserialize_with = "hexadecimal")]
        address: u32,
    },
    /// The stack pointer of thread mode gets this value, as after calls that went too deep.
    StackPointer {
        /// Its value.
        #[serde(deserialize_with = "hexadecimal")]
        address: u32,
    },
    /// The crystal stops and never starts again. A core that runs on it stands still.
    Crystal,
    /// Bits of the double word of flash at this address fall over.
    BitError {
        /// The address.
        #[serde(deserialize_with = "hexadecimal")]
        address: u32,
        /// 1, which the error code corrects, or 2, which it finds.
        bits: u8,
    },
    /// DMA serves nothing of this for so long.
    DmaStall {
        /// What is not served.
        of: Served,
        /// How long, µs.
        duration_us: u64,
    },
    /// No operation of the flash memory, under way or begun from now on, ends before so long; a reset ends that.
    FlashStall {
        /// How long, µs.
        duration_us: u64,
    },
    /// The converters miss all triggers for so long.
    TriggerStall {
        /// How long, µs.
        duration_us: u64,
    },
    /// The next so many characters on the line suffer.
    Line {
        /// Which way they go.
        towards: Towards,
        /// What becomes of them.
        effect: Effect,
        /// How many.
        characters: u32,
    },
}

/// What DMA serves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Served {
    /// All converters.
    Converters,
    /// The receiver of the serial port.
    Receiver,
    /// The transmitter of the serial port.
    Transmitter,
}

/// Direction of the serial line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Towards {
    /// To the board's receiver.
    Board,
    /// From the board's transmitter.
    Host,
}

/// What becomes of a character on the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Effect {
    /// It never arrives.
    Lost,
    /// One bit arrives wrong, and nobody notices.
    Damaged,
    /// One bit arrives wrong, and a receiver of the board's notices (NE).
    Noise,
    /// The stop bit is missing, and a receiver of the board's notices (FE).
    Framing,
}

fn hexadecimal<'de, D: Deserializer<'de>>(text: D) -> Result<u32, D::Error> {
    let text = String::deserialize(text)?;
    let digits = text
        .strip_prefix("0x")
        .map(|digits| digits.replace('_', ""));
    digits
        .and_then(|digits| u32::from_str_radix(&digits, 16).ok())
        .ok_or_else(|| de::Error::custom(format!("\"{text}\" is no address: write \"0x08040000\"")))
}
