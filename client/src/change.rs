//! Changes of the board's sets and key, each with its tag; see [`hexsense_core::wire::change`].
//!
//! ```text
//! identity, challenge → tag → change → answer, or a proof of the board and a look into its log
//! ```
//!
//! The beginning of an upload may be sent again when its answer is lost. Every other change must not be made twice: it is
//! sent once. When its answer is lost, the change may still be on its way, held back on the line. So the board first proves
//! itself ([`super::proof`]), which makes the change void if it has not arrived by then, and says by its key, its set and
//! its log whether the change was made. Without a proof nothing is claimed. A refusal is confirmed in the same way, because
//! whoever holds the line could have made it up.

use std::error::Error;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use hexsense_core::authority;
use hexsense_core::records::SetId;
use hexsense_core::records::log::Entry;
use hexsense_core::wire::change::{Act, Change, Key, Tag};
use hexsense_core::wire::log::{Nonce, Volume};
use hexsense_core::wire::message::{ActiveSet, Kept};
use hexsense_core::wire::{Refusal, Request, Response};

use super::bounds::{MAX_LOG, MAX_SETS, Said};
use super::client::Client;
use super::conversation::{ATTEMPTS, answer_error};
use super::error::LinkError;
use super::proof::ProofError;

/// How long a change may take on the board: with all erasures of a factory reset a quarter of a second.
pub(super) const CHANGE: Duration = Duration::from_millis(2_000);

/// The host's clock, seconds since 1970-01-01 UTC.
#[must_use]
pub fn unix_now() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    now.map_or(0, |now| now.as_secs())
}

/// Why a change was not made, or why it is not known whether it was made.
#[derive(Debug, thiserror::Error)]
pub enum ChangeError {
    /// The board refused.
    #[error(transparent)]
    Refused(Refusal),
    /// A virtual board still waits after a wrong key, and its time does not pass by itself.
    #[error(
        "after a wrong key the board takes no change for another {ms} ms of its own time, which stands still while no \
         host listens. Let it pass with `hexsense capture --seconds {} --out pause.csv --port {port}`, then use the \
         right key file",
        ms.div_ceil(1_000)
    )]
    StandsStill {
        /// Remaining wait, ms.
        ms: u32,
        /// The port.
        port: String,
    },
    /// The board did not have the change, and cannot make it any more.
    #[error("{0}. Nothing has changed on the board")]
    Before(LinkError),
    /// The board may have had the change, or may still get it.
    #[error(
        "it is not known whether the board made the change: {reason}. It is made whole or not at all, within ten \
         seconds; see which after that with `hexsense log --port {port}`"
    )]
    During {
        /// What went wrong.
        reason: String,
        /// The port.
        port: String,
    },
}

impl Client {
    /// Gives the board a key. `authority` is the key that it has now, or `new` itself on a board without a key.
    ///
    /// # Errors
    /// [`ChangeError`].
    pub fn provision(&mut self, authority: &Key, new: &Key) -> Result<(), ChangeError> {
        self.change(authority, Act::Provision(new.clone()))
            .map(drop)
    }

    /// Makes a kept set active again.
    ///
    /// # Errors
    /// [`ChangeError`].
    pub fn roll_back(&mut self, key: &Key, id: SetId) -> Result<ActiveSet, ChangeError> {
        let act = Act::Rollback(id);
        if let Some(Response::Committed(active)) = self.change(key, act)? {
            return Ok(active);
        }
        let active = self.active_set().map_err(|error| self.unknown(&error))?;
        active.ok_or_else(|| self.unknown(&answer_error(&Request::ActiveSet)))
    }

    /// Erases all sets, and returns those that were kept before.
    ///
    /// # Errors
    /// [`ChangeError`].
    pub fn factory_reset(&mut self, key: &Key) -> Result<Vec<Kept>, ChangeError> {
        let kept = self.history().map_err(|error| self.before(error))?;
        self.change(key, Act::FactoryReset)?;
        Ok(kept)
    }

    /// Closes the log's volume whose last entry has this counter, and begins the next.
    ///
    /// # Errors
    /// [`ChangeError`].
    pub fn new_volume(&mut self, key: &Key, last: u32) -> Result<(), ChangeError> {
        self.change(key, Act::NewVolume { last }).map(drop)
    }

    /// The sets that the board keeps, newest first.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn history(&mut self) -> Result<Vec<Kept>, LinkError> {
        let mut history = Vec::new();
        loop {
            let age = history.len() as u8;
            let request = Request::History { age };
            match self.conversation.ask(&request)? {
                Response::Kept(Some(kept)) => history.push(kept),
                Response::Kept(None) => return Ok(history),
                _ => return Err(answer_error(&request)),
            }
            let sets = history.len();
            Said("history of sets").within("the number of sets", sets, 0..=MAX_SETS)?;
        }
    }

    /// The entries of the log of changes from `counter` on.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn log(&mut self, counter: u32) -> Result<Vec<Entry>, LinkError> {
        let (mut log, mut next) = (Vec::new(), counter);
        loop {
            let (last, entries) = self.log_page(next)?;
            for entry in &entries {
                // They come in order and none comes twice, so that this ends.
                let numbers = next..=last.min(u32::MAX - 1);
                Said("log of changes").within("the number of an entry", entry.counter, numbers)?;
                next = entry.counter + 1;
            }
            log.extend_from_slice(&entries);
            let length = log.len();
            Said("log of changes").within("the number of entries", length, 0..=MAX_LOG)?;
            if entries.is_empty() || next > last {
                return Ok(log);
            }
        }
    }

    /// The log's volume, signed by the board with its key over this number.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn log_proof(&mut self, nonce: Nonce) -> Result<(Volume, Tag), LinkError> {
        let request = Request::LogProof { nonce };
        match self.conversation.ask(&request)? {
            Response::LogProof { volume, mac } => Ok((volume, mac)),
            _ => Err(answer_error(&request)),
        }
    }

    /// Counter of the last entry, and the first entries from `counter` on.
    fn log_page(&mut self, counter: u32) -> Result<(u32, Vec<Entry>), LinkError> {
        let request = Request::Log { counter };
        match self.conversation.ask(&request)? {
            Response::Log { last, entries } => Ok((last, entries.to_vec())),
            _ => Err(answer_error(&request)),
        }
    }

    /// The request of a change, with the tag that the board's next challenge asks for.
    fn tagged(&mut self, key: &Key, change: &Change) -> Result<Request, LinkError> {
        let board = self.identity()?.board;
        let Response::Challenge(challenge) = self.conversation.ask(&Request::Challenge)? else {
            return Err(answer_error(&Request::Challenge));
        };
        Ok(Request::Change {
            tag: authority::tag(key, &challenge, &board, change),
            change: change.clone(),
        })
    }

    /// Begins an upload; asked again, with a new challenge, when no answer comes.
    pub(super) fn begin_upload(&mut self, key: &Key, act: Act) -> Result<(), LinkError> {
        let unix_s = unix_now();
        let change = Change { unix_s, act };
        let start = self.now();
        let mut request = Request::Challenge;
        for _ in 0..ATTEMPTS {
            request = self.tagged(key, &change)?;
            match self.conversation.ask_once(&request, CHANGE)? {
                Some(Response::Done) => return Ok(()),
                Some(_) => return Err(answer_error(&request)),
                None => {}
            }
        }
        Err(self.conversation.silent(&request, ATTEMPTS, start).into())
    }

    /// Sends a change once; `None` when its answer was lost and the change was made.
    fn change(&mut self, key: &Key, act: Act) -> Result<Option<Response>, ChangeError> {
        let unix_s = unix_now();
        let change = Change { unix_s, act };
        let tagged = self.tagged(key, &change);
        let request = tagged.map_err(|error| self.before(error))?;
        let start = self.now();
        let error = match self.conversation.ask_once(&request, CHANGE) {
            Ok(Some(response)) => return Ok(Some(response)),
            Ok(None) => self.conversation.silent(&request, 1, start).into(),
            Err(LinkError::Refused(refusal)) => return Err(self.confirmed(key, refusal)),
            Err(error) => error,
        };
        match self.was_made(key, &change) {
            Ok(true) => Ok(None),
            Ok(false) => Err(ChangeError::Before(error)),
            Err(reason) => Err(self.unknown(&reason)),
        }
    }

    /// Whether a change without an answer was made. If it was not, it is void when this returns.
    fn was_made(&mut self, key: &Key, change: &Change) -> Result<bool, ProofError> {
        if let Act::Provision(new) = &change.act {
            return match self.prove(new) {
                Ok(_) => Ok(true),
                Err(ProofError::Link(LinkError::Refused(Refusal::Unprovisioned))) => Ok(false),
                Err(ProofError::WrongTag { .. }) => self.prove(key).map(|_| false),
                Err(error) => Err(error),
            };
        }
        let statement = self.prove(key)?;
        Ok(match change.act {
            Act::Rollback(id) => statement.set == Some(id),
            Act::NewVolume { last } if statement.changes != last.saturating_add(1) => false,
            Act::FactoryReset if statement.set.is_some() => false,
            // A board without a set looks the same before a factory reset and after it, and a new volume changes no set.
            _ => {
                let reason = change.act.reason();
                let is_it = |entry: &Entry| entry.reason == reason && entry.unix_s == change.unix_s;
                self.log(statement.changes)?.last().is_some_and(is_it)
            }
        })
    }

    /// The refusal of a change, when the board proves afterwards that it has the key: the change is void then. A refusal
    /// because of the key needs no proof, since a tag of another key is worth nothing.
    fn confirmed(&mut self, key: &Key, refusal: Refusal) -> ChangeError {
        let is_of_the_key = matches!(
            refusal,
            Refusal::WrongTag
                | Refusal::BackOff { .. }
                | Refusal::Unprovisioned
                | Refusal::KeyDamaged
        );
        match self.prove(key) {
            Err(ProofError::Link(LinkError::Refused(Refusal::Unprovisioned))) => {}
            Err(reason) if !is_of_the_key => return self.unknown(&reason),
            _ => {}
        }
        self.refused(refusal)
    }

    /// A refusal, with what to do when the board waits.
    pub(super) fn refused(&self, refusal: Refusal) -> ChangeError {
        match refusal {
            Refusal::BackOff { ms } if !self.is_real_time() => ChangeError::StandsStill {
                ms,
                port: self.port().to_owned(),
            },
            refusal => ChangeError::Refused(refusal),
        }
    }

    fn before(&self, error: LinkError) -> ChangeError {
        match error {
            LinkError::Refused(refusal) => self.refused(refusal),
            error => ChangeError::Before(error),
        }
    }

    fn unknown(&self, reason: &dyn Error) -> ChangeError {
        ChangeError::During {
            reason: reason.to_string(),
            port: self.port().to_owned(),
        }
    }
}
