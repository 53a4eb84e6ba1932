//! Faults of the bench, put into good recordings: each fails, and the part that is at fault is named first.

use hexsense_core::channel::{CHANNELS, INERTIAL, Scan};
use hexsense_core::kinematics::Geometry;
use hexsense_probe::analysis::RecordedRun;
use hexsense_probe::analysis::check::Check;
use hexsense_probe::geometry_file::GeometryFile;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::{Bench, failures};

/// Counts of a sensor or transducer at zero.
const ZERO: f64 = 32_768.0;
/// Seeds of each fault: each draws another base, bench and culprit.
const SEEDS: std::ops::Range<u64> = 21..24;

/// Changes one channel of every scan; the closure gets the run, the place in it from 0 to 1, and the counts.
fn change(runs: &mut [RecordedRun], channel: usize, mut to: impl FnMut(usize, f64, f64) -> f64) {
    for (index, run) in runs.iter_mut().enumerate() {
        let scans = run.capture.counts.len() as f64;
        for (scan, counts) in run.capture.counts.iter_mut().enumerate() {
            let changed = to(index, scan as f64 / scans, f64::from(counts[channel]));
            counts[channel] = changed.round().clamp(0.0, 65_535.0) as u16;
        }
    }
}

fn swap(runs: &mut [RecordedRun], a: usize, b: usize) {
    let scans = runs.iter_mut().flat_map(|run| &mut run.capture.counts);
    scans.for_each(|scan: &mut Scan| scan.swap(a, b));
}

/// Counts that a jack's transducer gives for one metre.
fn per_metre(bench: &Bench) -> f64 {
    let geometry = &bench.base.geometry;
    let stroke_m = geometry.length_max_m() - geometry.length_min_m();
    bench.sensors.jacks.full_stroke_volts / stroke_m * bench.sensors.counts_per_volt()
}

/// Counts of one unit of a sensor.
fn per_unit(bench: &Bench, channel: usize) -> f64 {
    let sheets = [
        &bench.sensors.linear_acceleration,
        &bench.sensors.angular_acceleration,
        &bench.sensors.angular_rate,
    ];
    sheets[channel / 3].volts_per_unit * bench.sensors.counts_per_volt()
}

/// The checks that a bench fails after `fault`, which gets a generator for the culprit and gives back its name.
fn judged<T>(seed: u64, fault: impl FnOnce(&mut Bench, &mut ChaCha8Rng) -> T) -> (Vec<Check>, T) {
    let mut bench = Bench::new(seed);
    let culprit = fault(&mut bench, &mut ChaCha8Rng::seed_from_u64(seed));
    let checks = bench.checks();
    let failed = failures(&checks);
    assert!(!failed.is_empty(), "seed {seed}: nothing is noticed");
    (failed.into_iter().cloned().collect(), culprit)
}

fn name(channel: usize) -> String {
    hexsense_core::channel::NAMES[channel].to_owned()
}

/// Puts a fault into one jack or sensor of each seed, and returns what fails; its first name must be the culprit's.
fn assert_named(
    check: &str,
    channels: std::ops::Range<usize>,
    fault: impl Fn(&mut Bench, usize, &mut ChaCha8Rng),
) {
    for seed in SEEDS {
        let (failed, culprit) = judged(seed, |bench, random| {
            let channel = random.random_range(channels.clone());
            fault(bench, channel, random);
            name(channel)
        });
        let first = &failed[0];
        assert_eq!(
            (first.name.as_str(), &first.names[0]),
            (check, &culprit),
            "seed {seed}: {failed:#?}"
        );
    }
}

const JACKS: std::ops::Range<usize> = INERTIAL..CHANNELS;
const SENSORS: std::ops::Range<usize> = 0..INERTIAL;

#[test]
fn exchanged_jacks_are_named_with_each_other() {
    for seed in SEEDS {
        let (failed, [a, b]) = judged(seed, |bench, random| {
            let a = random.random_range(0..6);
            let b = (a + random.random_range(1..6)) % 6;
            let [a, b] = [a, b].map(|jack| INERTIAL + jack);
            swap(&mut bench.runs, a, b);
            [a, b].map(name)
        });
        assert_eq!(failed[0].name, "jacks follow");
        for (jack, other) in [(&a, &b), (&b, &a)] {
            let said = format!("{jack} follows the program of {other}: are their plugs exchanged?");
            assert!(
                failed[0].means.contains(&said),
                "seed {seed}: {}",
                failed[0].means
            );
        }
        assert_eq!(failed[0].names.len(), 2);
    }
}

#[test]
fn an_inverted_jack_is_named() {
    assert_named("jacks follow", JACKS, |bench, jack, _| {
        change(&mut bench.runs, jack, |_, _, counts| 2.0 * ZERO - counts);
    });
}

#[test]
fn a_dead_jack_is_named() {
    assert_named("jacks follow", JACKS, |bench, jack, _| {
        change(&mut bench.runs, jack, |_, _, _| ZERO);
    });
}

#[test]
fn a_jack_that_reads_two_percent_too_much_is_named() {
    assert_named("jack gain", JACKS, |bench, jack, _| {
        change(&mut bench.runs, jack, |_, _, counts| {
            ZERO + 1.02 * (counts - ZERO)
        });
    });
}

#[test]
fn all_jacks_that_read_two_percent_too_much_are_a_matter_of_scale() {
    for seed in SEEDS {
        let (failed, ()) = judged(seed, |bench, _| {
            for jack in JACKS {
                change(&mut bench.runs, jack, |_, _, counts| {
                    ZERO + 1.02 * (counts - ZERO)
                });
            }
        });
        assert_eq!(
            (failed[0].name.as_str(), failed[0].names.len()),
            ("jack gain", 6)
        );
        assert!(
            failed[0].means.starts_with("all jacks move too far"),
            "{failed:?}"
        );
    }
}

#[test]
fn a_jack_that_steps_by_five_millimetres_in_a_run_is_named() {
    for run in [1, 3, 6] {
        assert_named("jack residual", JACKS, |bench, jack, _| {
            let step = 0.005 * per_metre(bench);
            change(&mut bench.runs, jack, |index, place, counts| {
                counts
                    + if index == run && place > 0.6 {
                        step
                    } else {
                        0.0
                    }
            });
        });
    }
}

#[test]
fn exchanged_sensors_are_named_with_each_other() {
    for seed in SEEDS {
        let (failed, [a, b]) = judged(seed, |bench, random| {
            let triad = 3 * random.random_range(0..3);
            let a = random.random_range(0..3);
            let b = (a + random.random_range(1..3)) % 3;
            swap(&mut bench.runs, triad + a, triad + b);
            [triad + a, triad + b].map(name)
        });
        let direction = failed.iter().find(|check| check.name == "sensor direction");
        let means = &direction.unwrap().means;
        for (sensor, other) in [(&a, &b), (&b, &a)] {
            let said =
                format!("{sensor} lies along the axis of {other}: are their plugs exchanged?");
            assert!(means.contains(&said), "seed {seed}: {means}");
        }
    }
}

#[test]
fn an_inverted_sensor_is_named() {
    assert_named("sensor direction", SENSORS, |bench, sensor, _| {
        change(&mut bench.runs, sensor, |_, _, counts| 2.0 * ZERO - counts);
    });
}

#[test]
fn a_dead_sensor_is_named() {
    assert_named("sensors answer", SENSORS, |bench, sensor, _| {
        change(&mut bench.runs, sensor, |_, _, _| ZERO);
    });
}

#[test]
fn a_sensor_with_half_the_gain_is_named() {
    assert_named("sensor gain", SENSORS, |bench, sensor, _| {
        change(&mut bench.runs, sensor, |_, _, counts| {
            ZERO + 0.5 * (counts - ZERO)
        });
    });
}

#[test]
fn a_sensor_that_clips_at_three_tenths_of_its_amplitude_is_named() {
    assert_named("signal shape", SENSORS, |bench, sensor, _| {
        let rest = f64::from(bench.runs[0].capture.counts[0][sensor]);
        let all = bench.runs.iter().flat_map(|run| &run.capture.counts);
        let moved = all.map(|scan| (f64::from(scan[sensor]) - rest).abs());
        let limit = 0.3 * moved.fold(0.0, f64::max);
        change(&mut bench.runs, sensor, |_, _, counts| {
            rest + (counts - rest).clamp(-limit, limit)
        });
    });
}

#[test]
fn a_sensor_ten_times_as_noisy_is_named() {
    assert_named("sensor noise", SENSORS, |bench, sensor, random| {
        let density = [
            &bench.sensors.linear_acceleration,
            &bench.sensors.angular_acceleration,
            &bench.sensors.angular_rate,
        ][sensor / 3]
            .noise_density;
        // White up to half of 1 kHz.
        let deviation = 10.0 * density * per_unit(bench, sensor) * 500f64.sqrt();
        change(&mut bench.runs, sensor, |_, _, counts| {
            let noise: f64 = StandardNormal.sample(random);
            counts + deviation * noise
        });
    });
}

#[test]
fn a_zero_that_steps_in_a_run_is_named() {
    assert_named("zero of the sensors", SENSORS, |bench, sensor, _| {
        let step = [0.196, 0.1, 0.5f64.to_radians()][sensor / 3] * per_unit(bench, sensor);
        change(&mut bench.runs, sensor, |index, place, counts| {
            counts
                + if index > 4 || index == 4 && place > 0.5 {
                    step
                } else {
                    0.0
                }
        });
    });
}

#[test]
fn a_home_that_moves_by_two_millimetres_is_told() {
    for seed in SEEDS {
        let (failed, ()) = judged(seed, |bench, _| {
            let step = 0.002 * per_metre(bench);
            for jack in JACKS {
                change(&mut bench.runs, jack, |index, _, counts| {
                    counts + if index > 3 { step } else { 0.0 }
                });
            }
        });
        assert_eq!(failed[0].name, "home", "{failed:?}");
    }
}

#[test]
fn exchanged_programs_are_told_with_their_runs() {
    for seed in SEEDS {
        let (failed, runs) = judged(seed, |bench, _| {
            let [heave, roll] = [3, 4].map(|run| bench.runs[run].program.clone());
            (bench.runs[3].program, bench.runs[4].program) = (roll, heave);
            [3, 4].map(|run| bench.runs[run].name.clone())
        });
        // Where half of the jacks move in heave as they do in roll, their residuals tell.
        let means = &failed[0].means;
        assert!(
            means.contains("was the right program loaded"),
            "seed {seed}: {failed:#?}"
        );
        assert!(runs.iter().any(|run| means.contains(run)), "{means}");
    }
}

/// Its stroke differs, and so the displacements that its transducers show.
#[test]
fn the_file_of_another_base_is_told() {
    let load = |name: &str| GeometryFile::load(name).unwrap();
    for (truth, file) in [
        ("il-96-300", "tu-204"),
        ("tu-204", "an-74tk-200"),
        ("rexroth_emotion8000", "il-96-300"),
    ] {
        let checks = Bench::with_file(31, &load(truth), load(file)).checks();
        let failed = failures(&checks);
        assert_eq!(
            (failed[0].name.as_str(), failed[0].names.len()),
            ("jack gain", 6),
            "{truth} as {file}: {failed:#?}"
        );
    }
}

#[test]
fn a_file_with_its_hinges_numbered_one_off_is_told() {
    for name in ["tu-204", "an-74tk-200", "rexroth_emotion8000"] {
        let truth = GeometryFile::load(name).unwrap();
        let old = &truth.geometry;
        let [lower, upper] = [old.lower(), old.upper()]
            .map(|hinges| std::array::from_fn(|jack| hinges[(jack + 1) % 6]));
        let [shortest, longest] = [old.length_min_m(), old.length_max_m()];
        let geometry = Geometry::new(lower, upper, shortest, longest, None).unwrap();
        let file = GeometryFile {
            geometry,
            ..truth.clone()
        };
        let checks = Bench::with_file(31, &truth, file).checks();
        let failed = failures(&checks);
        assert_eq!(failed[0].name, "sensor direction", "{name}: {failed:#?}");
        assert!(
            failed[0]
                .means
                .starts_with("most sensors lie along other axes")
        );
    }
}
