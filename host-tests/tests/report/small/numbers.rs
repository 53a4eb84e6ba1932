//! The results of the small campaign: round numbers, no two alike.

use hexsense_probe::analysis::check::{Check, Verdict};
use hexsense_probe::analysis::held_out::ChannelVerdict;
use hexsense_probe::analysis::lever_arm::SecondHarmonic;
use hexsense_probe::analysis::results::{ChannelResult, Measured, Results, Term};
use hexsense_probe::campaign::{BoardPoses, Verification};
use hexsense_probe::characteristics::frequency_response::FrequencyResponse;

const UNITS: [&str; 3] = ["m/s²", "rad/s²", "rad/s"];

/// Name; u0, its U and 95 %; diagonal, its U and 95 % in 10⁻⁴ or 10⁻⁵ unit per count; noise density.
type Channel = (&'static str, [f64; 3], [f64; 3], f64);

#[rustfmt::skip]
const CHANNELS: [Channel; 9] = [
    ("ax", [32100.4, 12.0, 11.0], [5.0e-4, 0.010e-4, 0.009e-4], 1.23e-3),
    ("ay", [32850.5, 3.4, 3.2], [4.0e-4, 0.024e-4, 0.022e-4], 2.34e-3),
    ("az", [33000.25, 0.56, 0.53], [8.0e-4, 0.064e-4, 0.048e-4], 4.56e-3),
    ("ex", [31000.3, 25.0, 24.0], [-2.0e-4, 0.002e-4, 0.0018e-4], 3.45e-2),
    ("ey", [31500.5, 7.8, 7.4], [1.0e-4, 0.003e-4, 0.0027e-4], 5.67e-2),
    ("ez", [31999.75, 0.91, 0.88], [2.5e-4, 0.010e-4, 0.0085e-4], 6.78e-2),
    ("wx", [34000.2, 40.0, 39.0], [1.6e-5, 0.016e-5, 0.0144e-5], 1.11e-4),
    ("wy", [34100.5, 5.6, 5.3], [3.2e-5, 0.048e-5, 0.0416e-5], 2.22e-4),
    ("wz", [34200.25, 0.78, 0.75], [6.4e-5, 0.1408e-5, 0.1216e-5], 3.33e-4),
];

/// Element of M beside the diagonal and its U, in the order of rows; 10⁻⁴, 10⁻⁴ and 10⁻⁵ unit per count.
#[rustfmt::skip]
const CROSS: [[(f64, f64); 2]; 9] = [
    [(0.0123, 0.0011), (-0.0231, 0.0012)],
    [(0.0312, 0.0013), (0.0132, 0.0014)],
    [(-0.0213, 0.0015), (0.0321, 0.0016)],
    [(0.0141, 0.0017), (0.0242, 0.0018)],
    [(0.0343, 0.0019), (-0.0444, 0.0021)],
    [(0.0545, 0.0022), (0.0646, 0.0023)],
    [(0.151, 0.024), (0.252, 0.025)],
    [(0.353, 0.026), (0.454, 0.027)],
    [(-0.555, 0.028), (0.656, 0.029)],
];

fn measured([estimate, expanded_uncertainty, interval_95]: [f64; 3]) -> Measured {
    Measured {
        estimate,
        expanded_uncertainty,
        interval_95,
    }
}

fn row(channel: usize) -> [Measured; 3] {
    let scale = if channel < 6 { 1e-4 } else { 1e-5 };
    let mut beside = CROSS[channel].iter();
    std::array::from_fn(|column| {
        if column == channel % 3 {
            return measured(CHANNELS[channel].2);
        }
        let (element, uncertainty) = beside.next().unwrap();
        measured([
            element * scale,
            uncertainty * scale,
            0.9 * uncertainty * scale,
        ])
    })
}

/// Terms that are 3 to 4, so that the combined uncertainty is 5: for the gain "clock" is larger, for the offset "noise".
/// The first channel has a third one, which is next to nothing.
fn budget(channel: usize) -> Vec<Term> {
    let (_, [_, offset, _], [gain, uncertainty, _], _) = CHANNELS[channel];
    let relative = uncertainty / gain.abs();
    let term = |cause: &str, gain_relative: f64, offset_counts: f64| Term {
        cause: cause.to_owned(),
        gain_relative,
        offset_counts,
    };
    let mut terms = vec![
        term("noise", 0.3 * relative, 0.4 * offset),
        term("clock", 0.4 * relative, 0.3 * offset),
    ];
    if channel == 0 {
        terms.push(term("dust", 1e-6, 0.0));
    }
    terms
}

fn channel(index: usize) -> ChannelResult {
    let (name, offset, gain, noise_density) = CHANNELS[index];
    ChannelResult {
        name: name.to_owned(),
        unit: UNITS[index / 3].to_owned(),
        offset: measured(offset),
        gain: measured(gain),
        cross: row(index),
        sensitivity: 1.0 / gain[0],
        budget: budget(index),
        noise_density,
        rest_uncertainty: 0.001 * (index as f64 + 1.0),
        bias_walk: 0.002 * (index as f64 + 1.0),
    }
}

fn checks() -> Vec<Check> {
    let check =
        |name: &str, verdict, numbers: Option<[f64; 2]>, unit: &str, names: &[&str]| Check {
            name: name.to_owned(),
            verdict,
            statistic: numbers.map(|[statistic, _]| statistic),
            limit: numbers.map(|[_, limit]| limit),
            unit: unit.to_owned(),
            names: names.iter().map(|name| (*name).to_owned()).collect(),
            means: format!("meaning of {name} & more"),
            accepted: None,
        };
    let (passes, fails) = (Verdict::Pass, Verdict::Fail);
    vec![
        check(
            "jack gain",
            passes,
            Some([1.234e-3, 0.01]),
            "relative",
            &["jack4"],
        ),
        Check {
            accepted: Some("a fan <nearby>".to_owned()),
            ..check(
                "sensor noise",
                fails,
                Some([4.56, 3.0]),
                "of the data sheet",
                &["wy", "ax"],
            )
        },
        check("home", Verdict::NotObservable, None, "m", &[]),
    ]
}

pub fn results() -> Results {
    let harmonic = |freedom: &str, channel: &str, numbers: [f64; 5]| SecondHarmonic {
        freedom: freedom.to_owned(),
        channel: channel.to_owned(),
        predicted: numbers[0],
        measured: numbers[1],
        difference: numbers[2],
        uncertainty: numbers[3],
        limit: numbers[4],
    };
    Results {
        channels: (0..9).map(channel).collect(),
        delays_s: [
            measured([1.5e-3, 0.11e-3, 0.10e-3]),
            measured([-2.3e-3, 0.12e-3, 0.11e-3]),
            measured([4.7e-3, 0.13e-3, 0.12e-3]),
        ],
        gravity_m_s2: measured([9.8154, 0.0004, 0.000392]),
        lever_arm_m: [
            measured([0.4123, 0.0045, 0.0044]),
            measured([-0.2611, 0.0056, 0.0055]),
            measured([0.0877, 0.00067, 0.00066]),
        ],
        second_harmonics: vec![
            harmonic("roll", "ax", [0.0101, 0.0112, 0.0023, 0.0004, 0.0056]),
            harmonic("roll", "ay", [0.0201, 0.0222, 0.0078, 0.0005, 0.0067]),
            harmonic("yaw", "az", [0.0301, 0.0332, 0.0089, 0.0006, 0.0091]),
        ],
        warnings: vec!["roll sine, ay: something does not fit".to_owned()],
        scans: 81_818,
        checks: checks(),
    }
}

/// Signal, error before, error after, mean error and its uncertainty. `ey` errs too much about its mean, `wz` in it.
#[rustfmt::skip]
const VERDICTS: [[f64; 5]; 9] = [
    [1.23, 0.456, 0.0123, -0.0021, 0.0045],
    [2.5, 0.31, 0.05, 0.0032, 0.0054],
    [3.6, 0.72, 0.09, 0.0043, 0.0063],
    [0.5, 0.0234, 0.006, 0.0011, 0.0019],
    [0.4, 0.0345, 0.016, -0.0012, 0.0018],
    [0.8, 0.0567, 0.004, 0.0013, 0.0017],
    [0.05, 0.00678, 0.0007, 0.00021, 0.00031],
    [0.06, 0.00789, 0.0009, -0.00022, 0.00032],
    [0.07, 0.00891, 0.0014, 0.00062, 0.00051],
];

pub fn verification() -> Verification {
    let verdict = |(index, numbers): (usize, &[f64; 5])| ChannelVerdict {
        name: CHANNELS[index].0.to_owned(),
        unit: UNITS[index / 3].to_owned(),
        rms_signal: numbers[0],
        rms_error_before: numbers[1],
        rms_error_after: numbers[2],
        mean_error: numbers[3],
        mean_uncertainty: numbers[4],
    };
    Verification {
        board_pose: BoardPoses {
            poses: 1886,
            largest_m: 2.46e-7,
            largest_rad: 1.14e-7,
            limit: 5e-7,
        },
        channels: VERDICTS.iter().enumerate().map(verdict).collect(),
    }
}

pub fn frequency_response() -> Vec<FrequencyResponse> {
    let response = |run: &str, freedom: &str, numbers: [f64; 6]| FrequencyResponse {
        run: run.to_owned(),
        freedom: freedom.to_owned(),
        frequency_hz: numbers[0],
        command: numbers[1],
        measured: numbers[2],
        ratio: numbers[3],
        phase_deg: numbers[4],
        distortion: numbers[5],
    };
    // 4° are 0.06981317 rad, 4.1° are 0.07155850 rad.
    vec![
        response(
            "heave",
            "heave",
            [0.50123, 0.05, 0.0485, 0.97, -12.34, 0.0123],
        ),
        response(
            "roll-sine",
            "roll",
            [0.25012, 0.069_813_17, 0.071_558_50, 1.025, 3.21, 0.0045],
        ),
    ]
}
