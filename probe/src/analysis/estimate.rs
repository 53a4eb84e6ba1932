//! Offsets, matrices and delays from condensed runs under assumptions.

use hexsense_core::calibration::triad::{MeasuredHold, Noise, SineRun, TriadFit, fit_triad};
use hexsense_core::calibration::truth::{SineTruth, sine_truth};
use hexsense_core::channel::{CHANNELS, Triad};
use hexsense_core::least_squares::NormalEquations;
use nalgebra::{Complex, Vector3};

use super::AnalysisError;
use super::assumptions::Assumptions;
use super::condense::{HoldRun, RestMeans, Sweep};
use super::poses::{complex, pose_harmonics, rest_truth};

/// All condensed runs of a campaign.
#[derive(Debug, Clone)]
pub struct Condensed {
    /// Scan rate, Hz.
    pub rate_hz: u32,
    /// The zero run.
    pub zero: RestMeans,
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

impl Condensed {
    /// Estimates everything under assumptions.
    ///
    /// # Errors
    /// [`AnalysisError::Pose`], [`AnalysisError::Triad`] and [`AnalysisError::Tolerance`].
    pub fn estimate(&self, assumptions: &Assumptions) -> Result<Estimate, AnalysisError> {
        let home = rest_truth(assumptions, &self.zero, "zero")?;
        let turns: Vec<SineTruth> = self
            .turns
            .iter()
            .map(|sweep| self.truth(sweep, assumptions))
            .collect::<Result<_, _>>()?;
        let heave = self.truth(&self.heave, assumptions)?;
        let [lifted, angular, rate] = self.sine_runs(&heave, &turns, assumptions);
        let fits = [
            self.fit(
                Triad::LinearAcceleration,
                &self.holds(assumptions)?,
                &lifted,
            )?,
            self.fit(Triad::AngularAcceleration, &[], &angular)?,
            self.fit(Triad::AngularRate, &[], &rate)?,
        ];
        let at_rest = [home, Vector3::zeros(), Vector3::zeros()];
        let offsets = Triad::ALL.map(|triad| {
            let counts = triad_counts(&self.zero.counts, triad, assumptions);
            fits[triad.index()].offset(&counts, &at_rest[triad.index()])
        });
        let (lever_arm_m, lever_arm_noise_m) = self.lever_arm(&turns, &fits[0], assumptions)?;
        Ok(Estimate {
            fits,
            offsets,
            home,
            lever_arm_m,
            lever_arm_noise_m,
        })
    }

    /// Truth of a sine run under assumptions.
    ///
    /// # Errors
    /// [`AnalysisError::Pose`] and [`AnalysisError::Tolerance`].
    pub fn truth(
        &self,
        sweep: &Sweep,
        assumptions: &Assumptions,
    ) -> Result<SineTruth, AnalysisError> {
        let fits = pose_harmonics(sweep, assumptions)?;
        let omega = sweep.omega / assumptions.clock;
        Ok(sine_truth(&fits, omega, assumptions.site.gravity_m_s2))
    }

    /// The sine runs that each triad is calibrated by: heave for the accelerometers, the turns for the others; given
    /// their truths.
    #[must_use]
    pub fn sine_runs(
        &self,
        heave: &SineTruth,
        turns: &[SineTruth],
        assumptions: &Assumptions,
    ) -> [Vec<SineRun>; 3] {
        let turned = |triad: Triad, part: fn(&SineTruth) -> [Complex<f64>; 3]| {
            let runs = self.turns.iter().zip(turns);
            runs.map(|(sweep, truth)| sine_run(sweep, triad, part(truth), assumptions))
                .collect()
        };
        let lifted = heave.specific_force(&assumptions.site.lever_arm_m)[0];
        let linear = Triad::LinearAcceleration;
        [
            vec![sine_run(&self.heave, linear, lifted, assumptions)],
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
        holds: &[MeasuredHold],
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
        assumptions: &Assumptions,
    ) -> Result<(Vector3<f64>, Vector3<f64>), AnalysisError> {
        let mut equations = NormalEquations::<3>::default();
        for (sweep, truth) in self.turns.iter().zip(turns) {
            let felt = felt(sweep, fit, assumptions, 1);
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
    pub fn holds(&self, assumptions: &Assumptions) -> Result<Vec<MeasuredHold>, AnalysisError> {
        let mut holds = Vec::new();
        for (run, hold_run) in self.hold_runs.iter().enumerate() {
            for rest in &hold_run.holds {
                let counts = triad_counts(&rest.counts, Triad::LinearAcceleration, assumptions);
                let truth = rest_truth(assumptions, rest, &hold_run.name)?;
                holds.push(MeasuredHold {
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

/// Counts of a triad at nominal supply, as assumed.
pub(super) fn triad_counts(
    counts: &[f64; CHANNELS],
    triad: Triad,
    assumptions: &Assumptions,
) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| {
        let channel = triad.first_channel() + axis;
        counts[channel] * assumptions.supply_of(channel)
    })
}

/// First harmonics of a triad's counts at the instants of the pose, and their truth.
fn sine_run(
    sweep: &Sweep,
    triad: Triad,
    truth: [Complex<f64>; 3],
    assumptions: &Assumptions,
) -> SineRun {
    SineRun {
        omega: sweep.omega,
        length_s: sweep.length_s,
        counts: amplitudes(sweep, triad, assumptions, 1),
        truth,
    }
}

/// Complex amplitudes of harmonic `k` of a triad's counts, the ranks of the converter put at one instant.
fn amplitudes(
    sweep: &Sweep,
    triad: Triad,
    assumptions: &Assumptions,
    k: usize,
) -> [Complex<f64>; 3] {
    core::array::from_fn(|axis| {
        let channel = triad.first_channel() + axis;
        let early = Complex::cis(-(k as f64) * sweep.omega * assumptions.board.instant_s(channel));
        complex(&sweep.sensors[channel].harmonics[k - 1]) * early * assumptions.supply_of(channel)
    })
}

/// Harmonic `k` of the specific force that the calibrated accelerometers show in a sine run, m/s².
#[must_use]
pub fn felt(
    sweep: &Sweep,
    fit: &TriadFit,
    assumptions: &Assumptions,
    k: usize,
) -> [Complex<f64>; 3] {
    let undelay = Complex::cis(k as f64 * sweep.omega * fit.delay_s);
    let counts = amplitudes(sweep, Triad::LinearAcceleration, assumptions, k);
    core::array::from_fn(|axis| {
        (0..3)
            .map(|sensor| counts[sensor] * fit.matrix[(axis, sensor)])
            .sum::<Complex<f64>>()
            * undelay
    })
}
