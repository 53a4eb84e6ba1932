//! What is left of transients on the holds and in the sines.
//!
//! Holds and sines have time to settle before they are averaged. The data show whether that was enough: everything is
//! estimated again from the *later* part of each, the second half of a hold, or a sine run without its first third. A
//! transient that decays faster than half the stretch is all but gone there, so the change of a result is what the
//! transient did to it (GUM 5.1.3, note 2).
//!
//! Noise changes the results too, and is in the budget already. So only the *share* of the change counts that noise does
//! not explain. For each hold and each part of each amplitude, D is the difference between the sensors and the fitted
//! model, later less whole, and v is its variance by noise and wandering. That variance is the one of the later less the
//! one of the whole, since the whole is the better estimate of the two:
//!
//! ```text
//! share = max(0, 1 − (n + 2√2n)/Σ(D²/v))        u(settling) = √share · |change of the result|
//! ```
//!
//! Noise alone reaches n + 2√2n in one case of forty, so a campaign without transients does not count its noise twice. A
//! slow motion on which sensors and jacks agree is no error and does not count.

use hexsense_core::calibration::triad::{MeasuredHold, Noise, SineRun, TriadFit};
use hexsense_core::calibration::truth::SineTruth;
use hexsense_core::channel::Triad;
use nalgebra::Complex;

use super::AnalysisError;
use super::assumptions::Assumptions;
use super::condense::Sweep;
use super::estimate::{Condensed, Estimate};

/// How the results change with more time to settle, and how much of the change noise does not explain.
pub struct Settling {
    /// The estimate from the later parts.
    pub later: Estimate,
    /// Share in the variance of the change that noise does not explain, for each triad, 0 to 1.
    pub share: [f64; 3],
}

impl Settling {
    /// Estimates from the later parts and compares.
    ///
    /// # Errors
    /// [`AnalysisError`] when there is no estimate from the later parts.
    pub fn new(
        whole: &Condensed,
        estimate: &Estimate,
        later: &Condensed,
        assumptions: &Assumptions,
    ) -> Result<Self, AnalysisError> {
        let mut all: [Disagreement; 3] = Default::default();
        let linear = Triad::LinearAcceleration.index();
        let model = |triad: usize| (&estimate.fits[triad], &whole.noise[triad]);
        for (whole, later) in whole
            .holds(assumptions)?
            .iter()
            .zip(later.holds(assumptions)?)
        {
            all[linear].add_hold(whole, &later, model(linear));
        }
        let runs = sine_runs(whole, assumptions)?.into_iter();
        for (triad, (whole, later)) in runs.zip(sine_runs(later, assumptions)?).enumerate() {
            for (whole, later) in whole.iter().zip(&later) {
                all[triad].add_sine(whole, later, model(triad));
            }
        }
        Ok(Self {
            later: later.estimate(assumptions)?,
            share: all.map(|disagreement| disagreement.share()),
        })
    }
}

/// A sine run and the time of its phase zero, s from the start of the capture.
type Timed = (SineRun, f64);

fn sine_runs(
    condensed: &Condensed,
    assumptions: &Assumptions,
) -> Result<[Vec<Timed>; 3], AnalysisError> {
    let heave = condensed.truth(&condensed.heave, assumptions)?;
    let turns: Vec<SineTruth> = condensed
        .turns
        .iter()
        .map(|sweep| condensed.truth(sweep, assumptions))
        .collect::<Result<_, _>>()?;
    let start_s = |sweep: &Sweep| sweep.first as f64 / f64::from(condensed.rate_hz);
    let [lifted, angular, rate] = condensed.sine_runs(&heave, &turns, assumptions);
    let timed = |runs: Vec<SineRun>, sweeps: &[Sweep]| -> Vec<Timed> {
        runs.into_iter().zip(sweeps.iter().map(start_s)).collect()
    };
    Ok([
        timed(lifted, std::slice::from_ref(&condensed.heave)),
        timed(angular, &condensed.turns),
        timed(rate, &condensed.turns),
    ])
}

/// Fit and noise of a triad.
type Model<'a> = (&'a TriadFit, &'a Noise);

/// Σ(D²/v) and n.
#[derive(Default)]
struct Disagreement {
    ratios: f64,
    count: f64,
}

impl Disagreement {
    fn add_hold(&mut self, whole: &MeasuredHold, later: &MeasuredHold, (fit, noise): Model) {
        let counts = later.counts - whole.counts;
        let difference = counts - fit.sensitivity * (later.truth - whole.truth);
        for sensor in 0..3 {
            let white = noise.hold_variance(sensor, later.length_s)
                - noise.hold_variance(sensor, whole.length_s);
            // The mean of a walk over the second half of T, less that over all of it, has the variance q²T/12.
            let walk = noise.walk[sensor] * noise.walk[sensor] * whole.length_s / 12.0;
            self.add(difference[sensor] * difference[sensor], white + walk, 1.0);
        }
    }

    fn add_sine(
        &mut self,
        (whole, from_s): &Timed,
        (later, later_from_s): &Timed,
        (fit, noise): Model,
    ) {
        let back = Complex::cis(-whole.omega * (later_from_s - from_s));
        for sensor in 0..3 {
            let difference =
                fit.disagreement(later, sensor) * back - fit.disagreement(whole, sensor);
            let variance = |run: &SineRun| -> f64 {
                let parts = noise.amplitude_variances(sensor, run.omega, run.length_s);
                parts.iter().sum()
            };
            self.add(
                difference.norm_sqr(),
                variance(later) - variance(whole),
                2.0,
            );
        }
    }

    /// Adds a squared difference of `parts` parts, with the variance of all of them.
    fn add(&mut self, square: f64, variance: f64, parts: f64) {
        // Nothing is later in a run of one period.
        if variance > 0.0 {
            self.ratios += square / variance * parts;
            self.count += parts;
        }
    }

    fn share(&self) -> f64 {
        let by_noise = self.count + 2.0 * (2.0 * self.count).sqrt();
        if self.ratios > by_noise {
            1.0 - by_noise / self.ratios
        } else {
            0.0
        }
    }
}
