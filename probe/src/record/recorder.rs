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
use hexsense_core::wire::StreamContent;
use hexsense_core::wire::telemetry::{Block, Header};

use super::board::{Streaming, board_record};
use super::error::RecordError;
use super::sink::{Notes, Recorded, Sink};
use crate::capture::Gap;
use crate::interrupt::Interrupt;

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
        is_fit(block)?;
        self.next_scan = first_scan + u64::from(scans);
        if !self.is_wanted(block) {
            // It becomes part of the next gap.
            return Ok(());
        }
        let is_first = self.recorded.scans == 0;
        if let Some(gap) = Gap::between(self.end, first_scan).filter(|_| !is_first) {
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

/// Refuses a block whose counts have no known scale, and numbers that are none.
fn is_fit(block: &Block) -> Result<(), RecordError> {
    let header = &block.header;
    let scan = header.first_scan;
    if header.supply_is_old {
        return Err(RecordError::OldSupply { scan });
    }
    let values = block.values.iter().flatten().flatten();
    let whats = [
        ("a supply factor", header.supply.is_finite()),
        ("a temperature", header.temperature_c.is_finite()),
        ("a value", values.copied().all(f32::is_finite)),
    ];
    match whats.into_iter().find(|(_, finite)| !finite) {
        Some((what, _)) => Err(RecordError::NotFinite { scan, what }),
        None => Ok(()),
    }
}
