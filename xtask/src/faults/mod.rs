//! The fault campaign: each promise of docs/guarantees.md against the faults that could break it, on the firmware's ELF
//! on the virtual board.
//!
//! | promise | what is injected |
//! |---|---|
//! | [`power_cut`] | the end of the power, at every flash operation of every change |
//!
//! [`bench`] is the board and its flash memory, [`line`] the serial line to it, [`keeper`] who changes its coefficients,
//! [`outcome`] the account of a promise.

mod bench;
mod keeper;
mod line;
mod outcome;
mod power_cut;

use anyhow::ensure;

use self::outcome::Outcome;
use self::power_cut::Extent;
use crate::build::{self, Parts};

#[derive(clap::Args)]
pub struct Arguments {
    /// Print one line of JSON for each promise
    #[arg(long)]
    json: bool,
    /// Seed of everything that is drawn
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Runs the campaign; fails when anything was lost or too little was tried.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let parts = build::everything()?;
    let outcomes = vec![power_cut::sweep(
        &parts,
        arguments.seed,
        &Extent {
            uploads: 10,
            every: 1,
        },
    )?];
    if !arguments.json {
        println!("promise    injected  minimum   lost");
    }
    for outcome in &outcomes {
        if arguments.json {
            println!("{}", outcome.json());
        } else {
            println!("{}", outcome.row());
        }
    }
    judge(&outcomes)
}

fn judge(outcomes: &[Outcome]) -> anyhow::Result<()> {
    let broken = outcomes.iter().filter(|outcome| !outcome.holds()).count();
    ensure!(broken == 0, "{broken} promises do not hold");
    Ok(())
}
