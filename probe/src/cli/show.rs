//! `hexsense show`: the coefficients that the board uses, and the pose that it finds with them.

use std::time::Duration;

use clap::Args;
use hexsense_core::records::CoefficientSet;
use hexsense_core::wire::{PoseReport, StreamContent};
use serde_json::json;

use super::arguments::Port;
use crate::terminal::{self, one_line};
use crate::{board_pose, coefficient_file};
use hexsense_client::{Client, LinkError};

/// How long the board may take to find its pose.
const POSE_WAIT: Duration = Duration::from_secs(2);

/// Read the active coefficient set back from the board and print it, with the pose of the base that the board finds
/// from its jacks.
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
        Ok(terminal::print(&text(&mut self.port.open()?, self.json)?)?)
    }
}

/// What the command prints of a board.
///
/// # Errors
/// What the link reports, and a set that does not decode.
pub fn text(client: &mut Client, json: bool) -> anyhow::Result<String> {
    let Some((active, encoded)) = client.read_set()? else {
        return Ok(match json {
            true => format!("{}\n", json!({"id": null})),
            false => "the board has no coefficients; calibrate and upload a set\n".to_owned(),
        });
    };
    let set = CoefficientSet::decode(&encoded)?;
    let pose = current_pose(client)?;
    if json {
        let mut document = coefficient_file::to_json(&set)?;
        document["sequence"] = active.sequence.into();
        document["pose"] = board_pose::to_json(&pose, &set)?;
        return Ok(format!("{document}\n"));
    }
    let base = one_line(&set.geometry);
    let head = format!(
        "set {}, uploaded with change {} of this board, base {base}\n",
        active.id, active.sequence
    );
    let pose = board_pose::line(&pose, &set)?;
    Ok(format!("{head}{}\n{pose}", coefficient_file::table(&set)))
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
