use super::*;
use crate::capture::Capture;
use hexsense_core::channel::Ratiometric;
use hexsense_core::excitation::Program;

/// Ten scans at 4 Hz of a base at rest; scan n of channel c counts 100·c + n, at a supply factor of a half, which does not
/// act on channel 4.
fn rest() -> RecordedRun {
    let scan = |n: u64| core::array::from_fn(|channel| 100 * channel as u16 + n as u16);
    RecordedRun {
        name: "zero".to_owned(),
        program: Program::default(),
        capture: Capture {
            scans: (40..50).collect(),
            counts: (0..10).map(scan).collect(),
            supply: vec![0.5; 10],
            temperature_c: vec![30.0; 10],
            values: None,
        },
        rate_hz: 4,
        ratiometric: Ratiometric::NONE.with(4),
    }
}

#[test]
fn a_single_missing_scan_is_a_gap_and_none_is_not() {
    assert!(Counts::new(&rest()).is_ok());
    let mut run = rest();
    run.capture.scans[7..]
        .iter_mut()
        .for_each(|scan| *scan += 1);
    let Err(error) = Counts::new(&run) else {
        panic!("the gap is not seen");
    };
    let told = "run zero: 1 scans are missing from scan 47 on; repeat the run";
    assert_eq!(error.to_string(), told);
}

#[test]
fn a_stretch_may_end_with_the_capture_and_not_a_scan_later() {
    let run = rest();
    let counts = Counts::new(&run).unwrap();
    assert_eq!(counts.stretch(0.0, 2.5).unwrap(), 0..10);
    let error = counts.stretch(0.0, 2.75).unwrap_err().to_string();
    let told = "run zero: the capture ends 0.2 s before the program does; repeat the run";
    assert_eq!(error, told);
}

#[test]
fn the_mean_of_a_stretch_is_over_its_scans_at_nominal_supply() {
    let run = rest();
    // Scans 4 to 7, from 1 s to 2 s of a capture that begins 10 s after the board's start.
    let rest = Counts::new(&run).unwrap().rest(1.0, 2.0).unwrap();
    assert_eq!((rest.time_s, rest.length_s), (11.5, 1.0));
    for (channel, mean) in rest.counts.into_iter().enumerate() {
        let factor = if channel == 4 { 1.0 } else { 0.5 };
        assert!((mean - factor * (100.0 * channel as f64 + 5.5)).abs() < 1e-9);
    }
}

#[test]
fn the_rest_before_a_movement_counts_when_more_than_a_second_of_it_is_left() {
    assert_eq!(before(1.4), None);
    let (from_s, to_s) = before(1.4_f64.next_up()).unwrap();
    assert_eq!((from_s, to_s), (0.2, 1.4_f64.next_up() - 0.2));
}
