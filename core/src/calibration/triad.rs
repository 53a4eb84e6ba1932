//! Sensitivity matrix and delay of a triad, from holds and sine runs.
//!
//! Each sensor i of the triad has a row s of the sensitivity matrix. A hold h of run r gives one real equation, a
//! sine run one complex one:
//!
//! ```text
//! u_i(h) = s·f(h) + offset(r)                     h: mean counts and specific force on the hold
//! U_i·e^{iωτ} = s·F                               U, F: complex amplitudes at the drive frequency
//! ```
//!
//! Rows are fitted by weighted least squares. Runs with holds have an offset each, because a bias wanders between
//! runs. The delay τ is common to the triad: it is the phase that is left, at the run's frequency, between the
//! sensors and the fitted sensitivity.
//!
//! A wandering bias makes the errors of successive holds alike, so the covariance of a row is not σ²(XᵀWX)⁻¹ but
//! G·V·Gᵀ with G = (XᵀWX)⁻¹XᵀW and V the covariance of the observations: white noise over the averaging time, plus
//! q²·min(t, t′) for a random walk of q per √s.

use nalgebra::{Complex, Matrix3, SMatrix, SVector, Vector3};

use super::AXES;
pub use super::observation::{MeasuredHold, Noise, SineRun};
use crate::least_squares::{NormalEquations, Solution};
use crate::records::record::is_singular;

/// Runs with holds: one along pitch, one along roll.
pub const HOLD_RUNS: usize = 2;
/// Unknowns of a row: three sensitivities and an offset for each run with holds.
const UNKNOWNS: usize = AXES + HOLD_RUNS;
type Row = SVector<f64, UNKNOWNS>;
/// Most rounds in which the delay is refined, and the change at which it is left as it is.
const DELAY_ROUNDS: usize = 20;
const SETTLED_DELAY_S: f64 = 1e-12;

/// A calibrated triad.
#[derive(Debug, Clone, PartialEq)]
pub struct TriadFit {
    /// S, counts per unit: rows are sensors, columns body axes.
    pub sensitivity: Matrix3<f64>,
    /// M = S⁻¹, unit per count.
    pub matrix: Matrix3<f64>,
    /// Delay of the sensors behind the jacks, s: Σ share·(delay of the sensor).
    pub delay_s: f64,
    /// Share of each sensor in the delay: what the sine runs moved it, squared. They add up to one.
    pub delay_shares: [f64; AXES],
    /// Standard uncertainty of the delay by the sensors' noise, s.
    pub delay_noise_s: f64,
    /// Covariance of each row of S by the sensors' noise and wandering, (counts per unit)².
    pub row_covariance: [Matrix3<f64>; AXES],
}

/// Why a triad could not be calibrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TriadError {
    /// The runs do not move all three axes.
    #[error(
        "the runs do not determine all three axes; add a hold or sine run along the missing one"
    )]
    Undetermined,
    /// Sensors that read alike.
    #[error(
        "the sensitivity matrix is singular: two sensors of the triad read the same; see whether a signal stands at an end of \
         the converter's range, then check volts_per_unit and zero_volts in the sensor file, and the wiring"
    )]
    Singular,
    /// A hold names a run that there is not.
    #[error("a hold names run {run}; there are {HOLD_RUNS}")]
    Run {
        /// As named.
        run: usize,
    },
}

/// Fits a triad.
///
/// # Errors
/// Every variant of [`TriadError`].
pub fn fit_triad(
    holds: &[MeasuredHold],
    sines: &[SineRun],
    noise: &Noise,
) -> Result<TriadFit, TriadError> {
    if let Some(hold) = holds.iter().find(|hold| hold.run >= HOLD_RUNS) {
        return Err(TriadError::Run { run: hold.run });
    }
    let mut delay_s = 0.0;
    let mut rows = fit_rows(holds, sines, noise, delay_s)?;
    // A wrong delay is partly taken up by the sensitivities, so that each round leaves a few per cent of it.
    for _ in 0..DELAY_ROUNDS {
        let remaining = Lag::new(sines, &sensitivity(&rows), noise, delay_s);
        delay_s += remaining.lag_s;
        rows = fit_rows(holds, sines, noise, delay_s)?;
        if remaining.lag_s.abs() < SETTLED_DELAY_S {
            break;
        }
    }
    let sensitivity = sensitivity(&rows);
    if is_singular(&sensitivity) {
        return Err(TriadError::Singular);
    }
    let matrix = sensitivity.try_inverse().ok_or(TriadError::Singular)?;
    let lag = Lag::new(sines, &sensitivity, noise, delay_s);
    let row_covariance =
        core::array::from_fn(|sensor| row_covariance(sensor, &rows[sensor], holds, sines, noise));
    Ok(TriadFit {
        sensitivity,
        matrix,
        delay_s,
        delay_shares: lag.shares,
        delay_noise_s: lag.noise_s,
        row_covariance,
    })
}

impl TriadFit {
    /// Counts at zero input from the mean counts at rest and the truth there: u0 = ū − S·truth. For a sensor that
    /// feels gravity this is not the mean at rest.
    #[must_use]
    pub fn offset(
        &self,
        counts_at_rest: &Vector3<f64>,
        truth_at_rest: &Vector3<f64>,
    ) -> Vector3<f64> {
        counts_at_rest - self.sensitivity * truth_at_rest
    }

    /// What the counts of a sensor in a sine run, put forward by the delay, are more than its sensitivity makes of the
    /// truth; counts, as a complex amplitude.
    #[must_use]
    pub fn disagreement(&self, sine: &SineRun, sensor: usize) -> Complex<f64> {
        let undelayed = sine.counts[sensor] * turned_by(sine.omega * self.delay_s);
        undelayed - of_truth(sine, sensor, &self.sensitivity)
    }

    /// Standard uncertainty of each element of [`TriadFit::matrix`] by [`TriadFit::row_covariance`]:
    /// δM = −M·δS·M with independent rows of δS.
    #[must_use]
    pub fn matrix_noise(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| {
            let column = self.matrix.column(j);
            let variance = (0..AXES).map(|sensor| {
                let spread = column.dot(&(self.row_covariance[sensor] * column));
                self.matrix[(i, sensor)] * self.matrix[(i, sensor)] * spread
            });
            libm::sqrt(variance.sum())
        })
    }
}

fn sensitivity(rows: &[Solution<UNKNOWNS>; AXES]) -> Matrix3<f64> {
    Matrix3::from_fn(|sensor, axis| rows[sensor].unknowns[axis])
}

fn fit_rows(
    holds: &[MeasuredHold],
    sines: &[SineRun],
    noise: &Noise,
    delay_s: f64,
) -> Result<[Solution<UNKNOWNS>; AXES], TriadError> {
    let fit = |sensor: usize| {
        let mut equations = NormalEquations::default();
        for hold in holds {
            equations.add(
                &hold_row(hold),
                hold.counts[sensor],
                hold_weight(hold, sensor, noise),
            );
        }
        for sine in sines {
            let undelayed = sine.counts[sensor] * turned_by(sine.omega * delay_s);
            let [re, im] = noise.amplitude_variances(sensor, sine.omega, sine.length_s);
            equations.add(&sine_row(sine, |c| c.re), undelayed.re, 1.0 / re);
            equations.add(&sine_row(sine, |c| c.im), undelayed.im, 1.0 / im);
        }
        // Offsets of runs without holds are determined to be zero, so that one kind of fit serves every triad.
        for run in (0..HOLD_RUNS).filter(|run| !holds.iter().any(|hold| hold.run == *run)) {
            equations.add(&Row::ith(AXES + run, 1.0), 0.0, 1.0);
        }
        equations.solve().ok_or(TriadError::Undetermined)
    };
    Ok([fit(0)?, fit(1)?, fit(2)?])
}

fn hold_row(hold: &MeasuredHold) -> Row {
    let mut row = Row::zeros();
    row.fixed_rows_mut::<AXES>(0).copy_from(&hold.truth);
    row[AXES + hold.run] = 1.0;
    row
}

fn sine_row(sine: &SineRun, part: fn(&Complex<f64>) -> f64) -> Row {
    let mut row = Row::zeros();
    for axis in 0..AXES {
        row[axis] = part(&sine.truth[axis]);
    }
    row
}

/// 1/variance of a hold's mean: white noise, and the walk over the time from hold to hold.
fn hold_weight(hold: &MeasuredHold, sensor: usize, noise: &Noise) -> f64 {
    let walk = noise.walk[sensor] * noise.walk[sensor] * 2.0 * hold.length_s;
    1.0 / (noise.hold_variance(sensor, hold.length_s) + walk)
}

/// Amplitude of a sensor's counts that follows from the truth.
fn of_truth(sine: &SineRun, sensor: usize, sensitivity: &Matrix3<f64>) -> Complex<f64> {
    (0..AXES)
        .map(|axis| sine.truth[axis] * sensitivity[(sensor, axis)])
        .sum()
}

/// By how much the sensors still lag behind the fitted sensitivity.
struct Lag {
    lag_s: f64,
    /// See [`TriadFit::delay_shares`].
    shares: [f64; AXES],
    /// Its standard uncertainty by the sensors' noise, s.
    noise_s: f64,
}

impl Lag {
    /// For a small angle, Im(model*·u)/|model|² is the phase by which u leads; its variance is that of one part of u,
    /// over |model|². Phases over ω are averaged with the weights |model|²ω².
    fn new(sines: &[SineRun], sensitivity: &Matrix3<f64>, noise: &Noise, delay_s: f64) -> Self {
        let (mut moment, mut variance, mut weights) = (0.0, 0.0, [0.0; AXES]);
        for sine in sines {
            for (sensor, weight) in weights.iter_mut().enumerate() {
                let model = of_truth(sine, sensor, sensitivity);
                let undelayed = sine.counts[sensor] * turned_by(sine.omega * delay_s);
                moment -= (model.conj() * undelayed).im * sine.omega;
                let square = model.norm_sqr() * sine.omega * sine.omega;
                let [re, im] = noise.amplitude_variances(sensor, sine.omega, sine.length_s);
                let spread = model.re * model.re * im + model.im * model.im * re;
                variance += spread * sine.omega * sine.omega;
                *weight += square;
            }
        }
        let weight: f64 = weights.iter().sum();
        let over = |value: f64| if weight > 0.0 { value / weight } else { 0.0 };
        Self {
            lag_s: over(moment),
            shares: weights.map(over),
            noise_s: over(libm::sqrt(variance)),
        }
    }
}

/// G·V·Gᵀ, see the module's head.
fn row_covariance(
    sensor: usize,
    row: &Solution<UNKNOWNS>,
    holds: &[MeasuredHold],
    sines: &[SineRun],
    noise: &Noise,
) -> Matrix3<f64> {
    let mut spread = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
    for one in holds {
        let left = hold_row(one) * hold_weight(one, sensor, noise);
        for other in holds {
            let right = hold_row(other) * hold_weight(other, sensor, noise);
            let mut covariance =
                noise.walk[sensor] * noise.walk[sensor] * one.time_s.min(other.time_s);
            if core::ptr::eq(one, other) {
                covariance += noise.hold_variance(sensor, one.length_s);
            }
            spread += left * right.transpose() * covariance;
        }
    }
    for sine in sines {
        let parts = [|c: &Complex<f64>| c.re, |c: &Complex<f64>| c.im];
        for (part, variance) in
            parts
                .into_iter()
                .zip(noise.amplitude_variances(sensor, sine.omega, sine.length_s))
        {
            let row = sine_row(sine, part);
            spread += row * row.transpose() / variance;
        }
    }
    (row.cofactors * spread * row.cofactors)
        .fixed_view::<AXES, AXES>(0, 0)
        .into()
}

/// e^{iφ}.
fn turned_by(phase: f64) -> Complex<f64> {
    let (sine, cosine) = libm::sincos(phase);
    Complex::new(cosine, sine)
}
