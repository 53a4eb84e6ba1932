//! The command line.

use std::path::PathBuf;

use clap::Parser;
use virtual_board::link::LinkAddress;
use virtual_board::peripherals::flash::options::Setting;

/// A NUCLEO-G474RE without the hardware: runs an unmodified firmware ELF on an emulated STM32G474 in virtual time.
///
/// When the link listens, one line of JSON on stdout gives its address: {"link":"lockstep:127.0.0.1:4000"}. The
/// firmware's log and remarks about the emulation go to stderr, with the virtual time in seconds in front.
///
/// Killing the process cuts the power; starting it again with the same flash file switches the power on.
#[derive(Debug, Parser)]
#[command(version)]
pub struct CommandLine {
    /// Firmware to run: the ELF file as cargo builds it (thumbv7em-none-eabihf). It is programmed into flash bank 1
    /// first, as a debug probe would do.
    #[arg(long, value_name = "FILE")]
    pub elf: PathBuf,

    /// File that keeps the flash memory (512 KB) over power cycles; created erased if it does not exist.
    #[arg(long, value_name = "FILE")]
    pub flash: PathBuf,

    /// Where the host connects to the board's serial port: tcp:HOST:PORT or pty (both at the pace of real time), or
    /// lockstep:HOST:PORT (time runs only while the host waits for the board). Port 0 picks a free port.
    #[arg(long, value_name = "ADDRESS")]
    pub link: LinkAddress,

    /// Where the twin listens for the board's pins, tcp:HOST:PORT. Without a twin every pin is at half the supply.
    #[arg(long, value_name = "tcp:HOST:PORT", value_parser = pins_address)]
    pub pins: Option<String>,

    /// Seed of noise and random numbers. The twin brings one of its own, which this replaces; without a twin it is 1.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,

    /// Make things go wrong: a file with one fault a line, such as {"at_s":2.5,"fault":"pin_reset"} or
    /// {"flash_operation":17,"progress":"half","fault":"power_cut"}. docs/virtual-bench.md lists them all. Times are
    /// virtual, and both count from power-on.
    #[arg(long, value_name = "FILE")]
    pub faults: Option<PathBuf>,

    /// Set an option register, as a debug probe would do it before the power comes on: OPTR, WRP1AR, WRP1BR, WRP2AR or
    /// WRP2BR. OPTR=0xffaff8aa is the factory setting with a single bank of flash (DBANK = 0). May be given several times.
    #[arg(long, value_name = "NAME=0xVALUE")]
    pub option: Vec<Setting>,

    /// Count the instructions of this function (its symbol, or its path without hash; it must not have been inlined) or
    /// of an interrupt's handler (irq:N), from the first instruction to the return: fewest, most and number of calls.
    /// May be given several times. Each time a host disconnects, and when the board halts, one line of JSON on stdout
    /// gives the counts: {"executed":N,"counts":[…],"masked":{…},"triggers":[…]} with all instructions that ran, the
    /// longest stretch for which interrupts were masked, and every run of triggers of the converters; instructions and
    /// stretches begin at zero for the next host.
    #[arg(long, value_name = "NAME")]
    pub count: Vec<String>,
}

fn pins_address(text: &str) -> Result<String, String> {
    text.strip_prefix("tcp:")
        .map(str::to_owned)
        .ok_or_else(|| "expected tcp:HOST:PORT, as the twin prints it".to_owned())
}
