//! Harmonics and calibration factors at report time, from the sums that the sample path has completed.
//!
//! This task runs in thread mode, below sample path and link. What the table did in the window is gone through in slices
//! between which the other tasks of thread mode run ([`Replay`]); a window that takes longer than [`PATIENCE`] is answered
//! as busy, and the next request goes on from there. The last replay is kept, so that fifteen channels cost one.

use embassy_futures::yield_now;
use embassy_sync::watch::Receiver;
use embassy_time::{Duration, Instant};
use hexsense_core::channel::{CHANNELS, INERTIAL, JACKS};
use hexsense_core::harmonics::{ChannelSums, Drive, Harmonics, Replay, Solver};
use hexsense_core::live_motion::Motion;
use hexsense_core::live_pose::Tracker;
use hexsense_core::wire::message::ChannelHarmonics;
use hexsense_core::wire::{AnalyserState, PoseRefusal, Refusal, Response};

use super::exchange::{Exchange, Guard};
use super::path;
use super::pose::Base;
use super::supply::Reading;

/// Blocks that are replayed before others run: a third of a millisecond.
const SLICE: u32 = 64;
/// How long a request may wait for a replay, well below the time that a host waits for an answer.
const PATIENCE: Duration = Duration::from_millis(200);

/// What the link may ask. Each is answered once.
#[derive(Clone, Copy)]
pub enum Command {
    /// Harmonics of one channel, 0 to 14, of one analyser.
    Harmonics(u8, u8),
    /// The motion at the drive frequency of one analyser.
    Motion(u8),
}

/// Solves for ever.
#[embassy_executor::task]
pub async fn solve(exchange: &'static Exchange) -> ! {
    // The exchange has a receiver of each for this task, which starts once.
    let mut room = Room {
        replay: None,
        base: exchange.base.receiver().expect("a receiver is left"),
        supply: exchange.supply.receiver().expect("a receiver is left"),
    };
    loop {
        let answer = match exchange.to_harmonics.receive().await {
            Command::Harmonics(analyser, channel) => room.fit(analyser, channel).await,
            Command::Motion(analyser) => room.motion(analyser).await,
        };
        let answer = answer.unwrap_or_else(Response::Refused);
        exchange.answers.send(answer).await;
    }
}

struct Room {
    replay: Option<Replay>,
    base: Receiver<'static, Guard, Option<Base>, 2>,
    supply: Receiver<'static, Guard, Reading, 3>,
}

impl Room {
    async fn fit(&mut self, analyser: u8, channel: u8) -> Result<Response, Refusal> {
        let sums = complete(analyser, channel)?;
        let replay = self.replay(sums.drive).await?;
        Ok(Response::Harmonics {
            drive: sums.drive,
            first_scan: sums.first_scan,
            harmonics: fit(replay, &sums, channel).ok_or(undetermined(sums.drive))?,
        })
    }

    async fn motion(&mut self, analyser: u8) -> Result<Response, Refusal> {
        let Base { base, jacks, .. } = self.base.try_get().flatten().ok_or(Refusal::NoSet)?;
        let supply = self.supply.try_get().ok_or(Refusal::NoSet)?.factor();
        let first = complete(analyser, 0)?;
        let replay = self.replay(first.drive).await?;
        let solved = solve_all(replay, analyser, &first)?;
        let motion = Tracker::new(&base, &jacks)
            .map_err(PoseRefusal::Base)
            .and_then(|tracker| move_base(&tracker, &solved, supply, &first));
        Ok(Response::Motion {
            drive: first.drive,
            first_scan: first.first_scan,
            motion,
        })
    }

    /// The replay of this drive, complete.
    async fn replay(&mut self, drive: Drive) -> Result<&Replay, Refusal> {
        if self
            .replay
            .as_ref()
            .is_none_or(|replay| *replay.drive() != drive)
        {
            self.replay = Some(Replay::new(drive).map_err(Refusal::Drive)?);
        }
        let replay = self.replay.as_mut().ok_or(Refusal::Busy)?;
        let end = Instant::now() + PATIENCE;
        while !replay.advance(SLICE) {
            if Instant::now() > end {
                return Err(Refusal::Busy);
            }
            yield_now().await;
        }
        Ok(replay)
    }
}

/// Complete sums of one channel.
struct Complete {
    drive: Drive,
    first_scan: u64,
    rate_hz: u32,
    sums: ChannelSums,
}

fn complete(analyser: u8, channel: u8) -> Result<Complete, Refusal> {
    path::with(|path| {
        let found = path.analysers.get(usize::from(analyser));
        let found = found.filter(|found| found.state() == AnalyserState::Complete)?;
        let (drive, first_scan, sums) = found.report(channel.into())?;
        Some(Complete {
            drive,
            first_scan,
            rate_hz: path.progress.rate_hz,
            sums,
        })
    })
    .ok_or(Refusal::Incomplete { analyser })
}

fn undetermined(drive: Drive) -> Refusal {
    Refusal::Undetermined {
        blocks: drive.blocks,
    }
}

/// One channel from a complete replay. Its instructions are counted on the virtual board by this symbol.
// SAFETY: no other symbol of the program has this name.
#[unsafe(export_name = "solve_harmonics")]
#[inline(never)]
fn fit(replay: &Replay, sums: &Complete, channel: u8) -> Option<ChannelHarmonics> {
    let found = Solver::new(replay)?.solve_channel(sums.rate_hz, channel.into(), &sums.sums);
    Some(ChannelHarmonics::from(&found))
}

/// What the motion needs of all channels.
struct Solved {
    sensors: [f64; INERTIAL],
    jacks: [Harmonics; JACKS],
}

/// All channels of the window that `first` is of.
fn solve_all(replay: &Replay, analyser: u8, first: &Complete) -> Result<Solved, Refusal> {
    let solver = Solver::new(replay).ok_or(undetermined(first.drive))?;
    let channel = |channel: usize| {
        let sums = complete(analyser, channel as u8)?;
        // Between two channels the host may have set another drive.
        if (sums.drive, sums.first_scan) != (first.drive, first.first_scan) {
            return Err(Refusal::Incomplete { analyser });
        }
        Ok(solver.solve_channel(sums.rate_hz, channel, &sums.sums))
    };
    let mut solved = Solved {
        sensors: [0.0; INERTIAL],
        jacks: [const { Harmonics::NONE }; JACKS],
    };
    for (index, amplitude) in solved.sensors.iter_mut().enumerate() {
        *amplitude = channel(index)?.first().amplitude();
    }
    for (index, jack) in (INERTIAL..CHANNELS).zip(&mut solved.jacks) {
        *jack = channel(index)?;
    }
    Ok(solved)
}

fn move_base(
    tracker: &Tracker<f32>,
    solved: &Solved,
    supply: f32,
    sums: &Complete,
) -> Result<Motion, PoseRefusal> {
    let omega = core::f64::consts::TAU * sums.drive.frequency_hz(sums.rate_hz);
    Motion::new(tracker, &solved.jacks, &solved.sensors, supply, omega).map_err(PoseRefusal::from)
}
