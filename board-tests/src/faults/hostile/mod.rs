//! No input can crash or block the board: it answers bad input with a typed refusal or not at all, loses no scan, and
//! answers the next good request.
//!
//! - requests whose values are impossible, each with the refusal that it must get;
//! - uploads of a wrong length, out of order, or of bytes that are not a set;
//! - frames that are cut, doubled or of a wrong kind, and bytes that are not frames;
//! - minutes of these at line rate.

mod impossible;

use std::time::Duration;

use anyhow::ensure;
use hexsense::FACTS;
use hexsense_core::records::{CoefficientSet, MAX_ENCODED};
use hexsense_core::wire::change;
use hexsense_core::wire::message::encode_request;
use hexsense_core::wire::{Kind, MAX_FRAME, Refusal, Request, StreamContent};

use self::impossible::Right;
use super::outcome::Outcome;
use crate::bench::Bench;
use crate::key_holder::{Account, KeyHolder, calibrate, pieces};
use crate::line::Line;
use crate::trial_set::Random;

/// Bytes that the line carries in a second.
const BYTES_PER_S: u32 = FACTS.baud / 10;
/// What is sent at a time: 10 ms.
const CHUNK_BYTES: usize = BYTES_PER_S as usize / 100;
/// After a flood the board has answered everything within this time.
const CALM: Duration = Duration::from_millis(500);

/// Sends each bad input once, then floods the line for `flood_s` virtual seconds with each kind.
pub fn attack(seed: u64, flood_s: u64) -> anyhow::Result<Outcome> {
    let bench = Bench::new("faults/hostile", seed)?;
    let mut board = bench.on(&[])?;
    let line = &mut board.line;
    let mut random = Random(seed as u32 | 1);
    let (key_holder, set) = calibrate(line, &mut random)?;
    line.order(&Request::Rate(4_000))?;
    let mut attack = Attack {
        scans_lost: line.status()?.scans_lost,
        account: Account::read(line)?,
        key_holder,
        random,
        outcome: Outcome::new("hostile", 100),
    };
    let done = attack.requests(line);
    attack.outcome.settle(done);
    let done = attack.uploads(line, &set);
    attack.outcome.settle(done);
    let done = attack.frames(line);
    attack.outcome.settle(done);
    for flood in [Flood::Noise, Flood::Requests, Flood::Cut, Flood::Nonsense] {
        let done = attack.flood(line, flood, flood_s);
        attack.outcome.settle(done);
    }
    let stack = line.status()?.stack;
    attack
        .outcome
        .check(stack.deepest < stack.size, || format!("{stack:?}"));
    attack.outcome.figure("stack_deepest", stack.deepest);
    attack.outcome.figure("virtual_s", line.now().as_secs());
    Ok(attack.outcome)
}

/// What the line is flooded with.
#[derive(Debug, Clone, Copy)]
enum Flood {
    /// Random bytes.
    Noise,
    /// Good requests, more than can be answered.
    Requests,
    /// Frames of which a part is missing.
    Cut,
    /// Whole frames of random payload and kind.
    Nonsense,
}

struct Attack {
    key_holder: KeyHolder,
    random: Random,
    /// What the board keeps; no input may change it.
    account: Account,
    /// Scans that were lost before.
    scans_lost: u64,
    outcome: Outcome,
}

impl Attack {
    /// Requests whose values are impossible.
    fn requests(&mut self, line: &mut Line) -> anyhow::Result<()> {
        for (request, right) in impossible::requests() {
            self.outcome.refused(line, &request, right)?;
        }
        self.unharmed(line)
    }

    /// Uploads that lie about their length, come out of order, or carry what is no set.
    fn uploads(&mut self, line: &mut Line, good: &CoefficientSet) -> anyhow::Result<()> {
        let mut room = [0; MAX_ENCODED];
        // Another set than the active one, which would be no change.
        let mut other = good.clone();
        other.unix_s += 1;
        let encoded = other.encode(&mut room)?.to_vec();
        for length in [0, MAX_ENCODED as u16 + 1, u16::MAX] {
            let digest = [0; 32];
            let request = self
                .key_holder
                .tagged(line, change::Act::Upload { length, digest })?;
            self.outcome.refused(line, &request, |refusal| {
                matches!(refusal, Refusal::Length { .. })
            })?;
        }
        let out_of_order = |refusal| matches!(refusal, Refusal::OutOfOrder { .. });
        let all: Vec<Request> = pieces(&encoded).collect();
        self.key_holder.begin(line, &encoded)?;
        self.outcome.refused(line, &all[1], out_of_order)?;
        line.order(&all[0])?;
        self.outcome.refused(line, &all[0], out_of_order)?;
        self.outcome.refused(line, &all[2], out_of_order)?;
        self.outcome
            .refused(line, &Request::UploadCommit, out_of_order)?;
        for spoil in impossible::spoilt_sets() {
            let mut set = good.clone();
            spoil(&mut set);
            let mut room = [0; MAX_ENCODED];
            let encoded = set.encode(&mut room)?;
            self.whole(line, encoded, |refusal| {
                matches!(refusal, Refusal::Record(_))
            })?;
        }
        for cut in [1, 4, encoded.len() - 1] {
            self.whole(line, &encoded[..cut], |refusal| {
                matches!(refusal, Refusal::Record(_))
            })?;
        }
        self.unharmed(line)
    }

    /// Uploads bytes whose commit must be refused.
    fn whole(&mut self, line: &mut Line, encoded: &[u8], right: Right) -> anyhow::Result<()> {
        self.key_holder.begin(line, encoded)?;
        for piece in pieces(encoded) {
            line.order(&piece)?;
        }
        self.outcome.refused(line, &Request::UploadCommit, right)
    }

    /// Frames that are no requests: of every length a good one is cut to, doubled, of every kind, of unknown payload.
    fn frames(&mut self, line: &mut Line) -> anyhow::Result<()> {
        let good = encoded(&Request::Status)?;
        for length in 1..good.len() - 1 {
            line.send_bytes(&[&good[..length], &[0]].concat())?;
            self.outcome.inject();
            self.answers(line)?;
        }
        line.send_bytes(&[&good[..], &good[..], &good[..]].concat())?;
        self.outcome.inject();
        self.answers(line)?;
        for kind in 0..=u8::MAX {
            line.send_bytes(&framed(kind, 1, &[0, 1, 2])?)?;
            self.outcome.inject();
        }
        self.answers(line)?;
        for request in 0..=u8::MAX {
            line.send_bytes(&framed(Kind::Request as u8, 2, &[request])?)?;
            self.outcome.inject();
            line.run(Duration::from_millis(2))?;
        }
        for length in [255, 256, 257, 1_000, 5_000, 20_000] {
            line.send_bytes(&[vec![0x55; length], vec![0]].concat())?;
            self.outcome.inject();
            self.answers(line)?;
        }
        // One of the payloads may have been a good request to change stream, rate or block.
        line.order(&Request::Stream(StreamContent::default()))?;
        self.unharmed(line)
    }

    /// Minutes of it at line rate.
    fn flood(&mut self, line: &mut Line, kind: Flood, flood_s: u64) -> anyhow::Result<()> {
        for _ in 0..flood_s * 100 {
            let bytes = self.wave(kind)?;
            line.send_bytes(&bytes)?;
            line.run(Duration::from_millis(10))?;
            line.forget_answers();
        }
        self.outcome.inject_many(flood_s * 100);
        line.send_bytes(&[0])?;
        line.run(CALM)?;
        line.forget_answers();
        self.unharmed(line)
            .map_err(|error| error.context(format!("after {flood_s} s of {kind:?}")))
    }

    /// Ten milliseconds of a flood.
    fn wave(&mut self, kind: Flood) -> anyhow::Result<Vec<u8>> {
        let mut bytes = Vec::with_capacity(CHUNK_BYTES + MAX_FRAME);
        while bytes.len() < CHUNK_BYTES {
            match kind {
                Flood::Noise => bytes.extend(self.random.bits().to_le_bytes()),
                Flood::Requests => bytes.extend(encoded(&Request::Status)?),
                Flood::Cut => {
                    let frame = encoded(&Request::History { age: 1 })?;
                    let length = 1 + self.random.bits() as usize % (frame.len() - 1);
                    bytes.extend(&frame[..length]);
                }
                Flood::Nonsense => {
                    // Never one of the first requests: to change rate or block costs ticks by right.
                    let mut payload = vec![32 + self.random.bits() as u8 % 200];
                    payload.extend((0..self.random.bits() % 200).map(|_| self.random.bits() as u8));
                    let kind = [Kind::Request as u8, self.random.bits() as u8];
                    bytes.extend(framed(kind[payload.len() % 2], 3, &payload)?);
                }
            }
        }
        bytes.truncate(CHUNK_BYTES);
        Ok(bytes)
    }

    /// The next good request works.
    fn answers(&mut self, line: &mut Line) -> anyhow::Result<()> {
        line.status().map(drop)
    }

    /// No tick was lost, nothing has changed, and the board is still in the life that it was in.
    fn unharmed(&mut self, line: &mut Line) -> anyhow::Result<()> {
        let status = line.status()?;
        ensure!(
            status.resets.starts == 1,
            "it was reset: {:?}, {:?}",
            status.resets,
            status.panic
        );
        let lost = status.scans_lost - self.scans_lost;
        self.scans_lost = status.scans_lost;
        self.outcome
            .lose(lost, || format!("{lost} scans were lost"));
        let before = (line.now(), status.scans);
        line.run(CALM)?;
        let scans = line.status()?.scans - before.1;
        let due = 4_000.0 * (line.now() - before.0).as_secs_f64();
        ensure!(
            (scans as f64 - due).abs() < 100.0,
            "{scans} scans instead of {due:.0}"
        );
        let found = Account::read(line)?;
        ensure!(found == self.account, "the account has become {found:?}");
        Ok(())
    }
}

fn encoded(request: &Request) -> anyhow::Result<Vec<u8>> {
    let mut bytes = [0; MAX_FRAME];
    let length = encode_request(request, 7, &mut bytes)?;
    Ok(bytes[..length].to_vec())
}

/// A whole frame of any kind: a good one whose kind is exchanged, with its checksum made anew.
fn framed(kind: u8, sequence: u16, payload: &[u8]) -> anyhow::Result<Vec<u8>> {
    let mut message = vec![kind];
    message.extend(sequence.to_le_bytes());
    message.extend(payload);
    let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&message);
    message.extend(checksum.to_le_bytes());
    let mut bytes = cobs::encode_vec(&message);
    bytes.push(0);
    Ok(bytes)
}
