//! `hexsense history`: the coefficient sets that the board keeps.

use clap::Args;
use hexsense_core::records::CoefficientSet;
use hexsense_core::wire::message::{ActiveSet, Kept};
use serde_json::{Value, json};

use super::arguments::Port;
use crate::date::utc;

/// Print the coefficient sets that the board keeps, newest first: the last eight that were uploaded.
///
/// For each set these are the number of its upload in the board's log (see `hexsense log`), its identity, the date of its
/// campaign, and the date of its upload by the clock of the computer that made it. `hexsense rollback ID` makes one of them
/// active again.
#[derive(Args)]
pub struct History {
    #[command(flatten)]
    port: Port,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl History {
    /// Runs the command.
    ///
    /// # Errors
    /// What the link reports.
    pub fn run(self) -> anyhow::Result<()> {
        let mut client = self.port.open()?;
        let history = client.history()?;
        let active = client.read_set()?;
        let base = active
            .as_ref()
            .and_then(|(_, encoded)| CoefficientSet::decode(encoded).ok())
            .map(|set| set.geometry.to_string());
        let active = active.map(|(active, _)| active);
        if self.json {
            println!("{}", to_json(&history, active, base.as_deref()));
            return Ok(());
        }
        if history.is_empty() {
            println!("the board keeps no coefficients; calibrate and upload a set");
            return Ok(());
        }
        print!("{}", table(&history, active));
        match (active, base) {
            (Some(active), Some(base)) => {
                println!("active: set {}, made for base {base}", active.id);
            }
            _ => println!("active: no set of these; they were made for another board"),
        }
        Ok(())
    }
}

/// The sets as a table for people; the active one is marked.
pub(super) fn table(history: &[Kept], active: Option<ActiveSet>) -> String {
    let mut text = String::from("  change  set               made                  uploaded\n");
    for kept in history {
        let mark = if is_active(kept, active) { '*' } else { ' ' };
        text += &format!(
            "{mark} {:>6}  {}  {:<20}  {}\n",
            kept.sequence,
            kept.id,
            utc(kept.made_unix_s),
            utc(kept.uploaded_unix_s)
        );
    }
    text
}

fn is_active(kept: &Kept, active: Option<ActiveSet>) -> bool {
    active.is_some_and(|active| active.sequence == kept.sequence)
}

fn to_json(history: &[Kept], active: Option<ActiveSet>, base: Option<&str>) -> Value {
    let sets = history.iter().map(|kept| {
        json!({
            "change": kept.sequence,
            "id": kept.id.to_string(),
            "bytes": kept.length,
            "made_unix_s": kept.made_unix_s,
            "made_utc": utc(kept.made_unix_s),
            "uploaded_unix_s": kept.uploaded_unix_s,
            "uploaded_utc": utc(kept.uploaded_unix_s),
            "active": is_active(kept, active),
            "geometry": is_active(kept, active).then_some(base),
        })
    });
    json!({"sets": sets.collect::<Vec<_>>()})
}
