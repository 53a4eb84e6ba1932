//! Offsets, matrices and delays from condensed runs under a belief.

use hexsense::calibration::triad::{Hold, Noise, SineRun, TriadFit, fit_triad};
use hexsense::calibration::truth::{self, SineTruth, Site, coordinates, specific_force_at_rest};
use hexsense::channel::{CHANNELS, INERTIAL, JACKS, Triad};
use hexsense::harmonics::{Harmonic, Harmonics, Series};
use hexsense::kinematics::forward::{Options, Solver};
use hexsense::kinematics::{Pose, forward::ForwardError};
use hexsense::least_squares::NormalEquations;
use hexsense::sampling::instant_s;
use nalgebra::{Complex, Vector3};

use super::AnalysisError;
use super::belief::Belief;
use super::condense::{HoldRun, Rest, Sweep};

/// All condensed runs of a campaign.
#[derive(Debug, Clone)]
pub struct Condensed {
    /// Scan rate, Hz.
    pub rate_hz: u32,
    /// The zero run.
    pub zero: Rest,
    /// The runs with holds: along pitch, along roll.
    pub hold_runs: Vec<HoldRun>,
    /// The heave run, which moves the accelerometers.
    pub heave: Sweep,
    /// The roll, yaw and pitch runs, which move the angular sensors.
    pub turns: Vec<Sweep>,
    /// Random errors of the sensors of each triad.
    pub noise: [Noise; 3],
}

/// Estimate of all triads.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// Sensitivity and delay of each triad.
    pub fits: [TriadFit; 3],
    /// Counts at zero input of each triad.
    pub offsets: [Vector3<f64>; 3],
    /// Place of the sensor block from O in body axes as the accelerometers feel it in the turns, m.
    pub lever_arm_m: Vector3<f64>,
}

/// Poses of a base, one after another.
pub struct Poses<'a> {
    belief: &'a Belief,
    solver: Solver<f64>,
    run: &'a str,
    last: Option<Pose<f64>>,
}

impl<'a> Poses<'a> {
    /// Starts at home; `run` is named in errors.
    ///
    /// # Errors
    /// [`AnalysisError::Tolerance`] when the belief is no motion base.
    pub fn new(belief: &'a Belief, run: &'a str) -> Result<Self, AnalysisError> {
        let geometry = belief
            .geometry()
            .map_err(|problem| AnalysisError::Tolerance {
                cause: "the hinges",
                problem: problem.to_string(),
            })?;
        // A jack may read beyond its stroke by the tolerance of its transducer.
        let options = Options {
            stroke_margin_m: 0.01,
            ..Options::default()
        };
        Ok(Self {
            belief,
            solver: Solver::new(&geometry, options),
            run,
            last: None,
        })
    }

    /// Pose from the counts of the jacks at nominal supply, solved from the pose before.
    ///
    /// # Errors
    /// [`AnalysisError::Pose`].
    pub fn next(&mut self, counts: &[f64; JACKS]) -> Result<Pose<f64>, AnalysisError> {
        let lengths = self.belief.lengths_m(counts);
        let solution = match &self.last {
            Some(pose) => self.solver.track(&lengths, pose),
            None => self.solver.solve(&lengths),
        };
        let pose = solution
            .map_err(|source: ForwardError<f64>| AnalysisError::Pose {
                run: self.run.to_owned(),
                source,
            })?
            .pose;
        self.last = Some(pose);
        Ok(pose)
    }
}

impl Condensed {
    /// Estimates everything under a belief.
    ///
    /// # Errors
    /// [`AnalysisError::Pose`], [`AnalysisError::Triad`] and [`AnalysisError::Tolerance`].
    pub fn estimate(&self, belief: &Belief) -> Result<Estimate, AnalysisError> {
        let home = self.home_force(belief)?;
        let heave = SweepTruth::new(&self.heave, self.rate_hz, belief)?;
        let turns: Vec<SweepTruth> = self
            .turns
            .iter()
            .map(|sweep| SweepTruth::new(sweep, self.rate_hz, belief))
            .collect::<Result<_, _>>()?;
        let sine_runs = |triad: Triad, part: fn(&SineTruth) -> [Complex<f64>; 3]| -> Vec<SineRun> {
            let runs = self.turns.iter().zip(&turns);
            runs.map(|(sweep, truth)| sine_run(sweep, triad, part(&truth.at(belief.site)), belief))
                .collect()
        };
        let runs = [
            vec![sine_run(
                &self.heave,
                Triad::LinearAcceleration,
                heave.at(belief.site).specific_force,
                belief,
            )],
            sine_runs(Triad::AngularAcceleration, |truth| {
                truth.angular_acceleration
            }),
            sine_runs(Triad::AngularRate, |truth| truth.angular_rate),
        ];
        let mut fits = Vec::new();
        let mut offsets = [Vector3::zeros(); 3];
        for triad in Triad::ALL {
            let feels_gravity = triad == Triad::LinearAcceleration;
            let holds = if feels_gravity {
                self.holds(belief)?
            } else {
                Vec::new()
            };
            let fit = fit_triad(&holds, &runs[triad.index()], &self.noise[triad.index()])
                .map_err(|source| AnalysisError::Triad { triad, source })?;
            let truth = if feels_gravity {
                home
            } else {
                Vector3::zeros()
            };
            offsets[triad.index()] =
                fit.offset(&triad_counts(&self.zero.counts, triad, belief), &truth);
            fits.push(fit);
        }
        let [a, e, w] = <[TriadFit; 3]>::try_from(fits)
            .unwrap_or_else(|_| unreachable!("one fit for each triad"));
        let lever_arm_m = self.lever_arm_m(&turns, &a, belief)?;
        Ok(Estimate {
            fits: [a, e, w],
            offsets,
            lever_arm_m,
        })
    }

    /// Lever arm from what the accelerometers feel in the turns. Specific force is linear in the lever arm r:
    /// f(r) = f(0) + Σ r_i·(f(e_i) − f(0)).
    fn lever_arm_m(
        &self,
        turns: &[SweepTruth],
        fit: &TriadFit,
        belief: &Belief,
    ) -> Result<Vector3<f64>, AnalysisError> {
        let mut equations = NormalEquations::<3>::default();
        for (sweep, truth) in self.turns.iter().zip(turns) {
            let at = |lever_arm_m| {
                truth
                    .at(Site {
                        lever_arm_m,
                        ..belief.site
                    })
                    .specific_force
            };
            let centre = at(Vector3::zeros());
            let along = [Vector3::x(), Vector3::y(), Vector3::z()].map(at);
            let counts = sine_run(sweep, Triad::LinearAcceleration, centre, belief).counts;
            let undelayed = counts.map(|count| count * Complex::cis(sweep.omega * fit.delay_s));
            for axis in 0..3 {
                let felt: Complex<f64> = (0..3)
                    .map(|sensor| undelayed[sensor] * fit.matrix[(axis, sensor)])
                    .sum();
                for part in [|c: Complex<f64>| c.re, |c: Complex<f64>| c.im] {
                    let columns = Vector3::from(along.map(|f| part(f[axis] - centre[axis])));
                    equations.add(&columns, part(felt - centre[axis]), 1.0);
                }
            }
        }
        let solution = equations.solve().ok_or(AnalysisError::MissingRun {
            run: "roll, yaw or pitch sine",
        })?;
        Ok(solution.unknowns)
    }

    /// Specific force at home under a belief, m/s².
    ///
    /// # Errors
    /// [`AnalysisError::Pose`] and [`AnalysisError::Tolerance`].
    pub fn home_force(&self, belief: &Belief) -> Result<Vector3<f64>, AnalysisError> {
        rest_truth(belief, &self.zero, "zero")
    }

    /// Means and true specific forces of all holds.
    ///
    /// # Errors
    /// [`AnalysisError::Pose`] and [`AnalysisError::Tolerance`].
    pub fn holds(&self, belief: &Belief) -> Result<Vec<Hold>, AnalysisError> {
        let mut holds = Vec::new();
        for (run, hold_run) in self.hold_runs.iter().enumerate() {
            for rest in &hold_run.holds {
                let counts = triad_counts(&rest.counts, Triad::LinearAcceleration, belief);
                let truth = rest_truth(belief, rest, &hold_run.name)?;
                holds.push(Hold {
                    run,
                    time_s: rest.time_s,
                    length_s: rest.length_s,
                    counts,
                    truth,
                });
            }
        }
        Ok(holds)
    }
}

/// Counts of a triad at nominal supply, as believed.
fn triad_counts(counts: &[f64; CHANNELS], triad: Triad, belief: &Belief) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| counts[triad.first_channel() + axis] * belief.supply)
}

/// Specific force on a base at rest.
fn rest_truth(belief: &Belief, rest: &Rest, run: &str) -> Result<Vector3<f64>, AnalysisError> {
    let counts = core::array::from_fn(|jack| rest.counts[INERTIAL + jack]);
    let pose = Poses::new(belief, run)?.next(&counts)?;
    Ok(specific_force_at_rest(&pose.rotation, &belief.site))
}

/// Harmonics of the six coordinates of the pose in a sine run, phase zero at the trigger of its first scan.
///
/// # Errors
/// [`AnalysisError::Pose`] and [`AnalysisError::NoSine`].
pub fn pose_harmonics(
    sweep: &Sweep,
    rate_hz: u32,
    belief: &Belief,
) -> Result<[Harmonics; 6], AnalysisError> {
    let period_s = 1.0 / f64::from(rate_hz);
    let group = sweep.group as f64;
    let per_group = sweep.omega * period_s * group;
    let mut poses = Poses::new(belief, &sweep.name)?;
    let mut series: [Series; 6] =
        core::array::from_fn(|_| Series::new(per_group, sweep.jacks.len()));
    for counts in &sweep.jacks {
        let coordinates = coordinates(&poses.next(counts)?);
        series
            .iter_mut()
            .zip(coordinates)
            .for_each(|(series, value)| series.push(value));
    }
    // A group's mean stands for its middle, and is smaller than the signal there by sin(kωGT/2)/(G·sin(kωT/2)).
    let late_s = (group - 1.0) / 2.0 * period_s + mean_jack_instant_s();
    let mut fits = Vec::new();
    for series in &series {
        let mut fit = series.solve().ok_or_else(|| AnalysisError::NoSine {
            run: sweep.name.clone(),
            channel: "jacks",
            frequency_hz: sweep.sine.frequency_hz,
        })?;
        for (k, harmonic) in (1..).zip(&mut fit.harmonics) {
            let half = f64::from(k) * sweep.omega * period_s / 2.0;
            let gain = (half * group).sin() / (group * half.sin());
            *harmonic = of_complex(
                complex(harmonic) * Complex::cis(-f64::from(k) * sweep.omega * late_s) / gain,
            );
        }
        fits.push(fit);
    }
    Ok(<[Harmonics; 6]>::try_from(fits)
        .unwrap_or_else(|_| unreachable!("one fit for each coordinate")))
}

/// Jacks are converted in six ranks; their pose belongs to the middle of them.
fn mean_jack_instant_s() -> f64 {
    (INERTIAL..CHANNELS).map(instant_s).sum::<f64>() / JACKS as f64
}

/// The truth of a sine run, for any place of the sensor block.
struct SweepTruth {
    fits: [Harmonics; 6],
    omega: f64,
}

impl SweepTruth {
    fn new(sweep: &Sweep, rate_hz: u32, belief: &Belief) -> Result<Self, AnalysisError> {
        let fits = pose_harmonics(sweep, rate_hz, belief)?;
        Ok(Self {
            fits,
            omega: sweep.omega / belief.clock,
        })
    }

    fn at(&self, site: Site) -> SineTruth {
        truth::sine_truth(&self.fits, self.omega, &site)
    }
}

fn sine_run(sweep: &Sweep, triad: Triad, truth: [Complex<f64>; 3], belief: &Belief) -> SineRun {
    let counts = core::array::from_fn(|axis| {
        let channel = triad.first_channel() + axis;
        let early = Complex::cis(-sweep.omega * instant_s(channel));
        complex(&sweep.sensors[channel].first()) * early * belief.supply
    });
    SineRun {
        omega: sweep.omega,
        length_s: sweep.length_s,
        counts,
        truth,
    }
}

/// Complex amplitude a − i·b of a·cos θ + b·sin θ.
#[must_use]
pub fn complex(harmonic: &Harmonic) -> Complex<f64> {
    Complex::new(harmonic.cosine, -harmonic.sine)
}

fn of_complex(amplitude: Complex<f64>) -> Harmonic {
    Harmonic {
        cosine: amplitude.re,
        sine: -amplitude.im,
    }
}
