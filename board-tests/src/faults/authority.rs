//! Only the key holder changes coefficients: a request without the right tag changes nothing.

use std::time::Duration;

use anyhow::{bail, ensure};
use hexsense_core::records::{CoefficientSet, MAX_ENCODED};
use hexsense_core::wire::change::{self, Key};
use hexsense_core::wire::{Refusal, Request, Response};

use super::outcome::Outcome;
use crate::bench::Bench;
use crate::key_holder::{Account, KeyHolder, pieces, upload_of};
use crate::line::Line;
use crate::trial_set::Random;

/// A challenge is good for ten seconds.
const EXPIRED: Duration = Duration::from_millis(10_001);
/// Wrong tags in a row; the wait after the last is 64 s.
const WRONG_IN_A_ROW: u32 = 8;

/// Tries to change the board without its key; `forgeries` tags are off by one bit each.
pub fn forge(seed: u64, forgeries: u64) -> anyhow::Result<Outcome> {
    let mut trial = Trial::new(seed, 100.min(forgeries + 30))?;
    let done = trial.unprovisioned();
    trial.outcome.settle(done);
    let recorded = trial.provision()?;
    let done = trial.replay(&recorded);
    trial.outcome.settle(done);
    for forgery in 0..forgeries {
        let done = trial.one_wrong_bit(forgery);
        trial.outcome.settle(done);
    }
    for done in [
        trial.strangers_key(),
        trial.waits(),
        trial.expired_and_used(),
        trial.other_boards_set(),
        trial.changed_on_the_way(),
    ] {
        trial.outcome.settle(done);
    }
    Ok(trial.outcome)
}

struct Trial {
    bench: Bench,
    key_holder: KeyHolder,
    set: CoefficientSet,
    random: Random,
    /// What the board keeps; no trial may change it.
    account: Account,
    outcome: Outcome,
}

impl Trial {
    fn new(seed: u64, minimum: u64) -> anyhow::Result<Self> {
        let bench = Bench::new("faults/authority", seed)?;
        let mut board = bench.on(&[])?;
        let key_holder = KeyHolder::of(&mut board.line)?;
        let account = Account::read(&mut board.line)?;
        drop(board);
        let mut random = Random(seed as u32 | 1);
        Ok(Self {
            bench,
            set: random.set(key_holder.board),
            key_holder,
            random,
            account,
            outcome: Outcome::new("authority", minimum),
        })
    }

    /// All changes that can be asked for; the board refuses each while it has no key.
    fn acts(&self) -> anyhow::Result<[change::Act; 3]> {
        let mut room = [0; MAX_ENCODED];
        Ok([
            upload_of(self.set.encode(&mut room)?),
            change::Act::Rollback(Default::default()),
            change::Act::FactoryReset,
        ])
    }

    fn unprovisioned(&mut self) -> anyhow::Result<()> {
        let mut board = self.bench.on(&[])?;
        ensure!(
            !board.line.status()?.provisioned,
            "a new board says that it has a key"
        );
        for act in self.acts()? {
            let request = self.key_holder.tagged(&mut board.line, act)?;
            self.outcome.refused(&mut board.line, &request, |refusal| {
                refusal == Refusal::Unprovisioned
            })?;
        }
        self.unchanged(&mut board.line)
    }

    /// Gives the board key and set; returns the requests as an eavesdropper on the line would record them.
    fn provision(&mut self) -> anyhow::Result<Vec<Request>> {
        let mut board = self.bench.on(&[])?;
        let line = &mut board.line;
        let mut recorded = vec![
            self.key_holder
                .tagged(line, change::Act::Provision(self.key_holder.key.clone()))?,
        ];
        line.order(&recorded[0])?;
        let mut room = [0; MAX_ENCODED];
        let encoded = self.set.encode(&mut room)?;
        let begin = self.key_holder.tagged(line, upload_of(encoded))?;
        for request in [begin].into_iter().chain(pieces(encoded)) {
            line.order(&request)?;
            recorded.push(request);
        }
        recorded.push(Request::UploadCommit);
        let committed = line.ask(&Request::UploadCommit)?;
        ensure!(matches!(committed, Response::Committed(_)), "{committed:?}");
        self.account = Account::read(line)?;
        ensure!(self.account.provisioned, "it has a key and does not say so");
        Ok(recorded)
    }

    /// The recorded requests are sent again: to the running board, to a board that has just started, and to a board with
    /// an open challenge.
    fn replay(&mut self, recorded: &[Request]) -> anyhow::Result<()> {
        let mut board = self.bench.on(&[])?;
        for round in 0..3 {
            if round == 1 {
                drop(board);
                board = self.bench.on(&[])?;
            }
            for request in recorded {
                if round == 2 {
                    board.line.ask(&Request::Challenge)?;
                }
                self.outcome.refused(&mut board.line, request, |_| true)?;
            }
        }
        self.unchanged(&mut board.line)
    }

    /// A tag with one wrong bit, to a board that has just started and so makes nobody wait.
    fn one_wrong_bit(&mut self, forgery: u64) -> anyhow::Result<()> {
        let mut board = self.bench.on(&[])?;
        let acts = self.acts()?;
        let act = acts[forgery as usize % acts.len()].clone();
        let mut request = self.key_holder.tagged(&mut board.line, act)?;
        if let Request::Change { tag, .. } = &mut request {
            let bit = self.random.bits() as usize % 256;
            tag[bit / 8] ^= 1 << (bit % 8);
        }
        self.outcome.refused(&mut board.line, &request, |refusal| {
            refusal == Refusal::WrongTag
        })?;
        self.unchanged(&mut board.line)
    }

    /// A stranger with another key, which the stranger also tries to give to the board.
    fn strangers_key(&mut self) -> anyhow::Result<()> {
        let mut stranger = KeyHolder::of(&mut self.bench.on(&[])?.line)?;
        stranger.key = Key([0x5A; 32]);
        for act in self
            .acts()?
            .into_iter()
            .chain([change::Act::Provision(stranger.key.clone())])
        {
            let mut board = self.bench.on(&[])?;
            let request = stranger.tagged(&mut board.line, act)?;
            self.outcome.refused(&mut board.line, &request, |refusal| {
                refusal == Refusal::WrongTag
            })?;
            self.unchanged(&mut board.line)?;
        }
        Ok(())
    }

    /// Wrong tags one after another: after each the board refuses all changes for a longer time.
    fn waits(&mut self) -> anyhow::Result<()> {
        let mut board = self.bench.on(&[])?;
        let line = &mut board.line;
        let mut last_ms = 0;
        for _ in 0..WRONG_IN_A_ROW {
            let mut request = self.key_holder.tagged(line, change::Act::FactoryReset)?;
            if let Request::Change { tag, .. } = &mut request {
                tag[0] ^= 1;
            }
            self.outcome
                .refused(line, &request, |refusal| refusal == Refusal::WrongTag)?;
            let right = self.key_holder.tagged(line, change::Act::FactoryReset)?;
            let Response::Refused(Refusal::BackOff { ms }) = line.ask(&right)? else {
                bail!("the board did not wait after a wrong tag");
            };
            self.outcome.inject();
            ensure!(
                ms > last_ms || ms > 60_000,
                "it waits {ms} ms after {last_ms} ms"
            );
            last_ms = ms;
            line.run(Duration::from_millis(u64::from(ms) + 1))?;
        }
        self.unchanged(line)
    }

    /// A challenge that is too old, a challenge that has been used, and no challenge.
    fn expired_and_used(&mut self) -> anyhow::Result<()> {
        let mut board = self.bench.on(&[])?;
        let line = &mut board.line;
        let none = |refusal| refusal == Refusal::NoChallenge;
        let old = self.key_holder.tagged(line, change::Act::FactoryReset)?;
        line.run(EXPIRED)?;
        self.outcome.refused(line, &old, none)?;
        self.outcome.refused(line, &old, none)?;
        let mut room = [0; MAX_ENCODED];
        let other = self.random.set(self.key_holder.board);
        let upload = upload_of(other.encode(&mut room)?);
        let used = self.key_holder.tagged(line, upload)?;
        line.order(&used)?;
        self.outcome.inject();
        self.outcome.refused(line, &used, none)?;
        self.unchanged(line)
    }

    /// The key holder cannot give the board the set of another board.
    fn other_boards_set(&mut self) -> anyhow::Result<()> {
        let mut board = self.bench.on(&[])?;
        let line = &mut board.line;
        let set = self.random.set(*b"another one.");
        let mut room = [0; MAX_ENCODED];
        let encoded = set.encode(&mut room)?;
        self.key_holder.begin(line, encoded)?;
        for piece in pieces(encoded) {
            line.order(&piece)?;
        }
        self.outcome
            .refused(line, &Request::UploadCommit, |refusal| {
                refusal == Refusal::OtherBoard
            })?;
        self.unchanged(line)
    }

    /// One bit of a piece of an upload is changed on the line: the digest under the tag does not fit.
    fn changed_on_the_way(&mut self) -> anyhow::Result<()> {
        let mut board = self.bench.on(&[])?;
        let line = &mut board.line;
        let set = self.random.set(self.key_holder.board);
        let mut room = [0; MAX_ENCODED];
        let encoded = set.encode(&mut room)?;
        for changed in 0..pieces(encoded).count() {
            self.key_holder.begin(line, encoded)?;
            for (index, mut piece) in pieces(encoded).enumerate() {
                if let Request::UploadChunk { bytes, .. } = &mut piece
                    && index == changed
                {
                    bytes[7] ^= 0x10;
                }
                line.order(&piece)?;
            }
            self.outcome
                .refused(line, &Request::UploadCommit, |refusal| {
                    refusal == Refusal::WrongIdentity
                })?;
        }
        self.unchanged(line)
    }

    fn unchanged(&mut self, line: &mut Line) -> anyhow::Result<()> {
        let found = Account::read(line)?;
        ensure!(found == self.account, "the account has become {found:?}");
        Ok(())
    }
}
