//! What happens while something is recorded, for the program that shows it.

use std::fmt;

use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::status::ResetCause;

use super::board::Streaming;
use crate::capture::Torn;
use crate::files::FileError;

/// Shows an event. Its text is for people; progress has no text.
pub type Show<'a> = &'a mut dyn FnMut(&Event);

/// Something that happens while something is recorded.
#[derive(Debug)]
pub enum Event<'a> {
    /// The board streams, and a recording of a given length begins.
    Streams {
        /// Its length, s.
        seconds: f64,
        /// How the board streams.
        streaming: Streaming,
        /// Share of what the link carries of telemetry that the stream takes at most.
        link_load: f64,
    },
    /// A run is skipped.
    RecordedAlready(Place<'a>),
    /// A run comes next.
    Next {
        /// The run and its place.
        place: Place<'a>,
        /// Its length, s.
        duration_s: f64,
        /// Scans that the board takes at a time in it.
        block: BlockSize,
    },
    /// An earlier recording of the run broke off.
    BrokeOffBefore {
        /// The run.
        run: &'a str,
        /// The scans that it left, and its torn row; or why its file cannot be read.
        left: Result<(usize, Option<Torn>), FileError>,
    },
    /// The recording of a run begins.
    Begins {
        /// The run.
        run: &'a str,
        /// Its length with what is recorded after it, s.
        duration_s: f64,
    },
    /// What the recording waits for; empty while the program runs.
    Phase(&'static str),
    /// So much of the run is recorded, s.
    Progress(f64),
    /// The recording has ended, well or not.
    Ends,
    /// Scans of a run did not arrive.
    Lost {
        /// The run.
        run: &'a str,
        /// How many.
        lost: u64,
        /// Scans that arrived.
        scans: u64,
    },
    /// The board went away.
    Away {
        /// The run that was being recorded; `None` for a recording outside a campaign.
        run: Option<&'a str>,
        /// How it was lost.
        lost: &'a str,
    },
    /// The board is waited for.
    Waiting {
        /// The port.
        port: &'a str,
        /// How much longer, s.
        left_s: f64,
    },
    /// The board is back.
    Back {
        /// Why it restarted, if it did.
        restarted: Option<ResetCause>,
    },
    /// The run is recorded again.
    Again {
        /// The run.
        run: &'a str,
    },
    /// The recording goes on after a time in which the board was away.
    GoesOn,
    /// Frames of the stream that did not arrive whole.
    FramesMissing(u64),
}

/// The place of a run in its campaign.
#[derive(Debug, Clone, Copy)]
pub struct Place<'a> {
    /// From 1.
    pub number: usize,
    /// Runs in all.
    pub of: usize,
    /// The run.
    pub run: &'a str,
}

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "run {} of {}: {}", self.number, self.of, self.run)
    }
}

impl Event<'_> {
    /// The event in words; `None` for events that only a progress bar shows.
    #[must_use]
    pub fn text(&self) -> Option<String> {
        Some(match self {
            Self::Begins { .. } | Self::Phase(_) | Self::Progress(_) | Self::Ends => return None,
            Self::Streams {
                seconds,
                streaming,
                link_load,
            } => format!(
                "recording {seconds} s at {} Hz in blocks of {}: {:.0} % of what the link carries",
                streaming.rate_hz,
                streaming.block.scans(),
                100.0 * link_load
            ),
            Self::RecordedAlready(place) => format!("{place} is recorded already"),
            Self::Next {
                place,
                duration_s,
                block,
            } => format!(
                "{place}, {duration_s:.0} s, in blocks of {} scans",
                block.scans()
            ),
            Self::BrokeOffBefore { run, left } => {
                let left = match left {
                    Ok((scans, None)) => format!(", after {scans} scans"),
                    Ok((scans, Some(torn))) => format!(", after {scans} scans; {torn}"),
                    Err(error) => format!(": {error}"),
                };
                format!("run {run} broke off before{left}; it is recorded again from its start")
            }
            Self::Lost { run, lost, scans } => {
                format!("run {run}: {lost} of {scans} scans were lost on the way")
            }
            Self::Away { run, lost } => match run {
                Some(run) => format!("run {run}: {lost}"),
                None => (*lost).to_owned(),
            },
            Self::Waiting { port, left_s } => {
                format!("waiting {left_s} s for the board to come back on {port}")
            }
            Self::Back { restarted } => match restarted {
                Some(cause) => format!("the board is back; it has restarted ({cause:?})"),
                None => "the board is back; it has kept sampling".to_owned(),
            },
            Self::Again { run } => format!("run {run} is recorded again from its start"),
            Self::GoesOn => {
                "the board is back and has kept sampling; the scans that are missing are a gap"
                    .to_owned()
            }
            Self::FramesMissing(frames) => {
                format!("{frames} frames of the stream did not arrive whole")
            }
        })
    }
}
