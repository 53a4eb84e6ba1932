//! `hexsense rollback`: a kept coefficient set becomes active again.

use anyhow::{bail, ensure};
use clap::Args;
use hexsense_core::records::{CoefficientSet, SetId};
use hexsense_core::wire::message::Kept;

use super::arguments::{Key, Port};
use crate::date::utc;
use crate::terminal::{one_line, say};

/// Make one of the coefficient sets that the board keeps active again, and prove it by reading it back.
///
/// `hexsense history` prints what the board keeps. Nothing is lost: the set that was active stays in the history, and
/// the change is an entry of the log. The board takes it only with its key.
#[derive(Args)]
pub struct Rollback {
    #[command(flatten)]
    port: Port,
    #[command(flatten)]
    key: Key,
    /// Identity of the set as `hexsense history` prints it, or its first digits, as many as make it unique
    #[arg(value_name = "ID")]
    id: String,
}

impl Rollback {
    /// Runs the command.
    ///
    /// # Errors
    /// An identity that no kept set or several kept sets have, a file that holds no key, and what the link reports.
    pub fn run(self) -> anyhow::Result<()> {
        let mut client = self.port.open()?;
        let key = self.key.load(&client.identity()?.board)?;
        let id = find(&client.history()?, &self.id)?;
        client.roll_back(&key, id)?;
        let Some((active, encoded)) = client.read_set()? else {
            bail!("the board has no active set after the rollback; see `hexsense log`");
        };
        let set = CoefficientSet::decode(&encoded)?;
        ensure!(
            active.id == id && CoefficientSet::id_of(&encoded) == id,
            "the board reads back set {} instead of {id}; see `hexsense log`, and replace the board if it happens \
             twice",
            CoefficientSet::id_of(&encoded)
        );
        say!(
            "set {id}, which was uploaded with change {}, is active again and reads back with this identity",
            active.sequence
        )?;
        say!(
            "it was made {} for base {}",
            utc(set.unix_s),
            one_line(&set.geometry)
        )?;
        Ok(())
    }
}

/// The one kept set whose identity begins with `digits`.
fn find(history: &[Kept], digits: &str) -> anyhow::Result<SetId> {
    let mut ids: Vec<SetId> = history.iter().map(|kept| kept.id).collect();
    ids.sort_unstable();
    ids.dedup();
    let wanted = digits.to_ascii_lowercase();
    let (found, others): (Vec<_>, Vec<_>) = ids
        .into_iter()
        .partition(|id| !wanted.is_empty() && id.to_string().starts_with(&wanted));
    match found[..] {
        [id] => Ok(id),
        [] if others.is_empty() => {
            bail!("the board keeps no coefficients to go back to; calibrate and upload a set")
        }
        [] => bail!(
            "the board keeps no set {digits:?}; it keeps {}",
            list(&others)
        ),
        _ => bail!(
            "several kept sets begin with {digits}: {}; give more digits",
            list(&found)
        ),
    }
}

fn list(ids: &[SetId]) -> String {
    let ids: Vec<String> = ids.iter().map(SetId::to_string).collect();
    ids.join(", ")
}
