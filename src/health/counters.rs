//! What went wrong since the start: how often, and when last. Every part of the board counts here what it loses.
//!
//! Only the host acts on these counts; it reads them in the status. Two counts are kept elsewhere: the sample path counts
//! the blocks that the link had no room for, in fixed time, and [`super::flash_errors`] counts torn words.

use core::cell::RefCell;

use embassy_sync::blocking_mutex::Mutex;
use embassy_time::Instant;
use hexsense_core::wire::status::{EventCount, Events};

use crate::shared::Guard;

static EVENTS: Mutex<Guard, RefCell<Events>> = Mutex::new(RefCell::new(Events::NONE));

/// Counts one more of the events that `pick` chooses, now.
#[inline(never)]
pub fn note(pick: fn(&mut Events) -> &mut EventCount) {
    let uptime_ms = Instant::now().as_millis();
    EVENTS.lock(|events| {
        // Nothing else has them now; the panic that `borrow_mut` would end in is left out.
        if let Ok(mut events) = events.try_borrow_mut() {
            pick(&mut events).note(uptime_ms);
        }
    });
}

/// All that was counted here: torn words and dropped blocks are not.
pub fn all() -> Events {
    EVENTS.lock(|events| *events.borrow())
}
