//! Refusals that the board counts, as the status shows them.

mod fake;

use std::sync::{Arc, Mutex};

use fake::FakeBoard;
use fake::key::KEY;
use fake::line::Line;
use fake::set::{encoded, set};
use fake::source::Still;
use hexsense_client::{ChangeError, Client, LinkError, UploadError};
use hexsense_core::wire::Refusal;
use hexsense_core::wire::change::Key;
use hexsense_core::wire::status::Events;

const OTHER_KEY: Key = Key([0x0D; 32]);

fn refused(client: &mut Client, key: &Key) -> Refusal {
    match client.upload(&encoded(&set(1)), key) {
        Err(UploadError::Refused(ChangeError::Refused(refusal))) => refusal,
        other => panic!("{other:?}"),
    }
}

/// Wrong tags, refused changes, refused requests.
fn counts(client: &mut Client) -> [u32; 3] {
    let Events {
        wrong_tags,
        changes_refused,
        requests_refused,
        ..
    } = client.status().unwrap().events;
    [wrong_tags, changes_refused, requests_refused].map(|event| event.count)
}

#[test]
fn refusals_are_counted_by_their_kind() {
    let board = Arc::new(Mutex::new(FakeBoard::new(Box::new(Still))));
    let mut client = Client::connect(Line::to(&board)).unwrap();
    assert_eq!(counts(&mut client), [0, 0, 0]);
    assert_eq!(refused(&mut client, &OTHER_KEY), Refusal::WrongTag);
    assert_eq!(counts(&mut client), [1, 0, 0]);
    // The board takes no change for a second now, and the next wrong tag is not looked at.
    let waits = refused(&mut client, &KEY);
    assert!(matches!(waits, Refusal::BackOff { .. }), "{waits:?}");
    assert_eq!(counts(&mut client), [1, 1, 0]);
    for _ in 0..3 {
        let error = client.sums(9, 0).unwrap_err();
        assert!(matches!(
            error,
            LinkError::Refused(Refusal::Analyser { .. })
        ));
    }
    assert_eq!(counts(&mut client), [1, 1, 3]);
}
