//! Why there is no campaign to work with.

use crate::files::FileError;
use crate::geometry_file::GeometryFileError;
use crate::plan::limits::BeyondLimit;

/// Why there is no campaign to work with.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// A file cannot be used.
    #[error(transparent)]
    File(#[from] FileError),
    /// The copy of the geometry file cannot be used.
    #[error(transparent)]
    Geometry(#[from] GeometryFileError),
    /// The base cannot make a movement.
    #[error("{file}: {reason}")]
    Limits {
        /// The plan.
        file: String,
        /// The movement and its limit.
        reason: BeyondLimit,
    },
    /// The folder belongs to something else.
    #[error("{folder} holds a campaign with {what}; choose another folder for this one")]
    Other {
        /// The folder.
        folder: String,
        /// What differs.
        what: String,
    },
    /// A run is missing.
    #[error("{folder} holds no recording of run {run}; record it with `hexsense {command}`")]
    NotRecorded {
        /// The folder.
        folder: String,
        /// The run.
        run: String,
        /// The command that records it.
        command: &'static str,
    },
    /// The plan has no run of this purpose.
    #[error("{file} plans no run to {purpose} with; add one with purpose = \"{purpose}\"")]
    NotPlanned {
        /// The plan.
        file: String,
        /// What the run would be for.
        purpose: &'static str,
    },
    /// A result is missing.
    #[error("{file} is missing: the campaign is not finished; finish it with `hexsense {command}`")]
    Unfinished {
        /// The missing file.
        file: String,
        /// The command that writes it.
        command: String,
    },
    /// A file or the captures are not those that the coefficients were found from.
    #[error(
        "{file} is not what the coefficients were found from; put the original back, or calibrate again in another \
         folder. Nothing has changed on the board"
    )]
    OtherSource {
        /// The file, or the folder of the captures.
        file: String,
    },
    /// There is no campaign to resume.
    #[error(
        "{folder} holds no campaign that was begun; begin it with `hexsense calibrate --geometry … --sensors … \
         --out {folder}`"
    )]
    NotBegun {
        /// The folder.
        folder: String,
    },
    /// What was given is not what the campaign was begun with.
    #[error(
        "{given} contradicts the campaign in {folder}, which was begun with {held}; leave it out to go on with that \
         campaign, or choose another folder"
    )]
    Contradiction {
        /// The argument as given.
        given: String,
        /// The folder.
        folder: String,
        /// What the folder holds instead.
        held: String,
    },
    /// The plan lacks what coefficients are fitted to.
    #[error("{file}: {what}. Nothing has moved")]
    Incomplete {
        /// The plan.
        file: String,
        /// What is not determined, and what to do.
        what: String,
    },
}
