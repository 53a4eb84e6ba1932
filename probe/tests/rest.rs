//! A run begins only when the base is at rest at home: both sides of the limits, in whole counts.
//!
//! The transducers of the sensor file give 3.1 V over the stroke of 1.3 m, and 65,536 counts are 3.3 V: a millimetre is
//! 47.357 counts.

mod fake;

use assert_cmd::Command;
use fake::FakeBoard;
use fake::line::lockstep;
use fake::source::Source;
use hexsense_core::channel::{CHANNELS, INERTIAL, Scan};

/// A base of which one jack, 1 to 6, stands off its home, and goes to and fro by some counts every second.
struct Off {
    jack: usize,
    off: i32,
    moves: u16,
    scans: u32,
}

impl Source for Off {
    fn scan(&mut self, rate_hz: u32) -> Scan {
        self.scans += 1;
        let there = u16::from(self.scans / (rate_hz / 2) % 2 == 1);
        let mut scan = [32_768; CHANNELS];
        let count = &mut scan[INERTIAL + self.jack - 1];
        *count = (32_768 + self.off) as u16 + there * self.moves;
        scan
    }
}

/// What `hexsense calibrate` says on this base, which never follows a program.
fn said(jack: usize, off: i32, moves: u16) -> String {
    let folder = tempfile::tempdir().unwrap();
    let sensors = folder.path().join("sensors.toml");
    std::fs::write(sensors, twin::papers::sensor_file(1)).unwrap();
    let base = Off {
        jack,
        off,
        moves,
        scans: 0,
    };
    let port = lockstep(FakeBoard::new(Box::new(base)));
    let output = Command::cargo_bin("hexsense")
        .unwrap()
        .current_dir(folder.path())
        .args(["calibrate", "--port", &port, "--geometry", "an-74tk-200"])
        .args(["--sensors", "sensors.toml", "--out", "campaign"])
        .write_stdin("\n\n")
        .output()
        .unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{text}");
    let recorded = folder.path().join("campaign/captures/zero.csv").exists();
    assert_eq!(recorded, !text.contains("run zero broke off"), "{text}");
    text
}

/// The run after the zero run fails later: the base rests at home and does not follow.
const BEGAN: &str = "no jack has moved within 30 s of the start of run pitch";

#[test]
fn a_jack_twenty_millimetres_from_home_is_at_home_and_one_count_further_it_is_not() {
    for (jack, off, told) in [(3, 947, "+20.0 mm"), (6, -947, "-20.0 mm")] {
        let text = said(jack, off, 0);
        assert!(text.contains(BEGAN), "{text}");
        let text = said(jack, off + off.signum(), 0);
        let away = format!("jack {jack} stands {told} from home before run zero");
        assert!(text.contains(&away), "{text}");
    }
}

#[test]
fn a_jack_that_moves_by_half_a_millimetre_is_at_rest_and_one_count_more_is_movement() {
    let text = said(5, 0, 23);
    assert!(text.contains(BEGAN), "{text}");
    let text = said(5, 0, 24);
    let moves = "jack 5 still moves (0.5 mm in a second) after 60 s, so run zero cannot start";
    assert!(text.contains(moves), "{text}");
}
