//! Figures that are measured, printed as a table or as JSON, and judged.

use serde::Serialize;

/// Figures with budgets or limits.
pub trait Figures: Serialize {
    /// Prints them for people.
    fn print_table(&self);

    /// Fails when they are not as they must be.
    fn check(&self) -> anyhow::Result<()>;
}

/// How figures are printed.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct Print {
    /// Print one JSON document on standard output, and nothing else there
    #[arg(long)]
    json: bool,
}

impl Print {
    /// Prints figures, then judges them.
    pub fn judged(self, figures: &impl Figures) -> anyhow::Result<()> {
        if self.json {
            println!("{}", serde_json::to_string_pretty(figures)?);
        } else {
            figures.print_table();
        }
        figures.check()
    }
}
