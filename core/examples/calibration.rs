//! Recorded counts → offsets and a sensitivity matrix with their uncertainties: three accelerometers on a motion base
//! that was tilted along pitch, then along roll, and held.
//!
//! ```text
//! cargo run -p hexsense-core --example calibration
//! ```
//!
//! `holds.csv` has the mean counts of `ax`, `ay`, `az` and the mean jack lengths at rest and on each hold, as a campaign
//! recorded them. The estimator sees nothing else but what a data sheet says. A campaign of `hexsense calibrate` adds a
//! heave sine, which determines the vertical axis far better than holds do: cos 20° is all that they change.

mod base;

use base::base;
use hexsense_core::calibration::budget::{Budget, COVERAGE, Cause, Shape, uniform};
use hexsense_core::calibration::triad::{Hold, Noise, TriadFit, fit_triad};
use hexsense_core::calibration::truth::{Site, specific_force_at_rest};
use hexsense_core::kinematics::forward::{Options, Solver};
use nalgebra::Vector3;

const RECORDED: &str = include_str!("holds.csv");
/// Each mean is over this long, s.
const HOLD_S: f64 = 1.9;
/// The data sheet's noise in counts: 0.98e-3 m/s²/√Hz, and a bias that walks 9.8e-3 m/s² in 300 s, at 1519 counts per
/// m/s².
const NOISE: Noise = Noise {
    density: [1.49; 3],
    walk: [0.86; 3],
};

/// What is taken as known, each with a tolerance: the estimate depends on it.
#[derive(Clone, Copy)]
struct Known {
    gravity_m_s2: f64,
    /// Factor on the displacements of all jacks: they share one converter.
    jack_scale: f64,
    /// Factor on all counts, the jacks' too: one reference tells what the supply is.
    supply: f64,
}

const NOMINAL: Known = Known {
    gravity_m_s2: 9.806_65,
    jack_scale: 1.0,
    supply: 1.0,
};

struct Calibration {
    fit: TriadFit,
    /// Counts at zero input.
    offset: Vector3<f64>,
}

/// Offsets and matrix of the triad, if `known` holds.
fn calibrate(recorded: &str, known: Known) -> Calibration {
    let base = base();
    let solver = Solver::new(&base, Options::<f64>::default());
    let site = Site {
        // A base at rest does not turn, so the place of the sensors does not matter.
        lever_arm_m: Vector3::zeros(),
        gravity_m_s2: known.gravity_m_s2,
    };
    let mut rest = None;
    let mut holds = Vec::new();
    for line in recorded.lines().skip(1) {
        let (run, numbers) = line.split_once(',').expect("a run and numbers");
        let numbers: Vec<f64> = numbers
            .split(',')
            .map(|number| number.parse().expect("a number"))
            .collect();
        let counts = Vector3::from_column_slice(&numbers[1..4]) * known.supply;
        // Jacks → pose → what gravity is in body axes.
        let lengths_m = std::array::from_fn(|jack| {
            let displacement = numbers[4 + jack] - base.mid_length_m();
            base.mid_length_m() + displacement * known.jack_scale * known.supply
        });
        let pose = solver
            .solve(&lengths_m)
            .expect("a pose with these lengths")
            .pose;
        let truth = specific_force_at_rest(&pose.rotation, &site);
        match run {
            "rest" => rest = Some((counts, truth)),
            _ => holds.push(Hold {
                run: usize::from(run == "roll"),
                time_s: numbers[0],
                length_s: HOLD_S,
                counts,
                truth,
            }),
        }
    }
    let fit = fit_triad(&holds, &[], &NOISE).expect("pitch and roll determine all three axes");
    let (counts, truth) = rest.expect("a mean at rest");
    let offset = fit.offset(&counts, &truth);
    Calibration { fit, offset }
}

/// Uncertainties of the gains, on the diagonal of the matrix, and of the offsets.
fn budgets(recorded: &str, estimate: &Calibration) -> [(Budget, Budget); 3] {
    // A cause's term is the change of the result when the cause changes by its standard uncertainty.
    let causes = [
        // The gravity of a place, to 50 mGal.
        (
            Cause::Gravity,
            Shape::Normal,
            Known {
                gravity_m_s2: NOMINAL.gravity_m_s2 + 5e-4,
                ..NOMINAL
            },
        ),
        // A converter's gain, to ± 0.1 %.
        (
            Cause::JackConverter,
            Shape::Uniform,
            Known {
                jack_scale: 1.0 + uniform(1e-3),
                ..NOMINAL
            },
        ),
        // The jacks' own gains are within ± 0.05 %; all wrong alike is the worst that they do.
        (
            Cause::JackGain,
            Shape::Uniform,
            Known {
                jack_scale: 1.0 + uniform(5e-4),
                ..NOMINAL
            },
        ),
        // The supply reference, to ± 0.17 %. Gains hardly feel it: counts and tilt grow alike.
        (
            Cause::SupplyReference,
            Shape::Uniform,
            Known {
                supply: 1.0 + uniform(1.7e-3),
                ..NOMINAL
            },
        ),
    ];
    let mut budgets = [(Budget::default(), Budget::default()); 3];
    let gain_noise = estimate.fit.matrix_noise();
    for (axis, (gain, offset)) in budgets.iter_mut().enumerate() {
        gain.add(Cause::SensorNoise, Shape::Normal, gain_noise[(axis, axis)]);
        offset.add(
            Cause::SensorNoise,
            Shape::Normal,
            offset_noise(&estimate.fit, axis),
        );
        for (cause, shape, known) in causes {
            let moved = calibrate(recorded, known);
            gain.add(
                cause,
                shape,
                (moved.fit.matrix - estimate.fit.matrix)[(axis, axis)],
            );
            offset.add(cause, shape, (moved.offset - estimate.offset)[axis]);
        }
    }
    budgets
}

/// u0 = ū − s·g: at rest gravity lies along Y, so that the uncertainty of the row's second element counts.
fn offset_noise(fit: &TriadFit, sensor: usize) -> f64 {
    fit.row_covariance[sensor][(1, 1)].sqrt() * NOMINAL.gravity_m_s2
}

fn main() {
    let estimate = calibrate(RECORDED, NOMINAL);
    let budgets = budgets(RECORDED, &estimate);
    println!("value = M·(counts − offset), expanded uncertainty U with k = {COVERAGE}\n");
    for (axis, (name, (gain, offset))) in ["ax", "ay", "az"].iter().zip(&budgets).enumerate() {
        println!(
            "{name}  offset {:9.2} counts, U {:6.2}    gain {:.4e} m/s² per count, U {:.1e} ({:.2} %)",
            estimate.offset[axis],
            offset.expanded(),
            estimate.fit.matrix[(axis, axis)],
            gain.expanded(),
            100.0 * gain.expanded() / estimate.fit.matrix[(axis, axis)].abs(),
        );
    }
    println!("\nM, m/s² per count; columns are the counts of ax, ay, az");
    for row in estimate.fit.matrix.row_iter() {
        println!("{:13.4e} {:13.4e} {:13.4e}", row[0], row[1], row[2]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the simulated sensors of the recording really were: offset in counts, gain in m/s² per count.
    const TRUTH: [(f64, f64); 3] = [
        (32_390.53, 6.623_298e-4),
        (32_729.47, 6.587_821e-4),
        (32_650.84, 6.535_002e-4),
    ];

    #[test]
    fn the_truth_lies_within_the_expanded_uncertainty() {
        let estimate = calibrate(RECORDED, NOMINAL);
        let budgets = budgets(RECORDED, &estimate);
        for (axis, ((offset, gain), (of_gain, of_offset))) in TRUTH.iter().zip(&budgets).enumerate()
        {
            let off = (estimate.fit.matrix[(axis, axis)] - gain).abs();
            assert!(
                off <= of_gain.expanded(),
                "gain {axis}: {off:e} of {:e}",
                of_gain.expanded()
            );
            let off = (estimate.offset[axis] - offset).abs();
            assert!(
                off <= of_offset.expanded(),
                "offset {axis}: {off} of {}",
                of_offset.expanded()
            );
            assert!(
                of_gain.expanded() < 5e-3 * gain,
                "a wide budget proves nothing"
            );
            assert!(of_offset.expanded() < 150.0, "a wide budget proves nothing");
        }
    }

    #[test]
    fn it_runs() {
        main();
    }
}
