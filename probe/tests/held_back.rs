//! Changes that somebody on the line holds back, and answers that the board did not give: what the host says of them is
//! true, also when they arrive later.

mod fake;

use std::sync::{Arc, Mutex};
use std::time::Duration;

use fake::key::KEY;
use fake::line::Line;
use fake::source::Still;
use fake::{FakeBoard, Lie};
use hexsense_client::{ChangeError, Client, UploadError};
use hexsense_core::records::{CoefficientSet, SetId};
use hexsense_core::wire::change::Key;
use hexsense_core::wire::{Refusal, Request, Response};

const OTHER_KEY: Key = Key([0x0D; 32]);

fn encoded(unix_s: u64) -> Vec<u8> {
    fake::set::encoded(&fake::set::set(unix_s))
}

fn id(unix_s: u64) -> SetId {
    CoefficientSet::id_of(&encoded(unix_s))
}

/// A board that had set 1, then set 2, and a client of it.
fn board_with_two_sets() -> (Arc<Mutex<FakeBoard>>, Client) {
    let board = Arc::new(Mutex::new(FakeBoard::new(Box::new(Still))));
    let mut client = Client::connect(Line::to(&board)).unwrap();
    for set in [1, 2] {
        client.upload(&encoded(set), &KEY).unwrap();
    }
    (board, client)
}

type Make = fn(&mut Client) -> Result<(), ChangeError>;

/// A change of each kind that is made in one step.
const CHANGES: [Make; 3] = [
    |client| client.roll_back(&KEY, id(1)).map(drop),
    |client| client.factory_reset(&KEY).map(drop),
    |client| client.provision(&KEY, &OTHER_KEY),
];

/// Content of the board's flash.
fn flash(board: &Mutex<FakeBoard>) -> Vec<u8> {
    let flash = board.lock().unwrap().flash.clone();
    flash.0.lock().unwrap().clone()
}

/// Lets what was held back arrive, at once and after some time: the board refuses all of it, and its flash stays as it was.
fn arrives_in_vain(board: &Mutex<FakeBoard>, before: &[u8]) {
    for pause in [Duration::ZERO, Duration::from_secs(1)] {
        board.lock().unwrap().wait(pause);
        let answers = board.lock().unwrap().deliver();
        assert!(!answers.is_empty());
        for answer in answers {
            assert!(matches!(answer, Response::Refused(_)), "{answer:?}");
        }
        assert!(flash(board) == before);
    }
}

#[test]
fn a_change_that_arrives_after_the_host_said_that_nothing_changed_is_not_made() {
    for make in CHANGES {
        let (board, mut client) = board_with_two_sets();
        let before = flash(&board);
        board.lock().unwrap().lie = |request| match request {
            Request::Change { .. } => Lie::Hold(None),
            _ => Lie::None,
        };
        let error = make(&mut client).unwrap_err();
        assert!(matches!(error, ChangeError::Before(_)), "{error}");
        assert!(error.to_string().contains("Nothing has changed"), "{error}");
        arrives_in_vain(&board, &before);
    }
}

#[test]
fn a_refusal_that_somebody_on_the_line_made_up_is_true_in_the_end() {
    for make in CHANGES {
        let (board, mut client) = board_with_two_sets();
        let before = flash(&board);
        board.lock().unwrap().lie = |request| match request {
            Request::Change { .. } => Lie::Hold(Some(Response::Refused(Refusal::LogFull))),
            _ => Lie::None,
        };
        let error = make(&mut client).unwrap_err();
        assert!(
            matches!(error, ChangeError::Refused(Refusal::LogFull)),
            "{error}"
        );
        arrives_in_vain(&board, &before);
    }
}

/// Begin, pieces and commit are held back and answered by the liar; all of them arrive when the host has given up.
#[test]
fn an_upload_that_arrives_after_the_host_said_that_the_old_set_is_active_is_not_made() {
    let lies: [fn(&Request) -> Lie; 2] = [
        |request| match request {
            Request::Change { .. } | Request::UploadChunk { .. } => Lie::Hold(Some(Response::Done)),
            Request::UploadCommit => Lie::Hold(None),
            _ => Lie::None,
        },
        |request| match request {
            Request::UploadCommit => Lie::Hold(Some(Response::Refused(Refusal::Expired))),
            _ => Lie::None,
        },
    ];
    for lie in lies {
        let (board, mut client) = board_with_two_sets();
        let before = flash(&board);
        board.lock().unwrap().lie = lie;
        let error = client.upload(&encoded(3), &KEY).unwrap_err();
        assert!(matches!(error, UploadError::Before(_)), "{error}");
        arrives_in_vain(&board, &before);
        assert_eq!(client.active_set().unwrap().unwrap().id, id(2));
    }
}

/// A liar who answers the question for a proof, or keeps it, gets no claim from the host.
#[test]
fn without_a_proof_the_host_says_that_it_does_not_know() {
    let lies: [fn(&Request) -> Lie; 4] = [
        |request| match request {
            Request::Change { .. } | Request::Prove { .. } => Lie::Hold(None),
            _ => Lie::None,
        },
        |request| match request {
            Request::Change { .. } => Lie::Hold(Some(Response::Refused(Refusal::LogFull))),
            Request::Prove { .. } => Lie::Hold(None),
            _ => Lie::None,
        },
        |request| match request {
            Request::Change { .. } => Lie::Hold(None),
            Request::Prove { .. } => {
                let statement = hexsense_core::wire::change::Statement {
                    set: Some(id(2)),
                    changes: 3,
                };
                let tag = [0x77; 32];
                Lie::Hold(Some(Response::Proof { statement, tag }))
            }
            _ => Lie::None,
        },
        |request| match request {
            Request::Change { .. } => Lie::Hold(None),
            Request::Prove { .. } => Lie::Hold(Some(Response::Done)),
            _ => Lie::None,
        },
    ];
    for (lie, make) in lies
        .into_iter()
        .flat_map(|lie| CHANGES.map(|make| (lie, make)))
    {
        let (board, mut client) = board_with_two_sets();
        board.lock().unwrap().lie = lie;
        let error = make(&mut client).unwrap_err();
        assert!(matches!(error, ChangeError::During { .. }), "{error}");
        let text = error.to_string();
        assert!(
            text.contains("not known") && text.contains("`hexsense log --port fake`"),
            "{text}"
        );
    }
}
