//! The right to change what the board keeps: the key holder has it, and proves it by answering a fresh challenge.
//!
//! See [`crate::wire::change`] for the exchange. A challenge serves once, right or wrong, and for [`CHALLENGE_MS`].
//! After a wrong tag the board refuses every change for a second, after the next for two, and so on up to
//! [`MAX_WAIT_MS`]; a right tag ends that. 256 bits cannot be guessed; the wait protects the board's time from a host
//! that tries.
//!
//! The board proves itself with the same key, see [`proof`].

use hmac::digest::CtOutput;
use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;

use crate::checksum::sha256;
use crate::records::BuildId;
use crate::records::key::Key;
use crate::wire::Refusal;
use crate::wire::change::{Challenge, Change, ProofChallenge, Statement, Tag};
use crate::wire::log::{Nonce, Volume};

/// How long a challenge may be answered, ms.
pub const CHALLENGE_MS: u64 = 10_000;
/// Wait after the first wrong tag, ms.
const FIRST_WAIT_MS: u64 = 1_000;
/// Longest wait after a wrong tag, ms.
pub const MAX_WAIT_MS: u64 = 64_000;
/// Begins a proof, so that no proof is the tag of a change: that begins with a challenge, which the board draws.
const PROOF: &[u8; 16] = b"hexsense proof 1";
/// Begins what is signed of a log, so that no signature is a proof or the tag of a change.
const LOG: &[u8; 12] = b"hexsense log";
/// Longest encoded change: 10 bytes of time, and an act of at most 36.
const MAX_CHANGE: usize = 64;

/// Tag of a change on the board with unique id `board`.
#[must_use]
pub fn tag(key: &Key, challenge: &Challenge, board: &[u8; 12], change: &Change) -> Tag {
    mac(key, challenge, board, change).into_bytes().into()
}

/// Tag by which the board with unique id `board` proves that it has the key, and what it says of itself.
#[must_use]
pub fn proof(
    key: &Key,
    challenge: &ProofChallenge,
    board: &[u8; 12],
    build: &BuildId,
    statement: &Statement,
) -> Tag {
    let (has_set, set) = (statement.set.is_some(), statement.set.unwrap_or_default());
    let parts: [&[u8]; 7] = [
        PROOF,
        challenge,
        board,
        &build.0,
        &[u8::from(has_set)],
        &set.0,
        &statement.changes.to_le_bytes(),
    ];
    keyed(key, &parts).into_bytes().into()
}

/// Signature of a log's volume by the board with unique id `board`.
#[must_use]
pub fn log_mac(key: &Key, nonce: &Nonce, board: &[u8; 12], volume: &Volume) -> Tag {
    let parts: [&[u8]; 7] = [
        LOG,
        nonce,
        board,
        &volume.first.to_le_bytes(),
        &volume.last.to_le_bytes(),
        &volume.head,
        &volume.build.0,
    ];
    keyed(key, &parts).into_bytes().into()
}

fn mac(
    key: &Key,
    challenge: &Challenge,
    board: &[u8; 12],
    change: &Change,
) -> CtOutput<Hmac<Sha256>> {
    let mut encoded = [0; MAX_CHANGE];
    // A change always fits. If it did not, its digest would be that of no bytes, which no other change has.
    let encoded = postcard::to_slice(change, &mut encoded).map_or(&[][..], |used| used);
    keyed(key, &[challenge, board, &sha256(encoded)])
}

/// HMAC of the parts one behind the other.
fn keyed(key: &Key, parts: &[&[u8]]) -> CtOutput<Hmac<Sha256>> {
    // A key shorter than a block of the hash is filled up with zeros (RFC 2104).
    let mut block = [0; 64];
    block[..key.0.len()].copy_from_slice(&key.0);
    let mut mac = Hmac::<Sha256>::new(&block.into());
    for part in parts {
        mac.update(part);
    }
    mac.finalize()
}

/// The open challenge, and the number of wrong tags.
#[derive(Debug, Default)]
pub struct Authority {
    open: Option<(Challenge, u64)>,
    wrong: u32,
    waits_until_ms: u64,
}

impl Authority {
    /// Opens a challenge at `now_ms` (ms since the start); an older one becomes void.
    pub fn open(&mut self, challenge: Challenge, now_ms: u64) {
        self.open = Some((challenge, now_ms));
    }

    /// Makes the open challenge void.
    pub fn close(&mut self) {
        self.open = None;
    }

    /// Checks that the change comes from the key holder; the challenge is used up.
    ///
    /// # Errors
    /// [`Refusal::BackOff`], [`Refusal::NoChallenge`] and [`Refusal::WrongTag`].
    pub fn check(
        &mut self,
        key: &Key,
        board: &[u8; 12],
        change: &Change,
        tag: &Tag,
        now_ms: u64,
    ) -> Result<(), Refusal> {
        let open = self.open.take();
        if now_ms < self.waits_until_ms {
            let ms = (self.waits_until_ms - now_ms) as u32;
            return Err(Refusal::BackOff { ms });
        }
        let (challenge, _) = open
            .filter(|(_, at_ms)| now_ms.saturating_sub(*at_ms) <= CHALLENGE_MS)
            .ok_or(Refusal::NoChallenge)?;
        // The comparison takes the same time for every wrong tag.
        if mac(key, &challenge, board, change) != CtOutput::new((*tag).into()) {
            let wait_ms = (FIRST_WAIT_MS << self.wrong.min(u32::BITS - 1)).min(MAX_WAIT_MS);
            self.wrong = self.wrong.saturating_add(1);
            self.waits_until_ms = now_ms.saturating_add(wait_ms);
            return Err(Refusal::WrongTag);
        }
        self.wrong = 0;
        Ok(())
    }
}
