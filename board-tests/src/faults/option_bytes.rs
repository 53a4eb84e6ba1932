//! Option bytes of a chip that was used before: where they do not allow changes, the board measures, refuses each change
//! for that reason, and no byte of its flash changes; elsewhere it takes changes as ever.
//!
//! Every bank mode is tried with every area of write protection, on an erased chip, on one with a key and sets, and on
//! one whose last change the power interrupted, which a start would complete. The levels of readout protection and
//! brown-out, which the board only reports, change from trial to trial.

use anyhow::ensure;
use hexsense_core::harmonics::ANALYSERS;
use hexsense_core::records::{CoefficientSet, MAX_ENCODED};
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::change::{Act, Key};
use hexsense_core::wire::status::OptionBytes;
use hexsense_core::wire::{Refusal, Request, Response, StreamContent};
use serde_json::{Value, json};

use super::outcome::Outcome;
use crate::bench::{Bench, Board};
use crate::key_holder::{self, KeyHolder, calibrate, upload_of};
use crate::line::is_gone;
use crate::power::FLASH;
use crate::trial_set::Random;

/// States of the flash, by the names under which they are kept.
const STATES: [&str; 3] = ["erased", "sets", "interrupted"];
/// Readout protection: byte and level.
const READOUT: [(u32, u8); 3] = [(0xAA, 0), (0xBB, 1), (0xCC, 2)];
/// Areas that are protected: WRP1A, WRP1B, WRP2A, WRP2B.
const AREAS: [[Option<(u8, u8)>; 4]; 6] = [
    [None; 4],
    [Some((0, 61)), None, None, None],
    [None, Some((64, 127)), None, None],
    [None, None, Some((0, 9)), None],
    [None, None, None, Some((127, 127))],
    [Some((3, 3)), None, Some((8, 9)), Some((10, 127))],
];
const REGISTERS: [&str; 4] = ["WRP1AR", "WRP1BR", "WRP2AR", "WRP2BR"];
/// OPTR as the chip leaves its factory, without DBANK, readout protection and brown-out level.
const OPTR: u32 = 0xFFAF_F800;
const DBANK: u32 = 1 << 22;

/// Tries one in `every` of all combinations.
pub fn combine(seed: u64, every: usize) -> anyhow::Result<Outcome> {
    let mut outcome = Outcome::new("option_bytes", 20);
    let bench = prepared(seed)?;
    let modes = [false, true].into_iter().flat_map(|dual_bank| {
        AREAS
            .iter()
            .flat_map(move |areas| STATES.map(|state| (dual_bank, areas, state)))
    });
    for (number, (dual_bank, areas, state)) in modes.enumerate().step_by(every) {
        let (byte, level) = READOUT[number % READOUT.len()];
        let brown_out = number % 5;
        let options = OptionBytes {
            dual_bank,
            readout_protection: level,
            brown_out_level: brown_out as u8,
            write_protected: *areas,
        };
        let mut registers = vec![format!(
            "OPTR=0x{:08x}",
            OPTR | byte | (brown_out as u32) << 8 | if dual_bank { DBANK } else { 0 }
        )];
        for (name, area) in REGISTERS.iter().zip(areas) {
            if let Some((first, last)) = area {
                registers.push(format!("{name}=0x00{last:02x}00{first:02x}"));
            }
        }
        bench.restore(state)?;
        let trial = Trial {
            bench: &bench,
            registers: &registers,
            options,
        };
        let done = if dual_bank && areas[2..] == [None; 2] {
            trial.allowed(&mut outcome)
        } else {
            trial.forbidden(&mut outcome)
        };
        outcome.settle(done.map_err(|error| error.context(format!("{registers:?}, {state}"))));
    }
    Ok(outcome)
}

/// A bench that keeps every one of [`STATES`].
fn prepared(seed: u64) -> anyhow::Result<Bench> {
    let bench = Bench::new("faults/option-bytes", seed)?;
    drop(bench.on(&[])?);
    bench.keep("erased")?;
    let mut random = Random(seed as u32 | 1);
    let mut board = bench.on(&[])?;
    let (key_holder, _) = calibrate(&mut board.line, &mut random)?;
    calibrate(&mut board.line, &mut random)?;
    drop(board);
    bench.keep("sets")?;
    for operation in 1.. {
        bench.restore("sets")?;
        let cut = json!({"flash_operation": operation, "progress": "half", "fault": "power_cut"});
        let mut board = bench.on(&[cut])?;
        let done = key_holder
            .clone()
            .carry_out(&mut board.line, &key_holder::Act::FactoryReset);
        drop(board);
        match done {
            Err(error) if is_gone(&error) => {}
            done => anyhow::bail!("no interrupted reset is completed at a start, then {done:?}"),
        }
        bench.keep("interrupted")?;
        let before = content(&bench)?;
        drop(bench.on(&[])?);
        if content(&bench)? != before {
            break;
        }
    }
    Ok(bench)
}

fn content(bench: &Bench) -> anyhow::Result<Vec<u8>> {
    Ok(std::fs::read(bench.folder().join(FLASH))?)
}

/// A chip with these option bytes.
struct Trial<'a> {
    bench: &'a Bench,
    registers: &'a [String],
    options: OptionBytes,
}

impl Trial<'_> {
    fn on(&self, faults: &[Value]) -> anyhow::Result<Board> {
        let registers: Vec<&str> = self.registers.iter().map(String::as_str).collect();
        let mut board = self.bench.on_with_options(&registers, faults)?;
        let status = board.line.status()?;
        ensure!(
            status.option_bytes == self.options,
            "it says {:?} instead of {:?}",
            status.option_bytes,
            self.options
        );
        ensure!(status.scans > 0, "it does not sample");
        Ok(board)
    }

    /// Every change is refused, everything else is answered, and no byte changes.
    fn forbidden(&self, outcome: &mut Outcome) -> anyhow::Result<()> {
        let before = content(self.bench)?;
        // A torn word among the sets, as any bench that was switched off may have, must not stop the board either.
        let torn = json!({"at_s": 0, "fault": "bit_error", "address": "0x08042000", "bits": 2});
        let mut board = self.on(&[torn])?;
        let line = &mut board.line;
        let key_holder = KeyHolder::of(line)?;
        let kept = Random(7).set(key_holder.board);
        let mut room = [0; MAX_ENCODED];
        let encoded = kept.encode(&mut room)?;
        let is_right = |refusal| refusal == Refusal::OptionBytes;
        for act in [
            upload_of(encoded),
            Act::Rollback(CoefficientSet::id_of(encoded)),
            Act::FactoryReset,
            Act::Provision(key_holder.key.clone()),
            Act::Provision(Key([0x5A; 32])),
        ] {
            let request = key_holder.tagged(line, act)?;
            outcome.refused(line, &request, is_right)?;
        }
        for request in key_holder::pieces(encoded).chain([Request::UploadCommit]) {
            outcome.refused(line, &request, is_right)?;
        }
        for request in questions() {
            outcome.inject();
            let answer = line.ask(&request)?;
            ensure!(
                answer != Response::Refused(Refusal::OptionBytes),
                "{request:?} was refused"
            );
        }
        line.run_s(0.2)?;
        let status = line.status()?;
        ensure!(status.resets.starts == 1, "{:?}", status.resets);
        drop(board);
        let after = content(self.bench)?;
        let changed = before.iter().zip(&after).filter(|(old, new)| old != new);
        let changed = changed.count() as u64;
        outcome.lose(changed, || {
            format!("{changed} bytes of {:?} changed", self.options)
        });
        Ok(())
    }

    /// A set is uploaded and active.
    fn allowed(&self, outcome: &mut Outcome) -> anyhow::Result<()> {
        let mut board = self.on(&[])?;
        outcome.inject();
        let (_, set) = calibrate(&mut board.line, &mut Random(9))?;
        let mut room = [0; MAX_ENCODED];
        let id = CoefficientSet::id_of(set.encode(&mut room)?);
        let account = key_holder::Account::read(&mut board.line)?;
        ensure!(account.active == Some(id), "{id} is not active");
        Ok(())
    }
}

/// Requests that change nothing that is kept.
fn questions() -> Vec<Request> {
    let mut questions = vec![
        Request::Identity,
        Request::Status,
        Request::Rate(2_000),
        Request::Block(BlockSize::Eight),
        Request::Stream(StreamContent::default()),
        Request::ActiveSet,
        Request::ReadSet { offset: 0 },
        Request::History { age: 0 },
        Request::Log { counter: 1 },
        Request::Challenge,
        Request::UploadAbort,
    ];
    for analyser in 0..ANALYSERS as u8 {
        questions.extend([
            Request::Sums {
                analyser,
                channel: 0,
            },
            Request::Harmonics {
                analyser,
                channel: 0,
            },
            Request::Motion { analyser },
        ]);
    }
    questions
}
