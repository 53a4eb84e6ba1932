//! A zero run at rest is accepted; a run that moved, drifted or holds no numbers is refused with the reason.

use approx::assert_relative_eq;
use hexsense_core::calibration::zero::{SEGMENTS, ZeroError, ZeroLimits, zero};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const LIMITS: ZeroLimits = ZeroLimits {
    deviation: 2.0,
    drift: 5.0,
};
const LENGTH: usize = 10_000;

/// A sensor at rest with noise of 30 counts, and something added.
fn run(added: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut noise = || -> f64 { StandardNormal.sample(&mut random) };
    (0..LENGTH)
        .map(|n| 32_900.0 + 30.0 * noise() + added(n as f64 / LENGTH as f64))
        .collect()
}

#[test]
fn noise_alone_is_no_movement() {
    let found = zero(&run(|_| 0.0), LIMITS).unwrap();
    // The mean of 10000 samples scatters by 0.3, a segment's by 0.95.
    assert!((found.mean - 32_900.0).abs() < 1.0, "{found:?}");
    assert!((0.4..1.6).contains(&found.deviation), "{found:?}");
    assert!(found.drift.abs() < 3.0, "{found:?}");
}

#[test]
fn the_mean_is_over_all_samples() {
    let samples: Vec<f64> = (0..1_007)
        .map(|n| if n < 1_000 { 5.0 } else { 5.7 })
        .collect();
    let found = zero(&samples, LIMITS).unwrap();
    assert_relative_eq!(found.mean, 5.0 + 0.7 * 7.0 / 1_007.0, max_relative = 1e-12);
}

#[test]
fn a_step_in_the_middle_is_a_movement_and_its_size_is_told() {
    let clean: Vec<f64> = (0..LENGTH)
        .map(|n| {
            if (LENGTH / 10..LENGTH / 5).contains(&n) {
                100.0
            } else {
                0.0
            }
        })
        .collect();
    // One segment of ten at 100, about the line through all: places −0.45 … 0.45.
    let place = |segment: usize| (segment as f64 + 0.5) / 10.0 - 0.5;
    let slope = place(1) * 100.0 / (0..10).map(|segment| place(segment).powi(2)).sum::<f64>();
    let value = |segment: usize| if segment == 1 { 100.0 } else { 0.0 };
    let squares: f64 = (0..10)
        .map(|segment| (value(segment) - 10.0 - slope * place(segment)).powi(2))
        .sum();
    match zero(&clean, LIMITS) {
        Err(ZeroError::Moved { deviation, limit }) => {
            assert_relative_eq!(deviation, (squares / 8.0).sqrt(), max_relative = 1e-9);
            assert_eq!(limit, LIMITS.deviation);
        }
        other => panic!("{other:?}"),
    }
    assert!(matches!(
        zero(&run(|at| if at > 0.6 { 20.0 } else { 0.0 }), LIMITS),
        Err(ZeroError::Moved { .. })
    ));
}

#[test]
fn a_swing_slower_than_a_segment_is_a_movement() {
    let swing = run(|at| 10.0 * (20.0 * at).sin());
    assert!(matches!(zero(&swing, LIMITS), Err(ZeroError::Moved { .. })));
}

#[test]
fn a_drift_is_refused_with_its_size_and_sign() {
    for drift in [20.0, -20.0] {
        match zero(&run(|at| drift * at), LIMITS) {
            Err(ZeroError::Drifted {
                drift: found,
                limit,
            }) => {
                assert!((found - drift).abs() < 3.0, "{found}");
                assert_eq!(limit, LIMITS.drift);
            }
            other => panic!("{other:?}"),
        }
    }
    let clean: Vec<f64> = (0..LENGTH)
        .map(|n| 4.0 * (n as f64 + 0.5) / LENGTH as f64)
        .collect();
    let found = zero(&clean, LIMITS).unwrap();
    assert_relative_eq!(found.drift, 4.0, max_relative = 1e-9);
    assert!(
        found.deviation < 1e-6,
        "a pure drift is no scatter: {}",
        found.deviation
    );
}

/// Ten samples are their own segments, at −0.45, −0.35 … 0.45. Drift and deviation may be their limits, to the last
/// digits of the fit.
#[test]
fn drift_and_deviation_may_be_as_large_as_their_limits() {
    let places = (0..10).map(|n| (f64::from(n) - 4.5) / 10.0);
    let line: Vec<f64> = places.clone().map(|place| 100.0 + 8.0 * place).collect();
    for sign in [-1.0, 1.0] {
        let samples: Vec<f64> = line.iter().map(|value| sign * value).collect();
        let with = |drift| {
            let deviation = 1e-9;
            zero(&samples, ZeroLimits { deviation, drift })
        };
        assert!(with(8.0 * (1.0 + 1e-12)).is_ok());
        let refused = with(8.0 * (1.0 - 1e-12));
        assert!(
            matches!(refused, Err(ZeroError::Drifted { .. })),
            "{refused:?}"
        );
    }
    // One up, one down: Σy² = 10, Σpy = −0.5, Σp² = 0.825; two unknowns leave eight degrees of freedom.
    let alternating: Vec<f64> = (0..10).map(|n| f64::from(1 - 2 * (n % 2))).collect();
    let expected = ((10.0 - 0.25 / 0.825) / 8.0_f64).sqrt();
    let with = |deviation| {
        zero(
            &alternating,
            ZeroLimits {
                deviation,
                drift: 1.0,
            },
        )
    };
    assert!(with(expected * (1.0 + 1e-12)).is_ok());
    let refused = with(expected * (1.0 - 1e-12));
    assert!(
        matches!(refused, Err(ZeroError::Moved { .. })),
        "{refused:?}"
    );
}

#[test]
fn what_is_not_a_number_is_refused() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for place in [0, 5_000, LENGTH - 1] {
            let mut samples = run(|_| 0.0);
            samples[place] = bad;
            let refused = Err(ZeroError::NotFinite { sample: place });
            assert_eq!(zero(&samples, LIMITS), refused, "{bad}");
        }
    }
    // The samples left over after ten segments count as well.
    let mut samples = vec![1.0; 1_009];
    samples[1_008] = f64::NAN;
    let refused = Err(ZeroError::NotFinite { sample: 1_008 });
    assert_eq!(zero(&samples, LIMITS), refused);
}

#[test]
fn too_few_samples_are_refused() {
    for length in 0..SEGMENTS {
        assert_eq!(
            zero(&vec![1.0; length], LIMITS),
            Err(ZeroError::Short { samples: length })
        );
    }
    assert!(zero(&[1.0; SEGMENTS], LIMITS).is_ok());
}

#[test]
fn the_refusal_says_how_much_and_what_to_do() {
    let refusal = zero(&run(|at| 20.0 * at), LIMITS).unwrap_err().to_string();
    assert!(
        refusal.contains("drifted by 19.5")
            && refusal.contains("limit 5.0")
            && refusal.contains("repeat"),
        "{refusal}"
    );
}
