//! The log at every level, with entries altered in flash, in a flash of something else, and as a forged export.
//!
//! Entries are written into the flash memory of a board that is off, by the core's own log: a board would need hours for
//! thousands of changes. What is altered gets a checksum that matches, as somebody with a debug probe would give it. Power
//! cuts in a new volume are among those of [`super::power_cut`].

use std::path::PathBuf;

use anyhow::{Context, bail, ensure};
use embassy_futures::block_on;
use hexsense_core::records::log::{ENTRY, Entry, Log, Reason, capacity};
use hexsense_core::wire::change;
use hexsense_core::wire::{Refusal, Request, Response};
use hexsense_probe::log_file::{LogFile, flaws, volume_flaws};
use hostile::nor_flash::{Nor, PAGE};

use super::outcome::Outcome;
use crate::bench::{Bench, STARTED};
use crate::key_holder::{Account, Act, KeyHolder};
use crate::line::Line;
use crate::power::FLASH;
use crate::trial_set::Random;

/// Where bank 2 begins in the file of the flash memory.
const BANK: usize = 256 * 1_024;
/// Entries of an altered log.
const ENTRIES: u32 = 70;

/// Tries all of it; `altered` entries are altered, each in one bit.
pub fn attack(seed: u64, altered: u64) -> anyhow::Result<Outcome> {
    let mut trial = Trial::new(seed, 20.min(altered + 10))?;
    let done = trial.levels();
    trial.outcome.settle(done);
    let done = trial.altered(altered);
    trial.outcome.settle(done);
    let done = trial.forged(altered);
    trial.outcome.settle(done);
    let done = trial.foreign();
    trial.outcome.settle(done);
    Ok(trial.outcome)
}

struct Trial {
    bench: Bench,
    key_holder: KeyHolder,
    random: Random,
    outcome: Outcome,
}

impl Trial {
    fn new(seed: u64, minimum: u64) -> anyhow::Result<Self> {
        let bench = Bench::new("faults/log", seed)?;
        let mut random = Random(seed as u32 | 1);
        let mut board = bench.on(&[])?;
        let mut key_holder = KeyHolder::of(&mut board.line)?;
        key_holder.provision(&mut board.line)?;
        let set = random.set(key_holder.board);
        key_holder.carry_out(&mut board.line, &Act::Upload(Box::new(set)))?;
        drop(board);
        bench.keep("two")?;
        Ok(Self {
            bench,
            key_holder,
            random,
            outcome: Outcome::new("log", minimum),
        })
    }

    fn file(&self) -> PathBuf {
        self.bench.folder().join(FLASH)
    }

    /// Bank 2, changed while the board is off.
    fn change_flash<T>(
        &self,
        change: impl FnOnce(&mut Nor) -> anyhow::Result<T>,
    ) -> anyhow::Result<T> {
        let mut file = std::fs::read(self.file())?;
        let bank = file
            .get_mut(BANK..)
            .context("the flash memory has no bank 2")?;
        let mut nor = Nor::new(bank.len() / PAGE);
        nor.overwrite(0, bank);
        let done = change(&mut nor)?;
        bank.copy_from_slice(nor.bytes());
        std::fs::write(self.file(), file)?;
        Ok(done)
    }

    /// A board with a key, a set and this many entries.
    fn with_entries(&self, entries: u32) -> anyhow::Result<()> {
        self.bench.restore("two")?;
        self.change_flash(|nor| {
            let mut log = Log::new(nor, hexsense::FACTS.flash.log());
            let mut end = log.end()?;
            let last = end.last.context("the board has logged nothing")?;
            for counter in last.counter + 1..=entries {
                let entry = Entry {
                    counter,
                    reason: Reason::Provision,
                    chain: end.head(),
                    previous: last.id,
                    ..last
                };
                block_on(log.append(&mut end, &entry))?;
            }
            Ok(())
        })
    }

    /// At every level the board starts in time with its set, tells the level, and takes what it still has room for.
    fn levels(&mut self) -> anyhow::Result<()> {
        let full = capacity(&hexsense::FACTS.flash);
        let mut slowest_ms = 0;
        for level in [2, 31, 32, 33, full / 2, full - 1, full, full + 8, full + 16] {
            self.with_entries(level)?;
            self.outcome.inject();
            let mut board = self.bench.on(&[])?;
            let line = &mut board.line;
            let status = line.status()?;
            let first_ms = status.first_with_set_ms.context("no block has a set")?;
            slowest_ms = slowest_ms.max(first_ms);
            let in_time = u128::from(first_ms) <= STARTED.as_millis();
            self.outcome.check(in_time, || {
                format!("level {level}: the first set after {first_ms} ms")
            });
            let told = status.log_used == Some(level);
            self.outcome.check(told, || {
                format!("level {level}: it tells {:?}", status.log_used)
            });
            let reset = self.key_holder.tagged(line, change::Act::FactoryReset)?;
            let answer = line.ask(&reset)?;
            let right = match answer {
                Response::Erased { .. } => level < full,
                Response::Refused(Refusal::LogFull) => level >= full,
                _ => false,
            };
            self.outcome
                .check(right, || format!("level {level}: the reset got {answer:?}"));
            if level >= full {
                self.replace_key_and_begin_a_volume(line, level, full + 16)?;
            }
            let account = Account::read(line)?;
            let audit = account.audit();
            self.outcome
                .check(audit.is_ok(), || format!("level {level}: {audit:?}"));
        }
        self.outcome.figure("first_set_ms_max", slowest_ms);
        Ok(())
    }

    fn replace_key_and_begin_a_volume(
        &mut self,
        line: &mut Line,
        level: u32,
        last: u32,
    ) -> anyhow::Result<()> {
        let mut new = self.key_holder.key.clone();
        new.0[0] ^= 0xFF;
        let key = change::Act::Provision(new.clone());
        let replaced = self.key_holder.tagged(line, key)?;
        let replaced = line.ask(&replaced)?;
        let old = self.key_holder.key.clone();
        if replaced == Response::Done {
            self.key_holder.key = new;
        }
        let right = match replaced {
            Response::Done => level < last,
            Response::Refused(Refusal::LogFull) => level == last,
            _ => false,
        };
        self.outcome
            .check(right, || format!("level {level}: the key got {replaced:?}"));
        let used = line.status()?.log_used.unwrap_or_default();
        let next = self.key_holder.carry_out(line, &Act::NewVolume(used));
        // The next level begins with the flash as it was.
        self.key_holder.key = old;
        self.outcome
            .check(next.is_ok(), || format!("level {level}: {next:?}"));
        Ok(())
    }

    /// The volume and its signature, as a host exports it.
    fn export(&self, line: &mut Line) -> anyhow::Result<LogFile> {
        let nonce = [0x5A; 32];
        let Response::LogProof { volume, mac } = line.ask(&Request::LogProof { nonce })? else {
            bail!("the log is not signed");
        };
        Ok(LogFile {
            board: self.key_holder.board,
            nonce,
            volume,
            mac,
            entries: Account::read(line)?.log,
        })
    }

    /// One bit of one entry in flash, with a checksum that matches: the chain breaks behind it, or the head is another.
    fn altered(&mut self, altered: u64) -> anyhow::Result<()> {
        self.with_entries(ENTRIES)?;
        let before = self.export(&mut self.bench.on(&[])?.line)?;
        ensure!(
            before.is_signed(&self.key_holder.key),
            "the signature is another's"
        );
        ensure!(
            volume_flaws(&before.entries, &before.volume).is_empty(),
            "it has flaws"
        );
        for _ in 0..altered {
            self.with_entries(ENTRIES)?;
            let [place, bit] = [ENTRIES, 480].map(|limit| self.random.bits() % limit);
            self.change_flash(|nor| {
                let at = hexsense::FACTS.flash.log().start as usize + place as usize * ENTRY;
                let mut entry = nor.bytes()[at..at + ENTRY].to_vec();
                entry[bit as usize / 8] ^= 1 << (bit % 8);
                let sum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&entry[..ENTRY - 4]);
                entry[ENTRY - 4..].copy_from_slice(&sum.to_le_bytes());
                nor.overwrite(at, &entry);
                Ok(())
            })?;
            self.outcome.inject();
            let found = self.export(&mut self.bench.on(&[])?.line)?;
            let is_seen =
                !flaws(&found.entries).is_empty() || found.volume.head != before.volume.head;
            self.outcome.check(is_seen, || {
                format!("bit {bit} of entry {place} was altered unseen")
            });
        }
        Ok(())
    }

    /// An export in which one bit of an entry, of the ends or of the signature is another.
    fn forged(&mut self, forged: u64) -> anyhow::Result<()> {
        self.with_entries(ENTRIES)?;
        let whole = self.export(&mut self.bench.on(&[])?.line)?;
        for number in 0..forged {
            let mut log = whole.clone();
            let bits = self.random.bits() as usize;
            let entry = bits % log.entries.len();
            match number % 5 {
                0 => log.entries[entry].unix_s ^= 1 << (bits % 64),
                1 => log.entries[entry].chain[bits % 16] ^= 1,
                2 => drop(log.entries.drain(entry..)),
                3 => log.volume.head[bits % 16] ^= 1,
                _ => log.mac[bits % 32] ^= 1,
            }
            self.outcome.inject();
            let is_taken = volume_flaws(&log.entries, &log.volume).is_empty()
                && log.is_signed(&self.key_holder.key);
            self.outcome
                .check(!is_taken, || format!("forged export {number} was taken"));
        }
        Ok(())
    }

    /// A bank that something else was in: the board says so, takes a key and sets, and keeps them.
    fn foreign(&mut self) -> anyhow::Result<()> {
        for pattern in [0x00, 0x5A, 0xA7_u8] {
            self.change_flash(|nor| {
                let content: Vec<u8> = (0..nor.bytes().len())
                    .map(|at| pattern ^ (at % 239) as u8)
                    .collect();
                nor.overwrite(0, &content);
                Ok(())
            })?;
            self.outcome.inject();
            let mut board = self.bench.on(&[])?;
            let status = board.line.status()?;
            let told = status.log_used.is_none() && !status.provisioned;
            self.outcome.check(told, || {
                format!("{pattern:#x}: the foreign flash is not told")
            });
            let mut key_holder = KeyHolder::of(&mut board.line)?;
            key_holder.provision(&mut board.line)?;
            for _ in 0..3 {
                let set = self.random.set(key_holder.board);
                key_holder.carry_out(&mut board.line, &Act::Upload(Box::new(set)))?;
            }
            let before = Account::read(&mut board.line)?;
            drop(board);
            let after = Account::read(&mut self.bench.on(&[])?.line)?;
            let kept = after == before && after.audit().is_ok() && after.log.len() == 4;
            self.outcome
                .check(kept, || format!("{pattern:#x}: {after:?}"));
        }
        Ok(())
    }
}
