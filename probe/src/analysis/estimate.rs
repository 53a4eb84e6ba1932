//! Offsets, matrices and delays from condensed runs under a belief.

use hexsense_core::calibration::triad::{Hold, Noise, SineRun, TriadFit, fit_triad};
use hexsense_core::calibration::truth::{
    SineTruth, coordinates, sine_truth, specific_force_at_rest,
};
use hexsense_core::channel::{CHANNELS, INERTIAL, JACKS, Triad};
use hexsense_core::facts::BoardFacts;
use hexsense_core::harmonics::{Harmonic, Harmonics, Series};
use hexsense_core::kinematics::forward::{Options, Solver};
use hexsense_core::kinematics::{Pose, forward::ForwardError};
use hexsense_core::least_squares::NormalEquations;
use hexsense_core::live_pose::STROKE_MARGIN_M;
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
    /// Specific force at home, m/s².
    pub home: Vector3<f64>,
    /// Place of the sensor block from O in body axes as the accelerometers feel it in the turns, m.
    pub lever_arm_m: Vector3<f64>,
    /// Its standard uncertainty by the sensors' noise, m.
    pub lever_arm_noise_m: Vector3<f64>,
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
        let options = Options {
            stroke_margin_m: STROKE_MARGIN_M,
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
        let home = rest_truth(belief, &self.zero, "zero")?;
        let turns: Vec<SineTruth> = self
            .turns
            .iter()
            .map(|sweep| self.truth(sweep, belief))
            .collect::<Result<_, _>>()?;
        let heave = self.truth(&self.heave, belief)?;
        let [lifted, angular, rate] = self.sine_runs(&heave, &turns, belief);
        let fits = [
            self.fit(Triad::LinearAcceleration, &self.holds(belief)?, &lifted)?,
            self.fit(Triad::AngularAcceleration, &[], &angular)?,
            self.fit(Triad::AngularRate, &[], &rate)?,
        ];
        let at_rest = [home, Vector3::zeros(), Vector3::zeros()];
        let offsets = Triad::ALL.map(|triad| {
            let counts = triad_counts(&self.zero.counts, triad, belief);
            fits[triad.index()].offset(&counts, &at_rest[triad.index()])
        });
        let (lever_arm_m, lever_arm_noise_m) = self.lever_arm(&turns, &fits[0], belief)?;
        Ok(Estimate {
            fits,
            offsets,
            home,
            lever_arm_m,
            lever_arm_noise_m,
        })
    }

    /// Truth of a sine run under a belief.
    ///
    /// # Errors
    /// [`AnalysisError::Pose`] and [`AnalysisError::Tolerance`].
    pub fn truth(&self, sweep: &Sweep, belief: &Belief) -> Result<SineTruth, AnalysisError> {
        let fits = pose_harmonics(sweep, self.rate_hz, belief)?;
        let omega = sweep.omega / belief.clock;
        Ok(sine_truth(&fits, omega, belief.site.gravity_m_s2))
    }

    /// The sine runs that each triad is calibrated by: heave for the accelerometers, the turns for the others; given
    /// their truths.
    #[must_use]
    pub fn sine_runs(
        &self,
        heave: &SineTruth,
        turns: &[SineTruth],
        belief: &Belief,
    ) -> [Vec<SineRun>; 3] {
        let turned = |triad: Triad, part: fn(&SineTruth) -> [Complex<f64>; 3]| {
            let runs = self.turns.iter().zip(turns);
            runs.map(|(sweep, truth)| sine_run(sweep, triad, part(truth), belief))
                .collect()
        };
        let lifted = heave.specific_force(&belief.site.lever_arm_m)[0];
        let linear = Triad::LinearAcceleration;
        [
            vec![sine_run(&self.heave, linear, lifted, belief)],
            turned(Triad::AngularAcceleration, |t| t.angular_acceleration),
            turned(Triad::AngularRate, |t| t.angular_rate),
        ]
    }

    /// Fits a triad to holds and sine runs.
    ///
    /// # Errors
    /// [`AnalysisError::Triad`].
    pub fn fit(
        &self,
        triad: Triad,
        holds: &[Hold],
        sines: &[SineRun],
    ) -> Result<TriadFit, AnalysisError> {
        fit_triad(holds, sines, &self.noise[triad.index()])
            .map_err(|source| AnalysisError::Triad { triad, source })
    }

    /// Lever arm from what the accelerometers feel in the turns, in which specific force is linear, and its standard
    /// uncertainty by their noise.
    fn lever_arm(
        &self,
        turns: &[SineTruth],
        fit: &TriadFit,
        belief: &Belief,
    ) -> Result<(Vector3<f64>, Vector3<f64>), AnalysisError> {
        let mut equations = NormalEquations::<3>::default();
        for (sweep, truth) in self.turns.iter().zip(turns) {
            let felt = felt(sweep, fit, belief, 1);
            for (axis, felt) in felt.iter().enumerate() {
                for part in [|c: Complex<f64>| c.re, |c: Complex<f64>| c.im] {
                    let columns = Vector3::from_fn(|i, _| part(truth.arm_force[i][0][axis]));
                    let beyond = felt - truth.centre_force[0][axis];
                    let weight = 1.0 / self.force_variance(fit, axis, sweep.length_s);
                    equations.add(&columns, part(beyond), weight);
                }
            }
        }
        let solution = equations.solve().ok_or(AnalysisError::MissingRun {
            run: "roll, yaw or pitch sine",
        })?;
        let noise_m = solution.cofactors.diagonal().map(f64::sqrt);
        Ok((solution.unknowns, noise_m))
    }

    /// Variance of the real or imaginary part of a specific force's amplitude on one axis, estimated over `length_s`,
    /// by the noise of the accelerometers, (m/s²)².
    #[must_use]
    pub fn force_variance(&self, fit: &TriadFit, axis: usize, length_s: f64) -> f64 {
        let density = &self.noise[Triad::LinearAcceleration.index()].density;
        let squares = (0..3).map(|sensor| (fit.matrix[(axis, sensor)] * density[sensor]).powi(2));
        squares.sum::<f64>() / length_s
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
pub(super) fn triad_counts(
    counts: &[f64; CHANNELS],
    triad: Triad,
    belief: &Belief,
) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| counts[triad.first_channel() + axis] * belief.supply)
}

/// Specific force on a base at rest.
pub(super) fn rest_truth(
    belief: &Belief,
    rest: &Rest,
    run: &str,
) -> Result<Vector3<f64>, AnalysisError> {
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
    let path: Vec<[f64; 6]> = sweep
        .jacks
        .iter()
        .map(|counts| Ok(coordinates(&poses.next(counts)?)))
        .collect::<Result<_, AnalysisError>>()?;
    let fits = Series::fit_all(per_group, path.into_iter());
    let mut fits: [Harmonics; 6] = fits.ok_or_else(|| AnalysisError::NoSine {
        run: sweep.name.clone(),
        channel: "jacks",
        frequency_hz: sweep.sine.frequency_hz,
    })?;
    // A group's mean stands for its middle, and is smaller than the signal there by sin(kωGT/2)/(G·sin(kωT/2)).
    let late_s = (group - 1.0) / 2.0 * period_s + mean_jack_instant_s(&belief.board);
    for fit in &mut fits {
        for (k, harmonic) in (1..).zip(&mut fit.harmonics) {
            let half = f64::from(k) * sweep.omega * period_s / 2.0;
            let gain = (half * group).sin() / (group * half.sin());
            *harmonic = of_complex(
                complex(harmonic) * Complex::cis(-f64::from(k) * sweep.omega * late_s) / gain,
            );
        }
    }
    Ok(fits)
}

/// Jacks are converted in six ranks; their pose belongs to the middle of them.
fn mean_jack_instant_s(board: &BoardFacts) -> f64 {
    let instants = (INERTIAL..CHANNELS).map(|channel| board.instant_s(channel));
    instants.sum::<f64>() / JACKS as f64
}

/// First harmonics of a triad's counts at the instants of the pose, and their truth.
fn sine_run(sweep: &Sweep, triad: Triad, truth: [Complex<f64>; 3], belief: &Belief) -> SineRun {
    SineRun {
        omega: sweep.omega,
        length_s: sweep.length_s,
        counts: amplitudes(sweep, triad, belief, 1),
        truth,
    }
}

/// Complex amplitudes of harmonic `k` of a triad's counts, the ranks of the converter put at one instant.
fn amplitudes(sweep: &Sweep, triad: Triad, belief: &Belief, k: usize) -> [Complex<f64>; 3] {
    core::array::from_fn(|axis| {
        let channel = triad.first_channel() + axis;
        let early = Complex::cis(-(k as f64) * sweep.omega * belief.board.instant_s(channel));
        complex(&sweep.sensors[channel].harmonics[k - 1]) * early * belief.supply
    })
}

/// Harmonic `k` of the specific force that the calibrated accelerometers show in a sine run, m/s².
#[must_use]
pub fn felt(sweep: &Sweep, fit: &TriadFit, belief: &Belief, k: usize) -> [Complex<f64>; 3] {
    let undelay = Complex::cis(k as f64 * sweep.omega * fit.delay_s);
    let counts = amplitudes(sweep, Triad::LinearAcceleration, belief, k);
    core::array::from_fn(|axis| {
        (0..3)
            .map(|sensor| counts[sensor] * fit.matrix[(axis, sensor)])
            .sum::<Complex<f64>>()
            * undelay
    })
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
