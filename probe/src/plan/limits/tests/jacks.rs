//! Each jack at each of its limits, in level movements, whose lengths need no rotation: |p + b − a|.

use super::super::*;
use crate::plan::{Freedom, Purpose, RampsEntry, Shape, SineEntry};
use hexsense_core::kinematics::Geometry;
use nalgebra::Vector3;

const HOME_M: f64 = 2.129_757;

fn base(change: impl FnOnce(&mut GeometryFile)) -> GeometryFile {
    let mut file = GeometryFile::load("an-74tk-200").unwrap();
    (file.speed_max_m_s, file.acceleration_max_m_s2) = (None, None);
    file.geometry = stroke(&file.geometry, 0.5, 9.0);
    change(&mut file);
    file
}

fn stroke(base: &Geometry<f64>, shortest_m: f64, longest_m: f64) -> Geometry<f64> {
    let (lower, upper) = (*base.lower(), *base.upper());
    Geometry::new(lower, upper, shortest_m, longest_m, Some(HOME_M)).unwrap()
}

/// From the lower to the upper hinge of each jack at home.
fn at_home() -> [Vector3<f64>; 6] {
    let geometry = base(|_| {}).geometry;
    std::array::from_fn(|jack| {
        geometry.upper()[jack] - geometry.lower()[jack] + Vector3::new(0.0, HOME_M, 0.0)
    })
}

/// The level direction in which jack `jack` grows (or shrinks) most.
fn away(jack: usize, sign: f64) -> Vector3<f64> {
    let along = at_home()[jack];
    sign * Vector3::new(along.x, 0.0, along.z).normalize()
}

/// A run that goes out to `way` and back home, smoothly.
fn ramps(way: Vector3<f64>) -> Run {
    let entry = |freedom, level: f64| RampsEntry {
        freedom,
        levels_deg: None,
        levels_m: Some(vec![level, level, 0.0, 0.0]),
        step_s: 4.0,
        shape: Shape::JerkLimited,
    };
    Run {
        name: "out".to_owned(),
        purpose: Purpose::Verify,
        rest_s: None,
        ramps: vec![entry(Freedom::Surge, way.x), entry(Freedom::Sway, way.z)],
        sine: Vec::new(),
        multisine: None,
    }
}

/// A run of a sine of half a hertz and 1 mm along `direction`.
fn sines(direction: Vector3<f64>) -> Run {
    let entry = |freedom, part: f64| SineEntry {
        freedom,
        amplitude_deg: None,
        amplitude_m: Some(0.001 * part),
        frequency_hz: 0.5,
        fade_s: 20.0,
        settle_s: 2.0,
        estimate_s: 6.0,
    };
    Run {
        ramps: Vec::new(),
        sine: vec![
            entry(Freedom::Surge, direction.x),
            entry(Freedom::Sway, direction.z),
        ],
        ..ramps(direction)
    }
}

/// The jack, quantity and limit that a run is refused for.
fn refused(run: &Run, base: &GeometryFile) -> Option<(usize, Quantity, f64)> {
    match check_run(run, base, 0.002) {
        Ok(_) => None,
        Err(BeyondLimit::Jack {
            jack,
            quantity,
            limit,
            ..
        }) => Some((jack, quantity, limit)),
        Err(other) => panic!("{other}"),
    }
}

/// The jack of the largest of six numbers, from 1, and that number.
fn largest(of: [f64; 6]) -> (usize, f64) {
    let largest = of.into_iter().zip(1..).max_by(|a, b| a.0.total_cmp(&b.0));
    let (value, jack) = largest.unwrap();
    (jack, value)
}

#[test]
fn each_jack_is_refused_when_it_gets_too_long_or_too_short_and_not_a_micrometre_before() {
    for jack in 0..6 {
        let way = 0.2 * away(jack, 1.0);
        let (longest_jack, longest_m) = largest(at_home().map(|home| (home + way).norm()));
        assert_eq!(longest_jack, jack + 1);
        let with = |longest_m| base(|file| file.geometry = stroke(&file.geometry, 0.5, longest_m));
        assert_eq!(refused(&ramps(way), &with(longest_m + 1e-6)), None);
        let expected = (jack + 1, Quantity::Length, longest_m);
        assert_eq!(refused(&ramps(way), &with(longest_m)), Some(expected));

        let way = 0.2 * away(jack, -1.0);
        let (shortest_jack, minus_m) = largest(at_home().map(|home| -(home + way).norm()));
        assert_eq!(shortest_jack, jack + 1);
        let with =
            |shortest_m| base(|file| file.geometry = stroke(&file.geometry, shortest_m, 9.0));
        assert_eq!(refused(&ramps(way), &with(-minus_m - 1e-6)), None);
        let expected = (jack + 1, Quantity::Length, -minus_m);
        assert_eq!(refused(&ramps(way), &with(-minus_m)), Some(expected));
    }
}

/// In small movements a jack's speed and acceleration are those of the platform times the cosine to it.
#[test]
fn each_jack_is_refused_when_it_is_too_fast_or_accelerates_too_much() {
    let omega = std::f64::consts::TAU * 0.5;
    for jack in 0..6 {
        let direction = away(jack, 1.0);
        let share = at_home().map(|home| (home.dot(&direction) / home.norm()).abs());
        let (fastest, cosine) = largest(share);
        assert_eq!(fastest, jack + 1);
        let run = sines(direction);
        let speed = 0.001 * omega * cosine;
        let with = |limit| base(|file| file.speed_max_m_s = Some(limit));
        assert_eq!(refused(&run, &with(1.01 * speed)), None);
        let expected = (jack + 1, Quantity::Speed, speed);
        assert_eq!(refused(&run, &with(speed)), Some(expected));

        let acceleration = speed * omega;
        let with = |limit| base(|file| file.acceleration_max_m_s2 = Some(limit));
        assert_eq!(refused(&run, &with(1.01 * acceleration)), None);
        let expected = (jack + 1, Quantity::Acceleration, acceleration);
        assert_eq!(refused(&run, &with(acceleration)), Some(expected));
    }
}

/// In a level movement the platform does not turn, so that both hinges of a jack turn alike.
#[test]
fn the_jack_that_swings_furthest_is_refused_in_either_hinge() {
    let mut named = [false; 6];
    for degrees in (0..360).step_by(15) {
        let (z, x) = f64::from(degrees).to_radians().sin_cos();
        let way = 0.2 * Vector3::new(x, 0.0, z);
        let angles = at_home().map(|home| (home + way).angle(&home).to_degrees());
        let (furthest, angle) = largest(angles);
        let mut others = angles;
        others[furthest - 1] = 0.0;
        if largest(others).1 > angle - 0.1 {
            continue;
        }
        named[furthest - 1] = true;
        for joint in Joint::ALL {
            let with = |limit_deg| {
                base(|file| match joint {
                    Joint::Lower => file.lower_hinge_angle_max_deg = Some(limit_deg),
                    Joint::Upper => file.upper_hinge_angle_max_deg = Some(limit_deg),
                })
            };
            // At 94 mm/s a jack of 2.1 to 2.8 m turns by 0.004° to 0.005° from one sample to the next.
            assert!(check_run(&ramps(way), &with(angle + 0.006), 0.002).is_ok());
            let refusal = check_run(&ramps(way), &with(angle + 0.002), 0.002).unwrap_err();
            let BeyondLimit::Hinge {
                jack, joint: at, ..
            } = refusal
            else {
                panic!("{refusal}");
            };
            assert_eq!((jack, at), (furthest, joint));
        }
    }
    assert_eq!(named, [true; 6], "each jack was the one");
}
