//! One function for each request, with an answer of the right type.

use std::time::Duration;

use hexsense_core::harmonics::ChannelSums;
use hexsense_core::live_motion::Motion;
use hexsense_core::records::MAX_ENCODED;
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::message::{ActiveSet, ChannelHarmonics};
use hexsense_core::wire::telemetry::Block;
use hexsense_core::wire::{
    AnalyserState, Drive, Identity, PoseRefusal, PoseReport, Request, Response, Status,
    StreamContent,
};

use super::bounds;
use super::conversation::{Contact, Conversation, answer_error};
use super::error::LinkError;
use super::port;
use super::transport::{Ended, Transport};

/// A board that has greeted and speaks our version.
pub struct Client {
    pub(super) conversation: Conversation,
    firmware: [u8; 3],
}

/// Harmonic sums of one channel with what they belong to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SumsReport {
    /// How far the sums are.
    pub state: AnalyserState,
    /// What is being estimated.
    pub drive: Drive,
    /// Scan counter of the first scan in the sums.
    pub first_scan: u64,
    /// The sums.
    pub sums: ChannelSums,
}

/// Harmonics of one channel with what they belong to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HarmonicsReport {
    /// What was estimated.
    pub drive: Drive,
    /// Scan counter of the first scan in the sums.
    pub first_scan: u64,
    /// What the board found.
    pub harmonics: ChannelHarmonics,
}

/// How long the board may work on a fit: two million blocks take it some ten seconds.
const MAX_SOLVE: Duration = Duration::from_secs(60);
/// How long the board may take from its start until it knows its build; it needs a tenth of that.
const BUILD_WAIT: Duration = Duration::from_secs(1);

impl Client {
    /// Opens `port` and makes sure that a board of our version is behind it. Nothing changes on the board: a stream that
    /// is on goes on.
    ///
    /// # Errors
    /// [`LinkError`], among them another wire version.
    pub fn open(port: &str) -> Result<Self, LinkError> {
        Self::connect(port::open(port)?)
    }

    /// The same on an open transport.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn connect(transport: Box<dyn Transport>) -> Result<Self, LinkError> {
        let mut conversation = Conversation::new(transport);
        let firmware = conversation.greet()?.firmware;
        Ok(Self {
            conversation,
            firmware,
        })
    }

    /// Ends the connection and opens the port again, for a board that went away. Waiting blocks are dropped. After an error
    /// there is no connection, and the call may be repeated.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn reopen(&mut self) -> Result<(), LinkError> {
        let port = self.port().to_owned();
        // The old connection ends first: a port is open to one at a time.
        self.conversation = Conversation::new(Box::new(Ended { port: port.clone() }));
        let mut conversation = Conversation::new(port::open(&port)?);
        self.firmware = conversation.greet()?.firmware;
        self.conversation = conversation;
        Ok(())
    }

    /// Version of the board's firmware: major, minor, patch.
    #[must_use]
    pub fn firmware(&self) -> [u8; 3] {
        self.firmware
    }

    /// The port as it was asked for.
    #[must_use]
    pub fn port(&self) -> &str {
        self.conversation.port()
    }

    /// Whether the board's clock goes on while no host waits for it.
    #[must_use]
    pub fn is_real_time(&self) -> bool {
        self.conversation.is_real_time()
    }

    /// Frames of telemetry, blocks and poses, that the board sent on this connection and that did not arrive.
    pub fn frames_missing(&self) -> u64 {
        self.conversation.frames_missing()
    }

    /// When and where the board was heard last.
    #[must_use]
    pub fn contact(&self) -> Contact {
        self.conversation.contact()
    }

    /// Time by the clock of the transport.
    #[must_use]
    pub fn now(&self) -> Duration {
        self.conversation.now()
    }

    /// The next block of samples, waiting at most for `timeout`.
    ///
    /// # Errors
    /// [`super::ProtocolError::NoSamples`] when nothing comes in time, and the errors of the line.
    pub fn block(&mut self, timeout: Duration) -> Result<Block, LinkError> {
        self.conversation.block(timeout)
    }

    /// The next pose, waiting at most for `timeout`.
    ///
    /// # Errors
    /// [`super::ProtocolError::NoSamples`] when nothing comes in time, and the errors of the line.
    pub fn pose(&mut self, timeout: Duration) -> Result<PoseReport, LinkError> {
        self.conversation.pose(timeout)
    }

    /// The poses that came beside the blocks and were not taken yet.
    pub fn take_poses(&mut self) -> Vec<PoseReport> {
        self.conversation.take_poses()
    }

    /// Forgets the blocks and poses that wait.
    pub fn forget_blocks(&mut self) {
        self.conversation.forget_blocks();
    }

    /// Identity of the board. A board that has just started is asked until it knows its build, at most for a second.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn identity(&mut self) -> Result<Identity, LinkError> {
        let end = self.now() + BUILD_WAIT;
        loop {
            let Response::Identity(identity) = self.conversation.ask(&Request::Identity)? else {
                return Err(answer_error(&Request::Identity));
            };
            bounds::facts(&identity.facts)?;
            if identity.build.is_some() || self.now() >= end {
                return Ok(identity);
            }
        }
    }

    /// State of the board.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn status(&mut self) -> Result<Status, LinkError> {
        match self.conversation.ask(&Request::Status)? {
            Response::Status(status) => {
                bounds::status(&status)?;
                Ok(status)
            }
            _ => Err(answer_error(&Request::Status)),
        }
    }

    /// Starts, changes or stops the stream of blocks.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn stream(&mut self, content: StreamContent) -> Result<(), LinkError> {
        self.conversation.command(&Request::Stream(content))
    }

    /// Sets the scan rate, Hz.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn rate(&mut self, hz: u32) -> Result<(), LinkError> {
        self.conversation.command(&Request::Rate(hz))
    }

    /// Sets how many scans the board takes at a time.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn block_size(&mut self, block: BlockSize) -> Result<(), LinkError> {
        self.conversation.command(&Request::Block(block))
    }

    /// Starts harmonic sums of an analyser, 0 to 2, from the next block on.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn drive(&mut self, analyser: u8, drive: Drive) -> Result<(), LinkError> {
        self.conversation
            .command(&Request::Drive { analyser, drive })
    }

    /// Harmonic sums of an analyser, 0 to 2, in one channel, 0 to 14.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn sums(&mut self, analyser: u8, channel: u8) -> Result<SumsReport, LinkError> {
        let request = Request::Sums { analyser, channel };
        match self.conversation.ask(&request)? {
            Response::Sums {
                state,
                drive,
                first_scan,
                sums,
            } => {
                bounds::first_scan("harmonic sums", first_scan)?;
                Ok(SumsReport {
                    state,
                    drive,
                    first_scan,
                    sums,
                })
            }
            _ => Err(answer_error(&request)),
        }
    }

    /// Harmonics of an analyser, 0 to 2, in one channel, 0 to 14, as the board solves them from its complete sums.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn harmonics(&mut self, analyser: u8, channel: u8) -> Result<HarmonicsReport, LinkError> {
        let request = Request::Harmonics { analyser, channel };
        match self.conversation.ask_patiently(&request, MAX_SOLVE)? {
            Response::Harmonics {
                drive,
                first_scan,
                harmonics,
            } => {
                bounds::first_scan("harmonics", first_scan)?;
                Ok(HarmonicsReport {
                    drive,
                    first_scan,
                    harmonics,
                })
            }
            _ => Err(answer_error(&request)),
        }
    }

    /// How the base moved at the drive frequency of an analyser, 0 to 2, or why the board's jacks give no pose.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn motion(&mut self, analyser: u8) -> Result<Result<Motion, PoseRefusal>, LinkError> {
        let request = Request::Motion { analyser };
        match self.conversation.ask_patiently(&request, MAX_SOLVE)? {
            Response::Motion { motion, .. } => Ok(motion),
            _ => Err(answer_error(&request)),
        }
    }

    /// Which set is active; `None` without one.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn active_set(&mut self) -> Result<Option<ActiveSet>, LinkError> {
        match self.conversation.ask(&Request::ActiveSet)? {
            Response::ActiveSet(active) => {
                active.as_ref().map_or(Ok(()), bounds::active_set)?;
                Ok(active)
            }
            _ => Err(answer_error(&Request::ActiveSet)),
        }
    }

    /// The active set and its encoded bytes; `None` without one.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn read_set(&mut self) -> Result<Option<(ActiveSet, Vec<u8>)>, LinkError> {
        let Some(active) = self.active_set()? else {
            return Ok(None);
        };
        let length = usize::from(active.length);
        let mut encoded = Vec::with_capacity(MAX_ENCODED);
        while encoded.len() < length {
            let request = Request::ReadSet {
                offset: encoded.len() as u16,
            };
            match self.conversation.ask(&request)? {
                Response::SetBytes { offset, bytes }
                    if usize::from(offset) == encoded.len()
                        && (1..=length - encoded.len()).contains(&bytes.len()) =>
                {
                    encoded.extend_from_slice(&bytes);
                }
                _ => return Err(answer_error(&request)),
            }
        }
        Ok(Some((active, encoded)))
    }
}
