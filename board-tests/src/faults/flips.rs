//! Bits of the coefficients flip in RAM, in every copy that there is: within a second the set from flash is at work again,
//! and where values were wrong until then, the event is counted once.
//!
//! All channels of the set are ratiometric, so that the sample path's copy holds the very offsets of the set, and the virtual
//! board finds each copy by its content.

use std::time::Duration;

use anyhow::ensure;
use hexsense_core::channel::{INERTIAL, Ratiometric};
use hexsense_core::sampling::Calibrator;
use serde_json::json;

use super::outcome::Outcome;
use crate::bench::Bench;
use crate::key_holder::{Act, KeyHolder, calibrate};
use crate::trial_set::Random;

/// When the bits flip at the earliest, and within which time the draw falls, s.
const FLIP_S: f64 = 1.0;
const DRAWN_S: f64 = 0.5;
/// The set is read from flash every second; then the values are right again, s.
const RESTORED_S: f64 = 1.1;
/// A quarter of the number, its sign, its size, and no number any more.
const MASKS: [&str; 4] = ["0x00400000", "0x80000000", "0x08000000", "0x38800000"];
/// Copies of a number that the firmware has at most.
const COPIES: usize = 40;

/// Flips the bits of so many of the masks in every copy of an offset.
pub fn flip(seed: u64, masks: usize) -> anyhow::Result<Outcome> {
    let bench = Bench::new("faults/flips", seed)?;
    let mut random = Random(seed as u32 | 1);
    let mut board = bench.on(&[])?;
    calibrate(&mut board.line, &mut random)?;
    let mut key_holder = KeyHolder::of(&mut board.line)?;
    let mut set = random.set(key_holder.board);
    set.ratiometric = (0..INERTIAL).fold(Ratiometric::NONE, Ratiometric::with);
    key_holder.carry_out(&mut board.line, &Act::Upload(Box::new(set.clone())))?;
    drop(board);
    let mut flips = Flips {
        bench,
        calibrator: Calibrator::new(&set),
        holds: format!("{:#010x}", set.triads[1].offset[1].to_bits()),
        outcome: Outcome::new("recovery", 0),
        restored: 0,
    };
    for skip in 0..COPIES {
        for mask in MASKS.iter().cycle().skip(skip).take(masks) {
            let at_s = FLIP_S + DRAWN_S * f64::from(random.share().abs());
            match flips.one(skip, mask, at_s) {
                Ok(true) => {}
                Ok(false) => return flips.end(skip),
                Err(error) => flips.outcome.lose(1, || {
                    format!("copy {skip}, {mask} at {at_s:.4} s: {error:#}")
                }),
            }
        }
    }
    flips.end(COPIES)
}

struct Flips {
    bench: Bench,
    calibrator: Calibrator,
    /// The offset whose copies are spoilt.
    holds: String,
    outcome: Outcome,
    /// Flips after which the board took the set from flash.
    restored: u32,
}

impl Flips {
    /// Flips bits of one copy; false when there are not so many.
    fn one(&mut self, skip: usize, mask: &str, at_s: f64) -> anyhow::Result<bool> {
        let fault = json!({"fault": "ram_word", "holds": self.holds, "skip": skip, "mask": mask, "at_s": at_s});
        let mut board = self.bench.on(&[fault])?;
        board.line.stream(true, false)?;
        board.line.run_until(Duration::from_secs_f64(at_s + 2.0))?;
        if self.bench.log().contains("is not in RAM") {
            return Ok(false);
        }
        self.outcome.inject();
        let mut wrong = 0;
        for arrived in board.line.blocks.drain(..) {
            let supply = arrived.block.header.supply;
            let counts = arrived.block.counts.iter().flatten();
            let right = counts
                .zip(arrived.block.values.iter().flatten())
                .all(|(scan, values)| {
                    values.map(f32::to_bits)
                        == self.calibrator.apply(scan, supply).map(f32::to_bits)
                });
            let late_s = arrived.at.as_secs_f64() - at_s;
            ensure!(
                right || late_s < RESTORED_S,
                "values are wrong {late_s:.3} s later"
            );
            wrong += u32::from(!right);
        }
        let status = board.line.status()?;
        ensure!(status.resets.starts == 1, "{:?}", status.resets);
        let counted = status.events.coefficients_restored.count;
        ensure!(
            counted <= 1 && (wrong == 0 || counted == 1),
            "{wrong} blocks were wrong, and {counted} events are counted"
        );
        self.restored += counted;
        Ok(true)
    }

    /// At least the sample path's copy and the one that it is made of were in use.
    fn end(mut self, copies: usize) -> anyhow::Result<Outcome> {
        self.outcome.figure("copies", copies);
        self.outcome.figure("coefficients_restored", self.restored);
        let restored = self.restored;
        self.outcome.check(restored >= 2, || {
            format!("of {copies} copies {restored} were noticed")
        });
        Ok(self.outcome)
    }
}
