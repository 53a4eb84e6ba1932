//! The command line tool `hexsense`; everything is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    hexsense_probe::cli::run()
}
