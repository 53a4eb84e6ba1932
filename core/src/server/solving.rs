//! Harmonics and calibration factors at report time, from the sums that the sample path has completed.
//!
//! What the table did in the window is gone through in slices ([`Replay`]), so that the board can do other work between
//! two of them. The last replay is kept, so that fifteen channels cost one:
//!
//! ```text
//! command ─▶ Solving::sums ─▶ Solving::advance … true ─▶ Solving::harmonics or Solving::motion ─▶ answer
//! ```

use crate::channel::{CHANNELS, INERTIAL, JACKS, Ratiometric};
use crate::facts::BoardFacts;
use crate::harmonics::{Drive, Harmonics, Replay, Solver};
use crate::live_motion::Motion;
use crate::live_pose::Tracker;
use crate::records::{JackCoefficients, MotionBase};
use crate::sample_path::CompleteSums;
use crate::wire::message::ChannelHarmonics;
use crate::wire::{PoseRefusal, Refusal, Response};

/// Looks up the complete sums of an analyser in a channel, as [`crate::sample_path::Path::complete_sums`] does.
pub type Lookup<'a> = &'a mut dyn FnMut(u8, u8) -> Option<CompleteSums>;

/// What motion base and transducers are, and the supply factor now.
#[derive(Clone, Copy)]
pub struct MotionInput<'a> {
    /// The motion base of the active set.
    pub base: &'a MotionBase,
    /// Its transducers.
    pub jacks: &'a JackCoefficients,
    /// The channels on which the supply factor does not act.
    pub ratiometric: Ratiometric,
    /// Supply factor.
    pub supply: f32,
}

/// The last replay.
#[derive(Default)]
pub struct Solving {
    replay: Option<Replay>,
}

impl Solving {
    /// Nothing replayed yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { replay: None }
    }

    /// Goes on with the replay of a drive by at most `blocks` blocks; whether it is complete.
    ///
    /// # Errors
    /// [`Refusal::Drive`] when there is no such drive.
    pub fn advance(&mut self, drive: Drive, blocks: u32) -> Result<bool, Refusal> {
        let is_other = |replay: &Replay| *replay.drive() != drive;
        if self.replay.as_ref().is_none_or(is_other) {
            self.replay = Some(Replay::new(drive).map_err(Refusal::Drive)?);
        }
        let replay = self.replay.as_mut().ok_or(Refusal::Busy)?;
        Ok(replay.advance(blocks))
    }

    /// Harmonics of one channel, once the replay of its drive is complete.
    ///
    /// # Errors
    /// [`Refusal::Undetermined`] when the blocks do not determine them.
    pub fn harmonics(
        &self,
        facts: &BoardFacts,
        sums: &CompleteSums,
        channel: u8,
    ) -> Result<Response, Refusal> {
        let solver = self.solver(sums.drive)?;
        let found = solver.solve_channel(late_scans(facts, sums, channel.into()), &sums.sums);
        Ok(Response::Harmonics {
            drive: sums.drive,
            first_scan: sums.first_scan,
            harmonics: ChannelHarmonics::from(&found),
        })
    }

    /// The motion of the base in the window that `first`, the sums of channel 0 of an analyser, belongs to, once the
    /// replay of its drive is complete.
    ///
    /// # Errors
    /// [`Refusal::Incomplete`] when the host has set another drive meanwhile, [`Refusal::Undetermined`] when the blocks do
    /// not determine the harmonics.
    pub fn motion(
        &self,
        facts: &BoardFacts,
        input: MotionInput<'_>,
        analyser: u8,
        first: &CompleteSums,
        lookup: Lookup<'_>,
    ) -> Result<Response, Refusal> {
        let solved = self.solve_all(facts, analyser, first, lookup)?;
        let omega = core::f64::consts::TAU * first.drive.frequency_hz(first.rate_hz);
        let motion = Tracker::new(input.base, input.jacks, input.ratiometric)
            .map_err(PoseRefusal::Base)
            .and_then(|tracker| {
                Motion::new(
                    &tracker,
                    &solved.jacks,
                    &solved.sensors,
                    (input.supply, input.ratiometric),
                    omega,
                )
                .map_err(PoseRefusal::from)
            });
        Ok(Response::Motion {
            drive: first.drive,
            first_scan: first.first_scan,
            motion,
        })
    }

    fn solver(&self, drive: Drive) -> Result<Solver<'_>, Refusal> {
        let replay = self.replay.as_ref().ok_or(Refusal::Busy)?;
        Solver::new(replay).ok_or(Refusal::Undetermined {
            blocks: drive.blocks,
        })
    }

    fn solve_all(
        &self,
        facts: &BoardFacts,
        analyser: u8,
        first: &CompleteSums,
        lookup: Lookup<'_>,
    ) -> Result<Solved, Refusal> {
        let solver = self.solver(first.drive)?;
        let mut channel = |channel: usize| {
            let sums = lookup(analyser, channel as u8).ok_or(Refusal::Incomplete { analyser })?;
            // Between two channels the host may have set another drive.
            if (sums.drive, sums.first_scan) != (first.drive, first.first_scan) {
                return Err(Refusal::Incomplete { analyser });
            }
            Ok(solver.solve_channel(late_scans(facts, &sums, channel), &sums.sums))
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
}

/// What the motion needs of all channels.
struct Solved {
    /// Amplitudes of the first harmonic, counts.
    sensors: [f64; INERTIAL],
    jacks: [Harmonics; JACKS],
}

/// From the trigger of a scan to the conversion of a channel, scans.
fn late_scans(facts: &BoardFacts, sums: &CompleteSums, channel: usize) -> f64 {
    facts.instant_s(channel) * f64::from(sums.rate_hz)
}
