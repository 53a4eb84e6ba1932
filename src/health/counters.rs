//! What went wrong since the start: how often, and when last. Every part of the board counts here what it loses.
//!
//! Nothing else is kept here, and nobody acts on it but the host, who reads it in the status. Blocks that the link had no
//! room for are the exception: the sample path counts them itself, in fixed time.

use core::cell::Cell;

use embassy_sync::blocking_mutex::Mutex;
use embassy_time::Instant;
use hexsense_core::wire::FrameError;
use hexsense_core::wire::status::{Events, EventCount};

use super::ecc;
use super::exchange::Guard;

static EVENTS: Mutex<Guard, Cell<Events>> = Mutex::new(Cell::new(Events::NONE));

/// Counts one more of what `tally` picks, now.
pub fn note(tally: fn(&mut Events) -> &mut EventCount) {
    let uptime_ms = Instant::now().as_millis();
    EVENTS.lock(|events| {
        let mut all = events.get();
        tally(&mut all).note(uptime_ms);
        events.set(all);
    });
}

/// All that was counted.
pub fn all() -> Events {
    Events {
        torn_words: ecc::torn_words(),
        ..EVENTS.lock(Cell::get)
    }
}

/// Length of a frame. Everything that is sent fits one, so an error here is a mistake of the build; the host will ask
/// again.
pub fn sendable(encoded: Result<usize, FrameError>) -> Option<usize> {
    encoded
        .inspect_err(|_| note(|events| &mut events.frames_unsent))
        .ok()
}
