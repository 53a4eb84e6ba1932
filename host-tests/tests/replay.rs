//! The board's sums, made again from a capture file: equal in every integer, or refused by name.

use std::path::Path;

use hexsense_core::channel::{CHANNELS, Scan};
use hexsense_core::harmonics::{ANALYSERS, Analyser, Drive, increment};
use hexsense_core::sampling::{BlockSize, BlockSums};
use hexsense_core::wire::StreamContent;
use hexsense_core::wire::telemetry::{Block, Header, MAX_SCANS};
use hexsense_probe::campaign::BoardSums;
use hexsense_probe::capture::{Capture, CaptureWriter};
use hexsense_probe::replay::{ReplayError, replay};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A board's work in one run: three analysers on its scans, and all scans sent to the host except those of `lost`, a
/// range of scan counters.
fn recorded(
    block: BlockSize,
    rate_hz: u32,
    lost: std::ops::Range<u64>,
    file: &Path,
) -> (Capture, Vec<BoardSums>) {
    let mut random = ChaCha8Rng::seed_from_u64(block.scans() as u64);
    let mut analysers: [Analyser; ANALYSERS] = Default::default();
    for (analyser, frequency_hz) in analysers.iter_mut().zip([0.37, 1.0, 2.9]) {
        analyser.start(Drive {
            increment: increment(frequency_hz, rate_hz).unwrap(),
            block,
            settle_blocks: random.random_range(0..9),
            blocks: random.random_range(40..90),
        });
    }
    let mut writer = CaptureWriter::create(file, false).unwrap();
    let start = 5_000_000_017;
    for first_scan in (start..).step_by(block.scans()).take(120) {
        let scans: Vec<Scan> = (0..block.scans()).map(|_| counts(&mut random)).collect();
        for analyser in &mut analysers {
            analyser.take(&BlockSums::of_scans(&scans, first_scan));
        }
        let first_scans = (first_scan..).step_by(MAX_SCANS);
        for (scans, first_scan) in scans.chunks(MAX_SCANS).zip(first_scans) {
            if !lost.contains(&(first_scan - start)) {
                writer.push(&sent(scans, first_scan, rate_hz)).unwrap();
            }
        }
    }
    writer.finish().unwrap();
    let sums = analysers.iter().map(|analyser| {
        let (drive, first_scan, _) = analyser.report(0).unwrap();
        let of_channel = |channel| analyser.report(channel).unwrap().2;
        BoardSums {
            drive,
            first_scan,
            channels: std::array::from_fn::<_, CHANNELS, _>(of_channel),
        }
    });
    (Capture::load(file).unwrap(), sums.collect())
}

fn counts(random: &mut impl Rng) -> Scan {
    std::array::from_fn(|_| random.random())
}

/// A block as the host gets it.
fn sent(scans: &[Scan], first_scan: u64, rate_hz: u32) -> Block {
    let header = Header {
        first_scan,
        scans: scans.len() as u8,
        rate_hz,
        supply: 1.000_1,
        temperature_c: 30.0,
        set: None,
        dropped: 0,
        content: StreamContent {
            counts: true,
            ..StreamContent::default()
        },
        supply_is_old: false,
    };
    Block {
        header,
        counts: Some(scans.iter().copied().collect()),
        values: None,
    }
}

#[test]
fn every_sum_of_three_analysers_in_every_block_is_made_again_from_the_file() {
    let folder = tempfile::tempdir().unwrap();
    for block in BlockSize::ALL {
        for rate_hz in [1_000, 4_000] {
            let (capture, sums) = recorded(block, rate_hz, 0..0, &folder.path().join("run.csv"));
            assert_eq!(sums.len(), ANALYSERS);
            for sums in &sums {
                replay(sums, &capture).unwrap_or_else(|error| panic!("{block:?}: {error}"));
            }
        }
    }
}

#[test]
fn a_sum_that_is_off_by_one_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let (capture, sums) = recorded(BlockSize::Four, 1_000, 0..0, &folder.path().join("run.csv"));
    let spoilt = |change: &dyn Fn(&mut BoardSums)| {
        let mut sums = sums[1].clone();
        change(&mut sums);
        replay(&sums, &capture).unwrap_err().to_string()
    };
    let says = |text: String, part: &str| assert!(text.starts_with(part), "{text}");
    says(
        spoilt(&|sums| sums.channels[0].offset += 1),
        "ax, sum offset:",
    );
    says(
        spoilt(&|sums| sums.channels[8].drift -= 1),
        "wz, sum drift:",
    );
    says(
        spoilt(&|sums| sums.channels[14].square += 1),
        "jack6, sum square:",
    );
    says(
        spoilt(&|sums| sums.channels[9].cosine[4] += 1),
        "jack1, sum cosine 5:",
    );
    says(
        spoilt(&|sums| sums.channels[4].sine[0] -= 1),
        "ey, sum sine 1:",
    );
    // The sums of the next block have other scans.
    assert!(spoilt(&|sums| sums.first_scan += 4).contains("the scans of the capture give"));
}

#[test]
fn a_gap_in_the_window_is_told_and_one_outside_does_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let (whole, sums) = recorded(BlockSize::Eight, 1_000, 0..0, &file);
    let window = sums[0].first_scan..sums[0].first_scan + 8 * u64::from(sums[0].drive.blocks);
    let start = whole.scans[0];
    let inside = window.start - start + 16;
    let (capture, again) = recorded(BlockSize::Eight, 1_000, inside..inside + 8, &file);
    assert_eq!(again, sums, "the board lost nothing");
    let expected = ReplayError::Missing {
        first: window.start,
        last: window.end - 1,
    };
    assert_eq!(replay(&sums[0], &capture), Err(expected));
    let after = window.end - start;
    let (capture, _) = recorded(BlockSize::Eight, 1_000, after..after + 8, &file);
    assert_eq!(capture.gaps().len(), 1);
    replay(&sums[0], &capture).unwrap();
}
