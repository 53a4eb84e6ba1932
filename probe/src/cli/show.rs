//! `hexsense show`: the coefficients that the board uses.

use clap::Args;
use hexsense::store::CoefficientSet;
use serde_json::json;

use super::arguments::Port;
use crate::coefficient_file;

/// Read the active coefficient set back from the board and print it.
#[derive(Args)]
pub struct Show {
    #[command(flatten)]
    port: Port,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Show {
    /// Runs the command.
    ///
    /// # Errors
    /// What the link reports, and a set that does not decode.
    pub fn run(self) -> anyhow::Result<()> {
        let Some((active, encoded)) = self.port.open()?.read_set()? else {
            if self.json {
                println!("{}", json!({"id": null}));
            } else {
                println!("the board has no coefficients; calibrate and upload a set");
            }
            return Ok(());
        };
        let set = CoefficientSet::decode(&encoded)?;
        if self.json {
            let mut document = coefficient_file::to_json(&set)?;
            document["sequence"] = active.sequence.into();
            println!("{document}");
        } else {
            println!(
                "set {}, commit {} on this board, base {}",
                active.id, active.sequence, set.geometry
            );
            print!("{}", coefficient_file::table(&set));
        }
        Ok(())
    }
}
