//! Changes of the board's sets and key, each with its tag; see [`hexsense_core::wire::change`].
//!
//! ```text
//! identity, challenge → tag → change → answer, or a look into the log
//! ```
//!
//! The beginning of an upload may be sent again when its answer is lost. Every other change must not be made twice: it is
//! sent once, and when its answer is lost the board's log shows whether it was made.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use hexsense_core::authority;
use hexsense_core::records::SetId;
use hexsense_core::records::log::Entry;
use hexsense_core::wire::change::{Act, Change, Key, Tag};
use hexsense_core::wire::log::{Nonce, Volume};
use hexsense_core::wire::message::{ActiveSet, Kept};
use hexsense_core::wire::{Refusal, Request, Response};

use super::client::Client;
use super::conversation::{ATTEMPTS, answer_error};
use super::error::LinkError;

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
    /// It broke off before the board had the change.
    #[error("{0}. Nothing has changed on the board")]
    Before(LinkError),
    /// It broke off when the board may have had the change.
    #[error(
        "the conversation broke off while the board was making the change: {0}. It was made whole or not at all; see \
         which with `hexsense log`"
    )]
    During(LinkError),
}

impl ChangeError {
    fn before(error: LinkError) -> Self {
        match error {
            LinkError::Refused(refusal) => Self::Refused(refusal),
            error => Self::Before(error),
        }
    }
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
        let active = self.active_set().map_err(ChangeError::During)?;
        active.ok_or_else(|| ChangeError::During(answer_error(&Request::ActiveSet)))
    }

    /// Erases all sets, and returns those that were kept before.
    ///
    /// # Errors
    /// [`ChangeError`].
    pub fn factory_reset(&mut self, key: &Key) -> Result<Vec<Kept>, ChangeError> {
        let kept = self.history().map_err(ChangeError::before)?;
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
        for age in 0..=u8::MAX {
            let request = Request::History { age };
            match self.conversation.ask(&request)? {
                Response::Kept(Some(kept)) => history.push(kept),
                Response::Kept(None) => break,
                _ => return Err(answer_error(&request)),
            }
        }
        Ok(history)
    }

    /// The entries of the log of changes from `counter` on.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn log(&mut self, counter: u32) -> Result<Vec<Entry>, LinkError> {
        let (mut log, mut next) = (Vec::new(), counter);
        loop {
            let (last, entries) = self.log_page(next)?;
            log.extend_from_slice(&entries);
            match entries.last() {
                Some(entry) if (next..last).contains(&entry.counter) => next = entry.counter + 1,
                _ => return Ok(log),
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

    /// Sends a change once; `None` when its answer was lost and the log shows that the change was made.
    fn change(&mut self, key: &Key, act: Act) -> Result<Option<Response>, ChangeError> {
        let unix_s = unix_now();
        let reason = act.reason();
        let change = Change { unix_s, act };
        let (last, _) = self.log_page(u32::MAX).map_err(ChangeError::before)?;
        let start = self.now();
        let request = self.tagged(key, &change).map_err(ChangeError::before)?;
        match self.conversation.ask_once(&request, CHANGE) {
            Ok(Some(response)) => return Ok(Some(response)),
            Ok(None) => {}
            Err(LinkError::Refused(refusal)) => return Err(ChangeError::Refused(refusal)),
            Err(error) => return Err(ChangeError::During(error)),
        }
        // The board answers this only after the change, if the change arrived.
        let since = self
            .log(last.saturating_add(1))
            .map_err(ChangeError::During)?;
        let made = |entry: &Entry| entry.reason == reason && entry.unix_s == unix_s;
        if since.iter().any(made) {
            return Ok(None);
        }
        let silent = self.conversation.silent(&request, 1, start);
        Err(ChangeError::Before(silent.into()))
    }
}
