//! Who the board is, why it started, and on what clock: known at the start, and the same until the next.

use embassy_futures::yield_now;
use hexsense::FACTS;
use hexsense_core::records::BuildId;
use hexsense_core::records::build::BuildHash;
use hexsense_core::server::board::PanicMessage;
use hexsense_core::wire::hello::Greeting;
use hexsense_core::wire::status::{OptionBytes, ResetCause, Resets};
use hexsense_core::wire::{Identity, VERSION};

use super::clock;

/// Board and chip.
const HARDWARE: &str = "NUCLEO-G474RE (STM32G474RE)";
const FIRMWARE: [u8; 3] = [
    number(env!("CARGO_PKG_VERSION_MAJOR")),
    number(env!("CARGO_PKG_VERSION_MINOR")),
    number(env!("CARGO_PKG_VERSION_PATCH")),
];

/// The code that is in flash, and the initial values of RAM behind it.
fn code() -> &'static [u8] {
    unsafe extern "C" {
        static __vector_table: u8;
        static __sidata: u8;
        static __sdata: u8;
        static __edata: u8;
    }
    let [start, values] = [&raw const __vector_table, &raw const __sidata];
    let [first, last] = [&raw const __sdata, &raw const __edata];
    let length = values.addr() - start.addr() + (last.addr() - first.addr());
    // SAFETY: the linker puts code, constants and initial values one behind the other, and nothing writes them.
    unsafe { core::slice::from_raw_parts(start, length) }
}

/// Computes the identity of this firmware from what is in flash; other tasks run meanwhile.
pub async fn build() -> BuildId {
    let mut hash = BuildHash::new(code(), FIRMWARE);
    loop {
        if let Some(build) = hash.advance() {
            return build;
        }
        yield_now().await;
    }
}

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
    pub panic: Option<PanicMessage>,
    /// Its option bytes.
    pub options: OptionBytes,
}

impl Origin {
    /// Answer to a hello.
    pub fn greeting(&self) -> Greeting {
        Greeting {
            wire: VERSION,
            firmware: FIRMWARE,
        }
    }

    /// Answer to the question who the board is.
    pub fn identity(&self, build: Option<BuildId>) -> Identity {
        Identity {
            board: self.board,
            hardware: HARDWARE.try_into().unwrap_or_default(),
            reset: self.reset,
            facts: FACTS,
            build,
        }
    }
}
