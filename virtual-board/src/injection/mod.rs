//! Injected faults: what can go wrong on a board, at a given instant or flash operation.
//!
//! - [`Fault`]: what goes wrong;
//! - [`timeline`]: the file with the times (`--faults FILE`, see docs/virtual-bench.md).
//!
//! The machine carries them out (`machine/inject.rs`).

pub mod timeline;

use serde::{Deserialize, Deserializer, de};

use crate::firmware::variables::Place;

/// Progress of a flash operation at the moment of its fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Progress {
    /// The operation has not begun, and never begins.
    NotBegun,
    /// The operation is under way: a reset or power cut now leaves a torn double word or page.
    Half,
    /// It has just ended.
    Done,
}

/// What goes wrong.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "fault", rename_all = "snake_case", deny_unknown_fields)]
pub enum Fault {
    /// The power goes, and this process ends.
    PowerCut,
    /// A person presses the reset button.
    PinReset,
    /// The supply dips: a brown-out reset.
    BrownOut {
        /// Whether the RAM has kept its content.
        ram_kept: bool,
    },
    /// The core hangs in an endless loop: as soon as this exception is active (0 is thread mode, 16 + n interrupt n),
    /// in place of its code; without an exception, the whole core hangs at once.
    Hang {
        /// Number of the exception.
        exception: Option<usize>,
    },
    /// The core jumps to this address out of thread mode.
    Jump {
        /// The address.
        #[serde(deserialize_with = "hexadecimal")]
        address: u32,
    },
    /// The stack pointer of thread mode gets this value, as after calls that went too deep.
    StackPointer {
        /// Its value.
        #[serde(deserialize_with = "hexadecimal")]
        address: u32,
    },
    /// The crystal stops. A core that runs on it stands still; a PLL that runs on it drifts to a fraction of its frequency.
    Crystal {
        /// The PLL then runs at 1 / drift of its frequency.
        #[serde(default = "usual_drift")]
        drift: u32,
        /// Whether the crystal works again after the next reset; otherwise it never starts again.
        #[serde(default)]
        returns: bool,
    },
    /// A debugger halts the core for a while; everything else runs on.
    Halt {
        /// Duration, µs.
        duration_us: u64,
    },
    /// A debug probe has set the log to blocking, and never reads it again.
    LogUnread,
    /// Bits of the double word of flash at this address flip.
    BitError {
        /// The address.
        #[serde(deserialize_with = "hexadecimal")]
        address: u32,
        /// 1, which the error code corrects, or 2, which it finds.
        bits: u8,
    },
    /// DMA does not serve this part for a while.
    DmaStall {
        /// The part that is not served.
        of: Served,
        /// Duration, µs.
        duration_us: u64,
    },
    /// DMA loses the next result of a converter, or takes it twice: it slips by one rank.
    DmaSlip {
        /// Number of the converter, 1 to 5.
        adc: u8,
        /// What happens to the result.
        result: Slip,
    },
    /// No operation of the flash memory, under way or new, ends within a duration; a reset ends that.
    FlashStall {
        /// Duration, µs.
        duration_us: u64,
    },
    /// The converters miss all triggers for a while.
    TriggerStall {
        /// Duration, µs.
        duration_us: u64,
    },
    /// The 48 MHz oscillator, which the generator of random numbers runs on, stops and never starts again.
    Hsi48,
    /// The generator of random numbers has a defect for a while.
    Random {
        /// What is wrong with it.
        defect: Defect,
        /// Duration, µs.
        duration_us: u64,
    },
    /// The input of the reference voltage VREFINT is at another voltage for a while.
    Reference {
        /// The voltage as a share of the converters' supply: below 0 reads as code 0, from 1 on as code 4095.
        share: f64,
        /// Duration, µs.
        duration_us: u64,
    },
    /// Bits of a word of RAM flip.
    RamBits {
        /// Address of the word.
        #[serde(deserialize_with = "hexadecimal")]
        address: u32,
        /// The bits.
        #[serde(deserialize_with = "hexadecimal")]
        mask: u32,
    },
    /// Bits of a word of RAM flip that is known by its content.
    RamWord {
        /// What the word holds.
        #[serde(deserialize_with = "hexadecimal")]
        holds: u32,
        /// How many words with this content are passed over; from the begin of RAM on.
        skip: usize,
        /// The bits.
        #[serde(deserialize_with = "hexadecimal")]
        mask: u32,
    },
    /// The next characters on the line are disturbed.
    Line {
        /// Their direction.
        towards: Towards,
        /// The effect on each.
        effect: Effect,
        /// Number of characters.
        characters: u32,
    },
    /// A variable of the firmware gets this value, as it would in years.
    Preset {
        /// Path of the static.
        variable: String,
        /// Path of its member through the types.
        member: String,
        /// The value, at most eight bytes.
        value: u64,
        /// Where it lies, once the firmware is known.
        #[serde(skip)]
        place: Option<Place>,
    },
}

/// What is wrong with the generator of random numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Defect {
    /// It makes no words.
    NotReady,
    /// It makes zeros only.
    Zeros,
    /// It makes the same word again and again.
    SameWord,
    /// Its noise fails the test.
    Seed,
    /// Its clock is too slow.
    Clock,
}

/// The parts that DMA serves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Served {
    /// All converters.
    Converters,
    /// The receiver of the serial port.
    Receiver,
    /// The transmitter of the serial port.
    Transmitter,
    /// The converter of supply and temperature.
    Supply,
}

/// A mistake of DMA.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Slip {
    /// The result is fetched and goes nowhere.
    Lost,
    /// It goes to two places, one after the other.
    Twice,
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

/// The effect of a disturbance on a character.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Effect {
    /// It never arrives.
    Lost,
    /// One bit arrives wrong, and nothing detects it.
    Damaged,
    /// One bit arrives wrong, and the board's receiver detects it (NE).
    Noise,
    /// The stop bit is missing, and the board's receiver detects it (FE).
    Framing,
}

/// Fraction at which a PLL without its input settles, when the fault does not say it.
fn usual_drift() -> u32 {
    4
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
