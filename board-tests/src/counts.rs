//! Instructions that the virtual board counted.

use anyhow::{Context, ensure};
use serde::Deserialize;

use crate::process::Beside;

/// Fewest and most instructions of a call.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct Range {
    /// Fewest.
    pub min: u64,
    /// Most.
    pub max: u64,
}

/// The calls of one function.
#[derive(Debug, Clone, Deserialize)]
pub struct Count {
    /// As it was asked for.
    pub name: String,
    /// The symbol that was found.
    pub symbol: String,
    /// Calls that returned.
    pub calls: u64,
    /// Instructions of a call, interrupts left out.
    pub instructions: Range,
    /// Sum over all calls.
    pub total: u64,
}

/// Triggers of the converters from one start of theirs to the next.
#[derive(Debug, Clone, Deserialize)]
pub struct TriggerRun {
    /// Time of the first, ns since power-on.
    pub first_ns: u64,
    /// How many there were.
    pub count: u64,
    /// Shortest interval, cycles of the core.
    pub min_cycles: u64,
    /// Longest interval.
    pub max_cycles: u64,
}

/// The longest stretch of code with masked interrupts.
#[derive(Debug, Clone, Default, Deserialize)]
pub struct Masked {
    /// Its length, cycles of the core.
    pub cycles: u64,
    /// The function in which it began.
    #[serde(rename = "where")]
    pub function: String,
}

/// Everything that was counted while one host was there.
#[derive(Debug, Deserialize)]
pub struct Counts {
    /// All instructions that ran.
    pub executed: u64,
    /// The longest stretch with masked interrupts.
    pub masked: Masked,
    /// Every run of triggers.
    pub triggers: Vec<TriggerRun>,
    counts: Vec<Count>,
}

impl Counts {
    /// What a virtual board says when its host has gone away.
    pub fn read(board: &mut Beside) -> anyhow::Result<Self> {
        let said = board.said();
        let said = said.context("the virtual board counted nothing")?;
        serde_json::from_value(said).context("the virtual board's counts cannot be read")
    }

    /// All functions that `name` stands for.
    pub fn of<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Count> {
        self.counts.iter().filter(move |count| count.name == name)
    }

    /// Instructions of every call of the only function called `name`.
    pub fn fixed(&self, name: &str) -> anyhow::Result<u64> {
        let mut found = self.of(name);
        let count = found
            .next()
            .with_context(|| format!("{name} was not counted"))?;
        ensure!(
            found.next().is_none(),
            "{name} stands for several functions"
        );
        let Range { min, max } = count.instructions;
        ensure!(count.calls > 0, "{name} was never called");
        ensure!(
            min == max,
            "{} takes {min} to {max} instructions: its time depends on data",
            count.symbol
        );
        Ok(min)
    }
}
