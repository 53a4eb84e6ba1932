//! A board that lies: it answers every request as a good board does, except where its lie says something else.
//!
//! Messages begin as what zeros decode to, so that a new field of a message is one of theirs without a word here.

use std::sync::LazyLock;

use hexsense_core::channel::{INERTIAL, JACKS};
use hexsense_core::records::{CoefficientSet, SetId};
use hexsense_core::wire::change::Act;
use hexsense_core::wire::frame::{self, Closed, Deframer};
use hexsense_core::wire::hello::Greeting;
use hexsense_core::wire::message::{ActiveSet, CHUNK, Kept, decode_request, encode_response};
use hexsense_core::wire::telemetry::{self, Header, Samples};
use hexsense_core::wire::{
    BoardPose, Identity, Kind, MAX_FRAME, PoseReport, Request, Response, Status, StreamContent,
    VERSION, pose,
};
use serde::de::DeserializeOwned;

use crate::sets::{encoded, numbered};

/// Scans in a second.
pub const RATE_HZ: u32 = 1_000;

/// What the board streams.
pub const CONTENT: StreamContent = StreamContent {
    counts: true,
    values: true,
    pose: true,
};

/// What a host may have sent.
#[derive(Debug, Clone, PartialEq)]
pub enum Heard {
    /// A hello.
    Hello,
    /// A request with its number.
    Request(u16, Request),
}

/// Takes the bytes of a host apart.
#[derive(Debug, Default)]
pub struct Ear(Box<Deframer<MAX_FRAME>>);

impl Ear {
    /// What ends in these bytes.
    pub fn hear(&mut self, bytes: &[u8]) -> Vec<Heard> {
        let mut heard = Vec::new();
        for byte in bytes {
            if let Some(Closed::Frame(bytes)) = self.0.push(*byte)
                && let Ok(frame) = frame::decode(bytes)
            {
                match frame.kind {
                    Kind::Hello => heard.push(Heard::Hello),
                    Kind::Request => {
                        let request = decode_request(frame.payload);
                        heard.extend(request.map(|it| Heard::Request(frame.sequence, it)));
                    }
                    _ => {}
                }
            }
        }
        heard
    }
}

/// What zeros decode to.
///
/// # Panics
/// For a type that zeros are not.
#[must_use]
pub fn zeroed<T: DeserializeOwned>() -> T {
    let decoded = postcard::take_from_bytes(&[0; 2_048]);
    decoded.expect("zeros are a message").0
}

/// Who the board is.
#[must_use]
pub fn identity() -> Identity {
    let mut identity: Identity = zeroed();
    identity.board = *b"lying board1";
    identity.facts = hexsense::FACTS;
    identity
}

/// How it is.
#[must_use]
pub fn status() -> Status {
    let mut status: Status = zeroed();
    (status.rate_hz, status.crystal, status.provisioned) = (RATE_HZ, true, true);
    (status.supply, status.supply_readings) = (1.0, 16);
    status
}

/// Its active set.
#[must_use]
pub fn active() -> ActiveSet {
    ActiveSet {
        id: *ID,
        length: SET.len() as u16,
        ..zeroed()
    }
}

/// The bytes of its set, and their identity.
static SET: LazyLock<Vec<u8>> = LazyLock::new(|| encoded(&numbered(1)));
static ID: LazyLock<SetId> = LazyLock::new(|| CoefficientSet::id_of(&SET));

/// A pose at home.
#[must_use]
pub fn pose_report() -> PoseReport {
    let mut pose: BoardPose = zeroed();
    (pose.position_m, pose.rotation) = ([0.0, 2.0, 0.0], [1.0, 0.0, 0.0, 0.0]);
    PoseReport {
        set: *ID,
        outcome: Ok(pose),
        ..zeroed()
    }
}

/// What a good board answers.
#[must_use]
pub fn answer(request: &Request) -> Response {
    match request {
        Request::Identity => Response::Identity(identity()),
        Request::Status => Response::Status(status()),
        Request::Sums { .. } => Response::Sums {
            state: zeroed(),
            drive: zeroed(),
            first_scan: 0,
            sums: zeroed(),
        },
        Request::ActiveSet => Response::ActiveSet(Some(active())),
        Request::ReadSet { offset } => {
            let rest = SET.get(usize::from(*offset)..).unwrap_or_default();
            Response::SetBytes {
                offset: *offset,
                bytes: rest.iter().take(CHUNK).copied().collect(),
            }
        }
        Request::History { age } => Response::Kept((*age == 0).then(|| Kept {
            id: *ID,
            ..zeroed()
        })),
        Request::Log { counter } => {
            let mut entry: hexsense_core::records::Entry = zeroed();
            entry.counter = 1;
            Response::Log {
                last: 1,
                entries: (*counter <= 1).then_some(entry).into_iter().collect(),
            }
        }
        Request::Challenge => Response::Challenge(zeroed()),
        Request::Change { change, .. } => match change.act {
            Act::Rollback(_) => Response::Committed(active()),
            Act::FactoryReset => Response::Erased { sets: 1 },
            _ => Response::Done,
        },
        Request::UploadCommit => Response::Committed(active()),
        Request::Harmonics { .. } => Response::Harmonics {
            drive: zeroed(),
            first_scan: 0,
            harmonics: zeroed(),
        },
        Request::Motion { .. } => Response::Motion {
            drive: zeroed(),
            first_scan: 0,
            motion: zeroed(),
        },
        _ => Response::Done,
    }
}

/// The frame of an answer.
#[must_use]
pub fn answer_frame(response: &Response, sequence: u16) -> Vec<u8> {
    filled(|out| encode_response(response, sequence, out))
}

/// The frame of the greeting.
#[must_use]
pub fn greeting_frame() -> Vec<u8> {
    let greeting = Greeting {
        wire: VERSION,
        firmware: [1, 2, 3],
    };
    filled(|out| greeting.encode(0, out))
}

/// The header of one scan.
#[must_use]
pub fn header(first_scan: u64, content: StreamContent) -> Header {
    Header {
        first_scan,
        scans: 1,
        rate_hz: RATE_HZ,
        supply: 1.0,
        temperature_c: 25.0,
        set: Some(*ID),
        content,
        ..zeroed()
    }
}

/// The frame of one scan.
#[must_use]
pub fn block_frame(header: &Header, value: f32, sequence: u16) -> Vec<u8> {
    let samples = Samples {
        inertial: &[[32_768; INERTIAL]; telemetry::MAX_SCANS],
        jacks: &[[32_768; JACKS]; telemetry::MAX_SCANS],
        values: &[[value; INERTIAL]; telemetry::MAX_SCANS],
    };
    filled(|out| telemetry::encode(header, samples, sequence, out))
}

/// The frame of a pose.
#[must_use]
pub fn pose_frame(report: &PoseReport, sequence: u16) -> Vec<u8> {
    filled(|out| pose::encode(report, sequence, out))
}

/// The bytes that `encode` writes.
fn filled<E: std::fmt::Debug>(encode: impl FnOnce(&mut [u8]) -> Result<usize, E>) -> Vec<u8> {
    let mut bytes = vec![0; MAX_FRAME];
    let length = encode(&mut bytes).expect("every message fits a frame");
    bytes.truncate(length);
    bytes
}
