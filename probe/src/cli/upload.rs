//! `hexsense upload`: a coefficient set onto the board.

use std::path::{Path, PathBuf};

use clap::Args;
use hexsense_core::records::{CoefficientSet, MAX_ENCODED};

use super::arguments::{Key, Port};
use crate::campaign::sources;
use crate::terminal::{say, tell};
use crate::{coefficient_file, files};

/// Store a coefficient set on the board, and prove it by reading it back.
///
/// The file must be as `hexsense calibrate` wrote it, and so must be the captures, the plan, the geometry file and the
/// sensor file that it was found from, as far as they lie beside it; what is not there is named as not checked. When the
/// upload breaks off, the old set is still active. The board keeps the set through power cuts. It takes the set
/// only with its key (see `hexsense provision`), and notes the change in its log (see `hexsense log`).
#[derive(Args)]
pub struct Upload {
    #[command(flatten)]
    port: Port,
    #[command(flatten)]
    key: Key,
    /// Folder of a finished campaign, or its coefficients.toml
    #[arg(value_name = "FOLDER|FILE")]
    from: PathBuf,
}

impl Upload {
    /// Runs the command.
    ///
    /// # Errors
    /// A file that holds no set or no key, a set for another board, and what the link reports.
    pub fn run(self) -> anyhow::Result<()> {
        let path = if self.from.is_dir() {
            self.from.join("coefficients.toml")
        } else {
            self.from
        };
        let (set, found_from) = coefficient_file::load(&path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        for unseen in sources::check(folder, &found_from)? {
            tell!("not checked: {unseen}");
        }
        let mut client = self.port.open()?;
        let board = client.identity()?.board;
        if board != set.board {
            anyhow::bail!(
                "{} was made for board {}, and this is board {}; calibrate this one. Its coefficients are unchanged",
                path.display(),
                files::hex(&set.board),
                files::hex(&board)
            );
        }
        let key = self.key.load(&board)?;
        let mut buffer = [0; MAX_ENCODED];
        let encoded = set.encode(&mut buffer)?;
        let id = CoefficientSet::id_of(encoded);
        let before = client.active_set()?;
        let active = client.upload(encoded, &key)?;
        let what = if before.is_some_and(|before| before.id == id) {
            "was active already and nothing was changed: it"
        } else {
            "is active and"
        };
        say!(
            "set {id} {what} reads back identical (change {} of this board)",
            active.sequence
        )?;
        Ok(())
    }
}
