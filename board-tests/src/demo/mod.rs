//! A whole calibration on the virtual bench.
//!
//! The real firmware starts on the virtual board and gets its key. The twin is driven along the movements of the method. The
//! coefficients are uploaded, the power is cut and comes back, and a movement that no coefficient was fitted to judges them.
//!
//! - `story`: the programs and their order; every step is a command that a user types.
//! - `alignment`: where a capture lies in the twin's time.
//! - `judgement`: the only place where estimate and truth meet.
//! - `document`: what is printed, as JSON or as tables.

mod alignment;
mod document;
mod judgement;
mod story;

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Context;

use crate::folders;

/// `cargo xtask demo`
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Seed that the truth, the noise and the board are drawn from
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Motion base: il-96-300, tu-204, an-74tk-200, rexroth_emotion8000, rexroth_emotion1500, or a geometry file
    #[arg(long, default_value = "an-74tk-200")]
    pub geometry: String,
    /// Print one JSON document on standard output, and nothing else there
    #[arg(long)]
    pub json: bool,
    /// Folder for captures and report; replaced if it is there [default: demo/GEOMETRY-SEED]
    #[arg(long)]
    pub out: Option<PathBuf>,
}

/// Runs the demo and prints its result.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let start = Instant::now();
    let folder = folder(arguments)?;
    let told = story::tell(arguments, &folder)?;
    let judged = judgement::judge(&told)?;
    let document = document::Document::new(arguments, &told, judged, start.elapsed())?;
    document.save(&folder)?;
    if arguments.json {
        println!("{}", serde_json::to_string(&document)?);
    } else {
        println!("{}", document.table());
        println!(
            "Captures, coefficients and report: {}",
            told.campaign.join("report.html").display()
        );
    }
    anyhow::ensure!(
        document.holds(),
        "the demo's result does not hold; see above"
    );
    Ok(())
}

/// An empty folder for this demo.
fn folder(arguments: &Arguments) -> anyhow::Result<PathBuf> {
    let name = arguments
        .geometry
        .rsplit('/')
        .next()
        .unwrap_or_default()
        .trim_end_matches(".toml");
    let default = || {
        folders::workspace()
            .join("demo")
            .join(format!("{name}-{}", arguments.seed))
    };
    let folder = arguments.out.clone().unwrap_or_else(default);
    folders::empty(&folder)?;
    folder
        .canonicalize()
        .with_context(|| format!("cannot make room in {}", folder.display()))
}
