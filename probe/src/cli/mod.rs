//! The commands of `hexsense`, one file each.
//!
//! Each file holds arguments, calls into the library, and what is printed; the work is done in the library's rooms. Results
//! go to standard output, progress to standard error, all of it through [`crate::terminal`]. A command that fails prints
//! one message, which says what to do, and ends with a status that is not zero: 3 when a campaign fails its checks, 130
//! after a request to stop.

mod arguments;
mod broken_off;
mod calibrate;
mod capture;
mod characterise;
mod confirm;
#[cfg(test)]
mod documents;
mod factory_reset;
pub mod harmonics;
pub mod history;
pub mod info;
mod kinematics;
pub mod log;
mod new;
mod plan;
mod progress;
pub mod proven;
mod provision;
mod report;
mod rollback;
pub mod show;
pub mod status;
mod upload;
mod verify;
mod volume;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::evaluation::EvaluationError;
use crate::interrupt;
use crate::terminal::tell;

/// Exit status when a campaign fails its checks.
const UNFIT: u8 = 3;

/// Calibrates the inertial sensors of a flight simulator where they stand: its motion base is driven along known
/// movements, the jacks give the true pose, and the sensors' signals are fitted to it.
///
/// The usual order: `info` to see that the board answers, `plan` to see the movements before anything moves,
/// `calibrate` to record them and compute the coefficients, `provision` to give the board a key once, `upload` to store the
/// coefficients on the board, and `verify` to prove them on a movement that they were not fitted to.
#[derive(Parser)]
#[command(name = "hexsense", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Info(info::Info),
    Status(status::Status),
    Capture(capture::Capture),
    Harmonics(harmonics::Harmonics),
    New(new::New),
    Plan(plan::Plan),
    Calibrate(calibrate::Calibrate),
    Provision(provision::Provision),
    Upload(upload::Upload),
    Show(show::Show),
    Verify(verify::Verify),
    Characterise(characterise::Characterise),
    Report(report::Report),
    History(history::History),
    Rollback(rollback::Rollback),
    FactoryReset(factory_reset::FactoryReset),
    Log(log::Log),
    Kinematics(kinematics::Kinematics),
}

/// Does what the command line asks.
#[must_use]
pub fn run() -> ExitCode {
    let command = Cli::parse().command;
    let result = interrupt::hear_of_file_size_limits().map_err(anyhow::Error::from);
    let result = result.and_then(|()| match command {
        Command::Info(command) => command.run(),
        Command::Status(command) => command.run(),
        Command::Capture(command) => command.run(),
        Command::Harmonics(command) => command.run(),
        Command::New(command) => command.run(),
        Command::Plan(command) => command.run(),
        Command::Calibrate(command) => command.run(),
        Command::Provision(command) => command.run(),
        Command::Upload(command) => command.run(),
        Command::Show(command) => command.run(),
        Command::Verify(command) => command.run(),
        Command::Characterise(command) => command.run(),
        Command::Report(command) => command.run(),
        Command::History(command) => command.run(),
        Command::Rollback(command) => command.run(),
        Command::FactoryReset(command) => command.run(),
        Command::Log(command) => command.run(),
        Command::Kinematics(command) => command.run(),
    });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tell!("hexsense: {error}");
            if interrupt::is_behind(error.as_ref()) {
                interrupt::STATUS.into()
            } else if let Some(EvaluationError::Unfit(_)) = error.downcast_ref() {
                UNFIT.into()
            } else {
                ExitCode::FAILURE
            }
        }
    }
}
