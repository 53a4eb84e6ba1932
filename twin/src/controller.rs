//! The motion controller: it takes a program, starts it after a random time, and commands the six jacks.
//!
//! It has a clock of its own: a run starts 0 to 10 s after the request, and its seconds are up to 100 ppm longer or
//! shorter than true ones. It refuses a program that leaves the stroke, is too fast, begins away from the base's
//! position, or comes while the base still moves. A stop brakes along the checked path of the program, and then moves
//! all jacks home together.
//!
//! The command is a sequence of *courses*, each valid from a moment on. Jacks answer late, so the controller also gives
//! the command of a moment in the recent past.

use std::collections::VecDeque;

use thiserror::Error;

use crate::geometry::Geometry;
use crate::limits::{BeyondLimit, Limits};
use crate::program::Program;
use crate::random::Stream;

/// Latest start of a run after the request, s.
pub const START_DELAY_MAX_S: f64 = 10.0;
/// Largest error of the controller's clock, ppm.
pub const CLOCK_TOLERANCE_PPM: f64 = 100.0;
/// Greatest distance between the first row of a program and the standing base, m: the rounding of a CSV file, not a
/// jump.
const START_TOLERANCE_M: f64 = 1e-4;
/// Time in which a stop brings the base to a halt on its path, s.
const BRAKE_S: f64 = 0.5;
/// Highest speed of a jack on the way home, m/s.
const RETURN_SPEED_M_S: f64 = 0.1;
/// Highest acceleration of a jack on the way home, m/s².
const RETURN_ACCELERATION_M_S2: f64 = 0.5;
/// Time for which old commands are kept, s: more than any jack's delay.
const MEMORY_S: f64 = 0.1;

/// The motion controller.
#[derive(Debug, Clone)]
pub struct Controller {
    limits: Limits,
    home_m: [f64; 6],
    /// Controller seconds per true second.
    clock: f64,
    start_delay: Stream,
    /// In order of time, never empty; each holds until the next begins.
    courses: VecDeque<(f64, Course)>,
}

/// The commanded course of the jacks from some moment on.
#[derive(Debug, Clone)]
enum Course {
    Hold([f64; 6]),
    Run {
        name: String,
        program: Program,
        start_s: f64,
    },
    /// A run that is braked from `from_s`, when its own time was `phase_s`.
    Brake {
        program: Program,
        from_s: f64,
        phase_s: f64,
    },
    Return {
        from_m: [f64; 6],
        from_s: f64,
        duration_s: f64,
    },
}

/// Why the controller refuses a program.
#[derive(Debug, Error, PartialEq)]
pub enum Refusal {
    /// The base still moves.
    #[error("{doing} has not ended; wait for it, or stop")]
    Busy {
        /// The run, or the way home.
        doing: String,
    },
    /// A row beyond a limit of the jacks.
    #[error(transparent)]
    Limit(#[from] BeyondLimit),
    /// The program begins elsewhere.
    #[error(
        "jack {jack} would jump from {from_m:.4} m, where it stands, to {to_m:.4} m, where the program begins \
         (limit {START_TOLERANCE_M} m); stop returns the base home"
    )]
    Jump {
        /// The jack, 1 to 6.
        jack: usize,
        /// Where it stands, m.
        from_m: f64,
        /// Where the program begins, m.
        to_m: f64,
    },
}

impl Controller {
    /// The controller of a base, holding it at home.
    #[must_use]
    pub fn draw(seed: u64, geometry: &Geometry) -> Self {
        let home_m = geometry.home_displacements_m();
        let ppm = Stream::new(seed, "controller.clock").within(CLOCK_TOLERANCE_PPM);
        Self {
            limits: Limits::of(geometry),
            home_m,
            clock: 1.0 + 1e-6 * ppm,
            start_delay: Stream::new(seed, "controller.start"),
            courses: VecDeque::from([(0.0, Course::Hold(home_m))]),
        }
    }

    /// Takes a program at true time `now_s`; it will start 0 to 10 s later.
    ///
    /// # Errors
    /// [`Refusal`]: the base still moves, or the program breaks a limit.
    pub fn run(&mut self, name: &str, program: Program, now_s: f64) -> Result<(), Refusal> {
        if let Some(doing) = self.occupation(now_s) {
            return Err(Refusal::Busy { doing });
        }
        self.limits.check(&program)?;
        for jack in 0..6 {
            let (from_m, to_m) = (self.command_m(jack, now_s), program.at(jack, 0.0));
            if (to_m - from_m).abs() > START_TOLERANCE_M {
                return Err(Refusal::Jump {
                    jack: jack + 1,
                    from_m,
                    to_m,
                });
            }
        }
        let start_s = now_s + self.start_delay.uniform(0.0, START_DELAY_MAX_S);
        let name = name.to_owned();
        self.set(
            now_s,
            Course::Run {
                name,
                program,
                start_s,
            },
        );
        Ok(())
    }

    /// Stops at true time `now_s` and returns home.
    pub fn stop(&mut self, now_s: f64) {
        let (halt_s, from_m) = match self.courses.back() {
            Some((
                _,
                Course::Run {
                    program, start_s, ..
                },
            )) => {
                let phase_s = (now_s - start_s) * self.clock;
                let program = program.clone();
                let halt = program_row(&program, phase_s + 0.5 * BRAKE_S * self.clock);
                self.set(
                    now_s,
                    Course::Brake {
                        program,
                        from_s: now_s,
                        phase_s,
                    },
                );
                (now_s + BRAKE_S, halt)
            }
            Some((_, Course::Hold(held))) => (now_s, *held),
            _ => return,
        };
        let duration_s = return_duration_s(&from_m, &self.home_m);
        self.set(
            halt_s,
            Course::Return {
                from_m,
                from_s: halt_s,
                duration_s,
            },
        );
    }

    /// Commanded displacement from mid-stroke of one jack (0 to 5), m, at a true time no further back than any jack's
    /// delay.
    #[must_use]
    pub fn command_m(&self, jack: usize, time_s: f64) -> f64 {
        let course = self
            .courses
            .iter()
            .rev()
            .find(|(from_s, _)| *from_s <= time_s)
            .or(self.courses.front());
        match course {
            None => self.home_m[jack],
            Some((_, Course::Hold(held))) => held[jack],
            Some((
                _,
                Course::Run {
                    program, start_s, ..
                },
            )) => program.at(jack, (time_s - start_s) * self.clock),
            Some((
                _,
                Course::Brake {
                    program,
                    from_s,
                    phase_s,
                },
            )) => {
                let s = (time_s - from_s).min(BRAKE_S);
                program.at(jack, phase_s + self.clock * (s - 0.5 * s * s / BRAKE_S))
            }
            Some((
                _,
                Course::Return {
                    from_m,
                    from_s,
                    duration_s,
                },
            )) => {
                let share = smooth((time_s - from_s) / duration_s);
                from_m[jack] + share * (self.home_m[jack] - from_m[jack])
            }
        }
    }

    /// The activity that keeps the base busy at `now_s`.
    pub(crate) fn occupation(&self, now_s: f64) -> Option<String> {
        match self.courses.back() {
            Some((
                _,
                Course::Run {
                    name,
                    program,
                    start_s,
                },
            )) => {
                let end_s = start_s + program.duration_s() / self.clock;
                (now_s < end_s).then(|| format!("run {name:?}"))
            }
            Some((
                _,
                Course::Return {
                    from_s, duration_s, ..
                },
            )) => (now_s < from_s + duration_s).then(|| "the return home".to_owned()),
            _ => None,
        }
    }

    /// Appends a course and drops those older than any jack's delay.
    fn set(&mut self, from_s: f64, course: Course) {
        self.courses.push_back((from_s, course));
        while self
            .courses
            .get(1)
            .is_some_and(|(next_s, _)| next_s + MEMORY_S < from_s)
        {
            self.courses.pop_front();
        }
    }
}

fn program_row(program: &Program, time_s: f64) -> [f64; 6] {
    std::array::from_fn(|jack| program.at(jack, time_s))
}

/// From 0 to 1 with no speed and no acceleration at either end (the minimum-jerk polynomial).
fn smooth(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 + s * (-15.0 + 6.0 * s))
}

/// Time that the way home takes, s, so that [`smooth`] keeps the limits of the way home.
fn return_duration_s(from_m: &[f64; 6], to_m: &[f64; 6]) -> f64 {
    let distance_m = from_m
        .iter()
        .zip(to_m)
        .fold(0.0, |max: f64, (from, to)| max.max((to - from).abs()));
    let by_speed = 1.875 * distance_m / RETURN_SPEED_M_S;
    let by_acceleration = (5.774 * distance_m / RETURN_ACCELERATION_M_S2).sqrt();
    by_speed.max(by_acceleration).max(1.0)
}
