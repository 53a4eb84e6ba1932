//! Where the built programs are: `cargo xtask` builds them and names each in a variable of the environment.

use std::path::PathBuf;

use anyhow::Context;

/// A built program.
#[derive(Debug, Clone, Copy)]
pub enum Program {
    /// The firmware's ELF.
    Firmware,
    /// The ELF that has the sample path beside others.
    SamplePathBench,
    /// The emulated board.
    VirtualBoard,
    /// The motion base.
    Twin,
    /// `hexsense`.
    HostTool,
}

impl Program {
    /// The variable that names its file.
    #[must_use]
    pub const fn variable(self) -> &'static str {
        match self {
            Self::Firmware => "HEXSENSE_FIRMWARE",
            Self::SamplePathBench => "HEXSENSE_SAMPLE_PATH_BENCH",
            Self::VirtualBoard => "HEXSENSE_VIRTUAL_BOARD",
            Self::Twin => "HEXSENSE_TWIN",
            Self::HostTool => "HEXSENSE_HOST_TOOL",
        }
    }

    /// Its file.
    pub fn path(self) -> anyhow::Result<PathBuf> {
        let variable = self.variable();
        let path = std::env::var_os(variable).with_context(|| {
            format!("{variable} must name a built program; `cargo xtask` builds it and sets the variable")
        })?;
        Ok(path.into())
    }
}
