//! A recording of a given length, outside of campaigns: the scans and a note of what they belong to.

use std::path::{Path, PathBuf};
use std::time::Duration;

use hexsense_client::Client;
use hexsense_core::wire::StreamContent;
use serde_json::json;

use super::board::Streaming;
use super::csv::CsvSink;
use super::error::RecordError;
use super::event::{Event, Show};
use super::reconnect::{Patience, reconnect};
use super::recorder::Recorder;
use super::sink::{Notes, Recorded};
use crate::files;
use crate::interrupt::Interrupt;

/// What is recorded, and where to.
pub struct TimedJob<'a> {
    /// How the board streams.
    pub streaming: Streaming,
    /// Length, s.
    pub seconds: f64,
    /// The capture file; the note is FILE.json beside it.
    pub out: &'a Path,
    /// How long a board that went away is waited for.
    pub wait: Duration,
    /// Asks to stop.
    pub interrupt: &'a Interrupt,
}

/// A recording that broke off.
#[derive(Debug)]
pub struct TimedError {
    /// Why.
    pub reason: Box<RecordError>,
    /// What is recorded; `None` when the board refused to stream, or a file could not be begun.
    pub recorded: Option<Recorded>,
}

impl<E: Into<RecordError>> From<E> for TimedError {
    fn from(reason: E) -> Self {
        Self {
            reason: Box::new(reason.into()),
            recorded: None,
        }
    }
}

impl TimedJob<'_> {
    /// Makes the recording. When the board goes away, it is waited for, and the scans of that time are a gap. The stream is
    /// off afterwards.
    ///
    /// # Errors
    /// [`TimedError`].
    pub fn record(&self, client: &mut Client, show: Show) -> Result<Recorded, TimedError> {
        let identity = client.identity()?;
        let board = identity.board;
        let mut recorder = Recorder::start(client, self.streaming, self.interrupt)?;
        show(&Event::Streams {
            seconds: self.seconds,
            streaming: self.streaming,
            link_load: self.streaming.link_load(&identity.facts),
        });
        let notes = recorder.notes().clone();
        files::write_part(&self.note_path(), &note(&notes, None))?;
        recorder.begin(vec![Box::new(CsvSink::new(self.out.to_owned()))])?;
        let patience = Patience {
            board,
            wait: self.wait,
            interrupt: self.interrupt,
        };
        let followed = self.follow(&mut recorder, patience, show);
        // The line may be what failed; the error at hand says so.
        let _ = recorder.client().stream(StreamContent::default());
        if let Err(reason) = followed {
            return Err(TimedError {
                reason: Box::new(reason),
                recorded: Some(recorder.recorded().clone()),
            });
        }
        let missing = recorder.client().frames_missing();
        if missing > 0 {
            show(&Event::FramesMissing(missing));
        }
        let recorded = recorder.end()?;
        files::replace(&self.note_path(), &note(&notes, Some(&recorded)))?;
        Ok(recorded)
    }

    fn note_path(&self) -> PathBuf {
        self.out.with_extension("json")
    }

    /// Records blocks until there are enough.
    fn follow(
        &self,
        recorder: &mut Recorder,
        patience: Patience,
        show: Show,
    ) -> Result<(), RecordError> {
        let length = (self.seconds * f64::from(self.streaming.rate_hz)).ceil() as u64;
        let (mut start, mut is_heard) = (None, true);
        while start.is_none_or(|start| recorder.next_scan() < start + length) {
            match recorder.next_block() {
                Ok(block) => {
                    start.get_or_insert(block.header.first_scan);
                    is_heard = true;
                }
                // Only once in a row: a board that comes back and sends nothing must not be waited for without end.
                Err(error) if error.is_loss() && is_heard => {
                    is_heard = false;
                    self.find_again(recorder.client(), &error, patience, show)?;
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Waits for a board that went away. It must have gone on counting scans.
    fn find_again(
        &self,
        client: &mut Client,
        lost: &RecordError,
        patience: Patience,
        show: Show,
    ) -> Result<(), RecordError> {
        let lost = lost.to_string();
        show(&Event::Away {
            run: None,
            lost: &lost,
        });
        if let Some(cause) = reconnect(client, lost, patience, show)? {
            return Err(RecordError::RestartedAway { cause });
        }
        client.stream(self.streaming.content)?;
        show(&Event::GoesOn);
        Ok(())
    }
}

/// What the recording belongs to, and what is in it when it is complete.
fn note(notes: &Notes, recorded: Option<&Recorded>) -> String {
    let mut note = json!({
        "board": notes.board.board,
        "firmware": notes.board.firmware,
        "build": notes.board.build,
        "set": notes.set.map(|set| set.to_string()),
        "rate_hz": notes.rate_hz,
        "block": notes.block.scans(),
    });
    if let Some(recorded) = recorded {
        let gaps = recorded.gaps.iter();
        let gaps = gaps.map(|gap| json!({"first_scan": gap.first_scan, "scans": gap.scans}));
        note["scans"] = recorded.scans.into();
        note["scans_lost"] = recorded.lost.into();
        note["gaps"] = gaps.collect();
    }
    format!("{note:#}\n")
}
