//! The printed truth against the sensors themselves.

mod support;

use support::{X, Z, an74, close, pass};
use twin::Bench;
use twin::algebra::Vec3;
use twin::bench::STEP_S;
use twin::board::BoardTruth;
use twin::sensor::Sensor;
use twin::sheet::TRIADS;
use twin::truth::{Document, TriadTruth};

const INPUTS: [[f64; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [0.9, -0.3, 0.5],
    [-0.2, 0.8, -0.7],
    [0.1, 0.4, 1.0],
];

/// s = M·(u − u0).
fn invert(truth: &TriadTruth, counts: [f64; 3]) -> [f64; 3] {
    truth.matrix.map(|row| {
        (0..3)
            .map(|j| row[j] * (counts[j] - truth.offset[j]))
            .sum::<f64>()
    })
}

#[test]
fn truth_matrix_times_sensitivity_is_the_identity() {
    for seed in 0..50 {
        let adc = BoardTruth::draw(seed).adc[0];
        for sheet in &TRIADS {
            let truth = TriadTruth::draw(seed, sheet, &adc);
            for i in 0..3 {
                for j in 0..3 {
                    let product: f64 = (0..3)
                        .map(|k| truth.matrix[i][k] * truth.sensitivity[k][j])
                        .sum();
                    close(product, f64::from(i == j), 1e-13, "M·S");
                }
            }
        }
    }
}

#[test]
fn the_truth_inverts_settled_sensors_and_converter() {
    for seed in 0..20 {
        let adc = BoardTruth::draw(seed).adc[0];
        for sheet in &TRIADS {
            let truth = TriadTruth::draw(seed, sheet, &adc);
            for input in INPUTS {
                // A new sensor is settled on its input and has neither noise nor drift yet.
                let counts = [0, 1, 2].map(|axis| {
                    let volts = Sensor::new(seed, sheet, axis, Vec3(input), STEP_S).volts();
                    65536.0 * volts / 3.3 * (1.0 + adc.gain_error) + 16.0 * adc.offset_lsb
                });
                let found = invert(&truth, counts);
                for (got, want) in found.into_iter().zip(input) {
                    close(got, want, 1e-10, sheet.name);
                }
            }
        }
    }
}

/// Mean counts of the nine channels over some seconds, as a board reads and normalises them.
fn mean_counts(bench: &mut Bench, seconds: f64) -> [f64; 9] {
    let adc = bench.board().adc[0];
    let (mut sums, mut count, mut rows) = ([0.0; 9], 0.0, Vec::new());
    for _ in 0..(seconds / 0.02) as usize {
        bench.next_chunk(&mut rows, |_| ()).unwrap();
        for row in rows.chunks_exact(17).skip(1) {
            let supply = f64::from(row[16]);
            for (sum, volts) in sums.iter_mut().zip(row) {
                let code = 65536.0 * f64::from(*volts) / supply * (1.0 + adc.gain_error);
                *sum += code * supply / 3.3 + 16.0 * adc.offset_lsb;
            }
            count += 1.0;
        }
    }
    sums.map(|sum| sum / count)
}

#[test]
fn counts_of_a_tilted_base_become_its_specific_force() {
    let geometry = an74();
    for seed in [1, 2, 3] {
        let mut bench = Bench::with_geometry(seed, &geometry).unwrap();
        let tilt = support::to_pose(&geometry, Vec3::ZERO, Z * 0.25 + X * -0.2, 15.0);
        bench.run("tilt", tilt).unwrap();
        let before = pass(&mut bench, 14.0);
        let counts = mean_counts(&mut bench, 2.0);
        let felt = before.last().unwrap().felt.specific_force.0;
        assert!(felt[0] > 2.0 && felt[2] > 1.5, "not tilted: {felt:?}");
        let truth = TriadTruth::draw(seed, &TRIADS[0], &bench.board().adc[0]);
        let found = invert(&truth, [counts[0], counts[1], counts[2]]);
        for (got, want) in found.into_iter().zip(felt) {
            // Four times the random walk of 16 s.
            close(got, want, 0.01, "specific force");
        }
    }
}

#[test]
fn the_document_is_what_it_was_when_seeds_were_given_their_meaning() {
    let document = serde_json::to_string(&Document::new(1, "an-74tk-200")).unwrap();
    assert_eq!(document + "\n", include_str!("data/truth-seed-1.json"));
}
