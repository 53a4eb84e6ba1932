//! A board that went away during a recording, and comes back.
//!
//! The port is opened again and again until a board answers on it. Then two questions decide whether a recording can go on:
//! is it the same board, by the unique id of its chip, and did it go on sampling or restart? It has restarted when its scan
//! counter is below the last one heard, or when its uptime is shorter than the time that it was away. The uptime of a
//! virtual board in lockstep says nothing, because its time stands still while no host is connected.

use std::thread;
use std::time::{Duration, Instant};

use hexsense_core::wire::status::ResetCause;

use hexsense_client::{Client, Contact, LinkError, ProtocolError};

use super::event::{Event, Show};
use crate::files;
use crate::interrupt::{Interrupt, Interrupted};

/// Pause between two tries.
const PAUSE: Duration = Duration::from_millis(200);
/// How often an event tells that the board is still away.
const SAY_EVERY: Duration = Duration::from_secs(10);

/// The board that is waited for, and how long.
#[derive(Debug, Clone, Copy)]
pub struct Patience<'a> {
    /// Unique id of its chip.
    pub board: [u8; 12],
    /// How long it may be away.
    pub wait: Duration,
    /// What ends the waiting early.
    pub interrupt: &'a Interrupt,
}

/// Why the board is not back.
#[derive(Debug, thiserror::Error)]
pub enum NotBack {
    /// No board.
    #[error("{lost}{}", waited_for(waited))]
    Away {
        /// How it went.
        lost: String,
        /// How long it was waited for.
        waited: Duration,
    },
    /// Another board.
    #[error(
        "board {found} answers on {port} where board {board} was; connect that one again, or calibrate this one in \
         another folder"
    )]
    Other {
        /// The port.
        port: String,
        /// The board that was lost, in hexadecimal digits.
        board: String,
        /// The board that is there now.
        found: String,
    },
    /// The board answers and cannot be used.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// A request to stop came while the board was waited for.
    #[error("{0}")]
    Interrupted(#[from] Interrupted),
}

/// Waits for the board of `client`, which was lost as `lost` says, and connects to it again. Returns why it restarted, if it
/// did. Its stream stays as it is.
///
/// # Errors
/// [`NotBack`].
pub fn reconnect(
    client: &mut Client,
    lost: String,
    patience: Patience,
    show: Show,
) -> Result<Option<ResetCause>, NotBack> {
    let contact = client.contact();
    reopen(client, lost, patience, show)?;
    let identity = client.identity()?;
    if identity.board != patience.board {
        return Err(NotBack::Other {
            port: client.port().to_owned(),
            board: files::hex(&patience.board),
            found: files::hex(&identity.board),
        });
    }
    Ok(has_restarted(client, contact)?.then_some(identity.reset))
}

/// Opens the port as soon as a board answers on it.
fn reopen(
    client: &mut Client,
    lost: String,
    patience: Patience,
    show: Show,
) -> Result<(), NotBack> {
    let start = Instant::now();
    let mut say = Duration::ZERO;
    loop {
        patience.interrupt.check()?;
        let waited = start.elapsed();
        if waited >= patience.wait {
            return Err(NotBack::Away { lost, waited });
        }
        if waited >= say {
            show(&Event::Waiting {
                port: client.port(),
                left_s: (patience.wait - waited).as_secs_f64().ceil(),
            });
            say = waited + SAY_EVERY;
        }
        match client.reopen() {
            Ok(()) => return Ok(()),
            Err(error @ LinkError::Protocol(ProtocolError::Version { .. })) => {
                return Err(error.into());
            }
            Err(_) => thread::sleep(PAUSE),
        }
    }
}

/// The end of a sentence.
fn waited_for(waited: &Duration) -> String {
    match waited.as_secs() {
        0 => String::new(),
        seconds => format!("; it has not come back within {seconds} s"),
    }
}

fn has_restarted(client: &mut Client, before: Contact) -> Result<bool, LinkError> {
    let status = client.status()?;
    let away = before.at.elapsed();
    let up = Duration::from_millis(status.uptime_ms);
    Ok(status.scans < before.next_scan || (client.is_real_time() && up < away))
}
