//! The core, its exceptions and the wiring of the chip, with programs of a few instructions.

mod code;
mod counting;
mod exceptions;
mod faults;
mod flash;
mod injection;
mod power;
mod serial;
mod sleep;

use std::path::PathBuf;

use code::Code;
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
    path: PathBuf,
}

impl Chip {
    /// The main program, and handlers by exception number.
    fn new(main: Code, handlers: &[(u32, Code)]) -> Self {
        let name = format!(
            "virtual-board-{}-{:?}.bin",
            std::process::id(),
            std::thread::current().id()
        );
        let path = std::env::temp_dir().join(name);
        let _ = std::fs::remove_file(&path);
        let mut flash = FlashMemory::open(&path).unwrap();
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
            path,
        }
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

impl Drop for Chip {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
        let _ = std::fs::remove_file(self.path.with_extension("bin.ecc"));
    }
}
