//! `hexsense history`: the coefficient sets that the board keeps.

use clap::Args;
use hexsense_core::records::CoefficientSet;
use hexsense_core::wire::message::{ActiveSet, Kept};
use serde_json::{Value, json};

use super::arguments::Port;
use crate::date::utc;
use crate::terminal::{self, one_line};
use hexsense_client::Client;

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
        Ok(terminal::print(&text(&mut self.port.open()?, self.json)?)?)
    }
}

/// What the command prints of a board.
///
/// # Errors
/// What the link reports.
pub fn text(client: &mut Client, json: bool) -> anyhow::Result<String> {
    let history = client.history()?;
    let active = client.read_set()?;
    let base = active
        .as_ref()
        .and_then(|(_, encoded)| CoefficientSet::decode(encoded).ok())
        .map(|set| set.geometry.to_string());
    let active = active.map(|(active, _)| active);
    if json {
        return Ok(format!("{}\n", to_json(&history, active, base.as_deref())));
    }
    if history.is_empty() {
        return Ok("the board keeps no coefficients; calibrate and upload a set\n".to_owned());
    }
    let last = match (active, base) {
        (Some(active), Some(base)) => {
            format!(
                "active: set {}, made for base {}\n",
                active.id,
                one_line(&base)
            )
        }
        _ => "active: no set of these; they were made for another board\n".to_owned(),
    };
    Ok(table(&history, active) + &last)
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

#[cfg(test)]
mod tests {
    use super::*;
    use hexsense_core::records::SetId;

    fn kept() -> [Kept; 2] {
        let kept = |sequence, id, length, made_unix_s, uploaded_unix_s| Kept {
            sequence,
            id: SetId(id),
            length,
            made_unix_s,
            uploaded_unix_s,
        };
        [
            kept(
                17,
                [1, 2, 3, 4, 5, 6, 7, 0xab],
                701,
                1_780_000_000,
                1_780_000_061,
            ),
            kept(9, [0x0a; 8], 702, 1_779_913_600, 1_779_917_200),
        ]
    }

    /// The older one, after a rollback.
    fn active() -> Option<ActiveSet> {
        Some(ActiveSet {
            id: SetId([0x0a; 8]),
            sequence: 9,
            length: 702,
        })
    }

    #[test]
    fn every_set_has_its_dates_in_their_columns_and_the_active_one_a_star() {
        let expected = "\
\x20 change  set               made                  uploaded
      17  01020304050607ab  2026-05-28T20:26:40Z  2026-05-28T20:27:41Z
*      9  0a0a0a0a0a0a0a0a  2026-05-27T20:26:40Z  2026-05-27T21:26:40Z
";
        assert_eq!(table(&kept(), active()), expected);
        assert!(!table(&kept(), None).contains('*'));
    }

    #[test]
    fn the_document_tells_the_base_of_the_active_set_alone() {
        let expected = json!({"sets": [
            {
                "change": 17,
                "id": "01020304050607ab",
                "bytes": 701,
                "made_unix_s": 1_780_000_000,
                "made_utc": "2026-05-28T20:26:40Z",
                "uploaded_unix_s": 1_780_000_061,
                "uploaded_utc": "2026-05-28T20:27:41Z",
                "active": false,
                "geometry": null,
            },
            {
                "change": 9,
                "id": "0a0a0a0a0a0a0a0a",
                "bytes": 702,
                "made_unix_s": 1_779_913_600,
                "made_utc": "2026-05-27T20:26:40Z",
                "uploaded_unix_s": 1_779_917_200,
                "uploaded_utc": "2026-05-27T21:26:40Z",
                "active": true,
                "geometry": "base seven",
            },
        ]});
        assert_eq!(to_json(&kept(), active(), Some("base seven")), expected);
    }
}
