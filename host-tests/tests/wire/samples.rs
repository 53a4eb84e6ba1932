//! One message of every kind, with numbers whose bytes are all different, as lines: kind, name, and frame in hexadecimal.

use std::fmt::Write;

use hexsense_core::channel::Triad;
use hexsense_core::facts::{BoardFacts, FlashLayout};
use hexsense_core::harmonics::{ChannelSums, DriveError, Uncertainty};
use hexsense_core::live_motion::Motion;
use hexsense_core::records::Entry;
use hexsense_core::records::log::{Chain, Reason};
use hexsense_core::records::{BaseError, BuildId, RecordError, SetId};
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::change::{Act, Change, Key, Statement};
use hexsense_core::wire::log::Volume;
use hexsense_core::wire::message::{
    ActiveSet, ChannelHarmonics, Chunk, Kept, encode_request, encode_response,
};
use hexsense_core::wire::status::{
    EventCount, Events, OptionBytes, PathCycles, ResetCause, Resets, StackUse,
};
use hexsense_core::wire::telemetry::{self, Header, Samples};
use hexsense_core::wire::{
    AnalyserState, BoardPose, Drive, FrameError, Identity, MAX_FRAME, PoseRefusal, PoseReport,
    Refusal, Request, Response, Status, StreamContent, pose,
};

/// A line for every variant of an enum, with a sample put into a message; a variant without a sample does not compile.
macro_rules! one_of_each {
    ($kind:literal, $frame:expr, $type:ident { $($name:ident $fields:tt => $sample:expr,)* }) => {{
        let exhaustive = |value: &$type| match value { $($type::$name $fields => stringify!($name),)* };
        let mut lines = String::new();
        $(
            let sample = $sample;
            assert_eq!(exhaustive(&sample), stringify!($name), "a sample is not of its variant");
            writeln!(lines, "{} {} {}", $kind, stringify!($name), $frame(sample)).unwrap();
        )*
        lines
    }};
}

pub const SEQUENCE: u16 = 0x0B0A;

/// A frame in hexadecimal.
pub fn hex(encode: impl FnOnce(&mut [u8]) -> Result<usize, FrameError>) -> String {
    let mut out = [0; MAX_FRAME];
    let length = encode(&mut out).unwrap();
    out[..length].iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").unwrap();
        text
    })
}

fn request(request: Request) -> String {
    hex(|out| encode_request(&request, SEQUENCE, out))
}

fn response(response: Response) -> String {
    hex(|out| encode_response(&response, SEQUENCE, out))
}

fn refused(error: RecordError) -> String {
    response(Response::Refused(Refusal::Record(error)))
}

/// The lines of all messages.
pub fn everything() -> String {
    let no_set = response(Response::ActiveSet(None));
    let no_samples = Samples {
        inertial: &[],
        jacks: &[],
        values: &[],
    };
    let header = Header {
        content: StreamContent::default(),
        ..header()
    };
    let block = hex(|out| telemetry::encode(&header, no_samples, SEQUENCE, out));
    [
        requests(),
        block_sizes(),
        acts(),
        responses(),
        format!("response NoActiveSet {no_set}\n"),
        refusals(),
        record_errors(),
        base_errors(),
        drive_errors(),
        triads(),
        reset_causes(),
        reasons(),
        harmonic_states(),
        format!("block Header {block}\n"),
        pose_reports(),
    ]
    .concat()
}

const ID: SetId = SetId([0xA1, 0xA2, 0xA3, 0xA4, 0xA5, 0xA6, 0xA7, 0xA8]);
const DRIVE: Drive = Drive {
    increment: 0x0102_0304_0506_0708,
    block: BlockSize::Eight,
    settle_blocks: 0x1112_1314,
    blocks: 0x2122_2324,
};
const ACTIVE: ActiveSet = ActiveSet {
    id: ID,
    sequence: 0x3132_3334,
    length: 0x4142,
};
const CONTENT: StreamContent = StreamContent {
    counts: true,
    values: false,
    pose: true,
};

const ENTRY: Entry = Entry {
    counter: 0x3132_3334,
    reason: Reason::Upload,
    unix_s: 0x6162_6364,
    id: Some(ID),
    previous: None,
    build: BUILD,
    chain: HEAD,
    reset: 0x7172_7374,
    page: 0x8182,
};
const BUILD: BuildId = BuildId([0x91, 0x92, 0x93, 0x94, 0x95, 0x96, 0x97, 0x98]);
const HEAD: Chain = *b"head of a volume";
const VOLUME: Volume = Volume {
    first: 0x0102_0304,
    last: 0x1112_1314,
    head: HEAD,
    build: BUILD,
};
const KEPT: Kept = Kept {
    sequence: 0x3132_3334,
    id: ID,
    length: 0x4142,
    made_unix_s: 0x5152_5354,
    uploaded_unix_s: 0x6162_6364,
};
const UPLOAD: Act = Act::Upload {
    length: 0x4142,
    digest: *b"ABCDEFGHIJKLMNOPQRSTUVWXYZ012345",
};

fn change(act: Act) -> Request {
    Request::Change {
        change: Change {
            unix_s: 0x6162_6364,
            act,
        },
        tag: *b"abcdefghijklmnopqrstuvwxyz678901",
    }
}

fn chunk() -> Chunk {
    Chunk::from_slice(&[0xC1, 0x00, 0xC3]).unwrap()
}

fn requests() -> String {
    one_of_each!("request", request, Request {
        Identity {} => Request::Identity,
        Status {} => Request::Status,
        Stream { .. } => Request::Stream(CONTENT),
        Rate { .. } => Request::Rate(4_000),
        Block { .. } => Request::Block(BlockSize::ThirtyTwo),
        Drive { .. } => Request::Drive { analyser: 2, drive: DRIVE },
        Sums { .. } => Request::Sums { analyser: 1, channel: 14 },
        ActiveSet {} => Request::ActiveSet,
        ReadSet { .. } => Request::ReadSet { offset: 0x5152 },
        History { .. } => Request::History { age: 7 },
        Log { .. } => Request::Log { counter: 0x6162_6364 },
        Challenge {} => Request::Challenge,
        Change { .. } => change(UPLOAD),
        UploadChunk { .. } => Request::UploadChunk { offset: 0x7172, bytes: chunk() },
        UploadCommit {} => Request::UploadCommit,
        UploadAbort {} => Request::UploadAbort,
        Harmonics { .. } => Request::Harmonics { analyser: 2, channel: 13 },
        Motion { .. } => Request::Motion { analyser: 1 },
        Prove { .. } => Request::Prove { challenge: *b"0123456789abcdefghijklmnopqrstuv" },
        LogProof { .. } => Request::LogProof { nonce: *b"nonce of the host, thirty-two b." },
    })
}

fn responses() -> String {
    one_of_each!("response", response, Response {
        Done {} => Response::Done,
        Refused { .. } => Response::Refused(Refusal::Malformed),
        Identity { .. } => identity(ResetCause::PowerOn),
        Status { .. } => Response::Status(status()),
        Sums { .. } => harmonics(AnalyserState::Idle),
        ActiveSet { .. } => Response::ActiveSet(Some(ACTIVE)),
        SetBytes { .. } => Response::SetBytes { offset: 0x5152, bytes: chunk() },
        Committed { .. } => Response::Committed(ACTIVE),
        Kept { .. } => Response::Kept(Some(KEPT)),
        Log { .. } => Response::Log { last: 0x0102_0304, entries: [ENTRY].into_iter().collect() },
        Challenge { .. } => Response::Challenge(*b"0123456789abcdef"),
        Erased { .. } => Response::Erased { sets: 8 },
        Harmonics { .. } => Response::Harmonics { drive: DRIVE, first_scan: 0x0102_0304, harmonics: fit() },
        Motion { .. } => Response::Motion { drive: DRIVE, first_scan: 0x0102_0304, motion: Ok(MOTION) },
        Proof { .. } => Response::Proof { statement: Statement { set: Some(ID), changes: 0x0102_0304 }, tag: [0xA7; 32] },
        LogProof { .. } => Response::LogProof { volume: VOLUME, mac: *b"abcdefghijklmnopqrstuvwxyz678901" },
    })
}

fn refusals() -> String {
    one_of_each!("refusal", |refusal| response(Response::Refused(refusal)), Refusal {
        Malformed {} => Refusal::Malformed,
        Rate { .. } => Refusal::Rate { hz: 0x0102_0304 },
        LinkCapacity { .. } => Refusal::LinkCapacity { bits_per_s: 0x0102_0304, limit: 0x1112_1314 },
        NoCrystal {} => Refusal::NoCrystal,
        Drive { .. } => Refusal::Drive(DriveError::Frequency),
        OtherBlock { .. } => Refusal::OtherBlock { drive: 8, board: 32 },
        Analyser { .. } => Refusal::Analyser { analyser: 3 },
        Channel { .. } => Refusal::Channel { channel: 15 },
        NoSet {} => Refusal::NoSet,
        Offset { .. } => Refusal::Offset { offset: 0x2122, length: 0x3132 },
        NoUpload {} => Refusal::NoUpload,
        Length { .. } => Refusal::Length { length: 0x2122, limit: 0x3132 },
        OutOfOrder { .. } => Refusal::OutOfOrder { expected: 0x4142 },
        WrongIdentity {} => Refusal::WrongIdentity,
        Record { .. } => Refusal::Record(RecordError::Layout),
        OtherBoard {} => Refusal::OtherBoard,
        Flash {} => Refusal::Flash,
        Unprovisioned {} => Refusal::Unprovisioned,
        NoChallenge {} => Refusal::NoChallenge,
        WrongTag {} => Refusal::WrongTag,
        BackOff { .. } => Refusal::BackOff { ms: 0x0102_0304 },
        Expired {} => Refusal::Expired,
        NoSuchSet {} => Refusal::NoSuchSet,
        AlreadyActive {} => Refusal::AlreadyActive,
        LogFull {} => Refusal::LogFull,
        Log {} => Refusal::Log,
        Erasure {} => Refusal::Erasure,
        Random {} => Refusal::Random,
        Busy {} => Refusal::Busy,
        Incomplete { .. } => Refusal::Incomplete { analyser: 2 },
        Undetermined { .. } => Refusal::Undetermined { blocks: 0x0102_0304 },
        EarlierLog {} => Refusal::EarlierLog,
        OptionBytes {} => Refusal::OptionBytes,
        KeyDamaged {} => Refusal::KeyDamaged,
        SameKey {} => Refusal::SameKey,
        LogMoved {} => Refusal::LogMoved,
    })
}

fn acts() -> String {
    one_of_each!("act", |act| request(change(act)), Act {
        Upload { .. } => UPLOAD,
        Rollback { .. } => Act::Rollback(ID),
        FactoryReset {} => Act::FactoryReset,
        Provision { .. } => Act::Provision(Key(*b"ABCDEFGHIJKLMNOPQRSTUVWXYZ543210")),
        NewVolume { .. } => Act::NewVolume { last: 0x3132_3334 },
    })
}

fn reasons() -> String {
    let log = |reason| {
        let entries = [Entry { reason, ..ENTRY }].into_iter().collect();
        response(Response::Log {
            last: 0x0102_0304,
            entries,
        })
    };
    one_of_each!("reason", log, Reason {
        Upload {} => Reason::Upload,
        Rollback {} => Reason::Rollback,
        FactoryReset {} => Reason::FactoryReset,
        Provision {} => Reason::Provision,
        Fallback {} => Reason::Fallback,
        FirmwareChange {} => Reason::FirmwareChange,
        NewVolume {} => Reason::NewVolume,
    })
}

fn record_errors() -> String {
    one_of_each!("record-error", refused, RecordError {
        Length { .. } => RecordError::Length { length: 0x0102_0304 },
        Checksum { .. } => RecordError::Checksum { stored: 0x0102_0304, computed: 0x1112_1314 },
        Layout {} => RecordError::Layout,
        NotFinite { .. } => RecordError::NotFinite { triad: Triad::LinearAcceleration },
        Singular { .. } => RecordError::Singular { triad: Triad::LinearAcceleration },
        Base { .. } => RecordError::Base(BaseError::NotFinite),
        Temperature {} => RecordError::Temperature,
        Values { .. } => RecordError::Values { triad: Triad::AngularRate },
    })
}

fn drive_errors() -> String {
    one_of_each!("drive-error", |error| response(Response::Refused(Refusal::Drive(error))), DriveError {
        Frequency {} => DriveError::Frequency,
        FifthHarmonic { .. } => DriveError::FifthHarmonic { scans: 32 },
        Blocks { .. } => DriveError::Blocks { blocks: 0x0102_0304 },
        Settle { .. } => DriveError::Settle { blocks: 0x0506_0708 },
    })
}

fn block_sizes() -> String {
    one_of_each!("block-size", |block| request(Request::Block(block)), BlockSize {
        One {} => BlockSize::One,
        Four {} => BlockSize::Four,
        Eight {} => BlockSize::Eight,
        Sixteen {} => BlockSize::Sixteen,
        ThirtyTwo {} => BlockSize::ThirtyTwo,
    })
}

fn base_errors() -> String {
    one_of_each!("base-error", |error| refused(RecordError::Base(error)), BaseError {
        NotFinite {} => BaseError::NotFinite,
        Stroke {} => BaseError::Stroke,
        Home { .. } => BaseError::Home { jack: 6 },
        Degenerate {} => BaseError::Degenerate,
        Transducer { .. } => BaseError::Transducer { jack: 5 },
    })
}

/// A pose, and every reason why there is none.
fn pose_reports() -> String {
    let pose = BoardPose {
        position_m: [0.5, 2.25, -0.75],
        rotation: [0.968_75, 0.125, -0.062_5, 0.203_125],
        residual_m: 0.015_625,
        condition_bound: 24.5,
        iterations: 3,
    };
    let report = |outcome| {
        let report = PoseReport {
            first_scan: 0x0102_0304_0506_0708,
            block: BlockSize::Four,
            set: ID,
            outcome,
        };
        hex(|out| pose::encode(&report, SEQUENCE, out))
    };
    let refused = one_of_each!("pose", |refusal| report(Err(refusal)), PoseRefusal {
        Base { .. } => PoseRefusal::Base(BaseError::Stroke),
        NotFinite { .. } => PoseRefusal::NotFinite { jack: 6 },
        OutsideStroke { .. } => PoseRefusal::OutsideStroke { jack: 5, length_m: 4.015_625 },
        Singular {} => PoseRefusal::Singular,
        Unreachable { .. } => PoseRefusal::Unreachable { short_m: 0.25 },
        NoConvergence { .. } => PoseRefusal::NoConvergence { short_m: 0.125 },
        BranchChanged {} => PoseRefusal::BranchChanged,
        Jump { .. } => PoseRefusal::Jump { distance_m: 0.062_5, angle_rad: 0.031_25 },
    });
    format!("pose Pose {}\n{refused}", report(Ok(pose)))
}

fn triads() -> String {
    one_of_each!("triad", |triad| refused(RecordError::Singular { triad }), Triad {
        LinearAcceleration {} => Triad::LinearAcceleration,
        AngularAcceleration {} => Triad::AngularAcceleration,
        AngularRate {} => Triad::AngularRate,
    })
}

fn reset_causes() -> String {
    one_of_each!("reset", |cause| response(identity(cause)), ResetCause {
        PowerOn {} => ResetCause::PowerOn,
        BrownOut {} => ResetCause::BrownOut,
        Pin {} => ResetCause::Pin,
        Software {} => ResetCause::Software,
        Panic {} => ResetCause::Panic,
        Watchdog {} => ResetCause::Watchdog,
        Other {} => ResetCause::Other,
        Crystal {} => ResetCause::Crystal,
    })
}

fn harmonic_states() -> String {
    one_of_each!("harmonic-state", |state| response(harmonics(state)), AnalyserState {
        Idle {} => AnalyserState::Idle,
        Settling {} => AnalyserState::Settling,
        Summing {} => AnalyserState::Summing,
        Complete {} => AnalyserState::Complete,
    })
}

pub fn header() -> Header {
    Header {
        first_scan: 0x0102_0304_0506_0708,
        scans: 3,
        rate_hz: 4_000,
        supply: 1.015_625,
        temperature_c: -12.5,
        set: Some(ID),
        dropped: 0x1112_1314,
        content: CONTENT,
        supply_is_old: true,
    }
}

fn identity(reset: ResetCause) -> Response {
    Response::Identity(Identity {
        board: *b"\x01\x02\x03\x04\x05\x06\x07\x08\x09\x0A\x0B\x0C",
        hardware: heapless::String::try_from("NUCLEO-G474RE").unwrap(),
        reset,
        facts: BoardFacts {
            rates_hz: [0x1112, 0x2122, 0x3132],
            rank_ns: 0x4142_4344,
            counts_at_supply: 0x5152_5354,
            nominal_supply_v: 3.25,
            baud: 0x6162_6364,
            flash: FlashLayout {
                page_bytes: 0x7172,
                pages: 0x8182,
            },
        },
        build: Some(BUILD),
    })
}

fn harmonics(state: AnalyserState) -> Response {
    Response::Sums {
        state,
        drive: DRIVE,
        first_scan: 0x0102_0304_0506_0708,
        sums: ChannelSums {
            offset: -1,
            drift: 2,
            square: 3,
            cosine: [-4, 5, -6, 7, -8],
            sine: [9, -10, 11, -12, 13],
        },
    }
}

const MOTION: Motion = Motion {
    amplitude: [0.5, 0.25, -0.5, 2.0, 4.0, 8.0],
    factors: [1.0, -1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0],
};

fn fit() -> ChannelHarmonics {
    ChannelHarmonics {
        offset: 0.5,
        drift: -0.25,
        amplitude: [1.0, 2.0, 3.0, 4.0, 5.0],
        phase: [-1.0, -2.0, -3.0, -4.0, -5.0],
        residual_rms: 6.0,
        distortion: 7.0,
        uncertainty: Uncertainty {
            offset: 0.125,
            drift: 8.0,
            amplitude: [9.0, 10.0, 11.0, 12.0, 13.0],
            phase: [14.0, 15.0, 16.0, 17.0, 18.0],
        },
    }
}

fn status() -> Status {
    Status {
        uptime_ms: 0x0102_0304_0506_0708,
        rate_hz: 2_000,
        scans: 0x1112_1314_1516_1718,
        block: BlockSize::ThirtyTwo,
        scans_lost: 0x2122_2324_2526_2728,
        first_lost_scan: Some(0x5152_5354_5556_5758),
        events: events(),
        first_with_set_ms: Some(0x6162_6364_6566_6768),
        path_cycles: PathCycles {
            min: 0x7172_7374,
            max: 0x0182_8384,
            last: 0x0192_9394,
        },
        analysers: [
            AnalyserState::Settling,
            AnalyserState::Summing,
            AnalyserState::Complete,
        ],
        crystal: true,
        supply: 0.984_375,
        supply_readings: 15,
        temperature_c: 31.25,
        in_calibrated_range: false,
        tilt_approximate_rad: Some([0.25, -0.125]),
        provisioned: true,
        resets: Resets {
            starts: 28,
            brown_outs: 1,
            pin: 2,
            software: 3,
            panics: 4,
            watchdog: 5,
            other: 6,
            previous_uptime_ms: Some(0x0132_3334_3536_3738),
            crystal: 7,
        },
        stack: StackUse {
            deepest: 0x2324,
            size: 0x6000,
        },
        panic: Some(heapless::String::try_from("at µ").unwrap()),
        option_bytes: OptionBytes {
            dual_bank: true,
            readout_protection: 1,
            brown_out_level: 4,
            write_protected: [None, Some((3, 61)), None, Some((8, 9))],
        },
        supply_is_old: true,
        key_damaged: true,
        log_used: Some(0x0102),
    }
}

fn events() -> Events {
    let tally = |number: u8| EventCount {
        count: number.into(),
        last_ms: 0x8000 | u64::from(number),
    };
    Events {
        overruns: tally(1),
        late_blocks: tally(2),
        stuck: tally(3),
        blocks_dropped: tally(4),
        frames_unsent: tally(5),
        frames_not_cobs: tally(6),
        frames_of_wrong_length: tally(7),
        frames_of_wrong_checksum: tally(8),
        frames_of_wrong_kind: tally(9),
        receiver_overruns: tally(10),
        receiver_errors: tally(11),
        flash_corrections: tally(12),
        torn_words: tally(13),
        slips: tally(14),
        supply_refused: tally(15),
        coefficients_restored: tally(16),
        wrong_tags: tally(17),
        changes_refused: tally(18),
        requests_refused: tally(19),
    }
}
