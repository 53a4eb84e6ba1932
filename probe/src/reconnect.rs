//! A board that went away during a recording, and comes back.
//!
//! The port is opened again and again until a board answers on it. Then two things are asked that a recording depends on:
//! whether it is the same board, by the unique id of its chip, and whether it went on meanwhile or started anew. It has
//! started anew when its scan counter is behind what was heard before, or when it has been up for less time than it was
//! away; the latter says nothing of a virtual board in lockstep, whose time stands still while it is away.

use std::thread;
use std::time::{Duration, Instant};

use hexsense_core::wire::status::ResetCause;

use crate::files;
use crate::interrupt::{Interrupt, Interrupted};
use hexsense_client::{Client, Contact, LinkError, ProtocolError};

/// Pause between two tries.
const PAUSE: Duration = Duration::from_millis(200);
/// How often it is said that the board is still away.
const SAY_EVERY: Duration = Duration::from_secs(10);

/// How a board is waited for.
#[derive(Debug, Clone, Copy)]
pub struct Patience<'a> {
    /// Unique id of its chip.
    pub board: [u8; 12],
    /// How long it may be away.
    pub wait: Duration,
    /// What ends the waiting early.
    pub interrupt: &'a Interrupt,
}

/// The same board again.
pub struct Back {
    /// The board; it does not stream.
    pub client: Client,
    /// Why it started anew, if it did.
    pub restarted: Option<ResetCause>,
}

/// Why recording cannot go on.
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
    /// Somebody asked to stop meanwhile.
    #[error("{0}")]
    Interrupted(#[from] Interrupted),
}

/// Waits for the board of `client`, which is lost as `lost` says.
///
/// # Errors
/// [`NotBack`].
pub fn reconnect(client: Client, lost: String, patience: Patience) -> Result<Back, NotBack> {
    let (port, contact) = (client.port().to_owned(), client.contact());
    // Most ports are open to one at a time.
    drop(client);
    let mut client = open(&port, lost, patience)?;
    let identity = client.identity()?;
    if identity.board != patience.board {
        return Err(NotBack::Other {
            port,
            board: files::hex(&patience.board),
            found: files::hex(&identity.board),
        });
    }
    let restarted = has_restarted(&mut client, contact)?.then_some(identity.reset);
    Ok(Back { client, restarted })
}

/// Opens the port as soon as a board answers on it.
fn open(port: &str, lost: String, patience: Patience) -> Result<Client, NotBack> {
    let start = Instant::now();
    let mut say = Duration::ZERO;
    loop {
        patience.interrupt.check()?;
        let waited = start.elapsed();
        if waited >= patience.wait {
            return Err(NotBack::Away { lost, waited });
        }
        if waited >= say {
            let left = (patience.wait - waited).as_secs_f64().ceil();
            eprintln!("waiting {left} s for the board to come back on {port}");
            say = waited + SAY_EVERY;
        }
        match Client::open(port) {
            Ok(client) => return Ok(client),
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
