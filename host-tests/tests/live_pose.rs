//! The board's own pose: right from counts on, in single precision, and refused by name where there is none.

use hexsense_core::channel::{INERTIAL, Ratiometric, Scan};
use hexsense_core::kinematics::{ForwardError, Geometry, Pose, inverse};
use hexsense_core::live_pose::{JackBlock, Tracker};
use hexsense_core::records::{JackCoefficients, MotionBase};
use hexsense_core::sampling::{BLOCK, BlockSize};
use hexsense_probe::geometry_file::{GeometryFile, preset_names};
use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Greatest error that the board may add, m and rad.
const ALLOWED: f64 = 5e-7;
const SUPPLY: f32 = 1.000_7;

fn bases() -> impl Iterator<Item = (&'static str, Geometry<f64>)> {
    preset_names()
        .into_iter()
        .map(|name| (name, GeometryFile::load(name).unwrap().geometry))
}

/// The whole stroke on nine tenths of the counts; jack 2 counts down.
fn transducers(geometry: &Geometry<f64>) -> JackCoefficients {
    let stroke_m = geometry.length_max_m() - geometry.length_min_m();
    let mut metres_per_count = [(stroke_m / 59_000.0) as f32; 6];
    metres_per_count[1] *= -1.0;
    JackCoefficients {
        zero_length_m: geometry.mid_length_m() as f32,
        zero_counts: [32_768.0, 32_700.3, 32_812.7, 32_768.0, 32_650.9, 32_790.1],
        metres_per_count,
    }
}

/// A block whose mean counts are those of `lengths`, to a sixteenth of a count.
fn block(jacks: &JackCoefficients, lengths: &[f64; 6]) -> JackBlock {
    let sums = std::array::from_fn(|jack| {
        let excess = lengths[jack] - f64::from(jacks.zero_length_m);
        let counts =
            excess / f64::from(jacks.metres_per_count[jack]) + f64::from(jacks.zero_counts[jack]);
        (counts / f64::from(SUPPLY) * BLOCK as f64).round() as u32
    });
    JackBlock {
        first_scan: 0,
        supply: SUPPLY,
        block: BlockSize::default(),
        sums,
    }
}

fn tracker<T: nalgebra::RealField + Copy>(geometry: &Geometry<f64>) -> Tracker<T> {
    Tracker::new(
        &MotionBase::new(geometry),
        &transducers(geometry),
        Ratiometric::NONE,
    )
    .unwrap()
}

fn double(pose: &Pose<f32>) -> Pose<f64> {
    Pose {
        position: pose.position.cast(),
        rotation: UnitQuaternion::new_normalize(pose.rotation.into_inner().cast()),
    }
}

#[test]
fn the_sums_of_a_block_are_those_of_its_jacks() {
    let scans: [Scan; BLOCK] =
        std::array::from_fn(|scan| std::array::from_fn(|channel| (100 * channel + scan) as u16));
    let block = JackBlock::new(32, 0.99, &scans).unwrap();
    // Sixteen times the first count and 0 + 1 + … + 15.
    assert_eq!(
        block.sums,
        [9, 10, 11, 12, 13, 14].map(|c| 16 * 100 * c + 120)
    );
    let full = JackBlock::new(0, 1.0, &[[u16::MAX; INERTIAL + 6]; BLOCK]).unwrap();
    assert_eq!(full.sums, [16 * 65_535; 6]);
}

/// From counts to pose, each of two thousand poses of a wandering base, against the pose that the counts were made of
/// and against double precision.
#[test]
fn single_precision_follows_a_wandering_base_to_half_a_micrometre() {
    let mut random = ChaCha8Rng::seed_from_u64(40);
    for (name, geometry) in bases() {
        let (mut board, mut host) = (tracker::<f32>(&geometry), tracker::<f64>(&geometry));
        let stroke_m = geometry.length_max_m() - geometry.length_min_m();
        let mut largest: f64 = 0.0;
        let phases: [f64; 6] = random.random();
        for step in 0..2_000 {
            let wave =
                |k: usize| (0.011 * (1.0 + 0.2 * k as f64) * step as f64 + 6.0 * phases[k]).sin();
            let sway_m = 0.1 * stroke_m;
            let pose = Pose {
                position: geometry.home().position
                    + Vector3::new(wave(0), wave(1), wave(2)) * sway_m,
                rotation: UnitQuaternion::from_scaled_axis(
                    Vector3::new(wave(3), wave(4), wave(5)) * 0.08,
                ),
            };
            let block = block(&transducers(&geometry), &inverse(&geometry, &pose));
            let exact = host.next(&block).unwrap().pose;
            let (distance, angle) = exact.distance(&pose);
            // A sixteenth of a count is one or two micrometres; rounding the hinges is a tenth.
            assert!(
                distance < 5e-6 && angle < 5e-6,
                "{name}: {distance} {angle}"
            );
            let solution = board.next(&block).unwrap();
            let (distance, angle) = double(&solution.pose).distance(&exact);
            assert!(
                distance < ALLOWED && angle < ALLOWED,
                "{name}: {distance} {angle}"
            );
            assert!(
                step == 0 || solution.iterations <= 3,
                "{name}: {solution:?}"
            );
            largest = largest.max(distance);
        }
        assert!(largest > 1e-9, "{name}: single precision is not exact");
    }
}

#[test]
fn a_jump_is_refused_once_and_the_next_block_is_found_from_home() {
    let (_, geometry) = bases().next().unwrap();
    let jacks = transducers(&geometry);
    let mut board = tracker::<f32>(&geometry);
    let at = |height_m: f64| {
        let mut pose = geometry.home();
        pose.position.y += height_m;
        block(&jacks, &inverse(&geometry, &pose))
    };
    board.next(&at(0.0)).unwrap();
    assert!(matches!(
        board.next(&at(0.2)),
        Err(ForwardError::Jump { .. })
    ));
    let height = board.next(&at(0.2)).unwrap().pose.position.y;
    assert!((f64::from(height) - geometry.home_height_m() - 0.2).abs() < 1e-5);
    board.restart();
    assert!(
        board.next(&at(-0.2)).is_ok(),
        "after a pause there is no jump"
    );
}

#[test]
fn counts_of_a_broken_transducer_or_supply_are_refused_by_the_jack() {
    let (_, geometry) = bases().next().unwrap();
    let mut board = tracker::<f32>(&geometry);
    let home = block(
        &transducers(&geometry),
        &inverse(&geometry, &geometry.home()),
    );
    for jack in 0..6 {
        for sum in [0, 16 * 65_520] {
            let mut broken = home;
            broken.sums[jack] = sum;
            let refused = board.next(&broken).unwrap_err();
            assert!(
                matches!(refused, ForwardError::OutsideStroke { jack: named, .. } if usize::from(named) == jack + 1),
                "{refused}"
            );
        }
    }
    for supply in [f32::NAN, f32::INFINITY] {
        let refused = board.next(&JackBlock { supply, ..home }).unwrap_err();
        assert!(
            matches!(refused, ForwardError::NotFinite { jack: 1, .. }),
            "{refused}"
        );
    }
    assert!(board.next(&home).is_ok());
}

/// A jack that is fed by the supply reads the same counts at every supply, another reads less at a higher one.
#[test]
fn the_supply_factor_acts_on_the_jacks_that_are_not_ratiometric() {
    let (_, geometry) = bases().next().unwrap();
    let (base, jacks) = (MotionBase::new(&geometry), transducers(&geometry));
    let lengths = inverse(&geometry, &geometry.home());
    let ratiometric = [0, 4];
    let counts = |jack: usize| {
        let excess = lengths[jack] - f64::from(jacks.zero_length_m);
        let counts =
            excess / f64::from(jacks.metres_per_count[jack]) + f64::from(jacks.zero_counts[jack]);
        let supply = if ratiometric.contains(&jack) {
            1.0
        } else {
            f64::from(SUPPLY)
        };
        (counts / supply * BLOCK as f64).round() as u32
    };
    let block = JackBlock {
        first_scan: 0,
        supply: SUPPLY,
        block: BlockSize::default(),
        sums: std::array::from_fn(counts),
    };
    let channels = ratiometric
        .map(|jack| INERTIAL + jack)
        .into_iter()
        .fold(Ratiometric::NONE, Ratiometric::with);
    let height_m = |channels| {
        let mut tracker = Tracker::<f64>::new(&base, &jacks, channels).unwrap();
        tracker.next(&block).unwrap().pose.position.y
    };
    assert!((height_m(channels) - geometry.home_height_m()).abs() < 1e-5);
    // 0.1 % of supply is most of a millimetre of a jack.
    assert!((height_m(Ratiometric::NONE) - geometry.home_height_m()).abs() > 1e-4);
}
