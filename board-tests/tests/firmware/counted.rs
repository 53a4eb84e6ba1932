//! Every loss is counted, and the status tells its time.

use hexsense_core::wire::status::{EventCount, Events};
use hexsense_core::wire::{Kind, MAX_FRAME, Request, frame};
use serde_json::{Value, json};

use crate::{calibrated, on, run_until_s};

/// When the fault comes, s after power-on, and how much later its event may be noted, s.
const FAULT_S: f64 = 2.0;
const NOTED_S: f64 = 0.15;
/// The board's clock starts this much later than its power at most, s.
const CLOCK_S: f64 = 0.01;

/// The events of a board with a set, of which one fault makes some.
fn events_after(name: &str, mut fault: Value) -> anyhow::Result<Events> {
    fault["at_s"] = json!(FAULT_S);
    let mut board = calibrated(name, &[fault])?;
    let line = &mut board.line;
    run_until_s(line, FAULT_S - 0.1)?;
    assert_eq!(line.status()?.events, Events::NONE, "{name}");
    run_until_s(line, FAULT_S)?;
    // Faults of receiver and transmitter need something to receive and to send.
    for _ in 0..4 {
        line.send(&Request::ActiveSet)?;
        line.run_s(0.05)?;
    }
    line.run_s(0.5)?;
    let status = line.status()?;
    println!("{name}: lost {}, {:?}", status.scans_lost, status.events);
    Ok(status.events)
}

fn told(event: EventCount, name: &str) {
    assert!(event.count > 0, "{name} was not counted");
    let (from, to) = (FAULT_S - CLOCK_S, FAULT_S + NOTED_S);
    let last_s = event.last_ms as f64 * 1e-3;
    assert!((from..to).contains(&last_s), "{name}: {last_s} s");
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn each_fault_is_counted_as_what_it_is_and_as_nothing_else() -> anyhow::Result<()> {
    type Pick = fn(&mut Events) -> &mut EventCount;
    let line =
        |effect| json!({"fault": "line", "towards": "board", "effect": effect, "characters": 1});
    let stall = |of, us| json!({"fault": "dma_stall", "of": of, "duration_us": us});
    let slip = |adc: u8, result| json!({"fault": "dma_slip", "adc": adc, "result": result});
    let faults: [(&str, Value, Pick); 9] = [
        ("inertial lost", slip(1, "lost"), |events| &mut events.slips),
        ("inertial twice", slip(1, "twice"), |events| {
            &mut events.slips
        }),
        ("jack lost", slip(2, "lost"), |events| &mut events.slips),
        ("jack twice", slip(2, "twice"), |events| &mut events.slips),
        ("overrun", stall("converters", 2_000), |events| {
            &mut events.overruns
        }),
        (
            "stuck",
            json!({"fault": "trigger_stall", "duration_us": 80_000}),
            |events| &mut events.stuck,
        ),
        ("noise", line("noise"), |events| &mut events.receiver_errors),
        ("framing", line("framing"), |events| {
            &mut events.receiver_errors
        }),
        ("receiver", stall("receiver", 20_000), |events| {
            &mut events.receiver_overruns
        }),
    ];
    for (name, fault, pick) in faults {
        let mut events = events_after(name, fault)?;
        told(std::mem::take(pick(&mut events)), name);
    }
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn flaws_of_the_flash_are_counted_when_they_are_read() -> anyhow::Result<()> {
    let flaw =
        |address, bits| json!({"at_s": 0, "fault": "bit_error", "address": address, "bits": bits});
    // The archive looks at the begin of both its halves when it starts.
    let mut board = calibrated("flaws", &[flaw("0x08040000", 1), flaw("0x08042000", 2)])?;
    let line = &mut board.line;
    run_until_s(line, 1.0)?;
    let status = line.status()?;
    println!("{:?}", status.events);
    for event in [status.events.flash_corrections, status.events.torn_words] {
        assert!(
            event.count > 0 && event.last_ms < 100,
            "{:?}",
            status.events
        );
    }
    assert!(status.first_with_set_ms.is_some(), "the set is lost");
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn damaged_frames_are_told_apart() -> anyhow::Result<()> {
    let mut board = on("frames")?;
    let line = &mut board.line;
    let mut good = [0; MAX_FRAME];
    let length = frame::encode(Kind::Hello, 7, &mut good, |_| Some(0)).unwrap();
    let good = &good[..length];
    let mut changed = good.to_vec();
    changed[length - 2] ^= 1;
    let mut block = [0; MAX_FRAME];
    let length = frame::encode(Kind::Block, 8, &mut block, |_| Some(0)).unwrap();
    // The first byte says that another zero follows after 200 bytes, and the frame ends before.
    for bytes in [&changed, &[200, 1, 1, 0][..], &[2, 1, 0], &[1; 400], &[0]] {
        line.send_bytes(bytes)?;
        line.run_s(10e-3)?;
    }
    line.send_bytes(&block[..length])?;
    let events = line.status()?.events;
    assert_eq!(events.frames_of_wrong_checksum.count, 1, "{events:?}");
    assert_eq!(events.frames_not_cobs.count, 1, "{events:?}");
    assert_eq!(events.frames_of_wrong_length.count, 2, "{events:?}");
    assert_eq!(events.frames_of_wrong_kind.count, 1, "{events:?}");
    assert_eq!(events.frames_damaged(), 5);
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_noisy_character_costs_the_frame_it_is_in_and_is_counted() -> anyhow::Result<()> {
    // At 4 kHz a block is on the line for more than half of the time, and the instants come at every part of it.
    const NOISES: u32 = 60;
    let at_s = |number: u32| FAULT_S + f64::from(number) * 0.020_173;
    let faults: Vec<Value> = (0..NOISES)
        .map(|number| {
            json!({
                "at_s": at_s(number), "fault": "line",
                "towards": "board", "effect": "noise", "characters": 1,
            })
        })
        .collect();
    let mut board = calibrated("noisy", &faults)?;
    let line = &mut board.line;
    line.stream_everything()?;
    for number in 0..NOISES {
        run_until_s(line, at_s(number))?;
        line.send(&Request::ActiveSet)?;
    }
    line.run_s(0.5)?;
    let blocks: Vec<u16> = line.blocks.iter().map(|block| block.sequence).collect();
    let missing = blocks
        .windows(2)
        .filter(|pair| pair[1] != pair[0].wrapping_add(1))
        .count();
    assert_eq!((line.damaged(), missing), (0, 0), "frames from the board");
    let events = line.status()?.events;
    assert_eq!(events.receiver_errors.count, NOISES, "{events:?}");
    Ok(())
}
