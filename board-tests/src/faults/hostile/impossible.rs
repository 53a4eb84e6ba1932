//! Requests whose values are impossible, and sets that no board may keep.

use hexsense_core::channel::Triad;
use hexsense_core::harmonics::Drive;
use hexsense_core::records::{CoefficientSet, MAX_ENCODED};
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::{Refusal, Request, StreamContent};

/// Whether a refusal says what is wrong.
pub type Right = fn(Refusal) -> bool;

/// Requests whose values are impossible, with the refusal that each must get.
pub fn requests() -> Vec<(Request, Right)> {
    let drive = |increment, settle_blocks, blocks| Request::Drive {
        analyser: 0,
        drive: Drive {
            increment,
            block: BlockSize::Sixteen,
            settle_blocks,
            blocks,
        },
    };
    let slow = 1 << 40;
    let mut requests: Vec<(Request, Right)> = Vec::new();
    // Above Nyquist, above a tenth of the rate, at zero; no periods at all, and more than can be summed, or
    // settle.
    for increment in [
        u64::MAX,
        1 << 63,
        (1 << 63) + 1,
        u64::MAX / 9,
        u64::MAX / 150,
        0,
    ] {
        requests.push((drive(increment, 0, 1), |refusal| {
            matches!(refusal, Refusal::Drive(_))
        }));
    }
    for blocks in [0, u32::MAX] {
        requests.push((drive(slow, 0, blocks), |refusal| {
            matches!(refusal, Refusal::Drive(_))
        }));
    }
    for settle in [(1 << 21) + 1, u32::MAX] {
        requests.push((drive(slow, settle, 1), |refusal| {
            matches!(refusal, Refusal::Drive(_))
        }));
    }
    for hz in [0, 1, 999, 3_999, 4_001, 8_000, u32::MAX] {
        requests.push((Request::Rate(hz), |refusal| {
            matches!(refusal, Refusal::Rate { .. })
        }));
    }
    for analyser in [3, u8::MAX] {
        let channel = 0;
        requests.push((Request::Sums { analyser, channel }, |refusal| {
            matches!(refusal, Refusal::Analyser { .. })
        }));
    }
    for channel in [15, u8::MAX] {
        let analyser = 0;
        requests.push((Request::Sums { analyser, channel }, |refusal| {
            matches!(refusal, Refusal::Channel { .. })
        }));
    }
    for offset in [MAX_ENCODED as u16 + 1, u16::MAX] {
        requests.push((Request::ReadSet { offset }, |refusal| {
            matches!(refusal, Refusal::Offset { .. })
        }));
    }
    let everything = StreamContent {
        counts: true,
        values: true,
        pose: true,
    };
    requests.push((Request::Stream(everything), |refusal| {
        matches!(refusal, Refusal::LinkCapacity { .. })
    }));
    requests.push((Request::UploadCommit, |refusal| {
        refusal == Refusal::NoUpload
    }));
    let piece = Request::UploadChunk {
        offset: u16::MAX,
        bytes: [0xFF; 128].into_iter().collect(),
    };
    requests.push((piece, |refusal| refusal == Refusal::NoUpload));
    requests
}

/// Ways to make a set useless.
pub fn spoilt_sets() -> Vec<fn(&mut CoefficientSet)> {
    vec![
        |set| set.triads[Triad::AngularRate as usize].matrix[1][2] = f32::NAN,
        |set| set.triads[0].matrix[0][0] = f32::INFINITY,
        |set| set.triads[1].offset[2] = f32::NEG_INFINITY,
        |set| set.triads[2].offset_uncertainty[0] = -1.0,
        |set| set.triads[0].matrix = [[0.0; 3]; 3],
        |set| set.triads[0].delay_s = f32::NAN,
        |set| set.jacks.metres_per_count[5] = f32::NAN,
        |set| set.jacks.zero_length_m = f32::INFINITY,
        |set| set.base.upper[3][0] = f32::NAN,
        |set| set.base.length_max_m = 0.0,
    ]
}
