//! After any reset the board samples with its coefficients at once, and says why it was reset and what it lost.

use hexsense_core::wire::change::Act;
use hexsense_core::wire::status::{ResetCause, Resets, Status};
use hexsense_core::wire::{Request, Response};

use crate::bench::Board;
use crate::set::{KEY, tagged, upload};

/// When the reset comes, s after power-on.
const RESET_S: f64 = 2.0;
/// How long the board may take from its reset to the first block with its set, s.
const LIMIT_S: f64 = 0.1;
/// How long a hang may last, s: the watchdog's second, which its oscillator makes from 0.95 to 1.05, and the period in
/// which it is fed.
const BITE_S: f64 = 1.2;

/// A board with a set, whose power was cut and comes back at time 0, and the fault that will come to it at [`RESET_S`].
fn with_set(name: &str, fault: &str) -> Board {
    let mut board = Board::on(name);
    upload(&mut board, 1);
    let line = if fault.is_empty() {
        String::new()
    } else {
        format!("{{\"at_s\":{RESET_S},{fault}}}\n")
    };
    board.power_cycled(&line)
}

/// The first status of a board that started after `since_s` and samples with its set, and the time from power-on to the
/// first such block, s.
fn sampling(board: &mut Board, since_s: f64, patience_s: f64) -> (Status, f64) {
    let until_us = board.now_us + (patience_s * 1e6) as u64;
    while board.now_us < until_us {
        let Some(status) = board.status_as_soon_as(patience_s) else {
            break;
        };
        let started_s = board.now_us as f64 * 1e-6 - status.uptime_ms as f64 * 1e-3;
        // Whoever hangs is not the one who answers, and that one goes on until the watchdog bites.
        let Some(first_ms) = status.first_with_set_ms else {
            continue;
        };
        if started_s >= since_s {
            return (status, started_s + first_ms as f64 * 1e-3);
        }
    }
    panic!("no block with the set");
}

fn cause(board: &mut Board) -> ResetCause {
    match board.ask(&Request::Identity) {
        Response::Identity(identity) => identity.reset,
        other => panic!("{other:?}"),
    }
}

/// What the fault ended in: why the board says it was reset, and from then on how long it took, s.
fn after(name: &str, fault: &str, patience_s: f64) -> (ResetCause, Status, f64) {
    let mut board = with_set(name, fault);
    board.run_s(RESET_S);
    let (status, first_s) = sampling(&mut board, RESET_S, patience_s);
    println!(
        "{name}: {:?}, first block with the set {:.1} ms after the fault, {:?}, panic {:?}",
        cause(&mut board),
        (first_s - RESET_S) * 1e3,
        status.resets,
        status.panic
    );
    (cause(&mut board), status, first_s - RESET_S)
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn after_power_on_it_samples_with_its_set_within_a_tenth_of_a_second() {
    let mut board = with_set("power-on", "");
    let (status, first_s) = sampling(&mut board, 0.0, 1.0);
    println!(
        "power-on: first block with the set after {:.1} ms",
        first_s * 1e3
    );
    assert!(first_s < LIMIT_S, "{first_s} s");
    let once = Resets {
        starts: 1,
        ..Resets::default()
    };
    assert_eq!(
        (cause(&mut board), status.resets),
        (ResetCause::PowerOn, once)
    );
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn after_a_reset_it_samples_with_its_set_within_a_tenth_of_a_second_and_says_why() {
    type Count = fn(&Resets) -> u32;
    let resets: [(&str, &str, ResetCause, Count); 5] = [
        ("pin", "\"fault\":\"pin_reset\"", ResetCause::Pin, |r| r.pin),
        (
            "brown-out",
            "\"fault\":\"brown_out\",\"ram_kept\":true",
            ResetCause::BrownOut,
            |r| r.brown_outs,
        ),
        (
            "hard-fault",
            "\"fault\":\"jump\",\"address\":\"0x60000000\"",
            ResetCause::Panic,
            |r| r.panics,
        ),
        (
            "overflow",
            "\"fault\":\"stack_pointer\",\"address\":\"0x20000010\"",
            ResetCause::Panic,
            |r| r.panics,
        ),
        (
            "deep-overflow",
            "\"fault\":\"stack_pointer\",\"address\":\"0x1ffffc00\"",
            ResetCause::Panic,
            |r| r.panics,
        ),
    ];
    for (name, fault, expected, count) in resets {
        let (found, status, took_s) = after(name, fault, 1.0);
        assert_eq!(found, expected, "{name}");
        assert!(took_s < LIMIT_S, "{name}: {took_s} s");
        assert_eq!(
            (status.resets.starts, count(&status.resets)),
            (2, 1),
            "{name}"
        );
        let before_ms = status.resets.previous_uptime_ms.unwrap();
        assert!(
            (1_800..2_000).contains(&before_ms),
            "{name}: {before_ms} ms"
        );
        let message = status.panic.as_deref().unwrap_or_default();
        let told = match name {
            "hard-fault" => message.contains("hard fault at 0x6000"),
            "overflow" | "deep-overflow" => message.contains("stack overflow"),
            _ => message.is_empty(),
        };
        assert!(told, "{name}: {message}");
    }
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_dip_that_empties_ram_is_a_power_on() {
    let (found, status, took_s) = after(
        "ram-lost",
        "\"fault\":\"brown_out\",\"ram_kept\":false",
        1.0,
    );
    assert_eq!((found, status.resets.starts), (ResetCause::PowerOn, 1));
    assert!(took_s < LIMIT_S, "{took_s} s");
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn resets_of_every_cause_add_up_over_resets() {
    let faults = [
        (0.2, "\"fault\":\"hang\""),
        (1.6, "\"fault\":\"pin_reset\""),
        (1.7, "\"fault\":\"pin_reset\""),
        (1.8, "\"fault\":\"brown_out\",\"ram_kept\":true"),
        (1.9, "\"fault\":\"brown_out\",\"ram_kept\":true"),
        (2.0, "\"fault\":\"brown_out\",\"ram_kept\":true"),
        (2.1, "\"fault\":\"jump\",\"address\":\"0x60000000\""),
        (2.2, "\"fault\":\"jump\",\"address\":\"0x60000000\""),
        (2.3, "\"fault\":\"jump\",\"address\":\"0x60000000\""),
        (2.4, "\"fault\":\"jump\",\"address\":\"0x60000000\""),
        (2.5, "\"fault\":\"jump\",\"address\":\"0x60000000\""),
    ];
    let lines = faults.map(|(at_s, fault)| format!("{{\"at_s\":{at_s},{fault}}}\n"));
    let mut board = Board::on("add-up").power_cycled(&lines.concat());
    board.run_s(2.7);
    let resets = board.status().resets;
    let expected = Resets {
        starts: 12,
        watchdog: 1,
        pin: 2,
        brown_outs: 3,
        panics: 5,
        previous_uptime_ms: resets.previous_uptime_ms,
        ..Resets::default()
    };
    assert_eq!(resets, expected);
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_part_that_hangs_is_bitten_by_the_watchdog() {
    // Thread mode: storage, pose, supervisor. Interrupts 82 and 83 run sampling task and link, 11 the sample path.
    for (name, exception) in [
        ("everything", None),
        ("thread", Some(0)),
        ("sampling-task", Some(16 + 82)),
        ("link", Some(16 + 83)),
        ("sample-path", Some(16 + 11)),
    ] {
        let exception = exception.map_or("null".to_owned(), |number| number.to_string());
        let fault = format!("\"fault\":\"hang\",\"exception\":{exception}");
        let (found, status, took_s) = after(name, &fault, 3.0);
        assert_eq!(found, ResetCause::Watchdog, "{name}");
        assert_eq!(
            (status.resets.starts, status.resets.watchdog),
            (2, 1),
            "{name}"
        );
        assert!(took_s < BITE_S + LIMIT_S, "{name}: {took_s} s");
    }
}

/// A stall of 1.3 s ends in a bite, and soon after the stall the board samples with its set.
fn assert_bitten_in_a_stall(name: &str, fault: &str) {
    let (found, status, took_s) = after(name, fault, 3.0);
    assert_eq!(found, ResetCause::Watchdog);
    assert_eq!((status.resets.starts, status.resets.watchdog), (2, 1));
    assert!(took_s < 1.3 + LIMIT_S, "{took_s} s");
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_link_that_waits_for_its_transmitter_is_bitten_by_the_watchdog() {
    // Sampling and storage are well meanwhile.
    assert_bitten_in_a_stall(
        "no-transmitter",
        "\"fault\":\"dma_stall\",\"of\":\"transmitter\",\"duration_us\":1300000",
    );
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_storage_that_waits_for_its_flash_is_bitten_by_the_watchdog() {
    // Sampling and link are well meanwhile: the board answers until it is bitten.
    let mut board = with_set(
        "no-end-of-erasure",
        "\"fault\":\"flash_stall\",\"duration_us\":9000000",
    );
    board.run_s(RESET_S);
    let request = tagged(&mut board, Act::Provision(KEY));
    board.send(&request);
    let (status, first_s) = sampling(&mut board, RESET_S, 3.0);
    assert_eq!(cause(&mut board), ResetCause::Watchdog);
    assert_eq!((status.resets.starts, status.resets.watchdog), (2, 1));
    let took_s = first_s - RESET_S;
    assert!(took_s < BITE_S + LIMIT_S, "{took_s} s");
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn converters_that_no_new_start_helps_are_bitten_by_the_watchdog() {
    // Link and storage are well meanwhile.
    assert_bitten_in_a_stall(
        "no-triggers",
        "\"fault\":\"trigger_stall\",\"duration_us\":1300000",
    );
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn without_its_crystal_it_comes_back_on_the_internal_oscillator_and_says_so() {
    let mut board = with_set("crystal", "\"fault\":\"crystal\"");
    board.run_s(1.0);
    assert!(board.status().crystal);
    board.run_s(RESET_S - 1.0);
    let (status, first_s) = sampling(&mut board, RESET_S, 5.0);
    assert_eq!(cause(&mut board), ResetCause::Watchdog);
    assert!(!status.crystal, "{status:?}");
    let took_s = first_s - RESET_S;
    assert!(took_s < BITE_S + LIMIT_S, "{took_s} s");
}
