//! The core, its exceptions and the wiring of the chip, with programs of a few instructions.

mod code;
mod counting;
mod exceptions;
mod faults;
mod flash;
mod injection;
mod log;
mod power;
mod serial;
mod sleep;

use code::Code;
use tempfile::TempDir;
use virtual_board::bus::Bus;
use virtual_board::firmware::log::FirmwareLog;
use virtual_board::machine::{Machine, Stop};
use virtual_board::memory::flash::FlashMemory;
use virtual_board::pins::{BoardParameters, Pins};

/// Where programs leave their results: words of RAM from here on.
const RESULTS: u32 = 0x2000_0100;
/// Initial stack pointer.
const STACK: u32 = 0x2001_0000;
/// Where the code of the main program and of each exception's handler begins.
const MAIN: u32 = 0x0800_0400;
const HANDLERS: u32 = 0x0800_1000;
const HANDLER_SPACE: u32 = 0x100;

/// A chip with a program.
struct Chip {
    machine: Machine,
    /// Where its flash is, `flash.bin`.
    folder: TempDir,
}

impl Chip {
    /// The main program, and handlers by exception number.
    fn new(main: Code, handlers: &[(u32, Code)]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut flash = FlashMemory::open(&folder.path().join("flash.bin")).unwrap();
        let mut put = |address: u32, bytes: &[u8]| {
            flash
                .write((address - 0x0800_0000) as usize, bytes)
                .unwrap()
        };
        put(0x0800_0000, &STACK.to_le_bytes());
        put(0x0800_0004, &(MAIN | 1).to_le_bytes());
        put(MAIN, &main.bytes());
        for (exception, code) in handlers {
            let address = HANDLERS + exception * HANDLER_SPACE;
            put(0x0800_0000 + 4 * exception, &(address | 1).to_le_bytes());
            put(address, &code.bytes());
        }
        let bus = Bus::new(BoardParameters::neutral(1), Pins::Neutral, flash);
        Self {
            machine: Machine::new(bus, FirmwareLog::none()).unwrap(),
            folder,
        }
    }

    /// A chip that has run its program for a millisecond.
    fn ran(main: Code, handlers: &[(u32, Code)]) -> Self {
        let mut chip = Self::new(main, handlers);
        chip.run(1e-3).unwrap();
        chip
    }

    /// Runs on for so many seconds.
    fn run(&mut self, duration_s: f64) -> Result<(), Stop> {
        self.machine.run(self.machine.bus().now_s() + duration_s)
    }

    /// The result at `index`.
    fn result(&self, index: u32) -> u32 {
        self.word(RESULTS + 4 * index)
    }

    fn word(&self, address: u32) -> u32 {
        self.machine
            .bus()
            .ram
            .word((address - 0x2000_0000) as usize)
            .unwrap()
    }
}
