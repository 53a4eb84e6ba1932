//! The virtual board's program: see `virtual-board --help`.

mod command_line;

use std::convert::Infallible;
use std::error::Error;
use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use virtual_board::bus::Bus;
use virtual_board::firmware::elf::Firmware;
use virtual_board::firmware::log::FirmwareLog;
use virtual_board::injection::timeline::Timeline;
use virtual_board::link::{Link, LinkError, print_counts};
use virtual_board::machine::counting::{Counting, Target};
use virtual_board::machine::{Machine, Stop};
use virtual_board::memory::flash::FlashMemory;
use virtual_board::pins::{BoardParameters, Pins};

use self::command_line::CommandLine;

const DEFAULT_SEED: u64 = 1;

fn main() -> ExitCode {
    let Err(error) = run(&CommandLine::parse());
    eprintln!("virtual-board: {error}");
    match error.downcast_ref() {
        Some(LinkError::Machine(Stop::PowerCut { .. })) => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    }
}

fn run(options: &CommandLine) -> Result<Infallible, Box<dyn Error>> {
    let firmware = Firmware::read(&options.elf)?;
    let mut flash = FlashMemory::open(&options.flash)?;
    firmware.program(&mut flash)?;
    let faults = options.faults.as_deref().map(Timeline::read).transpose()?;
    let mut faults = faults.unwrap_or_default();
    faults.locate(|variable, member| firmware.variable(variable, member))?;
    let link = Link::open(&options.link)?;
    let (pins, mut parameters) = match &options.pins {
        Some(address) => Pins::connect(address)?,
        None => (Pins::Neutral, BoardParameters::neutral(DEFAULT_SEED)),
    };
    parameters.seed = options.seed.unwrap_or(parameters.seed);
    let log = FirmwareLog::new(&firmware.file, firmware.rtt);
    let mut machine = Machine::new(Bus::new(parameters, pins, flash), log)?;
    for setting in &options.option {
        machine.bus_mut().flash.options_mut().set(setting);
    }
    machine.inject(faults);
    let mut stdout = std::io::stdout();
    writeln!(stdout, "{}", serde_json::json!({ "link": link.name()? }))?;
    stdout.flush()?;
    if !options.count.is_empty() {
        machine.count(targets(&options.count, &firmware)?);
    }
    let ended = link.serve(&mut machine);
    print_counts(&machine);
    Ok(ended?)
}

/// First interrupt's exception number.
const IRQ: usize = 16;

fn targets(names: &[String], firmware: &Firmware) -> Result<Counting, String> {
    let mut counting = Counting::new(firmware.all_functions());
    for name in names {
        if let Some(number) = name.strip_prefix("irq:") {
            let number: usize = number
                .parse()
                .map_err(|_| format!("--count {name}: expected irq:N with a number"))?;
            counting.add(Target::Exception(IRQ + number), name, name);
            continue;
        }
        let functions = firmware.functions(name);
        if functions.is_empty() {
            return Err(format!(
                "--count {name}: the firmware has no such function: it may be misspelt, or inlined everywhere"
            ));
        }
        for (symbol, address) in functions {
            counting.add(Target::Function(address), name, &symbol);
        }
    }
    Ok(counting)
}
