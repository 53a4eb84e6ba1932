//! What went wrong since the start: how often, and when last. Every part of the board counts here what it loses.
//!
//! Only the host acts on these counts; it reads them in the status. Two counts are kept elsewhere: the sample path counts
//! the blocks that the link had no room for, in fixed time, and [`super::flash_errors`] counts torn words.

use core::cell::Cell;

use embassy_sync::blocking_mutex::Mutex;
use embassy_time::Instant;
use hexsense_core::wire::status::{EventCount, Events};

use crate::shared::Guard;

static EVENTS: Mutex<Guard, Cell<Events>> = Mutex::new(Cell::new(Events::NONE));

/// Counts one more of the events that `pick` chooses, now.
pub fn note(pick: fn(&mut Events) -> &mut EventCount) {
    let uptime_ms = Instant::now().as_millis();
    EVENTS.lock(|events| {
        let mut all = events.get();
        pick(&mut all).note(uptime_ms);
        events.set(all);
    });
}

/// All that was counted here: torn words and dropped blocks are not.
pub fn all() -> Events {
    EVENTS.lock(Cell::get)
}
