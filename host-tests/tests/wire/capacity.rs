//! The largest messages fit their frames, and the stated need of a stream is not too small.

use hexsense::FACTS;
use hexsense_core::channel::{INERTIAL, JACKS};
use hexsense_core::records::SetId;
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::frame::{self, Closed, Deframer, FrameError};
use hexsense_core::wire::telemetry::{self, Header, MAX_SCANS, Samples};
use hexsense_core::wire::{
    BoardPose, Kind, MAX_FRAME, MAX_PAYLOAD, PoseReport, StreamContent, pose,
};

/// The block with the most bytes: no varint is short, and no zero saves COBS a byte.
fn largest_block(content: StreamContent, scans: usize) -> usize {
    let header = Header {
        first_scan: u64::MAX,
        scans: scans as u8,
        rate_hz: u32::MAX,
        supply: -1.999_999_9,
        temperature_c: -1.999_999_9,
        set: Some(SetId([0xFF; 8])),
        dropped: u32::MAX,
        content,
        supply_is_old: true,
    };
    let samples = Samples {
        inertial: &[[0xFFFF; INERTIAL]; MAX_SCANS],
        jacks: &[[0xFFFF; JACKS]; MAX_SCANS],
        values: &[[-1.999_999_9; INERTIAL]; MAX_SCANS],
    };
    telemetry::encode(&header, samples, 0xFFFF, &mut [0; MAX_FRAME]).unwrap()
}

/// The pose with the most bytes.
fn largest_pose() -> usize {
    let report = PoseReport {
        first_scan: u64::MAX,
        block: BlockSize::ThirtyTwo,
        set: SetId([0xFF; 8]),
        outcome: Ok(BoardPose {
            position_m: [-1.999_999_9; 3],
            rotation: [-1.999_999_9; 4],
            residual_m: -1.999_999_9,
            condition_bound: -1.999_999_9,
            iterations: u8::MAX,
        }),
    };
    pose::encode(&report, 0xFFFF, &mut [0; MAX_FRAME]).unwrap()
}

fn contents() -> [StreamContent; 8] {
    std::array::from_fn(|content| StreamContent {
        counts: content & 1 != 0,
        values: content & 2 != 0,
        pose: content & 4 != 0,
    })
}

#[test]
fn the_longest_pose_has_the_stated_length() {
    // Kind and sequence number 3, checksum 4, COBS 1, closing zero 1.
    assert_eq!(largest_pose(), pose::MAX_REPORT + 9);
}

#[test]
fn the_largest_block_fits_a_frame() {
    assert!(largest_block(contents()[7], MAX_SCANS) <= MAX_FRAME);
}

#[test]
fn capacity_is_an_upper_bound_of_real_frames_and_a_close_one() {
    for content in contents() {
        for (rate_hz, block) in FACTS
            .rates_hz
            .into_iter()
            .flat_map(|rate_hz| BlockSize::ALL.map(|block| (rate_hz, block)))
        {
            let scans = telemetry::scans_of_frame(
                content,
                rate_hz,
                block,
                FACTS.max_telemetry_bits_per_s(),
            );
            let (mut frames_hz, blocks_hz) = (
                f64::from(rate_hz) / scans as f64,
                f64::from(rate_hz) / block.scans() as f64,
            );
            let mut needed = 0.0;
            if content.counts || content.values {
                needed += largest_block(content, scans) as f64 * 10.0 * frames_hz;
                if scans > block.scans() {
                    // With each reading of the supply a frame ends early, and the next at the end of the ring.
                    needed += 20.0 * largest_block(StreamContent::default(), 0) as f64 * 10.0;
                    frames_hz += 20.0;
                }
            }
            if content.pose {
                needed += largest_pose() as f64 * 10.0 * blocks_hz.min(100.0);
            }
            let stated = f64::from(telemetry::bits_per_second(
                content,
                rate_hz,
                block,
                FACTS.max_telemetry_bits_per_s(),
            ));
            assert!(
                stated >= needed,
                "{content:?} at {rate_hz} Hz: {stated} < {needed}"
            );
            let spare = (stated - needed) / 10.0 / frames_hz;
            assert!(spare < 20.0, "{spare} bytes a frame are not needed");
        }
    }
}

#[test]
fn a_stream_that_goes_in_one_block_goes_in_every_block() {
    let fits = |content, rate_hz, block| {
        telemetry::bits_per_second(content, rate_hz, block, FACTS.max_telemetry_bits_per_s())
            <= FACTS.max_telemetry_bits_per_s()
    };
    for content in contents() {
        for rate_hz in FACTS.rates_hz {
            let large = fits(content, rate_hz, BlockSize::ThirtyTwo);
            let too_much = content.values && (content.counts || content.pose) && rate_hz == 4_000;
            assert_eq!(large, !too_much, "{content:?} at {rate_hz} Hz");
            for block in BlockSize::ALL {
                assert_eq!(
                    fits(content, rate_hz, block),
                    large,
                    "{content:?} in {block:?} at {rate_hz} Hz"
                );
            }
        }
    }
}

#[test]
fn a_frame_gathers_no_more_than_the_line_needs() {
    let counts = contents()[1];
    let scans = |rate_hz| {
        BlockSize::ALL.map(|block| {
            telemetry::scans_of_frame(counts, rate_hz, block, FACTS.max_telemetry_bits_per_s())
        })
    };
    assert_eq!(scans(1_000), [1, 4, 8, 16, 16]);
    assert_eq!(scans(2_000), [4, 4, 8, 16, 16]);
    assert_eq!(scans(4_000), [8, 8, 8, 16, 16]);
    // Without samples there is nothing to gather.
    let pose = telemetry::scans_of_frame(
        contents()[4],
        4_000,
        BlockSize::One,
        FACTS.max_telemetry_bits_per_s(),
    );
    assert_eq!(pose, 1);
}

#[test]
fn the_longest_payload_fits_and_one_more_byte_is_refused() {
    let mut out = [0; MAX_FRAME];
    let length = frame::encode(Kind::Block, 0xFFFF, &mut out, |payload| {
        payload.fill(0xFF);
        Some(payload.len())
    })
    .unwrap();
    let mut deframer = Deframer::<MAX_FRAME>::default();
    let closed = out[..length]
        .iter()
        .find_map(|byte| match deframer.push(*byte)? {
            Closed::Frame(bytes) => Some(frame::decode(bytes).map(|frame| frame.payload.len())),
            Closed::Overlong => None,
        });
    assert_eq!(closed, Some(Ok(MAX_PAYLOAD)));

    let refused = Err(FrameError::Long {
        length: MAX_PAYLOAD + 1,
    });
    let too_long = frame::encode(Kind::Block, 0, &mut out, |_| Some(MAX_PAYLOAD + 1));
    assert_eq!(too_long, refused);
    assert_eq!(frame::encode(Kind::Block, 0, &mut out, |_| None), refused);
}

#[test]
fn a_buffer_that_is_too_short_is_refused() {
    let frame = |out: &mut [u8]| frame::encode(Kind::Hello, 0, out, |_| Some(0));
    let needed = frame(&mut [0; MAX_FRAME]).unwrap();
    for length in 0..needed {
        assert_eq!(
            frame(&mut vec![0; length]),
            Err(FrameError::Long { length: 0 })
        );
    }
    assert_eq!(frame(&mut vec![0; needed]), Ok(needed));
}
