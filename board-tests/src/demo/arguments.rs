//! What a demo is asked for, and the folder that it may use.

use std::path::PathBuf;

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

impl Arguments {
    /// An empty folder for this demo.
    pub fn folder(&self) -> anyhow::Result<PathBuf> {
        let name = self
            .geometry
            .rsplit('/')
            .next()
            .unwrap_or_default()
            .trim_end_matches(".toml");
        let default = || {
            folders::workspace()
                .join("demo")
                .join(format!("{name}-{}", self.seed))
        };
        let folder = self.out.clone().unwrap_or_else(default);
        folders::empty(&folder)?;
        folder
            .canonicalize()
            .with_context(|| format!("cannot make room in {}", folder.display()))
    }
}
