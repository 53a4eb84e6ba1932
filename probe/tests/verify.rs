//! `hexsense verify` says no: to another board, to another set, and to a single channel that is off by its mean or by its
//! rms alone.

mod fake;

use std::process::Output;

use fake::FakeBoard;
use fake::bench::Bench;
use fake::line::lockstep;
use fake::source::Still;
use hexsense_core::records::CoefficientSet;
use hexsense_probe::coefficient_file;
use serde_json::Value;

const CHANNELS: [&str; 9] = ["ax", "ay", "az", "ex", "ey", "ez", "wx", "wy", "wz"];

/// A bench with a finished campaign, and the set that it found.
fn calibrated() -> (Bench, CoefficientSet) {
    let bench = Bench::new(|_| {});
    assert!(bench.record("calibrate").status.success());
    let (set, _) =
        coefficient_file::load(&bench.campaign().folder.join("coefficients.toml")).unwrap();
    (bench, set)
}

/// Makes `set` the set of the campaign.
fn save(bench: &Bench, set: &CoefficientSet) {
    let campaign = bench.campaign();
    let path = campaign.folder.join("coefficients.toml");
    coefficient_file::save(&path, set, &campaign.sources().unwrap()).unwrap();
}

/// Makes `set` the set of the campaign and of the board, and verifies.
fn verify(bench: &Bench, set: &CoefficientSet) -> Output {
    save(bench, set);
    assert!(bench.hexsense(&["upload", "campaign"]).status.success());
    bench.record("verify")
}

fn said(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// What verification.json holds of each channel: the rms error over the signal, and the mean error over its limit.
fn figures(bench: &Bench) -> Vec<(f64, f64)> {
    let path = bench.campaign().folder.join("verification.json");
    let noted: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let channels = noted["channels"].as_array().unwrap();
    assert!(
        channels
            .iter()
            .map(|c| c["name"].as_str().unwrap())
            .eq(CHANNELS)
    );
    let of = |channel: &Value, key: &str| channel[key].as_f64().unwrap();
    let figures = channels.iter().map(|channel| {
        let rms = of(channel, "rms_error_after") / of(channel, "rms_signal");
        let mean = of(channel, "mean_error").abs() / of(channel, "mean_uncertainty");
        (rms, mean)
    });
    figures.collect()
}

/// The lines of the table in which a verdict stands.
fn verdicts(output: &Output) -> Vec<String> {
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    let lines = text
        .lines()
        .filter(|line| line.ends_with("pass") || line.ends_with("passes"));
    lines.map(str::to_owned).collect()
}

/// That one channel alone did not pass, and that the command says so and fails.
fn assert_fails_alone(output: &Output, channel: &str) {
    assert_eq!(output.status.code(), Some(1));
    let last = said(output);
    let last = last.lines().last().unwrap();
    assert_eq!(
        last,
        format!("hexsense: {channel} did not pass; calibrate again")
    );
    let verdicts = verdicts(output);
    assert!(verdicts.iter().map(|line| &line[..2]).eq(CHANNELS));
    for line in verdicts {
        assert_eq!(
            line.ends_with("does not pass"),
            line.starts_with(channel),
            "{line}"
        );
    }
}

#[test]
fn one_channel_that_is_off_by_its_mean_or_its_rms_alone_fails() {
    let (bench, set) = calibrated();
    let good = verify(&bench, &set);
    assert_eq!(good.status.code(), Some(0), "{}", said(&good));
    assert!(verdicts(&good).iter().all(|line| line.ends_with(" passes")));
    let within = figures(&bench);
    assert!(
        within
            .iter()
            .all(|(rms, mean)| *rms <= 0.03 && *mean <= 1.0)
    );

    for channel in [1, 5, 6] {
        // A mean error of four times what is allowed: an offset moves the mean and nothing else.
        let (triad, axis) = (channel / 3, channel % 3);
        let allowed = mean_uncertainty(&bench, channel);
        let mut shifted = set.clone();
        let triad = &mut shifted.triads[triad];
        triad.offset[axis] += (4.0 * allowed) as f32 / triad.matrix[axis][axis];
        assert_fails_alone(&verify(&bench, &shifted), CHANNELS[channel]);
        let after = figures(&bench);
        assert!(after[channel].0 <= 0.03, "the rms is as before: {after:?}");
        assert!((3.0..5.0).contains(&after[channel].1), "{after:?}");
    }
    for channel in [0, 4, 8] {
        // Values that are a tenth too large: these channels go to and fro about zero, so that their means hardly move.
        let mut steeper = set.clone();
        let triad = &mut steeper.triads[channel / 3];
        triad.matrix[channel % 3] = triad.matrix[channel % 3].map(|gain| 1.1 * gain);
        assert_fails_alone(&verify(&bench, &steeper), CHANNELS[channel]);
        let after = figures(&bench);
        assert!((0.08..0.13).contains(&after[channel].0), "{after:?}");
        assert!(
            after[channel].1 <= 1.0,
            "the mean is within its limit: {after:?}"
        );
    }
}

/// The largest mean error of a channel that passes.
fn mean_uncertainty(bench: &Bench, channel: usize) -> f64 {
    let path = bench.campaign().folder.join("verification.json");
    let noted: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    noted["channels"][channel]["mean_uncertainty"]
        .as_f64()
        .unwrap()
}

#[test]
fn a_set_that_differs_in_the_last_bit_of_one_number_is_another_set() {
    let (bench, set) = calibrated();
    let mut other = set.clone();
    other.triads[2].matrix[1][0] = other.triads[2].matrix[1][0].next_up();
    save(&bench, &other);
    assert!(bench.hexsense(&["upload", "campaign"]).status.success());
    save(&bench, &set);
    let refused = bench.record("verify");
    assert_eq!(refused.status.code(), Some(1));
    let text = said(&refused);
    assert!(text.contains("hexsense: the board uses set "), "{text}");
    assert!(text.contains("which is not the one of campaign"), "{text}");
    assert!(
        !bench.campaign().is_recorded("held-out"),
        "nothing has moved"
    );
    save(&bench, &other);
    assert_eq!(bench.record("verify").status.code(), Some(0));
}

#[test]
fn another_board_is_refused_before_its_set_is_looked_at() {
    let (bench, _) = calibrated();
    let other = lockstep(FakeBoard::new(Box::new(Still)));
    let bench = Bench {
        port: other,
        ..bench
    };
    let refused = bench.record("verify");
    assert_eq!(refused.status.code(), Some(1));
    let text = said(&refused);
    // "fake board 1" in hexadecimal digits.
    assert!(text.contains("holds a campaign with board "), "{text}");
    assert!(
        text.contains("not with board 66616b6520626f6172642031"),
        "{text}"
    );
    assert!(!bench.campaign().is_recorded("held-out"));
}
