//! Requests, responses and refusals.

use serde::{Deserialize, Serialize};

use crate::facts::BoardFacts;
use crate::harmonics::{
    AnalyserState, ChannelSums, Drive, HARMONICS, Harmonic, Harmonics, Uncertainty,
};
use crate::live_motion::Motion;
use crate::records::log::Entry;
use crate::records::{BuildId, SetId};
use crate::sampling::BlockSize;
use crate::wire::change::{Challenge, Change, ProofChallenge, Statement, Tag};
use crate::wire::frame::{self, FrameError, Kind};
use crate::wire::log::{Nonce, Volume};
use crate::wire::pose::PoseRefusal;
use crate::wire::refusal::Refusal;
use crate::wire::status::{ResetCause, Status};

/// Bytes of a coefficient set that travel in one message.
pub const CHUNK: usize = 128;
/// Log entries that travel in one message.
pub const LOG_ENTRIES: usize = 4;
/// A piece of an encoded coefficient set.
pub type Chunk = heapless::Vec<u8, CHUNK>;

/// What the host may ask. Every request is answered by exactly one [`Response`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// Who are you? → [`Response::Identity`].
    Identity,
    /// How are you? → [`Response::Status`].
    Status,
    /// Start, change or stop the stream of blocks and poses → [`Response::Done`].
    Stream(StreamContent),
    /// Set the scan rate, Hz; one of [`BoardFacts::rates_hz`]. As with [`Request::Block`], the analysers stop and
    /// the scan counter goes on → [`Response::Done`].
    Rate(u32),
    /// Set the number of scans in a block. The converters restart and the analysers stop; the scan counter goes on and
    /// counts the scans of the pause as lost → [`Response::Done`].
    Block(BlockSize),
    /// Estimate at this drive frequency from the next block on; the other analysers and the stream go on →
    /// [`Response::Done`].
    Drive {
        /// Index of the analyser, 0 to 2.
        analyser: u8,
        /// What to estimate; made for the block that the board takes now.
        drive: Drive,
    },
    /// Sums of one channel at the drive frequency of one analyser → [`Response::Sums`].
    Sums {
        /// Index of the analyser, 0 to 2.
        analyser: u8,
        /// Index of the channel in a scan, 0 to 14.
        channel: u8,
    },
    /// Which set is active? → [`Response::ActiveSet`].
    ActiveSet,
    /// Bytes of the active set from `offset` on → [`Response::SetBytes`].
    ReadSet {
        /// Offset in the encoded set, bytes.
        offset: u16,
    },
    /// One of the kept sets → [`Response::Kept`].
    History {
        /// How many places older it is than the newest.
        age: u8,
    },
    /// Entries of the log of changes → [`Response::Log`].
    Log {
        /// Counter of the first entry that is wanted; the oldest entry has 1.
        counter: u32,
    },
    /// Random bytes for the tag of a change → [`Response::Challenge`].
    Challenge,
    /// A change of what the board keeps, see [`super::change`]. It ends an upload under way → [`Response::Done`] for an
    /// upload, whose pieces may then come, for a key and for a new volume; [`Response::Committed`] for a rollback;
    /// [`Response::Erased`] for a factory reset.
    Change {
        /// What to do.
        change: Change,
        /// Proof that the change comes from the key holder.
        #[serde(deserialize_with = "crate::bytes::read")]
        tag: Tag,
    },
    /// The next piece of the set → [`Response::Done`].
    UploadChunk {
        /// Offset in the encoded set, bytes: exactly what has arrived so far.
        offset: u16,
        /// The bytes.
        bytes: Chunk,
    },
    /// Check the whole set, store it, read it back, make it active → [`Response::Committed`].
    UploadCommit,
    /// Forget the upload under way → [`Response::Done`].
    UploadAbort,
    /// Harmonics of one channel from the complete sums of one analyser, solved by the board → [`Response::Harmonics`].
    /// [`Refusal::Busy`] while the board works through a long window: ask again.
    Harmonics {
        /// Index of the analyser, 0 to 2.
        analyser: u8,
        /// Index of the channel in a scan, 0 to 14.
        channel: u8,
    },
    /// Motion of the base at the drive frequency of one analyser, and each sensor's signal of it →
    /// [`Response::Motion`]; refused without an active set, otherwise as [`Request::Harmonics`].
    Motion {
        /// Index of the analyser, 0 to 2.
        analyser: u8,
    },
    /// Prove that you have the key, see [`super::change`]. The board's own challenge and an upload under way are void
    /// afterwards → [`Response::Proof`]; [`Refusal::Busy`] within 10 ms of the proof before.
    Prove {
        /// Random bytes of the host.
        #[serde(deserialize_with = "crate::bytes::read")]
        challenge: ProofChallenge,
    },
    /// Sign the log, see [`super::log`] → [`Response::LogProof`].
    LogProof {
        /// A number of the host's.
        #[serde(deserialize_with = "crate::bytes::read")]
        nonce: Nonce,
    },
}

/// What the stream carries: counts and values in blocks, the pose in frames of its own.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StreamContent {
    /// Raw counts of all fifteen channels.
    pub counts: bool,
    /// The nine calibrated values; refused without an active set.
    pub values: bool,
    /// The pose from the jacks; refused without an active set.
    pub pose: bool,
}

impl StreamContent {
    /// Whether there are blocks in the stream.
    #[must_use]
    pub const fn has_blocks(&self) -> bool {
        self.counts || self.values
    }
}

/// Answers.
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap, and a few answers exist at a time"
)]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Response {
    /// The request was carried out.
    Done,
    /// The request was not carried out, and nothing changed.
    Refused(Refusal),
    /// Who the board is.
    Identity(Identity),
    /// How the board is.
    Status(Status),
    /// Sums of one channel at the drive frequency.
    Sums {
        /// How far the sums are.
        state: AnalyserState,
        /// What is being estimated.
        drive: Drive,
        /// Scan counter of the first scan in the sums.
        first_scan: u64,
        /// The sums.
        sums: ChannelSums,
    },
    /// The active set, `None` when the board has none.
    ActiveSet(Option<ActiveSet>),
    /// Bytes of the active set.
    SetBytes {
        /// Offset of the first byte.
        offset: u16,
        /// At most [`CHUNK`] bytes; fewer at the end.
        bytes: Chunk,
    },
    /// The set is stored, read back and active.
    Committed(ActiveSet),
    /// A kept set; `None` when the board keeps no set of that age.
    Kept(Option<Kept>),
    /// Entries of the log, in the order of their counters.
    Log {
        /// Counter of the last entry there is, zero when there is none.
        last: u32,
        /// The entries asked for, as many as fit.
        entries: heapless::Vec<Entry, LOG_ENTRIES>,
    },
    /// Random bytes; a change must answer them within ten seconds.
    Challenge(Challenge),
    /// The sets are erased.
    Erased {
        /// How many sets were erased.
        sets: u8,
    },
    /// Harmonics of one channel.
    Harmonics {
        /// What was estimated.
        drive: Drive,
        /// Scan counter of the first scan in the sums.
        first_scan: u64,
        /// What the board found.
        harmonics: ChannelHarmonics,
    },
    /// The motion at the drive frequency.
    Motion {
        /// What was estimated.
        drive: Drive,
        /// Scan counter of the first scan in the sums.
        first_scan: u64,
        /// The motion, or why the jacks give none.
        motion: Result<Motion, PoseRefusal>,
    },
    /// The board has the key.
    Proof {
        /// What it says of itself.
        statement: Statement,
        /// Made with the key.
        tag: Tag,
    },
    /// The log's volume, signed.
    LogProof {
        /// What is signed.
        volume: Volume,
        /// The signature.
        mac: Tag,
    },
}

/// Harmonics of one channel as the board solves them, counts and rad at the trigger of the first scan.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ChannelHarmonics {
    /// Mean over the window, counts.
    pub offset: f64,
    /// Change from the window's start to its end, counts.
    pub drift: f64,
    /// Amplitude of each harmonic, counts.
    pub amplitude: [f64; HARMONICS],
    /// Phase φ of amplitude·cos(kθ − φ), rad.
    pub phase: [f64; HARMONICS],
    /// Root mean square of the residuals of the block means, counts.
    pub residual_rms: f64,
    /// Total harmonic distortion, as a fraction of the first amplitude.
    pub distortion: f64,
    /// Standard uncertainties.
    pub uncertainty: Uncertainty,
}

/// A set that the board keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Kept {
    /// Counter of the log entry of its upload.
    pub sequence: u32,
    /// Identity by content.
    pub id: SetId,
    /// Length of the encoded set, bytes.
    pub length: u16,
    /// When its campaign ended, seconds since 1970-01-01 UTC.
    pub made_unix_s: u64,
    /// When it was uploaded, by the host's clock.
    pub uploaded_unix_s: u64,
}

impl From<&Harmonics> for ChannelHarmonics {
    fn from(found: &Harmonics) -> Self {
        Self {
            offset: found.offset,
            drift: found.drift,
            amplitude: found.harmonics.each_ref().map(Harmonic::amplitude),
            phase: found.harmonics.each_ref().map(Harmonic::phase),
            residual_rms: found.residual_rms,
            distortion: found.distortion(),
            uncertainty: found.uncertainty,
        }
    }
}

/// Which set is active.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ActiveSet {
    /// Identity by content.
    pub id: SetId,
    /// Counter of the log entry of its upload.
    pub sequence: u32,
    /// Length of the encoded set, bytes.
    pub length: u16,
}

/// Who the board is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// Unique id of the microcontroller.
    pub board: [u8; 12],
    /// Name of the board and chip.
    pub hardware: heapless::String<32>,
    /// Why the board last started.
    pub reset: ResetCause,
    /// The numbers of this kind of board.
    pub facts: BoardFacts,
    /// Identity of its firmware; `None` in the first tenth of a second after a start, until the board has computed it.
    pub build: Option<BuildId>,
}

/// Encodes a request as a frame into `out` and returns its length.
///
/// # Errors
/// [`FrameError::Long`] when `out` is shorter than the frame.
pub fn encode_request(
    request: &Request,
    sequence: u16,
    out: &mut [u8],
) -> Result<usize, FrameError> {
    frame::encode_message(Kind::Request, request, sequence, out)
}

/// Encodes a response as a frame into `out` and returns its length.
///
/// # Errors
/// [`FrameError::Long`] when `out` is shorter than the frame.
pub fn encode_response(
    response: &Response,
    sequence: u16,
    out: &mut [u8],
) -> Result<usize, FrameError> {
    frame::encode_message(Kind::Response, response, sequence, out)
}

/// Decodes the payload of a request frame; `None` when it is not a request of this version.
#[must_use]
pub fn decode_request(payload: &[u8]) -> Option<Request> {
    frame::decode_message(payload)
}

/// Decodes the payload of a response frame; `None` when it is not a response of this version.
#[must_use]
pub fn decode_response(payload: &[u8]) -> Option<Response> {
    frame::decode_message(payload)
}
