//! Everything that is lost is counted, with its time, and told in the status.

use hexsense_core::wire::status::{EventCount, Events};
use hexsense_core::wire::{Kind, MAX_FRAME, frame};

use crate::bench::Board;
use crate::set::upload;

/// When the fault comes, s after power-on, and how much later its event may be noted, s.
const FAULT_S: f64 = 2.0;
const NOTED_S: f64 = 0.15;
/// The board's clock starts this much later than its power at most, s.
const CLOCK_S: f64 = 0.01;

/// The events of a board with a set, of which one fault makes some.
fn events_after(name: &str, faults: &[&str]) -> Events {
    let mut board = Board::on(name);
    upload(&mut board, 1);
    let lines: String = faults
        .iter()
        .map(|fault| format!("{{\"at_s\":{FAULT_S},{fault}}}\n"))
        .collect();
    let mut board = board.power_cycled(&lines);
    board.run_s(FAULT_S - 0.1);
    assert_eq!(board.status().events, Events::NONE, "{name}");
    board.run_s(0.1);
    // Something to receive and to send for whatever disturbs that.
    for _ in 0..4 {
        board.send(&hexsense_core::wire::Request::ActiveSet);
        board.run_s(0.05);
    }
    board.run_s(0.5);
    let status = board.status();
    println!("{name}: lost {}, {:?}", status.scans_lost, status.events);
    status.events
}

fn told(tally: EventCount, name: &str) {
    assert!(tally.count > 0, "{name} was not counted");
    let (from, to) = (FAULT_S - CLOCK_S, FAULT_S + NOTED_S);
    let last_s = tally.last_ms as f64 * 1e-3;
    assert!((from..to).contains(&last_s), "{name}: {last_s} s");
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn each_fault_is_counted_as_what_it_is_and_as_nothing_else() {
    type Pick = fn(&mut Events) -> &mut EventCount;
    let faults: [(&str, &str, Pick); 5] = [
        (
            "overrun",
            "\"fault\":\"dma_stall\",\"of\":\"converters\",\"duration_us\":2000",
            |events| &mut events.overruns,
        ),
        (
            "stuck",
            "\"fault\":\"trigger_stall\",\"duration_us\":80000",
            |events| &mut events.stuck,
        ),
        (
            "noise",
            "\"fault\":\"line\",\"towards\":\"board\",\"effect\":\"noise\",\"characters\":1",
            |events| &mut events.receiver_errors,
        ),
        (
            "framing",
            "\"fault\":\"line\",\"towards\":\"board\",\"effect\":\"framing\",\"characters\":1",
            |events| &mut events.receiver_errors,
        ),
        (
            "receiver",
            "\"fault\":\"dma_stall\",\"of\":\"receiver\",\"duration_us\":20000",
            |events| &mut events.receiver_overruns,
        ),
    ];
    for (name, fault, pick) in faults {
        let mut events = events_after(name, &[fault]);
        told(std::mem::take(pick(&mut events)), name);
    }
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn flaws_of_the_flash_are_counted_when_they_are_read() {
    let mut board = Board::on("flaws");
    upload(&mut board, 1);
    // The archive looks at the begin of both its halves when it starts.
    let mut board = board.power_cycled(
        "{\"at_s\":0,\"fault\":\"bit_error\",\"address\":\"0x08040000\",\"bits\":1}\n\
         {\"at_s\":0,\"fault\":\"bit_error\",\"address\":\"0x08042000\",\"bits\":2}\n",
    );
    board.run_s(1.0);
    let status = board.status();
    println!("{:?}", status.events);
    for tally in [status.events.flash_corrections, status.events.torn_words] {
        assert!(
            tally.count > 0 && tally.last_ms < 100,
            "{:?}",
            status.events
        );
    }
    assert!(status.first_with_set_ms.is_some(), "the set is lost");
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn damaged_frames_are_told_apart() {
    let mut board = Board::on("frames");
    let mut good = [0; MAX_FRAME];
    let length = frame::encode(Kind::Hello, 7, &mut good, |_| Some(0)).unwrap();
    let good = &good[..length];
    let mut changed = good.to_vec();
    changed[length - 2] ^= 1;
    let mut block = [0; MAX_FRAME];
    let length = frame::encode(Kind::Block, 8, &mut block, |_| Some(0)).unwrap();
    // The first byte says that another zero follows after 200 bytes, and the frame ends before.
    for bytes in [&changed, &[200, 1, 1, 0][..], &[2, 1, 0], &[1; 400], &[0]] {
        board.raw(bytes);
    }
    board.raw(&block[..length]);
    let events = board.status().events;
    assert_eq!(events.frames_of_wrong_checksum.count, 1, "{events:?}");
    assert_eq!(events.frames_not_cobs.count, 1, "{events:?}");
    assert_eq!(events.frames_of_wrong_length.count, 2, "{events:?}");
    assert_eq!(events.frames_of_wrong_kind.count, 1, "{events:?}");
    assert_eq!(events.frames_damaged(), 5);
}
