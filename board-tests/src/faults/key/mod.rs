//! A damaged key opens the board to nobody, a new key takes the place of the old one in one step, no line gets a key that
//! exists, and a change that is held back is void once the board has proven itself.

mod line;

use std::fs;
use std::io::ErrorKind;
use std::path::PathBuf;

use anyhow::{Context, ensure};
use hexsense_core::authority::MAX_WAIT_MS;
use hexsense_core::wire::change::{self, Key};
use hexsense_core::wire::{Refusal, Response};
use serde_json::{Value, json};

use super::outcome::Outcome;
use crate::bench::{Bench, Board};
use crate::key_holder::{Account, Act, KeyHolder, upload_of};
use crate::line::{Line, is_gone};
use crate::power::FLASH;
use crate::trial_set::Random;

/// Where the first page of the key is in the flash memory: bank 2 behind eight pages of sets.
const KEY_PAGE: usize = 0x4_0000 + 8 * 2_048;
/// The copies of a key in its page, and the words of each.
const COPIES: [usize; 2] = [0, 1_024];
const WORDS: usize = 7;
/// The key that takes the place of the first.
const NEW_KEY: Key = Key(*b"the key that takes the place of.");
/// The key of somebody else.
const STRANGER: Key = Key(*b"the key of somebody without any.");
/// How far a flash operation has got when the power goes.
const FORMS: [&str; 2] = ["half", "done"];

/// Damages one in `every` words and cuts the power at one in `every` operations; at least `minimum` faults.
pub fn guard(seed: u64, every: usize, minimum: u64) -> anyhow::Result<Outcome> {
    let mut trial = Trial::new(seed, minimum)?;
    for done in [
        trial.one_damaged_copy(every),
        trial.two_damaged_copies(),
        trial.replacement(every),
        trial.held_back(),
        trial.lying_board(),
    ] {
        trial.outcome.settle(done);
    }
    Ok(trial.outcome)
}

/// What is wrong with a word of flash.
#[derive(Debug, Clone, Copy)]
enum Flaw {
    /// These bits are inverted, and the error correction code does not tell.
    Bits(u64),
    /// These bits are inverted, and reading the word raises the non-maskable interrupt.
    Torn(u64),
}

/// One bit, two bits, a torn word.
const FLAWS: [Flaw; 3] = [
    Flaw::Bits(1 << 11),
    Flaw::Bits(1 << 3 | 1 << 44),
    Flaw::Torn(0x00FF_0F00_A5A5_0001),
];

struct Trial {
    bench: Bench,
    key_holder: KeyHolder,
    account: Account,
    random: Random,
    outcome: Outcome,
}

impl Trial {
    /// A board with a key and a set, kept as `before`.
    fn new(seed: u64, minimum: u64) -> anyhow::Result<Self> {
        let bench = Bench::new("faults/key", seed)?;
        let mut random = Random(seed as u32 | 1);
        let mut board = bench.on(&[])?;
        let mut key_holder = KeyHolder::of(&mut board.line)?;
        key_holder.provision(&mut board.line)?;
        let set = random.set(key_holder.board);
        key_holder.carry_out(&mut board.line, &Act::Upload(Box::new(set)))?;
        let account = Account::read(&mut board.line)?;
        drop(board);
        bench.keep("before")?;
        Ok(Self {
            bench,
            key_holder,
            account,
            random,
            outcome: Outcome::new("key", minimum),
        })
    }

    /// The board as it was, but for these words of the copies of its key.
    fn damaged(&self, flaws: &[(usize, Flaw)]) -> anyhow::Result<Board> {
        self.bench.restore("before")?;
        let file = self.file("");
        let mut flash = fs::read(&file)?;
        let mut torn = String::new();
        for (place, flaw) in flaws {
            let place = KEY_PAGE + place;
            let (Flaw::Bits(bits) | Flaw::Torn(bits)) = flaw;
            let word = flash.get_mut(place..place + 8).context("a short flash")?;
            for (byte, bits) in word.iter_mut().zip(bits.to_le_bytes()) {
                *byte ^= bits;
            }
            if let Flaw::Torn(_) = flaw {
                torn += &format!("{place:#08x} torn\n");
            }
        }
        fs::write(&file, flash)?;
        match fs::remove_file(self.file(".ecc")) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error.into()),
            _ => fs::write(self.file(".ecc"), torn)?,
        }
        self.bench.on(&[])
    }

    /// A holder of another key.
    fn somebody(&self, key: &Key) -> KeyHolder {
        let mut somebody = self.key_holder.clone();
        somebody.key = key.clone();
        somebody
    }

    fn file(&self, ending: &str) -> PathBuf {
        self.bench.folder().join(format!("{FLASH}{ending}"))
    }

    /// The key works, and the board keeps what it kept.
    fn one_damaged_copy(&mut self, every: usize) -> anyhow::Result<()> {
        let places = COPIES
            .iter()
            .flat_map(|copy| (0..WORDS).map(move |word| copy + 8 * word));
        let cases = places.flat_map(|place| FLAWS.map(|flaw| (place, flaw)));
        for case in cases.step_by(every) {
            let mut board = self.damaged(&[case])?;
            self.outcome.inject();
            let holds = serves(&mut board.line, &self.key_holder)?
                && Account::read(&mut board.line)? == self.account;
            self.outcome
                .check(holds, || format!("the key is lost with {case:?}"));
        }
        Ok(())
    }

    /// Nobody changes anything, and the board measures on with its set.
    fn two_damaged_copies(&mut self) -> anyhow::Result<()> {
        for flaw in FLAWS {
            let mut board = self.damaged(&COPIES.map(|copy| (copy + 24, flaw)))?;
            let line = &mut board.line;
            let status = line.status()?;
            self.outcome
                .check(status.key_damaged && !status.provisioned, || {
                    format!("a key that is damaged by {flaw:?} is not told")
                });
            for key in [self.key_holder.key.clone(), STRANGER] {
                let somebody = self.somebody(&key);
                for act in self.acts(&key)? {
                    let request = somebody.tagged(line, act)?;
                    let is_right = |refusal| refusal == Refusal::KeyDamaged;
                    self.outcome.refused(line, &request, is_right)?;
                }
            }
            let found = Account::read(line)?;
            let same = (found.active, &found.history, &found.log)
                == (
                    self.account.active,
                    &self.account.history,
                    &self.account.log,
                );
            self.outcome
                .check(same, || format!("the account has become {found:?}"));
        }
        Ok(())
    }

    /// The changes that somebody may ask for: this key, a set, a rollback, an erasure.
    fn acts(&mut self, key: &Key) -> anyhow::Result<[change::Act; 4]> {
        let mut room = [0; hexsense_core::records::MAX_ENCODED];
        let set = self.random.set(self.key_holder.board);
        Ok([
            change::Act::Provision(key.clone()),
            upload_of(set.encode(&mut room)?),
            change::Act::Rollback(self.account.active.unwrap_or_default()),
            change::Act::FactoryReset,
        ])
    }

    /// The power is cut at one in `every` operations of the replacement of the key: one of the two keys works, the new one
    /// exactly when the log has it, and the same one after another start.
    fn replacement(&mut self, every: usize) -> anyhow::Result<()> {
        for operation in (1_u64..).step_by(every) {
            for form in FORMS {
                self.bench.restore("before")?;
                if !self.cut(operation, form)? {
                    ensure!(operation > 1, "a replacement has no flash operation");
                    return Ok(());
                }
                let mut found = Vec::new();
                for _ in 0..2 {
                    let mut board = self.bench.on(&[])?;
                    let new = self.somebody(&NEW_KEY);
                    let served =
                        [&self.key_holder, &new].map(|holder| serves(&mut board.line, holder));
                    let [old, new] = served;
                    found.push((old?, new?, Account::read(&mut board.line)?.log.len()));
                }
                let logged = self.account.log.len();
                let whole = [(true, false, logged), (false, true, logged + 1)];
                self.outcome.check(whole.contains(&found[0]) && found[0] == found[1], || {
                    format!("old key, new key, entries: {found:?} after a cut {form} in operation {operation}")
                });
            }
        }
        Ok(())
    }

    /// Replaces the key until the power goes; false if it does not.
    fn cut(&mut self, operation: u64, form: &str) -> anyhow::Result<bool> {
        let fault: Value =
            json!({"flash_operation": operation, "progress": form, "fault": "power_cut"});
        let mut key_holder = self.key_holder.clone();
        let done = self
            .bench
            .on(&[fault])
            .and_then(|mut board| key_holder.carry_out(&mut board.line, &Act::Provision(NEW_KEY)));
        match done {
            Ok(()) => Ok(false),
            Err(error) if is_gone(&error) => {
                self.outcome.inject();
                Ok(true)
            }
            Err(error) => Err(error),
        }
    }
}

/// Whether the board makes changes for this key holder. A wait after a wrong key passes first.
fn serves(line: &mut Line, key_holder: &KeyHolder) -> anyhow::Result<bool> {
    loop {
        let request = key_holder.tagged(line, change::Act::Rollback(Default::default()))?;
        match line.ask(&request)? {
            Response::Refused(Refusal::NoSuchSet) => return Ok(true),
            Response::Refused(Refusal::WrongTag) => return Ok(false),
            Response::Refused(Refusal::BackOff { ms }) if u64::from(ms) <= MAX_WAIT_MS => {
                line.run_s(f64::from(ms) / 1e3)?;
            }
            other => anyhow::bail!("a rollback to no set was answered by {other:?}"),
        }
    }
}
