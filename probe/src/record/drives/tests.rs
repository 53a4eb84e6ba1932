use super::*;
use crate::known_board;
use crate::plan::{Freedom, Purpose, SineEntry};
use hexsense_core::harmonics::choice::MAX_TURN;

const COUNTS: StreamContent = StreamContent {
    counts: true,
    values: false,
    pose: false,
};
const ALL: StreamContent = StreamContent {
    counts: true,
    values: true,
    pose: true,
};

fn run(frequency_hz: f64) -> Run {
    let entry = SineEntry {
        freedom: Freedom::Heave,
        amplitude_deg: None,
        amplitude_m: Some(0.01),
        frequency_hz,
        fade_s: 2.0,
        settle_s: 2.0,
        estimate_s: (3.0 / frequency_hz).max(3.0),
    };
    Run {
        name: "heave".to_owned(),
        purpose: Purpose::Calibrate,
        rest_s: None,
        ramps: Vec::new(),
        sine: vec![entry],
        multisine: None,
    }
}

fn sensors(lines: &str) -> SensorFile {
    let papers = twin::papers::sensor_file(1);
    let kept = papers.lines().filter(|line| !line.starts_with("lines_hz"));
    let text: String = kept.flat_map(|line| [line, "\n"]).collect();
    SensorFile::parse("sensors.toml", &format!("{lines}\n{text}")).unwrap()
}

fn chosen(frequency_hz: f64, rate_hz: u32, lines: &str) -> Result<BlockSize, NoChoice> {
    DriveChoice::new(&run(frequency_hz), &sensors(lines), rate_hz, COUNTS)
        .map(|choice| choice.block)
}

#[test]
fn every_drive_from_a_hundredth_to_fifty_hertz_is_taken_at_every_rate_in_the_block_that_it_allows()
{
    for frequency_hz in [
        0.01, 0.03, 0.1, 0.5, 1.0, 2.5, 5.0, 7.7, 10.0, 20.0, 33.0, 50.0,
    ] {
        for rate_hz in known_board::FACTS.rates_hz {
            let block =
                |lines| DriveChoice::new(&run(frequency_hz), &sensors(lines), rate_hz, COUNTS);
            let choice = block("lines_hz = []").unwrap();
            let turn = |scans| 5.0 * frequency_hz * scans as f64 / f64::from(rate_hz);
            let scans = choice.block.scans();
            assert!(turn(scans) <= MAX_TURN || scans == 1);
            // The run's own frequency may forbid the largest.
            let allowed = [1, 4, 8, 16, 32]
                .into_iter()
                .rfind(|scans| turn(*scans) <= MAX_TURN);
            assert!(scans <= allowed.unwrap_or(1));
            let drive = choice.lines[0].drive(rate_hz, choice.block, 7).unwrap();
            drive.check().unwrap();
            block("").unwrap();
        }
    }
    assert_eq!(chosen(50.0, 1_000, "lines_hz = []"), Ok(BlockSize::One));
    assert_eq!(chosen(9.9, 4_000, "lines_hz = []"), Ok(BlockSize::Four));
}

#[test]
fn the_block_keeps_known_disturbances_off_the_harmonics() {
    // 16 scans at 1 kHz come at 62.5 Hz: 59.5 Hz is the third harmonic of 1 Hz below it; 8 scans come at 125 Hz.
    assert_eq!(
        chosen(0.5, 1_000, "lines_hz = []").unwrap(),
        BlockSize::ThirtyTwo
    );
    assert_eq!(
        chosen(1.0, 1_000, "lines_hz = []").unwrap(),
        BlockSize::Sixteen
    );
    assert_eq!(
        chosen(1.0, 1_000, "lines_hz = [59.5]").unwrap(),
        BlockSize::Eight
    );
    // Multiples of a disturbance count.
    assert_eq!(
        chosen(1.0, 1_000, "lines_hz = [29.75]").unwrap(),
        BlockSize::Eight
    );
    // Mains of 50 Hz is what is expected where nothing is said.
    assert_eq!(
        chosen(1.0, 1_000, "").unwrap(),
        chosen(1.0, 1_000, "lines_hz = [50.0]").unwrap()
    );
}

#[test]
fn a_disturbance_forbids_a_block_and_no_stream() {
    // At 4 kHz blocks of 32 and 16 come at multiples of 125 Hz, blocks of 8 at 500 Hz.
    assert_eq!(
        chosen(1.0, 4_000, "lines_hz = [124.0]").unwrap(),
        BlockSize::Four
    );
    let error = DriveChoice::new(&run(1.0), &sensors(""), 4_000, ALL).unwrap_err();
    assert!(
        matches!(
            error,
            NoChoice::Link {
                refusal: Refusal::LinkCapacity { .. },
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn a_multisine_takes_the_largest_line_of_each_freedom() {
    let text = std::fs::read_to_string(
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/multisine-run.toml"),
    )
    .unwrap();
    let head = "geometry = \"\"\ngeometry_sha256 = \"\"\nperiod_s = 0.002\n";
    let plan = crate::plan::Plan::parse("plan.toml", &(head.to_owned() + &text)).unwrap();
    let choice = DriveChoice::new(&plan.runs[0], &sensors(""), 1_000, ALL).unwrap();
    let hertz: Vec<f64> = choice.lines.iter().map(|line| line.frequency_hz).collect();
    for (found, expected) in hertz.iter().zip([0.3, 0.4, 0.5]) {
        assert!((found - expected).abs() < 1e-12, "{hertz:?}");
    }
    assert_eq!(hertz.len(), ANALYSERS);
    assert!(
        choice
            .lines
            .iter()
            .all(|line| line.start_s == 15.0 && line.length_s == 20.0)
    );
}

#[test]
fn a_rest_is_taken_in_blocks_of_sixteen() {
    let rest = Run {
        rest_s: Some(10.0),
        sine: Vec::new(),
        ..run(1.0)
    };
    let choice = DriveChoice::new(&rest, &sensors(""), 4_000, COUNTS).unwrap();
    assert_eq!((choice.block, choice.lines.len()), (BlockSize::Sixteen, 0));
}

/// A sine of 1 Hz that is estimated over 4 s: a disturbance must stay 2/4 Hz away.
fn four_seconds(lines: &str) -> BlockSize {
    let mut run = run(1.0);
    run.sine[0].estimate_s = 4.0;
    DriveChoice::new(&run, &sensors(lines), 1_000, COUNTS)
        .unwrap()
        .block
}

#[test]
fn a_disturbance_may_be_two_reciprocals_of_the_estimate_from_a_harmonic_and_no_nearer() {
    // Blocks of 16 scans at 1 kHz come at 62.5 Hz; the fifth harmonics lie at 57.5 Hz and 67.5 Hz.
    for (far, near) in [(57.0, 57.0_f64.next_up()), (68.0, 68.0_f64.next_down())] {
        let with = |line: f64| four_seconds(&format!("lines_hz = [{line:?}]"));
        assert_eq!(with(far), BlockSize::Sixteen);
        assert_eq!(with(near), BlockSize::Eight);
    }
    // A third of a line's frequency is as near: multiples count up to the fifth.
    assert_eq!(four_seconds("lines_hz = [19.0]"), BlockSize::Sixteen);
    assert_eq!(four_seconds("lines_hz = [19.01]"), BlockSize::Eight);
}

#[test]
fn a_stream_may_take_all_of_the_line_that_is_for_telemetry_and_no_more() {
    // Counts of 15 channels at 4 kHz in frames of 16 scans: 250 frames a second of 42 + 16·30 + 16 characters of ten
    // bits are 1,345,000 bit/s, four fifths of 1,681,250.
    let mut sensors = sensors("");
    let mut judged = |baud| {
        sensors.board.baud = baud;
        carried(&sensors.board, COUNTS, 4_000, BlockSize::Sixteen)
    };
    assert_eq!(judged(1_681_250), Ok(()));
    let refused = Refusal::LinkCapacity {
        bits_per_s: 1_345_000,
        limit: 1_344_996,
    };
    assert_eq!(judged(1_681_245), Err(refused));
}
