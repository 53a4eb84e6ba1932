//! Harmonics and calibration factors at report time, from the sums that the sample path has completed.
//!
//! This task runs in thread mode, below sample path and link. It replays the window of a drive in slices ([`Solving`]);
//! the other tasks of thread mode run between two slices. When a window takes longer than [`PATIENCE`], the answer is
//! "busy", and the next request goes on from there.

use embassy_futures::yield_now;
use embassy_sync::watch::Receiver;
use embassy_time::{Duration, Instant, with_timeout};
use hexsense::FACTS;
use hexsense_core::harmonics::Drive;
use hexsense_core::sample_path::CompleteSums;
use hexsense_core::sampling::SupplyReading;
use hexsense_core::server::HarmonicsCommand;
use hexsense_core::server::solving::{MotionInput, Solving};
use hexsense_core::wire::{Refusal, Response};

use crate::chip::timing::HEARTBEAT;
use crate::sampling::path;
use crate::shared::{Base, Guard, Shared, Task};

/// Blocks that are replayed before others run: a third of a millisecond.
const SLICE: u32 = 64;
/// How long a request may wait for a replay, well below the time that a host waits for an answer.
const PATIENCE: Duration = Duration::from_millis(200);

/// Solves for ever.
#[embassy_executor::task]
pub async fn solve(shared: &'static Shared) -> ! {
    // There is a receiver of each for this task, which starts once.
    let mut solver = Solver {
        solving: Solving::new(),
        base: shared.base.receiver().expect("a receiver is left"),
        supply: shared.supply.receiver().expect("a receiver is left"),
    };
    loop {
        shared.alive.sign(Task::Harmonics);
        let Ok(command) = with_timeout(HEARTBEAT, shared.to_harmonics.receive()).await else {
            continue;
        };
        let answer = match command {
            HarmonicsCommand::Channel { analyser, channel } => {
                solver.channel(analyser, channel).await
            }
            HarmonicsCommand::Motion { analyser } => solver.motion(analyser).await,
        };
        let answer = answer.unwrap_or_else(Response::Refused);
        shared.answers.send(answer).await;
    }
}

struct Solver {
    solving: Solving,
    base: Receiver<'static, Guard, Option<Base>, 2>,
    supply: Receiver<'static, Guard, SupplyReading, 3>,
}

impl Solver {
    async fn channel(&mut self, analyser: u8, channel: u8) -> Result<Response, Refusal> {
        let sums = sums(analyser, channel).ok_or(Refusal::Incomplete { analyser })?;
        self.replay(sums.drive).await?;
        solve_harmonics(&self.solving, &sums, channel)
    }

    async fn motion(&mut self, analyser: u8) -> Result<Response, Refusal> {
        let Base {
            base,
            jacks,
            ratiometric,
            ..
        } = self.base.try_get().flatten().ok_or(Refusal::NoSet)?;
        let supply = self.supply.try_get().ok_or(Refusal::NoSet)?.factor;
        let first = sums(analyser, 0).ok_or(Refusal::Incomplete { analyser })?;
        self.replay(first.drive).await?;
        let input = MotionInput {
            base: &base,
            jacks: &jacks,
            ratiometric,
            supply,
        };
        self.solving
            .motion(&FACTS, input, analyser, &first, &mut sums)
    }

    /// Completes the replay of this drive.
    async fn replay(&mut self, drive: Drive) -> Result<(), Refusal> {
        let end = Instant::now() + PATIENCE;
        while !self.solving.advance(drive, SLICE)? {
            if Instant::now() > end {
                return Err(Refusal::Busy);
            }
            yield_now().await;
        }
        Ok(())
    }
}

fn sums(analyser: u8, channel: u8) -> Option<CompleteSums> {
    path::with(|path| path.complete_sums(analyser, channel))
}

/// One channel from a complete replay. Its instructions are counted on the virtual board by this symbol.
// SAFETY: no other symbol of the program has this name.
#[unsafe(export_name = "solve_harmonics")]
#[inline(never)]
fn solve_harmonics(
    solving: &Solving,
    sums: &CompleteSums,
    channel: u8,
) -> Result<Response, Refusal> {
    solving.harmonics(&FACTS, sums, channel)
}
