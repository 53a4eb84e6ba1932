//! The programs and tests that commands call, in `board-tests` and `host-tests`. Flags go to them as they are.

use std::ffi::OsString;
use std::process::Command;

use anyhow::Context;

use crate::build::{self, Part};
use crate::command::cargo;

/// The flags of a command, which the called program knows.
#[derive(Debug, Default, clap::Args)]
pub struct Flags {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    flags: Vec<OsString>,
}

impl Flags {
    /// Whether the command is asked for its help: nothing needs to be built for that.
    fn ask_for_help(&self) -> bool {
        self.flags
            .iter()
            .any(|flag| flag == "--help" || flag == "-h")
    }
}

/// A command of `board-tests`, for which these parts are built.
pub fn board_tests(parts: &[Part], command: &[&str], flags: &Flags) -> anyhow::Result<Command> {
    on_the_board(parts, &[], command, flags)
}

/// The same for a command that drives no host tool: none is built.
pub fn board_alone(parts: &[Part], command: &[&str], flags: &Flags) -> anyhow::Result<Command> {
    on_the_board(parts, &["--no-default-features"], command, flags)
}

fn on_the_board(
    parts: &[Part],
    options: &[&str],
    command: &[&str],
    flags: &Flags,
) -> anyhow::Result<Command> {
    if !flags.ask_for_help() {
        build::build(parts)?;
    }
    let mut call = run("board-tests", "board-tests");
    build::name(parts, &mut call)?;
    call.args(options).arg("--").args(command);
    call.args(&flags.flags);
    Ok(call)
}

/// A file of tests of `board-tests`, for which everything is built.
pub fn tests_on_the_board(file: &str) -> anyhow::Result<Command> {
    build::build(&Part::ALL)?;
    let mut tests = cargo("test");
    tests.args(["--package", "board-tests", "--test", file]);
    build::name(&Part::ALL, &mut tests)?;
    tests.args(["--", "--ignored"]);
    Ok(tests)
}

/// A program of `host-tests`, built with optimisation.
pub fn host_tests(program: &str, flags: &Flags) -> Command {
    let mut call = run("host-tests", program);
    call.args(["--release", "--"]).args(&flags.flags);
    call
}

fn run(package: &str, program: &str) -> Command {
    let mut run = cargo("run");
    run.args(["--quiet", "--package", package, "--bin", program]);
    run
}

/// Runs a call and ends as it does: it has told what is wrong.
pub fn finish(mut call: Command) -> anyhow::Result<()> {
    let status = call.status();
    let status = status.with_context(|| format!("cannot start {call:?}"))?;
    std::process::exit(status.code().unwrap_or(1));
}
