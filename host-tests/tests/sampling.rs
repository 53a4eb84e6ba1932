//! The sample path: correct, the same on every machine, and independent of the supply.

use hexsense::FACTS;
use hexsense_core::channel::{CHANNELS, INERTIAL, NAMES, Ratiometric, Scan, Triad};
use hexsense_core::records::{CoefficientSet, JackCoefficients, MotionBase, TriadCoefficients};
use hexsense_core::sampling::{BLOCK, BlockSize, BlockSums, Calibrator};
use proptest::prelude::*;

fn set(triads: [TriadCoefficients; 3]) -> CoefficientSet {
    CoefficientSet {
        board: [0; 12],
        geometry: heapless::String::new(),
        geometry_hash: [0; 8],
        unix_s: 0,
        temperature_c: 25.0,
        provenance: [0; 32],
        ratiometric: Default::default(),
        build: None,
        triads,
        base: MotionBase {
            lower: [[0.0; 3]; 6],
            upper: [[0.0; 3]; 6],
            length_min_m: 0.0,
            length_max_m: 0.0,
            home_height_m: 0.0,
        },
        jacks: JackCoefficients {
            zero_length_m: 0.0,
            zero_counts: [0.0; 6],
            metres_per_count: [0.0; 6],
        },
    }
}

fn coefficients(offset: [f32; 3], matrix: [[f32; 3]; 3]) -> TriadCoefficients {
    TriadCoefficients {
        offset,
        matrix,
        offset_uncertainty: [0.0; 3],
        matrix_uncertainty: [[0.0; 3]; 3],
        delay_s: 0.0,
    }
}

fn any_triads() -> impl Strategy<Value = [TriadCoefficients; 3]> {
    let element = || -1e-3_f32..1e-3;
    let triad = || {
        let offset = std::array::from_fn::<_, 3, _>(|_| 20_000.0_f32..45_000.0);
        let matrix =
            std::array::from_fn::<_, 3, _>(|_| std::array::from_fn::<_, 3, _>(|_| element()));
        (offset, matrix).prop_map(|(offset, matrix)| coefficients(offset, matrix))
    };
    [triad(), triad(), triad()]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// u − u0/c first, then the three products with c·M of a row, added from left to right; every step rounded to f32.
    #[test]
    fn values_are_bit_for_bit_those_of_the_stated_order(
        triads in any_triads(), scan: Scan, supply in 0.9_f32..1.1,
    ) {
        let values = Calibrator::new(&set(triads)).apply(&scan, supply);
        for (index, triad) in triads.iter().enumerate() {
            let x: [f32; 3] = std::array::from_fn(|axis| {
                f32::from(scan[3 * index + axis]) - triad.offset[axis] / supply
            });
            for row in 0..3 {
                let [a, b, c] = triad.matrix[row].map(|element| element * supply);
                let expected = a * x[0] + b * x[1] + c * x[2];
                prop_assert_eq!(values[3 * index + row].to_bits(), expected.to_bits());
            }
        }
    }

    #[test]
    fn values_are_those_of_double_precision_to_rounding(
        triads in any_triads(), scan: Scan, supply in 0.9_f32..1.1,
    ) {
        let values = Calibrator::new(&set(triads)).apply(&scan, supply);
        for (channel, value) in values.iter().enumerate() {
            let triad = &triads[channel / 3];
            let (mut expected, mut size) = (0.0, 0.0);
            for axis in 0..3 {
                let counts = f64::from(supply) * f64::from(scan[channel / 3 * 3 + axis]);
                let element = f64::from(triad.matrix[channel % 3][axis]);
                expected += element * (counts - f64::from(triad.offset[axis]));
                size += element.abs() * (counts + f64::from(triad.offset[axis]));
            }
            let bound = 3.0 * f64::from(f32::EPSILON) * size;
            prop_assert!((f64::from(*value) - expected).abs() <= bound, "{} for {}", value, expected);
        }
    }

    /// The same voltages, converted at another supply: the counts differ, and the values by one rounded count at most.
    #[test]
    fn the_supply_factor_cancels_a_change_of_supply(
        triads in any_triads(), volts in [0.1_f64..2.8; 1], spread in 0.0_f64..0.01, supply_v in 3.0_f64..3.6,
    ) {
        let counts = |supply_v: f64| -> Scan {
            std::array::from_fn(|channel| {
                let volts = volts[0] + spread * channel as f64;
                (65_536.0 * volts / supply_v).round() as u16
            })
        };
        let calibrator = Calibrator::new(&set(triads));
        let nominal = f64::from(FACTS.nominal_supply_v);
        let at_nominal = calibrator.apply(&counts(nominal), 1.0);
        let elsewhere = calibrator.apply(&counts(supply_v), (supply_v / nominal) as f32);
        for channel in 0..INERTIAL {
            let row = triads[channel / 3].matrix[channel % 3];
            let count: f32 = row.iter().map(|element| element.abs()).sum();
            prop_assert!((at_nominal[channel] - elsewhere[channel]).abs() <= 1.1 * count + 1e-4);
        }
    }
}

/// Values computed once in another language; a host that recomputes a board's values must get these very bits.
#[test]
fn the_bits_of_one_scan_are_known() {
    let triad = |gain: f32| {
        let matrix = [
            [1.0, 0.02, -0.01],
            [-0.015, 1.01, 0.005],
            [0.01, -0.02, 0.99],
        ];
        coefficients(
            [32_768.25, 32_700.5, 33_000.125],
            matrix.map(|row| row.map(|element: f32| element * gain)),
        )
    };
    let calibrator = Calibrator::new(&set([triad(6e-4), triad(3e-4), triad(-5e-5)]));
    let scan: Scan = std::array::from_fn(|channel| 30_011 + 613 * channel as u16);
    let bits = calibrator.apply(&scan, 0.998_7).map(f32::to_bits);
    assert_eq!(
        bits,
        [
            0xBFD8_9E4D,
            0xBFA1_A116,
            0xBF88_09D5,
            0xBE94_4FFE,
            0xBDA4_9F09,
            0x3C0C_4C8A,
            0xBD36_2626,
            0xBDA0_A1C6,
            0xBDBB_3AF6,
        ]
    );
}

/// Half of the full scale of 32,768 counts is ± 2 g: 0.1 % of supply on counts at zero is 2 mg.
#[test]
fn the_supply_factor_acts_on_the_channels_that_are_not_ratiometric() {
    let gain = 2.0 * 9.81 / 32_768.0;
    let matrix = [[gain, 0.0, 0.0], [0.0, gain, 0.0], [0.0, 0.0, gain]];
    let mut set = set([coefficients([32_768.0; 3], matrix); 3]);
    set.ratiometric = Ratiometric::NONE.with(1).with(5);
    let supply = 1.001;
    // At zero: a sensor with its own supply reads 0.1 % less, one that is fed by the converters' supply the same.
    let zero: Scan = std::array::from_fn(|channel| match channel {
        1 | 5 => 32_768,
        _ => 32_735,
    });
    let values = Calibrator::new(&set).apply(&zero, supply);
    assert!(values.iter().all(|value| value.abs() < 5e-4), "{values:?}");
    set.ratiometric = Ratiometric::NONE;
    let values = Calibrator::new(&set).apply(&zero, supply);
    for channel in [1, 5] {
        assert!((values[channel] - 0.001 * 32_768.0 * gain).abs() < 1e-4);
    }
    assert!(values[0].abs() < 5e-4);
}

/// The sample path takes whole blocks; a host that recomputes a capture takes scans.
#[test]
fn a_block_gives_the_values_of_its_scans_and_their_sums_at_every_size() {
    let triad =
        |gain: f32| coefficients([32_768.25, 32_700.5, 33_000.125], [[gain, 1e-5, -2e-5]; 3]);
    let prepared =
        Calibrator::of_triads(&[triad(6e-4), triad(3e-4), triad(-5e-5)], Ratiometric::NONE)
            .at_supply(1.001);
    for size in BlockSize::ALL {
        let scans: Vec<Scan> = (0..size.scans())
            .map(|n| {
                std::array::from_fn(|channel| (n * 7_919 + channel * 4_099 * n + 65_500) as u16)
            })
            .collect();
        let inertial: Vec<[u16; INERTIAL]> = scans
            .iter()
            .map(|scan| std::array::from_fn(|channel| scan[channel]))
            .collect();
        let mut values = [[0.0; INERTIAL]; BlockSize::MAX_SCANS];
        let mut sums = [0; INERTIAL];
        prepared.block(&inertial, &mut values, &mut sums);
        for (scan, values) in inertial.iter().zip(&values) {
            assert_eq!(
                prepared.apply(scan).map(f32::to_bits),
                values.map(f32::to_bits)
            );
        }
        assert!(
            values[size.scans()..]
                .iter()
                .all(|rest| *rest == [0.0; INERTIAL])
        );
        let expected = |channel: usize| {
            scans
                .iter()
                .map(|scan| u32::from(scan[channel]))
                .sum::<u32>()
        };
        let all = BlockSums::of_scans(&scans, 5);
        for (channel, name) in NAMES.into_iter().enumerate() {
            let found = if channel < INERTIAL {
                all.inertial[channel]
            } else {
                all.jacks[channel - INERTIAL]
            };
            assert_eq!(found, expected(channel), "{name} of {}", size.scans());
        }
        assert_eq!((sums, all.first_scan), (all.inertial, 5));
    }
}

#[test]
fn channels_are_in_the_order_of_a_scan() {
    assert_eq!(NAMES.len(), CHANNELS);
    let first = Triad::ALL.map(|triad| NAMES[triad.first_channel()]);
    assert_eq!(first, ["ax", "ex", "wx"]);
    assert_eq!(Triad::ALL.map(Triad::index), [0, 1, 2]);
    assert_eq!(NAMES[INERTIAL], "jack1");
}

#[test]
fn instants_are_the_middles_of_sixteen_conversions_one_after_another() {
    // RM0440: 16 conversions of 47.5 + 12.5 cycles at 37.5 MHz.
    let rank_s = 16.0 * 60.0 / 37.5e6;
    assert!((f64::from(FACTS.rank_ns) * 1e-9 - rank_s).abs() < 1e-15);
    for (channel, rank) in (0..INERTIAL).chain(0..6).enumerate() {
        let expected = (rank as f64 + 0.5) * rank_s;
        assert!(
            (FACTS.instant_s(channel) - expected).abs() < 1e-15,
            "{}",
            NAMES[channel]
        );
    }
    // A scan ends before the next begins, at every rate, and a block is a whole number of scans.
    let scan_s = INERTIAL as f64 * rank_s;
    assert!(
        FACTS
            .rates_hz
            .iter()
            .all(|rate| scan_s < 1.0 / f64::from(*rate))
    );
    assert_eq!(BLOCK, 16);
}
