//! `hexsense show`: the coefficients that the board uses, and the pose that it finds with them.

use std::time::Duration;

use clap::Args;
use hexsense_core::records::CoefficientSet;
use hexsense_core::wire::{PoseReport, StreamContent};
use serde_json::json;

use super::arguments::{Key, Port};
use super::proven::Proven;
use crate::terminal::{self, one_line};
use crate::{board_pose, coefficient_file};
use hexsense_client::{Client, LinkError};

/// How long the board may take to find its pose.
const POSE_WAIT: Duration = Duration::from_secs(2);

/// Read the active coefficient set back from the board and print it, with the pose of the base that the board finds
/// from its jacks. With its key at hand the board proves that it is the board, and that this set is the active one.
#[derive(Args)]
pub struct Show {
    #[command(flatten)]
    port: Port,
    #[command(flatten)]
    key: Key,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

impl Show {
    /// Runs the command.
    ///
    /// # Errors
    /// What the link reports, a set that does not decode, and a board that does not have the key at hand.
    pub fn run(self) -> anyhow::Result<()> {
        let mut client = self.port.open()?;
        let proven = Proven::of(&mut client, &self.key)?;
        terminal::print(&text(&mut client, self.json, &proven)?)?;
        proven.check()
    }
}

/// What the command prints of a board.
///
/// # Errors
/// What the link reports, a set that does not decode, and a set that is not the one that the board proves.
pub fn text(client: &mut Client, json: bool, proven: &Proven) -> anyhow::Result<String> {
    let read = client.read_set()?;
    proven.check_set(read.as_ref().map(|(_, bytes)| CoefficientSet::id_of(bytes)))?;
    let (is_proven, proof) = (proven.is_proven(), proven.line());
    let Some((active, encoded)) = read else {
        return Ok(match json {
            true => format!("{}\n", json!({"id": null, "proven": is_proven})),
            false => {
                format!("the board has no coefficients; calibrate and upload a set\n{proof}\n")
            }
        });
    };
    let set = CoefficientSet::decode(&encoded)?;
    let pose = current_pose(client)?;
    if json {
        let mut document = coefficient_file::to_json(&set)?;
        document["sequence"] = active.sequence.into();
        document["pose"] = board_pose::to_json(&pose, &set)?;
        document["proven"] = is_proven.into();
        return Ok(format!("{document}\n"));
    }
    let base = one_line(&set.geometry);
    let head = format!(
        "set {}, uploaded with change {} of this board, base {base}\n",
        active.id, active.sequence
    );
    let pose = board_pose::line(&pose, &set)?;
    let table = coefficient_file::table(&set);
    Ok(format!("{head}{table}\n{pose}{proof}\n"))
}

/// The board's next pose.
fn current_pose(client: &mut Client) -> Result<PoseReport, LinkError> {
    client.stream(StreamContent {
        pose: true,
        ..StreamContent::default()
    })?;
    let pose = client.pose(POSE_WAIT)?;
    client.stream(StreamContent::default())?;
    Ok(pose)
}
