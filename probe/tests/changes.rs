//! Changes of what the board keeps, through the link client: made once or not at all, only with the key, each logged.

mod fake;

use std::sync::{Arc, Mutex};
use std::time::Duration;

use fake::key::KEY;
use fake::line::Line;
use fake::source::Still;
use fake::{FakeBoard, Fault};
use hexsense_client::{ChangeError, Client, UploadError};
use hexsense_core::records::log::{Entry, Reason};
use hexsense_core::records::{CoefficientSet, SetId};
use hexsense_core::wire::Refusal;
use hexsense_core::wire::change::Key;

const OTHER_KEY: Key = Key([0x0D; 32]);
const FACTORY_RESET: &str = "factory reset";
const ROLLBACK: &str = "rollback";
const PROVISION: &str = "provision";

fn encoded(unix_s: u64) -> Vec<u8> {
    fake::set::encoded(&fake::set::set(unix_s))
}

fn id(unix_s: u64) -> SetId {
    CoefficientSet::id_of(&encoded(unix_s))
}

fn connect(board: &Arc<Mutex<FakeBoard>>) -> Client {
    Client::connect(Line::to(board)).unwrap()
}

/// A board that had set 1, then set 2, and a client of it that has asked only for that.
fn board_with_two_sets() -> (Arc<Mutex<FakeBoard>>, Client) {
    let board = Arc::new(Mutex::new(FakeBoard::new(Box::new(Still))));
    let mut client = connect(&board);
    for set in [1, 2] {
        client.upload(&encoded(set), &KEY).unwrap();
    }
    (board, client)
}

/// What a board is made of for these tests: reasons in its log, kept sets, active set.
type Kept = (Vec<Reason>, Vec<SetId>, Option<SetId>);

fn kept(client: &mut Client) -> Kept {
    let log = client.log(1).unwrap();
    assert!(
        log.iter()
            .map(|entry| entry.counter)
            .eq(1..=log.len() as u32)
    );
    let history = client.history().unwrap();
    (
        log.iter().map(|entry| entry.reason).collect(),
        history.iter().map(|kept| kept.id).collect(),
        client.active_set().unwrap().map(|active| active.id),
    )
}

/// What a board with two sets is made of before and after a change.
fn before() -> Kept {
    let log = [Reason::Provision, Reason::Upload, Reason::Upload];
    (log.to_vec(), vec![id(2), id(1)], Some(id(2)))
}

fn after(change: &str) -> Kept {
    let (mut log, mut history, mut active) = before();
    match change {
        ROLLBACK => {
            log.push(Reason::Rollback);
            active = Some(id(1));
        }
        FACTORY_RESET => {
            log.push(Reason::FactoryReset);
            (history, active) = (Vec::new(), None);
        }
        _ => log.push(Reason::Provision),
    }
    (log, history, active)
}

fn make(client: &mut Client, change: &str, key: &Key) -> Result<(), ChangeError> {
    match change {
        ROLLBACK => {
            let active = client.roll_back(key, id(1))?;
            // Its upload was the second change, after the key.
            assert_eq!((active.id, active.sequence), (id(1), 2));
        }
        FACTORY_RESET => {
            let erased = client.factory_reset(key)?;
            let ids: Vec<_> = erased.iter().map(|kept| kept.id).collect();
            assert_eq!(ids, [id(2), id(1)]);
        }
        _ => client.provision(key, &OTHER_KEY)?,
    }
    Ok(())
}

const CHANGES: [&str; 3] = [ROLLBACK, FACTORY_RESET, PROVISION];

/// Requests of a change are fewer than this: history of a reset, end of the log, identity, challenge, change, and what
/// is asked when an answer is lost.
const REQUESTS: u32 = 12;

#[test]
fn a_change_survives_any_single_lost_or_damaged_answer_and_is_made_once() {
    for change in CHANGES {
        for at in 0..REQUESTS {
            for fault in [Fault::LoseAnswer, Fault::DamageAnswer, Fault::DelayAnswer] {
                let (board, mut client) = board_with_two_sets();
                {
                    let mut board = board.lock().unwrap();
                    board.fault = fault(board.requests() + 1 + at);
                }
                make(&mut client, change, &KEY)
                    .unwrap_or_else(|error| panic!("{change}, request {at}: {error}"));
                board.lock().unwrap().fault = Fault::None;
                assert_eq!(kept(&mut client), after(change), "{change}, request {at}");
            }
        }
    }
}

#[test]
fn a_change_that_the_line_swallows_is_made_whole_or_not_at_all_and_the_error_says_so() {
    for change in CHANGES {
        let mut not_made = 0;
        for at in 0..REQUESTS {
            let (board, mut client) = board_with_two_sets();
            {
                let mut board = board.lock().unwrap();
                board.fault = Fault::LoseRequest(board.requests() + 1 + at);
            }
            let made = make(&mut client, change, &KEY);
            board.lock().unwrap().fault = Fault::None;
            match made {
                Ok(()) => assert_eq!(kept(&mut client), after(change), "{change} {at}"),
                Err(error) => {
                    let text = error.to_string();
                    assert!(text.contains("Nothing has changed on the board"), "{text}");
                    assert_eq!(kept(&mut client), before(), "{change} {at}");
                    not_made += 1;
                }
            }
        }
        // All but the change itself are asked again.
        assert_eq!(not_made, 1, "{change}");
    }
}

#[test]
fn a_change_cut_off_anywhere_says_whether_it_may_have_been_made() {
    for change in CHANGES {
        const FAULTS: [fn(u32) -> Fault; 2] = [Fault::CutAt, Fault::CutAfter];
        let mut unsure = Vec::new();
        for (at, fault) in (0..REQUESTS).flat_map(|at| FAULTS.map(|fault| (at, fault))) {
            let (board, mut client) = board_with_two_sets();
            {
                let mut board = board.lock().unwrap();
                board.fault = fault(board.requests() + 1 + at);
            }
            let made = make(&mut client, change, &KEY);
            board.lock().unwrap().switch_on();
            let now = kept(&mut connect(&board));
            match made {
                Ok(()) => assert_eq!(now, after(change)),
                Err(ChangeError::Before(_)) => assert_eq!(now, before()),
                Err(error @ ChangeError::During { .. }) => {
                    assert!(error.to_string().contains("hexsense log"), "{error}");
                    unsure.push(now);
                }
                Err(error) => panic!("{change} {at}: {error}"),
            }
        }
        assert_eq!(unsure, [before(), after(change)]);
    }
}

#[test]
fn another_key_changes_nothing_and_the_board_then_waits_ever_longer() {
    let (board, mut client) = board_with_two_sets();
    let mut wait_ms = 1_000;
    for change in [CHANGES, CHANGES].concat() {
        let refused = make(&mut client, change, &OTHER_KEY).unwrap_err();
        assert!(
            matches!(refused, ChangeError::Refused(Refusal::WrongTag)),
            "{refused}"
        );
        // Not even the right key helps now.
        let refused = make(&mut client, change, &KEY).unwrap_err();
        let ChangeError::Refused(Refusal::BackOff { ms }) = refused else {
            panic!("{refused}")
        };
        assert!(
            (1..=wait_ms).contains(&ms) && ms > wait_ms / 2,
            "{ms} of {wait_ms}"
        );
        assert!(
            refused.to_string().contains(&format!("{ms} ms")),
            "{refused}"
        );
        let uploaded = client.upload(&encoded(3), &KEY).unwrap_err();
        assert!(
            matches!(
                uploaded,
                UploadError::Refused(ChangeError::Refused(Refusal::BackOff { .. }))
            ),
            "{uploaded}"
        );
        assert_eq!(kept(&mut client), before());
        board
            .lock()
            .unwrap()
            .wait(Duration::from_millis(wait_ms.into()));
        wait_ms *= 2;
    }
    make(&mut client, ROLLBACK, &KEY).unwrap();
    assert_eq!(kept(&mut client), after(ROLLBACK));
}

#[test]
fn a_recorded_session_played_again_changes_nothing() {
    let (board, mut client) = board_with_two_sets();
    make(&mut client, ROLLBACK, &KEY).unwrap();
    client.upload(&encoded(3), &KEY).unwrap();
    client.provision(&KEY, &OTHER_KEY).unwrap();
    client.provision(&OTHER_KEY, &KEY).unwrap();
    let flash = board.lock().unwrap().flash.clone();
    let content = || flash.0.lock().unwrap().clone();
    let before = content();
    // At once; when no wait is left over from it; and after the power was cut.
    for play in 0..3 {
        let mut board = board.lock().unwrap();
        let heard = board.heard.clone();
        board.take(&heard);
        assert!(content() == before, "play {play} changed the flash");
        board.wait(Duration::from_secs(120));
        if play == 1 {
            board.switch_on();
        }
    }
    assert_eq!(client.active_set().unwrap().unwrap().id, id(3));
}

#[test]
fn a_board_without_a_key_takes_nothing_but_a_key() {
    let board = Arc::new(Mutex::new(FakeBoard::unprovisioned(Box::new(Still))));
    let mut client = connect(&board);
    assert!(!client.status().unwrap().provisioned);
    let refused = client.upload(&encoded(1), &KEY).unwrap_err().to_string();
    assert!(
        refused.contains("hexsense provision") && refused.contains("unchanged"),
        "{refused}"
    );
    for refused in [
        client.roll_back(&KEY, id(1)).map(drop).unwrap_err(),
        client.factory_reset(&KEY).map(drop).unwrap_err(),
    ] {
        assert!(
            matches!(refused, ChangeError::Refused(Refusal::Unprovisioned)),
            "{refused}"
        );
    }
    // The tag of the first key is made with itself.
    let refused = client.provision(&OTHER_KEY, &KEY).unwrap_err();
    assert!(
        matches!(refused, ChangeError::Refused(Refusal::WrongTag)),
        "{refused}"
    );
    board.lock().unwrap().wait(Duration::from_secs(1));
    client.provision(&KEY, &KEY).unwrap();
    assert!(client.status().unwrap().provisioned);
    client.upload(&encoded(1), &KEY).unwrap();
    let log = client.log(1).unwrap();
    let reasons = log.iter().map(|entry| entry.reason);
    assert!(reasons.eq([Reason::Provision, Reason::Upload]));
}

#[test]
fn a_log_of_many_pages_comes_whole_and_in_order() {
    let (_board, mut client) = board_with_two_sets();
    for change in 0..30 {
        client.roll_back(&KEY, id(1 + change % 2)).unwrap();
    }
    let log = client.log(1).unwrap();
    assert!(log.iter().map(|entry| entry.counter).eq(1..=33));
    for pair in log[1..].windows(2) {
        let [before, after]: &[Entry; 2] = pair.try_into().unwrap();
        assert_eq!(after.previous, before.id);
        assert_ne!(after.id, before.id);
    }
    assert_eq!(client.log(30).unwrap(), log[29..]);
    assert_eq!(client.log(34).unwrap(), []);
    assert_eq!(client.history().unwrap().len(), 2);
}
