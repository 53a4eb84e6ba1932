//! What happens in the demo, in order.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::arguments::Arguments;
use crate::process::checked;
use crate::virtual_bench::VirtualBench;

/// From the start of the campaign to the start of the verification, s: longer than a campaign takes.
pub const VERIFY_AFTER_S: u64 = 600;

/// What the demo leaves.
pub struct Told {
    /// The campaign's folder.
    pub campaign: PathBuf,
    /// The true movement of the held-out run, from the twin.
    pub truth_log: PathBuf,
    /// The twin's truth about the sensors, as it prints it.
    pub truth: Value,
    /// Identity of the set before the power cut.
    pub uploaded_id: String,
    /// Identity of the set after it.
    pub read_back_id: String,
}

/// Drives everything; progress goes to standard error.
pub fn tell(arguments: &Arguments, folder: &Path) -> anyhow::Result<Told> {
    let bench = VirtualBench {
        seed: arguments.seed,
        geometry: &arguments.geometry,
        folder,
    };
    let twin = bench.twin()?;
    bench.papers()?;
    let board = bench.board(&twin)?;
    eprintln!("— the firmware runs; giving the board its key");
    bench.provision(&board)?;
    eprintln!("— calibrating");
    checked(&mut bench.drive("calibrate", &board, &twin, 0)?)?;
    eprintln!("— uploading");
    checked(&mut bench.upload(&board)?)?;
    let uploaded_id = bench.active_id(&board)?;
    drop(board);

    eprintln!("— power off, power on");
    let board = bench.board(&twin)?;
    let read_back_id = bench.active_id(&board)?;
    eprintln!("— verifying on a movement that nothing was fitted to");
    checked(&mut bench.drive("verify", &board, &twin, VERIFY_AFTER_S)?)?;
    Ok(Told {
        campaign: bench.campaign(),
        truth_log: bench.truth_log(),
        truth: bench.truth()?,
        uploaded_id,
        read_back_id,
    })
}
