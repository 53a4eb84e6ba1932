use super::*;
use crate::cli::documents::assert_same;
use hexsense_core::harmonics::ChannelSums;
use hexsense_core::records::SetId;
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::Drive;
use hexsense_core::wire::status::{EventCount, Events, OptionBytes, Resets};

/// Counts that are powers of two tell in every sum what was added.
fn events() -> Events {
    let mut number = 0;
    let mut event = || {
        number += 1;
        EventCount {
            count: 1 << (number - 1),
            last_ms: 1_001 * number,
        }
    };
    Events {
        overruns: event(),
        late_blocks: event(),
        stuck: event(),
        blocks_dropped: event(),
        frames_unsent: event(),
        frames_not_cobs: event(),
        frames_of_wrong_length: event(),
        frames_of_wrong_checksum: event(),
        frames_of_wrong_kind: event(),
        receiver_overruns: event(),
        receiver_errors: event(),
        flash_corrections: event(),
        torn_words: EventCount::NONE,
        supply_refused: event(),
        coefficients_restored: event(),
        wrong_tags: event(),
        changes_refused: event(),
        requests_refused: event(),
        slips: event(),
    }
}

fn report(state: AnalyserState, increment: u64, block: BlockSize, blocks: u32) -> SumsReport {
    SumsReport {
        state,
        drive: Drive {
            increment,
            block,
            settle_blocks: 3,
            blocks,
        },
        first_scan: 244_000,
        sums: ChannelSums::default(),
    }
}

fn reading() -> Reading {
    let status = BoardStatus {
        uptime_ms: 123_456,
        rate_hz: 2_000,
        scans: 245_000,
        block: BlockSize::Eight,
        scans_lost: 12,
        first_lost_scan: Some(7_000),
        events: events(),
        first_with_set_ms: Some(321),
        path_cycles: PathCycles {
            min: 3_000,
            max: 4_800,
            last: 4_500,
        },
        analysers: [
            AnalyserState::Idle,
            AnalyserState::Settling,
            AnalyserState::Summing,
        ],
        crystal: false,
        supply: 0.75,
        supply_readings: 5,
        temperature_c: 45.5,
        in_calibrated_range: false,
        tilt_approximate_rad: Some([0.125, -0.25]),
        resets: Resets {
            starts: 22,
            brown_outs: 1,
            pin: 2,
            software: 3,
            panics: 4,
            watchdog: 5,
            other: 6,
            previous_uptime_ms: Some(98_700),
            crystal: 7,
        },
        stack: StackUse {
            deepest: 5_120,
            size: 8_192,
        },
        provisioned: true,
        panic: Some("index out of bounds".try_into().unwrap()),
        option_bytes: OptionBytes {
            dual_bank: true,
            readout_protection: 2,
            brown_out_level: 3,
            write_protected: [None, Some((64, 127)), None, None],
        },
        supply_is_old: false,
        key_damaged: false,
        log_used: Some(3_348),
    };
    Reading {
        status,
        last_start: ResetCause::Watchdog,
        // 80 % of it are for telemetry: 1 Mbit/s.
        facts: BoardFacts {
            baud: 1_250_000,
            nominal_supply_v: 3.5,
            ..crate::known_board::facts()
        },
        active: Some(ActiveSet {
            id: SetId([1, 2, 3, 4, 5, 6, 7, 0xab]),
            sequence: 42,
            length: 777,
        }),
        // 2⁵² and 2⁵¹ of 2⁶⁴ are a 4096th and an 8192nd of 2000 Hz.
        analysers: vec![
            report(AnalyserState::Idle, 0, BlockSize::One, 11),
            report(AnalyserState::Settling, 1 << 52, BlockSize::Four, 300),
            report(AnalyserState::Summing, 1 << 51, BlockSize::Sixteen, 500),
        ],
    }
}

#[test]
fn every_line_has_its_figures_and_units() {
    // A block is 4 ms; 4800 cycles at 150 MHz are 32 µs, 0.8 % of it. 1012 scans since the first are 63 whole blocks of
    // 16, and 437 are left. A frame of 8 scans has 58 bytes and 30 for the counts of each: 74.5 % of 1 Mbit/s.
    let expected = "\
uptime         123.5 s
scans          245000 at 2000 Hz in blocks of 8
restarts       of the converters (131079 times after a fault): 12 scans passed meanwhile, the first was scan 7000; what a recording lost stands in its note
event          1 converter overruns, last 1.001 s after the start
event          2 blocks read too late, last 2.002 s after the start
event          4 stops of the converters, last 3.003 s after the start
event          8 blocks that the link had no room for, last 4.004 s after the start
event          16 frames that could not be sent, last 5.005 s after the start
event          32 received frames that were not COBS, last 6.006 s after the start
event          64 received frames of a wrong length, last 7.007 s after the start
event          128 received frames with a wrong checksum, last 8.008 s after the start
event          256 received frames of a wrong kind, last 9.009 s after the start
event          512 overruns of the receiver, last 10.010 s after the start
event          1024 framing errors or noise on the line, last 11.011 s after the start
event          2048 bits of flash corrected, last 12.012 s after the start
event          131072 results of converters lost or doubled, last 18.018 s after the start
event          4096 readings of supply and temperature refused, last 13.013 s after the start
event          8192 times that the coefficients at work were damaged and read from flash again, last 14.014 s after the start
event          16384 changes refused because they came without the board's key, last 15.015 s after the start
event          32768 changes refused for another reason, last 16.016 s after the start
event          65536 other requests refused, last 17.017 s after the start
sample path    3000 cycles (20.0 µs) to 4800 cycles (32.0 µs), latest 4500 cycles (30.0 µs); at most 0.80 % of a block's 4.0 ms
analyser 0     idle
analyser 1     0.488281 Hz, settling, 300 of 300 blocks left
analyser 2     0.244141 Hz, summing, 437 of 500 blocks left
link           of 1.0 Mbit/s for telemetry, counts take 74 %, counts and values do not fit, counts, values and pose do not fit; 8 blocks dropped, 480 damaged frames
clock          internal oscillator, about 1 % off: not fit to calibrate
supply         2.625 V, settling: mean of 5 readings of 16
temperature    45.5 °C, more than 10 K from the calibration: calibrate again
tilt, rough    roll 7.2°, pitch -14.3°
key            provisioned; the board takes changes only with its key
coefficients   set 01020304050607ab, uploaded with change 42
log            3348 of 3720 entries, nearly full; export it and begin its next volume with `hexsense log --export FILE --new-volume`
last start     watchdog: a part of the board made no progress, after 98.7 s
starts         22 since power-on; resets: 1 by dips of the supply, 2 by the pin, 3 by software, 4 by panics, 5 by the watchdog, 6 by others, 7 by failures of the crystal
stack          5120 of 8192 bytes used at most
option bytes   two banks of flash, readout protection level 2, protected from writing: WRP1B pages 64 to 127, brown-out level 3 (2.5 V)
last panic     index out of bounds
";
    assert_eq!(reading().table(), expected);
}

#[test]
fn a_board_at_its_best_says_so() {
    let mut reading = reading();
    reading.active = None;
    let status = &mut reading.status;
    (status.crystal, status.supply_readings, status.provisioned) = (true, 16, false);
    (
        status.panic,
        status.tilt_approximate_rad,
        status.first_lost_scan,
    ) = (None, None, None);
    status.path_cycles = PathCycles::default();
    status.resets = Resets {
        starts: 1,
        ..Resets::default()
    };
    status.events = Events::NONE;
    let text = reading.table();
    for line in [
        "restarts       of the converters (rate or block changed; none after a fault): 12 scans passed meanwhile; what a recording lost stands in its note\nsample path    not measured yet\n",
        "clock          crystal\nsupply         2.625 V\ntemperature    45.5 °C\nkey            NONE: the board takes no changes",
        "coefficients   none; calibrate and upload a set\n",
        "starts         1 since power-on; no reset\n",
        "last panic     none\n",
    ] {
        assert!(text.contains(line), "{line:?} in {text}");
    }
    let mut reading = self::reading();
    reading.status.in_calibrated_range = true;
    assert!(
        reading
            .table()
            .contains("45.5 °C, within 10 K of the calibration\n")
    );
}

#[test]
fn a_supply_that_is_old_or_not_known_is_no_figure_to_rely_on() {
    let mut reading = reading();
    reading.status.supply_is_old = true;
    let text = reading.table();
    assert!(
        text.contains("readings of 16, OLD: no good reading for a second. Recordings are refused"),
        "{text}"
    );
    reading.status.supply_readings = 0;
    let text = reading.table();
    assert!(
        text.contains("\nsupply         not known yet, OLD: no good reading"),
        "{text}"
    );
    assert!(text.contains("\ntemperature    not known yet\n"), "{text}");
    let document = reading.to_json();
    assert!(document["supply_v"].is_null() && document["temperature_c"].is_null());
    assert_eq!(document["supply_is_old"], true);
}

#[test]
fn the_document_has_every_figure_under_its_key() {
    let event = |count: u32, last_s: f64| json!({"count": count, "last_uptime_s": last_s});
    let expected = json!({
        "uptime_s": 123.456,
        "rate_hz": 2_000,
        "block": 8,
        "scans": 245_000,
        "scans_lost": 12,
        "first_lost_scan": 7_000,
        "faults": 131_079,
        "events": {
            "overruns": event(1, 1.001),
            "late_blocks": event(2, 2.002),
            "stuck": event(4, 3.003),
            "blocks_dropped": event(8, 4.004),
            "frames_unsent": event(16, 5.005),
            "frames_not_cobs": event(32, 6.006),
            "frames_of_wrong_length": event(64, 7.007),
            "frames_of_wrong_checksum": event(128, 8.008),
            "frames_of_wrong_kind": event(256, 9.009),
            "receiver_overruns": event(512, 10.010),
            "receiver_errors": event(1_024, 11.011),
            "flash_corrections": event(2_048, 12.012),
            "torn_words": {"count": 0, "last_uptime_s": null},
            "slips": event(131_072, 18.018),
            "supply_refused": event(4_096, 13.013),
            "coefficients_restored": event(8_192, 14.014),
            "wrong_tags": event(16_384, 15.015),
            "changes_refused": event(32_768, 16.016),
            "requests_refused": event(65_536, 17.017),
        },
        "first_with_set_ms": 321,
        "sample_path": {
            "min": {"cycles": 3_000, "us": 20.0, "block_percent": 0.5},
            "max": {"cycles": 4_800, "us": 32.0, "block_percent": 0.8},
            "last": {"cycles": 4_500, "us": 30.0, "block_percent": 0.75},
        },
        "analysers": [
            {"state": "idle", "frequency_hz": null, "blocks": 11, "blocks_left": 0},
            {"state": "settling", "frequency_hz": 0.488_281_25, "blocks": 300, "blocks_left": 300},
            {"state": "summing", "frequency_hz": 0.244_140_625, "blocks": 500, "blocks_left": 437},
        ],
        // Counts and values: frames of 16 scans, 1114 bytes, 125 times a second, and 20 frames of 58 bytes that end early;
        // poses: 73 bytes, 100 times a second.
        "link": {
            "limit_bits_per_s": 1_000_000,
            "load_percent": {"counts": 74.5, "counts and values": 140.41, "counts, values and pose": 147.71},
            "blocks_dropped": 8,
            "frames_damaged": 480,
        },
        "clock": "internal",
        "supply_v": 2.625,
        "supply_readings": 5,
        "supply_is_old": false,
        "temperature_c": 45.5,
        "in_calibrated_range": false,
        "tilt_approximate_rad": [0.125, -0.25],
        "provisioned": true,
        "key_damaged": false,
        "set": {"id": "01020304050607ab", "sequence": 42},
        "start": {
            "cause": "watchdog",
            "starts": 22,
            "brown_outs": 1,
            "pin": 2,
            "software": 3,
            "panics": 4,
            "watchdog": 5,
            "other": 6,
            "crystal": 7,
            "previous_uptime_s": 98.7,
        },
        "stack": {"deepest_bytes": 5_120, "bytes": 8_192},
        "log": {"used": 3_348, "capacity": 3_720},
        "panic": "index out of bounds",
        "option_bytes": {
            "dual_bank": true,
            "readout_protection": 2,
            "brown_out_level": 3,
            "write_protected": [{"area": "WRP1B", "first_page": 64, "last_page": 127}],
            "changes_allowed": true,
        },
    });
    assert_same(&reading().to_json(), &expected);
}

#[test]
fn scans_that_pass_while_the_rate_changes_are_no_losses_of_a_recording() {
    assert_eq!(restarts(0, None, 0), "none since the start");
    let changed = restarts(21, Some(4_096), 0);
    assert!(
        changed.contains("rate or block changed; none after a fault"),
        "{changed}"
    );
    assert!(
        changed.contains("21 scans passed meanwhile, the first was scan 4096"),
        "{changed}"
    );
    assert!(
        !changed.contains("21 lost") && !changed.contains("lost 21"),
        "{changed}"
    );
    assert!(restarts(40, Some(7), 2).contains("2 times after a fault"));
}

#[test]
fn a_log_tells_what_to_do_from_nine_tenths_on() {
    let told = |used| log(Some(used), 3_720);
    assert_eq!(told(3_347), "3347 of 3720 entries");
    for (used, word) in [
        (3_348, "nearly full"),
        (3_719, "nearly full"),
        (3_720, "FULL"),
        (3_736, "FULL"),
    ] {
        let told = told(used);
        assert!(
            told.contains(word) && told.contains("--new-volume"),
            "{told}"
        );
    }
}
