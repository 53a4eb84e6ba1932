//! The link client against a board made of the core's own parts.

mod fake;

use std::sync::{Arc, Mutex};
use std::time::Duration;

use fake::key::KEY;
use fake::line::Line;
use fake::source::Still;
use fake::{FakeBoard, Fault};
use hexsense_client::{Client, LinkError, ProtocolError, TransportError, UploadError};
use hexsense_core::wire::{Refusal, StreamContent, VERSION};

const COUNTS: StreamContent = StreamContent {
    counts: true,
    values: false,
    pose: false,
};

fn board(change: impl FnOnce(&mut FakeBoard)) -> Arc<Mutex<FakeBoard>> {
    let mut board = FakeBoard::new(Box::new(Still));
    change(&mut board);
    Arc::new(Mutex::new(board))
}

fn connect(board: &Arc<Mutex<FakeBoard>>) -> Result<Client, LinkError> {
    Client::connect(Line::to(board))
}

/// A set for the fake board, encoded; `unix_s` makes them differ.
fn encoded(unix_s: u64) -> Vec<u8> {
    fake::set::encoded(&fake::set::set(unix_s))
}

/// The set that the board has after its power was cut and came back.
fn after_power_cut(board: &Arc<Mutex<FakeBoard>>) -> Option<u64> {
    let mut board = board.lock().unwrap();
    board.switch_on();
    board.active().map(|active| active.content.unix_s)
}

#[test]
fn another_wire_version_is_named_with_what_to_update() {
    for (wire, update) in [
        (VERSION + 1, "update hexsense"),
        (VERSION - 1, "update the board"),
    ] {
        // Version 0 is the absence of a greeting, so the older board here is one of version 0 only when VERSION is 1.
        let older = board(|board| board.wire = wire);
        let Err(error) = connect(&older) else {
            panic!("connected to version {wire}")
        };
        let text = error.to_string();
        assert!(text.contains(&format!("version {wire}")), "{text}");
        assert!(
            text.contains(&format!("version {VERSION}")) && text.contains(update),
            "{text}"
        );
    }
}

#[test]
fn a_server_that_closes_a_connection_at_once_is_in_use() {
    let listener = fake::source::listener();
    let address = fake::source::address(&listener);
    std::thread::spawn(move || listener.incoming().for_each(drop));
    for scheme in ["tcp", "lockstep"] {
        let port = format!("{scheme}:{address}");
        let error = Client::open(&port).err().expect("a closed connection");
        assert!(
            matches!(error, LinkError::Transport(TransportError::InUse { .. })),
            "{error}"
        );
        let text = error.to_string();
        assert!(text.starts_with(&format!("{port} is in use")), "{text}");
    }
}

#[test]
fn a_lost_answer_is_asked_for_again() {
    for fault in [Fault::LoseAnswer(1), Fault::DamageAnswer(1)] {
        let board = board(|board| board.fault = fault);
        let mut client = connect(&board).unwrap();
        assert_eq!(
            client.identity().unwrap().board,
            *b"fake board 1",
            "{fault:?}"
        );
    }
}

#[test]
fn an_answer_that_comes_too_late_is_not_taken_for_another_one() {
    let board = board(|board| board.fault = Fault::DelayAnswer(1));
    let mut client = connect(&board).unwrap();
    client.identity().unwrap();
    assert_eq!(client.status().unwrap().rate_hz, fake::RATE_HZ);
}

#[test]
fn a_silent_board_is_reported_within_five_seconds() {
    let board = board(|board| board.fault = Fault::SilentFrom(1));
    let mut client = connect(&board).unwrap();
    let start = client.now();
    let before = board.lock().unwrap().heard.len();
    let error = client.identity().unwrap_err();
    assert!(
        matches!(
            error,
            LinkError::Protocol(ProtocolError::Silent { attempts: 3, .. })
        ),
        "{error}"
    );
    assert!(client.now() - start < Duration::from_secs(5));
    let heard = &board.lock().unwrap().heard[before..];
    let zeros = heard.iter().filter(|byte| **byte == 0).count();
    assert_eq!(zeros, 2 * 3, "one before and one after each request");
}

#[test]
fn a_board_that_never_answers_is_greeted_three_times() {
    let board = board(|board| board.fault = Fault::SilentFrom(0));
    let Err(error) = connect(&board) else {
        panic!("connected to a silent board")
    };
    assert!(
        matches!(error, LinkError::Protocol(ProtocolError::NoGreeting { .. })),
        "{error}"
    );
    // Before each greeting a zero closes what the board may hold.
    let heard = &board.lock().unwrap().heard;
    let zeros = heard.iter().filter(|byte| **byte == 0).count();
    assert_eq!(zeros, 2 * 3);
}

#[test]
fn a_new_connection_leaves_the_stream_on_and_asks_beside_it() {
    let board = board(|_| {});
    let mut killed = connect(&board).unwrap();
    killed.stream(COUNTS).unwrap();
    drop(killed);
    let mut client = connect(&board).unwrap();
    for _ in 0..50 {
        client.identity().unwrap();
        client.block(Duration::from_secs(1)).unwrap();
    }
    assert!(board.lock().unwrap().streams());
}

#[test]
fn blocks_arrive_in_order_beside_answers() {
    let mut client = connect(&board(|_| {})).unwrap();
    client.stream(COUNTS).unwrap();
    let mut last = None;
    for _ in 0..50 {
        client.status().unwrap();
        let block = client.block(Duration::from_secs(1)).unwrap();
        if let Some(last) = last {
            assert_eq!(block.header.first_scan, last + 16);
        }
        last = Some(block.header.first_scan);
    }
}

#[test]
fn a_pose_comes_with_each_block_and_only_with_a_set() {
    let mut client = connect(&board(|_| {})).unwrap();
    let poses = StreamContent {
        pose: true,
        ..COUNTS
    };
    let refused = client.stream(poses).unwrap_err();
    assert!(
        matches!(refused, LinkError::Refused(Refusal::NoSet)),
        "{refused}"
    );
    let id = client.upload(&encoded(1), &KEY).unwrap().id;
    client.stream(poses).unwrap();
    for _ in 0..20 {
        let block = client.block(Duration::from_secs(1)).unwrap();
        let report = client.pose(Duration::from_secs(1)).unwrap();
        assert_eq!(
            (report.first_scan, report.set),
            (block.header.first_scan, id)
        );
        // Mid-scale is mid-stroke, which is home.
        let height = report.outcome.unwrap().position_m[1];
        assert!((height - 2.129757).abs() < 1e-6, "{height}");
    }
    assert!(client.take_poses().is_empty());
}

#[test]
fn a_stream_that_stops_is_reported() {
    let board = board(|_| {});
    let mut client = connect(&board).unwrap();
    client.stream(COUNTS).unwrap();
    client.block(Duration::from_secs(1)).unwrap();
    board.lock().unwrap().fault = Fault::SilentFrom(0);
    let error = client.block(Duration::from_secs(2)).unwrap_err();
    assert!(
        matches!(error, LinkError::Protocol(ProtocolError::NoSamples { .. })),
        "{error}"
    );
}

#[test]
fn an_uploaded_set_is_active_after_the_power_was_cut() {
    let board = board(|_| {});
    let mut client = connect(&board).unwrap();
    // The first change was its key.
    assert_eq!(client.upload(&encoded(1), &KEY).unwrap().sequence, 2);
    assert_eq!(client.upload(&encoded(2), &KEY).unwrap().sequence, 3);
    assert_eq!(client.read_set().unwrap().unwrap().1, encoded(2));
    assert_eq!(after_power_cut(&board), Some(2));
}

#[test]
fn an_upload_survives_any_single_lost_or_damaged_answer() {
    // Requests: identity, challenge, begin, five pieces, commit, active set, five times bytes.
    assert_eq!(encoded(1).len().div_ceil(128), 5);
    for at in 1..=15 {
        for fault in [Fault::LoseAnswer(at), Fault::DamageAnswer(at)] {
            let board = board(|board| board.fault = fault);
            let mut client = connect(&board).unwrap();
            client
                .upload(&encoded(1), &KEY)
                .unwrap_or_else(|error| panic!("{fault:?}: {error}"));
            assert_eq!(after_power_cut(&board), Some(1));
        }
    }
}

#[test]
fn an_upload_cut_off_anywhere_leaves_the_old_set_or_the_whole_new_one_and_says_which() {
    let pieces = encoded(1).len().div_ceil(128) as u32;
    // Identity, challenge, begin, pieces, commit, active set, bytes.
    for at in 1..=3 + pieces + 1 + 1 + pieces {
        let board = board(|_| {});
        let mut client = connect(&board).unwrap();
        client.upload(&encoded(1), &KEY).unwrap();
        let done = 3 + pieces + 1 + 1 + pieces;
        board.lock().unwrap().fault = Fault::CutAt(done + at);
        let error = client.upload(&encoded(2), &KEY).unwrap_err();
        let commits = at > 3 + pieces;
        let now = after_power_cut(&board);
        let text = error.to_string();
        match error {
            UploadError::Before(LinkError::Transport(TransportError::Closed { .. })) => {
                assert!(now == Some(1) && !commits);
                assert!(text.contains("old coefficients are still active"), "{text}");
            }
            UploadError::During { .. } => {
                assert!(matches!(now, Some(1 | 2)) && commits);
                assert!(text.contains("hexsense show"), "{text}");
            }
            UploadError::After(_) => assert_eq!(now, Some(2)),
            other => panic!("cut at {at}: {other}"),
        }
    }
}

#[test]
fn a_refusal_of_the_board_is_told_apart_from_the_line() {
    let mut client = connect(&board(|_| {})).unwrap();
    let error = client.rate(123).unwrap_err();
    assert!(matches!(error, LinkError::Refused(_)));
    assert!(error.to_string().contains("123 Hz"));
    let mut other = fake::set::set(1);
    other.board = [0; 12];
    let other = fake::set::encoded(&other);
    let error = client.upload(&other, &KEY).unwrap_err().to_string();
    assert!(
        error.contains("another board") && error.contains("still active"),
        "{error}"
    );
}

#[test]
fn a_set_that_reads_back_differently_is_reported() {
    let board = board(|board| board.fault = Fault::WornFlash);
    let error = connect(&board)
        .unwrap()
        .upload(&encoded(1), &KEY)
        .unwrap_err();
    assert!(matches!(error, UploadError::Different { .. }), "{error}");
}
