//! The time that kinematics takes.
//!
//! | figure | timed work |
//! |---|---|
//! | cold | [`Solver::solve`], from home, one call after another: ten thousand random poses, uniform within ±0.1 m and ±12° in each coordinate |
//! | warm | [`Solver::track`], from the pose before: ten seconds of a 1 Hz movement of ±0.1 m and ±12° in all six coordinates, at 1 kHz |
//! | inverse | [`inverse()`] of the random poses |
//! | batch | a million samples of the movement by [`PoseTracker`], in blocks of 1024 shared out to all cores, as `hexsense kinematics pose` solves them |
//!
//! The base has hinge radii of 0.75 m (lower, pairs 20° apart) and 0.5 m (upper, pairs 20° apart, turned by 60°) and
//! home at 0.8 m; solutions are exact to 1e-10 m. A time is the median over rounds of the mean of a round. The rounds
//! of the first three figures take turns, so that other load of the machine affects all of them and their ratios hold.
//! Only an optimised build gives a meaningful time.

use std::f64::consts::TAU;
use std::hint::black_box;
use std::num::NonZero;
use std::ops::Range;
use std::thread;
use std::time::Instant;

use hexsense_core::kinematics::{
    Angles, Convention, ForwardError, Geometry, Options, Pose, PoseTracker, Solution,
    SolveFromHome, Solver, inverse,
};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Uniform};
use serde::Serialize;

/// Number of poses: more than a branch predictor can learn.
const POSES: usize = 10_000;
/// Calls of a round, which takes the next of the poses: so few that the scheduler seldom interrupts.
const CALLS: usize = 500;
/// Samples of a period of the movement.
const PERIOD: usize = 1_000;
/// Rounds of a median.
const ROUNDS: usize = 4_000;
/// Samples of the batch.
const BATCH: usize = 1_000_000;
/// Samples after which a tracker starts again.
const BLOCK: usize = 1024;
/// Rounds of the batch.
const BATCH_ROUNDS: usize = 5;
const SEED: u64 = 1;
const HOME_HEIGHT_M: f64 = 0.8;
const REACH_M: f64 = 0.1;
const REACH_DEG: f64 = 12.0;

type Found = Result<Solution<f64>, ForwardError<f64>>;

/// What was measured.
#[derive(Debug, Clone, Serialize)]
pub struct Figures {
    /// Forward kinematics from home.
    pub cold: Forward,
    /// Forward kinematics from the pose before.
    pub warm: Forward,
    /// Inverse kinematics.
    pub inverse: Inverse,
    /// Forward kinematics of a recorded run on all cores.
    pub batch: Batch,
}

/// Forward kinematics on one thread.
#[derive(Debug, Clone, Serialize)]
pub struct Forward {
    /// Time of a solve, ns.
    pub ns: f64,
    /// Mean number of iterations.
    pub iterations_mean: f64,
    /// Greatest number of iterations.
    pub iterations_max: u32,
    /// Poses that were not found, or found more than 1e-9 m or rad from the true pose.
    pub failed: usize,
}

/// Inverse kinematics on one thread.
#[derive(Debug, Clone, Serialize)]
pub struct Inverse {
    /// Time for six lengths, ns.
    pub ns: f64,
}

/// Forward kinematics on all cores.
#[derive(Debug, Clone, Serialize)]
pub struct Batch {
    /// Samples solved in a second by all threads together.
    pub solves_per_second: f64,
    /// Threads.
    pub threads: usize,
}

/// A base and its poses, for another program to solve.
#[derive(Debug, Clone, Serialize)]
pub struct Cases {
    /// Lower hinges, axes with Y up, m.
    pub lower: [[f64; 3]; 6],
    /// Upper hinges, m.
    pub upper: [[f64; 3]; 6],
    /// Position at home, m.
    pub start: [f64; 3],
    /// Jack lengths of each pose, m.
    pub lengths: Vec<[f64; 6]>,
}

/// The base of the figures, and the first of the random poses.
#[must_use]
pub fn cases() -> Cases {
    let base = base();
    let numbers = |hinges: &[Vector3<f64>; 6]| hinges.map(Into::into);
    Cases {
        lower: numbers(base.lower()),
        upper: numbers(base.upper()),
        start: base.home().position.into(),
        lengths: all_lengths(&base, &random_poses()[..CALLS]),
    }
}

/// Measures everything; takes some seconds.
#[must_use]
pub fn measure() -> Figures {
    let solver = Solver::new(&base(), Options::default());
    let geometry = solver.geometry();
    let (still, moving) = (random_poses(), movement());
    let (still_lengths, moving_lengths) = (
        all_lengths(geometry, &still),
        all_lengths(geometry, &moving),
    );
    let mut cold = |round: usize| {
        for lengths in &still_lengths[calls(round)] {
            let _ = black_box(solver.solve(black_box(lengths)));
        }
    };
    let mut warm = |round: usize| {
        let last = moving[(calls(round).start + POSES - 1) % POSES];
        for answer in track(&solver, &moving_lengths[calls(round)], last) {
            let _ = black_box(answer);
        }
    };
    let mut back = |round: usize| {
        for pose in &still[calls(round)] {
            black_box(inverse(geometry, black_box(pose)));
        }
    };
    let [cold_ns, warm_ns, inverse_ns] =
        medians_ns(ROUNDS, CALLS, [&mut cold, &mut warm, &mut back]);
    let cold = still_lengths.iter().map(|lengths| solver.solve(lengths));
    let warm = track(&solver, &moving_lengths, moving[POSES - 1]);
    Figures {
        cold: judge(cold_ns, &still, cold),
        warm: judge(warm_ns, &moving, warm),
        inverse: Inverse { ns: inverse_ns },
        batch: batch(&solver, &moving_lengths),
    }
}

/// The poses of a round. The movement is periodic: its last pose comes before its first.
fn calls(round: usize) -> Range<usize> {
    let start = round * CALLS % POSES;
    start..start + CALLS
}

fn base() -> Geometry<f64> {
    let hinges = |radius: f64, from_axis_deg: f64| {
        std::array::from_fn(|k| {
            let side = if k % 2 == 0 { -1.0 } else { 1.0 };
            let angle_deg = 120.0 * (k / 2) as f64 + side * from_axis_deg;
            let (sine, cosine) = angle_deg.to_radians().sin_cos();
            Vector3::new(radius * cosine, 0.0, radius * sine)
        })
    };
    Geometry::new(
        hinges(0.75, 50.0),
        hinges(0.5, 10.0),
        0.3,
        2.0,
        Some(HOME_HEIGHT_M),
    )
    .expect("these hinges hold a platform")
}

/// The pose whose coordinates, as fractions of the reach, are given.
fn pose(coordinates: [f64; 6]) -> Pose<f64> {
    let [x, y, z, roll, pitch, yaw] = coordinates;
    let position = Vector3::new(x, y, z) * REACH_M + Vector3::y() * HOME_HEIGHT_M;
    let [roll, pitch, yaw] = [roll, pitch, yaw].map(|angle| (angle * REACH_DEG).to_radians());
    Convention::Gost.pose(position, Angles { roll, pitch, yaw })
}

fn random_poses() -> Vec<Pose<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let coordinate = Uniform::new_inclusive(-1.0, 1.0).expect("an interval");
    (0..POSES)
        .map(|_| pose(std::array::from_fn(|_| coordinate.sample(&mut random))))
        .collect()
}

fn movement() -> Vec<Pose<f64>> {
    let at = |sample: usize| {
        let turn = TAU * sample as f64 / PERIOD as f64;
        pose(std::array::from_fn(|freedom| (turn + freedom as f64).sin()))
    };
    (0..POSES).map(at).collect()
}

fn all_lengths(geometry: &Geometry<f64>, poses: &[Pose<f64>]) -> Vec<[f64; 6]> {
    poses.iter().map(|pose| inverse(geometry, pose)).collect()
}

/// Solves sample after sample, each from the pose before.
fn track(
    solver: &Solver<f64>,
    lengths: &[[f64; 6]],
    before: Pose<f64>,
) -> impl Iterator<Item = Found> {
    let mut last = before;
    lengths.iter().map(move |lengths| {
        let found = solver.track(black_box(lengths), &last);
        if let Ok(solution) = &found {
            last = solution.pose;
        }
        found
    })
}

/// Counts the iterations, and the wrong or missing answers.
fn judge(ns: f64, poses: &[Pose<f64>], answers: impl Iterator<Item = Found>) -> Forward {
    let mut iterations = Vec::new();
    for (answer, pose) in answers.zip(poses) {
        if let Ok(solution) = answer {
            let (distance_m, angle_rad) = solution.pose.distance(pose);
            if distance_m <= 1e-9 && angle_rad <= 1e-9 {
                iterations.push(solution.iterations);
            }
        }
    }
    Forward {
        ns,
        iterations_mean: f64::from(iterations.iter().sum::<u32>()) / iterations.len() as f64,
        iterations_max: iterations.iter().copied().max().unwrap_or(0),
        failed: poses.len() - iterations.len(),
    }
}

fn batch(solver: &Solver<f64>, movement: &[[f64; 6]]) -> Batch {
    let threads = thread::available_parallelism().map_or(1, NonZero::get);
    let run: Vec<[f64; 6]> = movement.iter().copied().cycle().take(BATCH).collect();
    let mut answers: Vec<_> = run.iter().map(|lengths| solver.solve(lengths)).collect();
    let share = BATCH.div_ceil(threads).next_multiple_of(BLOCK);
    let mut solve = |_| {
        thread::scope(|scope| {
            for (run, answers) in run.chunks(share).zip(answers.chunks_mut(share)) {
                scope.spawn(|| {
                    for (run, answers) in run.chunks(BLOCK).zip(answers.chunks_mut(BLOCK)) {
                        let mut tracker = PoseTracker::new(solver.clone(), SolveFromHome);
                        for (lengths, answer) in run.iter().zip(answers) {
                            *answer = tracker.next(lengths);
                        }
                    }
                });
            }
        });
        black_box(&answers);
    };
    let [ns] = medians_ns(BATCH_ROUNDS, BATCH, [&mut solve]);
    Batch {
        solves_per_second: 1e9 / ns,
        threads,
    }
}

/// Medians over `rounds` of the time of one of the `calls` of each kind of work, ns; the kinds take turns.
fn medians_ns<const N: usize>(
    rounds: usize,
    calls: usize,
    mut works: [&mut dyn FnMut(usize); N],
) -> [f64; N] {
    let mut times = [const { Vec::new() }; N];
    for round in 0..rounds {
        for (work, times) in works.iter_mut().zip(&mut times) {
            let start = Instant::now();
            work(round);
            times.push(start.elapsed().as_secs_f64() * 1e9 / calls as f64);
        }
    }
    times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[rounds / 2]
    })
}
