//! Who the board is, why it started, and on what clock: known at the start, and the same until the next.

use hexsense_core::wire::hello::Greeting;
use hexsense_core::wire::status::{ResetCause, Resets};
use hexsense_core::wire::{Identity, VERSION};

use super::clock;
use super::panic;
use super::resets::{self, Memory};

/// Board and chip.
const HARDWARE: &str = "NUCLEO-G474RE (STM32G474RE)";
const FIRMWARE: [u8; 3] = [
    number(env!("CARGO_PKG_VERSION_MAJOR")),
    number(env!("CARGO_PKG_VERSION_MINOR")),
    number(env!("CARGO_PKG_VERSION_PATCH")),
];

/// A part of the package's version; a part above 255 stops the build.
const fn number(text: &str) -> u8 {
    match u8::from_str_radix(text, 10) {
        Ok(number) => number,
        Err(_) => panic!("a part of the version does not fit a byte"),
    }
}

/// What is known of this start.
#[derive(Clone)]
pub struct Origin {
    /// Unique id of the microcontroller.
    pub board: [u8; 12],
    /// Why it started.
    pub reset: ResetCause,
    /// How often it did since the power came on.
    pub resets: Resets,
    /// What drives the clock.
    pub clock: clock::Source,
    /// Message of the panic before the start, if there was one.
    pub panic: Option<panic::Message>,
}

impl Origin {
    /// Reads what the chip knows, and clears it for the next start. To be called once.
    pub fn take(clock: clock::Source) -> (Self, Memory) {
        let panic = panic::take();
        let (reset, resets, memory) = resets::take(panic.is_some());
        let origin = Self {
            board: embassy_stm32::uid::uid(),
            reset,
            resets,
            clock,
            panic,
        };
        (origin, memory)
    }

    /// Answer to a hello.
    pub fn greeting(&self) -> Greeting {
        Greeting {
            wire: VERSION,
            firmware: FIRMWARE,
        }
    }

    /// Answer to the question who the board is.
    pub fn identity(&self) -> Identity {
        Identity {
            board: self.board,
            hardware: HARDWARE.try_into().unwrap_or_default(),
            reset: self.reset,
        }
    }
}
