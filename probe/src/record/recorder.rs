//! The recorder: the one owner of the board's stream while a recording is made.
//!
//! ```text
//! board ── block ── gap found ─┬─ every sink
//!                              └─ the caller: rest and onset of the base, progress, end of the recording
//! ```
//!
//! Missing scans are found here and in no other place. A request to stop takes effect between two blocks, and a stream from
//! which no block comes for two seconds is an error.

use std::time::Duration;

use hexsense_client::{Client, LinkError};
use hexsense_core::channel::NAMES;
use hexsense_core::wire::telemetry::{Block, Header};
use hexsense_core::wire::{Refusal, StreamContent};

use super::board::{Streaming, board_record};
use super::error::RecordError;
use super::sink::{Notes, Recorded, Sink};
use crate::capture::Gap;
use crate::interrupt::Interrupt;

/// Gaps that a recording may have; each costs the host memory and a line of the note.
const MAX_GAPS: usize = 65_536;
/// Blocks in a row that may hold something else than was asked for: those on their way when the stream was changed.
const MAX_OTHERS: u32 = 4_096;
/// The scan counter may fall behind time by so much, s, and by half of the time beside.
const MAX_BEHIND_S: f64 = 10.0;
/// How long the next block may take.
const BLOCK_WAIT: Duration = Duration::from_secs(2);

/// A stream of blocks on its way to the sinks.
pub struct Recorder<'a> {
    client: &'a mut Client,
    interrupt: &'a Interrupt,
    notes: Notes,
    sinks: Vec<Box<dyn Sink>>,
    recorded: Recorded,
    /// The scan after the last one in the recording.
    end: u64,
    /// The scan that is due next.
    next_scan: u64,
    /// Blocks in a row that did not hold what was asked for.
    others: u32,
    /// Time and scan from which the pace of the stream is counted.
    pace: Option<(Duration, u64)>,
}

impl<'a> Recorder<'a> {
    /// Starts the stream. Nothing is recorded before [`Recorder::begin`].
    ///
    /// # Errors
    /// What the link reports, and what the board refuses.
    pub fn start(
        client: &'a mut Client,
        streaming: Streaming,
        interrupt: &'a Interrupt,
    ) -> Result<Self, LinkError> {
        let Streaming {
            rate_hz,
            block,
            content,
        } = streaming;
        // A recording that was killed leaves its stream on.
        client.stream(StreamContent::default())?;
        let status = client.status()?;
        if status.rate_hz != rate_hz {
            client.rate(rate_hz)?;
        }
        if status.block != block {
            client.block_size(block)?;
        }
        let identity = client.identity()?;
        if !identity.facts.rates_hz.contains(&rate_hz) {
            return Err(Refusal::Rate { hz: rate_hz }.into());
        }
        let notes = Notes {
            board: board_record(client, &identity),
            set: client.active_set()?.map(|set| set.id),
            rate_hz,
            block,
            content,
        };
        client.forget_blocks();
        client.stream(content)?;
        Ok(Self {
            client,
            interrupt,
            notes,
            sinks: Vec::new(),
            recorded: Recorded::default(),
            end: 0,
            next_scan: 0,
            others: 0,
            pace: None,
        })
    }

    /// Begins the recording with the next block, into these sinks.
    ///
    /// # Errors
    /// [`RecordError::File`].
    pub fn begin(&mut self, sinks: Vec<Box<dyn Sink>>) -> Result<(), RecordError> {
        self.sinks = sinks;
        self.begin_again()
    }

    /// Drops what is recorded and begins again with the next block.
    ///
    /// # Errors
    /// [`RecordError::File`].
    pub fn begin_again(&mut self) -> Result<(), RecordError> {
        self.recorded = Recorded::default();
        for sink in &mut self.sinks {
            sink.begin(&self.notes)?;
        }
        Ok(())
    }

    /// Waits for the next block, gives it to the sinks, and returns it.
    ///
    /// # Errors
    /// [`RecordError`].
    pub fn next_block(&mut self) -> Result<Block, RecordError> {
        self.interrupt.check()?;
        let block = self.client.block(BLOCK_WAIT)?;
        self.take(&block)?;
        Ok(block)
    }

    fn take(&mut self, block: &Block) -> Result<(), RecordError> {
        let Header {
            first_scan,
            scans,
            set,
            ..
        } = block.header;
        if set != self.notes.set {
            return Err(RecordError::OtherSet { scan: first_scan });
        }
        if first_scan < self.next_scan {
            return Err(RecordError::Restarted {
                scan: first_scan,
                expected: self.next_scan,
            });
        }
        self.next_scan = first_scan + u64::from(scans);
        self.check_pace()?;
        if !self.is_wanted(block) {
            // It becomes part of the next gap.
            self.others += 1;
            return match self.others {
                blocks @ MAX_OTHERS.. => Err(RecordError::OtherContent { blocks }),
                _ => Ok(()),
            };
        }
        self.others = 0;
        check_finite(block)?;
        let is_first = self.recorded.scans == 0;
        if let Some(gap) = Gap::between(self.end, first_scan).filter(|_| !is_first) {
            if self.recorded.gaps.len() == MAX_GAPS {
                return Err(RecordError::Gaps { limit: MAX_GAPS });
            }
            self.recorded.lost += gap.scans;
            self.recorded.gaps.push(gap);
            for sink in &mut self.sinks {
                sink.gap(gap)?;
            }
        }
        for sink in &mut self.sinks {
            sink.block(block)?;
        }
        self.recorded.scans += u64::from(scans);
        self.end = self.next_scan;
        Ok(())
    }

    /// Whether scans pass about as fast as they are due. A recording ends with a scan, so that a counter which stands
    /// almost still would never let it end.
    fn check_pace(&mut self) -> Result<(), RecordError> {
        let (now, scan, rate_hz) = (self.client.now(), self.next_scan, self.notes.rate_hz);
        // A connection that was opened again has a clock of its own.
        let (since, from) = match self.pace {
            Some((since, from)) if since <= now => (since, from),
            _ => *self.pace.insert((now, scan)),
        };
        let (seconds, scans) = ((now - since).as_secs_f64(), scan - from);
        if scans as f64 >= (seconds / 2.0 - MAX_BEHIND_S) * f64::from(rate_hz) {
            return Ok(());
        }
        Err(RecordError::Slow {
            scans,
            seconds,
            rate_hz,
        })
    }

    /// Whether a block has what the recording shall hold.
    fn is_wanted(&self, block: &Block) -> bool {
        let StreamContent { counts, values, .. } = self.notes.content;
        (block.counts.is_some() || !counts) && (block.values.is_some() || !values)
    }

    /// The scan that is due next.
    #[must_use]
    pub fn next_scan(&self) -> u64 {
        self.next_scan
    }

    /// What the recording belongs to.
    #[must_use]
    pub fn notes(&self) -> &Notes {
        &self.notes
    }

    /// What is in the recording so far.
    #[must_use]
    pub fn recorded(&self) -> &Recorded {
        &self.recorded
    }

    /// The board, for requests beside the stream.
    pub fn client(&mut self) -> &mut Client {
        self.client
    }

    /// Completes the recording; the stream is the caller's to stop.
    ///
    /// # Errors
    /// [`RecordError::File`].
    pub fn end(mut self) -> Result<Recorded, RecordError> {
        for sink in &mut self.sinks {
            sink.end(&self.recorded)?;
        }
        Ok(self.recorded)
    }
}

/// Refuses numbers that are not finite: what is recorded is computed with.
fn check_finite(block: &Block) -> Result<(), RecordError> {
    let Header {
        first_scan,
        supply,
        temperature_c,
        ..
    } = block.header;
    let common = [
        ("the supply factor", first_scan, supply),
        ("the temperature", first_scan, temperature_c),
    ];
    let values = (first_scan..).zip(block.values.iter().flatten());
    let values = values.flat_map(|(scan, values)| {
        let named = NAMES.into_iter().zip(*values);
        named.map(move |(name, value)| (name, scan, value))
    });
    match common
        .into_iter()
        .chain(values)
        .find(|(.., value)| !value.is_finite())
    {
        Some((what, scan, value)) => Err(RecordError::NotFinite { what, scan, value }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;
