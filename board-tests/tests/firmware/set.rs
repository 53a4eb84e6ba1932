//! A coefficient set for the board on the bench, and its upload.

use hexsense_core::authority::tag;
use hexsense_core::records::{
    CoefficientSet, JackCoefficients, MAX_ENCODED, MotionBase, TriadCoefficients,
};
use hexsense_core::wire::change::{Act, Change, Key};
use hexsense_core::wire::message::{CHUNK, Chunk};
use hexsense_core::wire::{Request, Response};
use hexsense_probe::geometry_file::GeometryFile;

use sha2::{Digest, Sha256};

use crate::bench::Board;

/// A set in which mid-scale counts are a base at mid-stroke, and no two elements of a matrix are alike.
pub fn set(board: [u8; 12], unix_s: u64) -> CoefficientSet {
    let triad = |gain: f32| TriadCoefficients {
        offset: [32_768.25, 32_700.5, 33_000.125],
        matrix: [
            [1.0, 0.02, -0.01],
            [-0.015, 1.01, 0.005],
            [0.01, -0.02, 0.99],
        ]
        .map(|row| row.map(|element: f32| element * gain)),
        offset_uncertainty: [1.0; 3],
        matrix_uncertainty: [[1e-7; 3]; 3],
        delay_s: 0.002,
    };
    let geometry = GeometryFile::load("an-74tk-200").unwrap().geometry;
    CoefficientSet {
        board,
        geometry: "an-74tk-200".try_into().unwrap(),
        geometry_hash: [1; 8],
        unix_s,
        temperature_c: 25.0,
        provenance: [2; 32],
        triads: [triad(6e-4), triad(3e-4), triad(-5e-5)],
        base: MotionBase::new(&geometry),
        jacks: JackCoefficients {
            zero_length_m: geometry.mid_length_m() as f32,
            zero_counts: [32_768.0; 6],
            metres_per_count: [2e-5; 6],
        },
    }
}

/// The key of every board on the bench.
pub const KEY: Key = Key(*b"key of the board on the bench...");

/// Has the board carry out a change, with the key.
pub fn change(board: &mut Board, act: Act) -> Response {
    let request = tagged(board, act);
    board.ask(&request)
}

/// The request of a change, with its tag.
pub fn tagged(board: &mut Board, act: Act) -> Request {
    let Response::Identity(identity) = board.ask(&Request::Identity) else {
        panic!("no identity");
    };
    let Response::Challenge(challenge) = board.ask(&Request::Challenge) else {
        panic!("no challenge");
    };
    let change = Change {
        unix_s: 1_790_000_000,
        act,
    };
    let tag = tag(&KEY, &challenge, &identity.board, &change);
    Request::Change { change, tag }
}

/// Uploads a set made for this board, which gets a key first if it has none, and returns the set.
pub fn upload(board: &mut Board, unix_s: u64) -> CoefficientSet {
    let Response::Identity(identity) = board.ask(&Request::Identity) else {
        panic!("no identity");
    };
    if !board.status().provisioned {
        assert_eq!(change(board, Act::Provision(KEY)), Response::Done);
    }
    let set = set(identity.board, unix_s);
    let mut buffer = [0; MAX_ENCODED];
    let bytes = set.encode(&mut buffer).unwrap().to_vec();
    let id = CoefficientSet::id_of(&bytes);
    let unlock = Act::Upload {
        length: bytes.len() as u16,
        digest: Sha256::digest(&bytes).into(),
    };
    assert_eq!(change(board, unlock), Response::Done);
    for (index, piece) in bytes.chunks(CHUNK).enumerate() {
        board.order(&Request::UploadChunk {
            offset: (index * CHUNK) as u16,
            bytes: Chunk::from_slice(piece).unwrap(),
        });
    }
    let committed = board.ask(&Request::UploadCommit);
    assert!(matches!(committed, Response::Committed(active) if active.id == id));
    set
}
