//! Any message: proptest strategies for everything that travels.

use hexsense_core::channel::Triad;
use hexsense_core::harmonics::{ChannelSums, DriveError, Uncertainty};
use hexsense_core::live_motion::Motion;
use hexsense_core::records::Entry;
use hexsense_core::records::log::Reason;
use hexsense_core::records::{BaseError, RecordError, SetId};
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::change::{Act, Change, Key};
use hexsense_core::wire::message::{ActiveSet, CHUNK, ChannelHarmonics, Chunk, Kept};
use hexsense_core::wire::status::{EventCount, Events, PathCycles, ResetCause, Resets, StackUse};
use hexsense_core::wire::telemetry::{Block, Header, MAX_SCANS};
use hexsense_core::wire::{
    AnalyserState, BoardPose, Drive, Identity, PoseRefusal, PoseReport, Refusal, Request, Response,
    Status, StreamContent,
};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

pub fn request() -> impl Strategy<Value = Request> {
    prop_oneof![
        Just(Request::Identity),
        Just(Request::Status),
        content().prop_map(Request::Stream),
        any::<u32>().prop_map(Request::Rate),
        block_size().prop_map(Request::Block),
        (any::<u8>(), drive()).prop_map(|(analyser, drive)| Request::Drive { analyser, drive }),
        (any::<u8>(), any::<u8>())
            .prop_map(|(analyser, channel)| Request::Sums { analyser, channel }),
        Just(Request::ActiveSet),
        any::<u16>().prop_map(|offset| Request::ReadSet { offset }),
        any::<u8>().prop_map(|age| Request::History { age }),
        any::<u32>().prop_map(|counter| Request::Log { counter }),
        Just(Request::Challenge),
        (change(), any::<[u8; 32]>()).prop_map(|(change, tag)| Request::Change { change, tag }),
        (any::<u16>(), chunk()).prop_map(|(offset, bytes)| Request::UploadChunk { offset, bytes }),
        Just(Request::UploadCommit),
        Just(Request::UploadAbort),
        (any::<u8>(), any::<u8>())
            .prop_map(|(analyser, channel)| Request::Harmonics { analyser, channel }),
        any::<u8>().prop_map(|analyser| Request::Motion { analyser }),
    ]
}

pub fn response() -> impl Strategy<Value = Response> {
    let harmonics =
        (state(), drive(), any::<u64>(), sums()).prop_map(|(state, drive, first_scan, sums)| {
            Response::Sums {
                state,
                drive,
                first_scan,
                sums,
            }
        });
    prop_oneof![
        Just(Response::Done),
        refusal().prop_map(Response::Refused),
        identity().prop_map(Response::Identity),
        status().prop_map(Response::Status),
        harmonics,
        option::of(active_set()).prop_map(Response::ActiveSet),
        (any::<u16>(), chunk()).prop_map(|(offset, bytes)| Response::SetBytes { offset, bytes }),
        active_set().prop_map(Response::Committed),
        option::of(kept()).prop_map(Response::Kept),
        (any::<u32>(), vec(entry(), 0..=8)).prop_map(|(last, entries)| Response::Log {
            last,
            entries: entries.into_iter().collect(),
        }),
        any::<[u8; 16]>().prop_map(Response::Challenge),
        any::<u8>().prop_map(|sets| Response::Erased { sets }),
        (drive(), any::<u64>(), fit()).prop_map(|(drive, first_scan, fit)| Response::Harmonics {
            drive,
            first_scan,
            harmonics: fit,
        }),
        (drive(), any::<u64>(), motion()).prop_map(|(drive, first_scan, motion)| {
            Response::Motion {
                drive,
                first_scan,
                motion,
            }
        }),
    ]
}

fn fit() -> impl Strategy<Value = ChannelHarmonics> {
    any::<[f64; 6]>().prop_map(|[offset, drift, a, phase, residual_rms, distortion]| {
        ChannelHarmonics {
            offset,
            drift,
            amplitude: [a; 5],
            phase: [phase; 5],
            residual_rms,
            distortion,
            uncertainty: Uncertainty {
                offset,
                drift,
                amplitude: [phase; 5],
                phase: [a; 5],
            },
        }
    })
}

fn motion() -> impl Strategy<Value = Result<Motion, PoseRefusal>> {
    let moved = any::<([f32; 6], [f32; 9])>();
    prop_oneof![
        moved.prop_map(|(amplitude, factors)| Ok(Motion { amplitude, factors })),
        any::<u8>().prop_map(|jack| Err(PoseRefusal::NotFinite { jack })),
    ]
}

pub fn change() -> impl Strategy<Value = Change> {
    let act = prop_oneof![
        (any::<u16>(), any::<[u8; 32]>())
            .prop_map(|(length, digest)| Act::Upload { length, digest }),
        set_id().prop_map(Act::Rollback),
        Just(Act::FactoryReset),
        any::<[u8; 32]>().prop_map(|key| Act::Provision(Key(key))),
    ];
    (any::<u64>(), act).prop_map(|(unix_s, act)| Change { unix_s, act })
}

fn entry() -> impl Strategy<Value = Entry> {
    let reason = proptest::sample::select(vec![
        Reason::Upload,
        Reason::Rollback,
        Reason::FactoryReset,
        Reason::Provision,
        Reason::Fallback,
    ]);
    let ids = (option::of(set_id()), option::of(set_id()));
    (any::<u32>(), reason, any::<u64>(), ids).prop_map(
        |(counter, reason, unix_s, (id, previous))| Entry {
            counter,
            reason,
            unix_s,
            id,
            previous,
        },
    )
}

fn kept() -> impl Strategy<Value = Kept> {
    let times = (any::<u64>(), any::<u64>());
    (any::<u32>(), set_id(), any::<u16>(), times).prop_map(
        |(sequence, id, length, (made_unix_s, uploaded_unix_s))| Kept {
            sequence,
            id,
            length,
            made_unix_s,
            uploaded_unix_s,
        },
    )
}

pub fn refusal() -> impl Strategy<Value = Refusal> {
    let two = (any::<u16>(), any::<u16>());
    prop_oneof![
        Just(Refusal::Malformed),
        any::<u32>().prop_map(|hz| Refusal::Rate { hz }),
        (any::<u32>(), any::<u32>())
            .prop_map(|(bits_per_s, limit)| Refusal::LinkCapacity { bits_per_s, limit }),
        Just(Refusal::NoCrystal),
        drive_error().prop_map(Refusal::Drive),
        (any::<u8>(), any::<u8>()).prop_map(|(drive, board)| Refusal::OtherBlock { drive, board }),
        any::<u8>().prop_map(|analyser| Refusal::Analyser { analyser }),
        any::<u8>().prop_map(|channel| Refusal::Channel { channel }),
        Just(Refusal::NoSet),
        two.prop_map(|(offset, length)| Refusal::Offset { offset, length }),
        Just(Refusal::NoUpload),
        two.prop_map(|(length, limit)| Refusal::Length { length, limit }),
        any::<u16>().prop_map(|expected| Refusal::OutOfOrder { expected }),
        Just(Refusal::WrongIdentity),
        record_error().prop_map(Refusal::Record),
        Just(Refusal::OtherBoard),
        Just(Refusal::Flash),
        Just(Refusal::Unprovisioned),
        Just(Refusal::NoChallenge),
        Just(Refusal::WrongTag),
        any::<u32>().prop_map(|ms| Refusal::BackOff { ms }),
        Just(Refusal::Expired),
        Just(Refusal::NoSuchSet),
        Just(Refusal::AlreadyActive),
        Just(Refusal::LogFull),
        Just(Refusal::Log),
        Just(Refusal::Erasure),
        Just(Refusal::Random),
        Just(Refusal::Busy),
        any::<u8>().prop_map(|analyser| Refusal::Incomplete { analyser }),
        any::<u32>().prop_map(|blocks| Refusal::Undetermined { blocks }),
        Just(Refusal::EarlierLog),
    ]
}

pub fn block() -> impl Strategy<Value = Block> {
    header().prop_flat_map(|header| {
        let scans = usize::from(header.scans);
        let counts = vec(any::<[u16; 15]>(), scans).prop_map(|scans| scans.into_iter().collect());
        let values = vec(any::<[f32; 9]>(), scans).prop_map(|values| values.into_iter().collect());
        (counts, values).prop_map(move |(counts, values)| Block {
            header,
            counts: header.content.counts.then_some(counts),
            values: header.content.values.then_some(values),
        })
    })
}

pub fn header() -> impl Strategy<Value = Header> {
    (
        any::<u64>(),
        1..=MAX_SCANS as u8,
        any::<u32>(),
        any::<f32>(),
        any::<f32>(),
        option::of(set_id()),
        any::<u32>(),
        content(),
    )
        .prop_map(
            |(first_scan, scans, rate_hz, supply, temperature_c, set, dropped, content)| Header {
                first_scan,
                scans,
                rate_hz,
                supply,
                temperature_c,
                set,
                dropped,
                content,
            },
        )
}

fn record_error() -> impl Strategy<Value = RecordError> {
    let triad = proptest::sample::select(&Triad::ALL[..]);
    prop_oneof![
        any::<u32>().prop_map(|length| RecordError::Length { length }),
        (any::<u32>(), any::<u32>())
            .prop_map(|(stored, computed)| RecordError::Checksum { stored, computed }),
        Just(RecordError::Layout),
        triad
            .clone()
            .prop_map(|triad| RecordError::NotFinite { triad }),
        triad.prop_map(|triad| RecordError::Singular { triad }),
        base_error().prop_map(RecordError::Base),
        Just(RecordError::Temperature),
    ]
}

fn drive_error() -> impl Strategy<Value = DriveError> {
    prop_oneof![
        Just(DriveError::Frequency),
        any::<u8>().prop_map(|scans| DriveError::FifthHarmonic { scans }),
        any::<u32>().prop_map(|blocks| DriveError::Blocks { blocks }),
    ]
}

fn block_size() -> impl Strategy<Value = BlockSize> {
    proptest::sample::select(&BlockSize::ALL[..])
}

fn base_error() -> impl Strategy<Value = BaseError> {
    prop_oneof![
        Just(BaseError::NotFinite),
        Just(BaseError::Stroke),
        any::<u8>().prop_map(|jack| BaseError::Home { jack }),
        Just(BaseError::Degenerate),
        any::<u8>().prop_map(|jack| BaseError::Transducer { jack }),
    ]
}

pub fn pose_report() -> impl Strategy<Value = PoseReport> {
    let pose = (
        [any::<f32>(); 3],
        [any::<f32>(); 4],
        [any::<f32>(); 2],
        any::<u8>(),
    )
        .prop_map(|(position_m, rotation, bounds, iterations)| BoardPose {
            position_m,
            rotation,
            residual_m: bounds[0],
            condition_bound: bounds[1],
            iterations,
        });
    let outcome = prop_oneof![pose.prop_map(Ok), pose_refusal().prop_map(Err)];
    (any::<u64>(), block_size(), set_id(), outcome).prop_map(|(first_scan, block, set, outcome)| {
        PoseReport {
            first_scan,
            block,
            set,
            outcome,
        }
    })
}

fn pose_refusal() -> impl Strategy<Value = PoseRefusal> {
    prop_oneof![
        base_error().prop_map(PoseRefusal::Base),
        any::<u8>().prop_map(|jack| PoseRefusal::NotFinite { jack }),
        (any::<u8>(), any::<f32>())
            .prop_map(|(jack, length_m)| PoseRefusal::OutsideStroke { jack, length_m }),
        Just(PoseRefusal::Singular),
        any::<f32>().prop_map(|short_m| PoseRefusal::Unreachable { short_m }),
        any::<f32>().prop_map(|short_m| PoseRefusal::NoConvergence { short_m }),
        Just(PoseRefusal::BranchChanged),
        (any::<f32>(), any::<f32>()).prop_map(|(distance_m, angle_rad)| PoseRefusal::Jump {
            distance_m,
            angle_rad
        }),
    ]
}

fn status() -> impl Strategy<Value = Status> {
    let text = "[a-z µ]{0,64}".prop_map(|text| heapless::String::try_from(text.as_str()).unwrap());
    (
        (any::<u64>(), any::<u32>(), any::<u64>(), any::<u64>()),
        (
            block_size(),
            option::of(any::<u64>()),
            events(),
            option::of(any::<u64>()),
        ),
        ([any::<u32>(); 3], [state(), state(), state()]),
        (any::<f32>(), any::<u8>(), any::<f32>(), any::<bool>()),
        (resets(), [any::<u32>(); 2]),
        (
            [any::<bool>(); 2],
            option::of([any::<f32>(); 2]),
            option::of(text),
        ),
    )
        .prop_map(|(scans, converters, path, analog, starts, rest)| Status {
            uptime_ms: scans.0,
            rate_hz: scans.1,
            scans: scans.2,
            block: converters.0,
            scans_lost: scans.3,
            first_lost_scan: converters.1,
            events: converters.2,
            first_with_set_ms: converters.3,
            path_cycles: PathCycles {
                min: path.0[0],
                max: path.0[1],
                last: path.0[2],
            },
            analysers: path.1,
            crystal: rest.0[0],
            supply: analog.0,
            supply_readings: analog.1,
            temperature_c: analog.2,
            in_calibrated_range: analog.3,
            tilt_approximate_rad: rest.1,
            provisioned: rest.0[1],
            resets: starts.0,
            stack: StackUse {
                deepest: starts.1[0],
                size: starts.1[1],
            },
            panic: rest.2,
        })
}

fn events() -> impl Strategy<Value = Events> {
    [(any::<u32>(), any::<u64>()); 13].prop_map(|tallies| {
        let [a, b, c, d, e, f, g, h, i, j, k, l, m] =
            tallies.map(|(count, last_ms)| EventCount { count, last_ms });
        Events {
            overruns: a,
            late_blocks: b,
            stuck: c,
            blocks_dropped: d,
            frames_unsent: e,
            frames_not_cobs: f,
            frames_of_wrong_length: g,
            frames_of_wrong_checksum: h,
            frames_of_wrong_kind: i,
            receiver_overruns: j,
            receiver_errors: k,
            flash_corrections: l,
            torn_words: m,
        }
    })
}

fn resets() -> impl Strategy<Value = Resets> {
    ([any::<u32>(); 7], option::of(any::<u64>())).prop_map(|(counts, previous_uptime_ms)| {
        let [starts, brown_outs, pin, software, panics, watchdog, other] = counts;
        Resets {
            starts,
            brown_outs,
            pin,
            software,
            panics,
            watchdog,
            other,
            previous_uptime_ms,
        }
    })
}

fn identity() -> impl Strategy<Value = Identity> {
    let reset = prop_oneof![
        Just(ResetCause::PowerOn),
        Just(ResetCause::BrownOut),
        Just(ResetCause::Pin),
        Just(ResetCause::Software),
        Just(ResetCause::Panic),
        Just(ResetCause::Watchdog),
        Just(ResetCause::Other),
    ];
    ([any::<u8>(); 12], "[A-Z0-9-]{0,32}", reset).prop_map(|(board, hardware, reset)| Identity {
        board,
        hardware: heapless::String::try_from(hardware.as_str()).unwrap(),
        reset,
        facts: hexsense::FACTS,
    })
}

fn sums() -> impl Strategy<Value = ChannelSums> {
    (
        any::<i64>(),
        any::<i64>(),
        any::<u64>(),
        [any::<i64>(); 5],
        [any::<i64>(); 5],
    )
        .prop_map(|(offset, drift, square, cosine, sine)| ChannelSums {
            offset,
            drift,
            square,
            cosine,
            sine,
        })
}

fn drive() -> impl Strategy<Value = Drive> {
    (any::<u64>(), block_size(), any::<u32>(), any::<u32>()).prop_map(
        |(increment, block, settle_blocks, blocks)| Drive {
            increment,
            block,
            settle_blocks,
            blocks,
        },
    )
}

fn state() -> impl Strategy<Value = AnalyserState> {
    prop_oneof![
        Just(AnalyserState::Idle),
        Just(AnalyserState::Settling),
        Just(AnalyserState::Summing),
        Just(AnalyserState::Complete),
    ]
}

fn active_set() -> impl Strategy<Value = ActiveSet> {
    (set_id(), any::<u32>(), any::<u16>()).prop_map(|(id, sequence, length)| ActiveSet {
        id,
        sequence,
        length,
    })
}

fn content() -> impl Strategy<Value = StreamContent> {
    [any::<bool>(); 3].prop_map(|[counts, values, pose]| StreamContent {
        counts,
        values,
        pose,
    })
}

fn set_id() -> impl Strategy<Value = SetId> {
    [any::<u8>(); 8].prop_map(SetId)
}

fn chunk() -> impl Strategy<Value = Chunk> {
    vec(any::<u8>(), 0..=CHUNK).prop_map(|bytes| Chunk::from_slice(&bytes).unwrap())
}
