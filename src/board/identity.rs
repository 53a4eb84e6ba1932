//! Who the board is, why it started, and on what clock: known at the start, and the same until the next.

use embassy_stm32::pac;
use hexsense::wire::hello::Greeting;
use hexsense::wire::status::ResetCause;
use hexsense::wire::{Identity, VERSION};

use super::clock;
use super::panic;

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
    /// What drives the clock.
    pub clock: clock::Source,
    /// Message of the panic before the start, if there was one.
    pub panic: Option<panic::Message>,
}

impl Origin {
    /// Reads what the chip knows, and clears it for the next start.
    pub fn take(clock: clock::Source) -> Self {
        Self {
            board: embassy_stm32::uid::uid(),
            reset: take_reset_cause(),
            clock,
            panic: panic::take(),
        }
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

/// Cause of the last reset. The flags add up until they are cleared, and any reset sets that of the pin.
fn take_reset_cause() -> ResetCause {
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|csr| csr.set_rmvf(true));
    if flags.iwdgrstf() {
        ResetCause::Watchdog
    } else if flags.sftrstf() {
        ResetCause::Software
    } else if flags.borrstf() {
        ResetCause::PowerOn
    } else if flags.pinrstf() {
        ResetCause::Pin
    } else {
        ResetCause::Other
    }
}
