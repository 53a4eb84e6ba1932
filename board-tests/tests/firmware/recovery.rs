//! After any reset the board samples with its coefficients at once, and it reports the cause and the losses.

use std::time::Duration;

use anyhow::{Context, ensure};
use board_tests::bench::Board;
use board_tests::key_holder::KeyHolder;
use board_tests::line::Line;
use hexsense_core::wire::change::Act;
use hexsense_core::wire::status::{ResetCause, Resets, Status};
use serde_json::{Value, json};

use crate::{bench, calibrated, run_until_s};

/// When the reset comes, s after power-on.
const RESET_S: f64 = 2.0;
/// How long the board may take from its reset to the first block with its set, s.
const LIMIT_S: f64 = 0.1;
/// How long a hang may last, s: the watchdog's second, which its oscillator makes from 0.95 to 1.05, and the period in
/// which it is fed.
const BITE_S: f64 = 1.2;

/// A stall that only a bite ends, µs and s.
const STALL_US: u32 = 1_300_000;
const STALL_S: f64 = 1.3;
/// The test asks for a status so often while it may be in a reset.
const LOOK: Duration = Duration::from_millis(2);

/// A board with a set, to which this fault comes at [`RESET_S`].
fn with_set(name: &str, mut fault: Value) -> anyhow::Result<Board> {
    fault["at_s"] = json!(RESET_S);
    calibrated(name, &[fault])
}

/// The end of a fault.
struct Recovered {
    /// The board's reason for its reset.
    cause: ResetCause,
    /// The first status after it in which the board samples with its set.
    status: Status,
    /// From the fault to the first block with the set, s.
    took_s: f64,
}

/// Waits until a board that started after `since_s` samples with its set.
fn sampling(line: &mut Line, since_s: f64, patience_s: f64) -> anyhow::Result<Recovered> {
    let until = line.now() + Duration::from_secs_f64(patience_s);
    while line.now() < until {
        let Some(status) = line.status_within(LOOK)? else {
            continue;
        };
        let started_s = line.now().as_secs_f64() - status.uptime_ms as f64 * 1e-3;
        // A task that hangs does not answer; the link does, until the watchdog bites.
        if let Some(first_ms) = status.first_with_set_ms
            && started_s >= since_s
        {
            return Ok(Recovered {
                cause: line.identity()?.reset,
                status,
                took_s: started_s + first_ms as f64 * 1e-3 - since_s,
            });
        }
    }
    anyhow::bail!("no block with the set")
}

/// What the fault ended in.
fn after(name: &str, fault: Value, patience_s: f64) -> anyhow::Result<Recovered> {
    let mut board = with_set(name, fault)?;
    run_until_s(&mut board.line, RESET_S)?;
    let recovered = sampling(&mut board.line, RESET_S, patience_s).context(name.to_owned())?;
    println!(
        "{name}: {:?}, first block with the set {:.1} ms after the fault, {:?}, panic {:?}",
        recovered.cause,
        recovered.took_s * 1e3,
        recovered.status.resets,
        recovered.status.panic
    );
    Ok(recovered)
}

impl Recovered {
    /// The watchdog bit once, and within `limit_s` of the fault the board sampled with its set.
    fn assert_bitten(&self, name: &str, limit_s: f64) {
        assert_eq!(self.cause, ResetCause::Watchdog, "{name}");
        let resets = &self.status.resets;
        assert_eq!((resets.starts, resets.watchdog), (2, 1), "{name}");
        assert!(self.took_s < limit_s, "{name}: {} s", self.took_s);
    }
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn after_power_on_it_samples_with_its_set_within_a_tenth_of_a_second() -> anyhow::Result<()> {
    let mut board = calibrated("power-on", &[])?;
    let recovered = sampling(&mut board.line, 0.0, 1.0)?;
    let took_s = recovered.took_s;
    println!(
        "power-on: first block with the set after {:.1} ms",
        took_s * 1e3
    );
    assert!(took_s < LIMIT_S, "{took_s} s");
    let once = Resets {
        starts: 1,
        ..Resets::default()
    };
    assert_eq!(recovered.cause, ResetCause::PowerOn);
    assert_eq!(recovered.status.resets, once);
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn after_a_reset_it_samples_with_its_set_within_a_tenth_of_a_second_and_says_why()
-> anyhow::Result<()> {
    type Count = fn(&Resets) -> u32;
    let overflow = |address| json!({"fault": "stack_pointer", "address": address});
    let resets: [(&str, Value, ResetCause, Count); 5] = [
        ("pin", json!({"fault": "pin_reset"}), ResetCause::Pin, |r| {
            r.pin
        }),
        (
            "brown-out",
            json!({"fault": "brown_out", "ram_kept": true}),
            ResetCause::BrownOut,
            |r| r.brown_outs,
        ),
        (
            "hard-fault",
            json!({"fault": "jump", "address": "0x60000000"}),
            ResetCause::Panic,
            |r| r.panics,
        ),
        ("overflow", overflow("0x20000010"), ResetCause::Panic, |r| {
            r.panics
        }),
        (
            "deep-overflow",
            overflow("0x1ffffc00"),
            ResetCause::Panic,
            |r| r.panics,
        ),
    ];
    for (name, fault, expected, count) in resets {
        let Recovered {
            cause,
            status,
            took_s,
        } = after(name, fault, 1.0)?;
        assert_eq!(cause, expected, "{name}");
        assert!(took_s < LIMIT_S, "{name}: {took_s} s");
        let counted = (status.resets.starts, count(&status.resets));
        assert_eq!(counted, (2, 1), "{name}");
        let before_ms = status.resets.previous_uptime_ms;
        let before_ms = before_ms.context("no life before")?;
        ensure!(
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
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_dip_that_empties_ram_is_a_power_on() -> anyhow::Result<()> {
    let fault = json!({"fault": "brown_out", "ram_kept": false});
    let recovered = after("ram-lost", fault, 1.0)?;
    assert_eq!(recovered.cause, ResetCause::PowerOn);
    assert_eq!(recovered.status.resets.starts, 1);
    assert!(recovered.took_s < LIMIT_S, "{} s", recovered.took_s);
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn resets_of_every_cause_add_up_over_resets() -> anyhow::Result<()> {
    let mut faults = vec![json!({"fault": "hang", "at_s": 0.2})];
    let mut at_s = 1.5;
    for (fault, times) in [
        (json!({"fault": "pin_reset"}), 2),
        (json!({"fault": "brown_out", "ram_kept": true}), 3),
        (json!({"fault": "jump", "address": "0x60000000"}), 5),
    ] {
        for _ in 0..times {
            at_s += 0.1;
            let mut fault = fault.clone();
            fault["at_s"] = json!(at_s);
            faults.push(fault);
        }
    }
    let mut board = bench("add-up")?.on(&faults)?;
    run_until_s(&mut board.line, at_s + 0.2)?;
    let resets = board.line.status()?.resets;
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
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_part_that_hangs_is_bitten_by_the_watchdog() -> anyhow::Result<()> {
    // Thread mode: storage, pose, supervisor. Interrupts 82 and 83 run sampling task and link, 11 the sample path.
    for (name, exception) in [
        ("everything", None),
        ("thread", Some(0)),
        ("sampling-task", Some(16 + 82)),
        ("link", Some(16 + 83)),
        ("sample-path", Some(16 + 11)),
    ] {
        let fault = json!({"fault": "hang", "exception": exception});
        after(name, fault, 3.0)?.assert_bitten(name, BITE_S + LIMIT_S);
    }
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_link_that_waits_for_its_transmitter_is_bitten_by_the_watchdog() -> anyhow::Result<()> {
    // Sampling and storage still work.
    let fault = json!({"fault": "dma_stall", "of": "transmitter", "duration_us": STALL_US});
    after("no-transmitter", fault, 3.0)?.assert_bitten("link", STALL_S + LIMIT_S);
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_storage_that_waits_for_its_flash_is_bitten_by_the_watchdog() -> anyhow::Result<()> {
    // Sampling and link still work: the board answers until the watchdog bites.
    let fault = json!({"fault": "flash_stall", "duration_us": 9_000_000});
    let mut board = with_set("no-end-of-erasure", fault)?;
    let line = &mut board.line;
    run_until_s(line, RESET_S)?;
    let key_holder = KeyHolder::of(line)?;
    let mut other = key_holder.key.clone();
    other.0[0] ^= 1;
    let request = key_holder.tagged(line, Act::Provision(other))?;
    line.send(&request)?;
    sampling(line, RESET_S, 3.0)?.assert_bitten("storage", BITE_S + LIMIT_S);
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn converters_that_no_new_start_helps_are_bitten_by_the_watchdog() -> anyhow::Result<()> {
    // Link and storage still work.
    let fault = json!({"fault": "trigger_stall", "duration_us": STALL_US});
    after("no-triggers", fault, 3.0)?.assert_bitten("converters", STALL_S + LIMIT_S);
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn without_its_crystal_it_comes_back_on_the_internal_oscillator_and_says_so() -> anyhow::Result<()>
{
    // The PLL runs on at a half, or a twelfth of its frequency; neither would keep the core from working.
    for drift in [2, 12] {
        let mut board = with_set("crystal", json!({"fault": "crystal", "drift": drift}))?;
        let line = &mut board.line;
        run_until_s(line, 1.0)?;
        assert!(line.status()?.crystal);
        run_until_s(line, RESET_S)?;
        let recovered = sampling(line, RESET_S, 5.0)?;
        let status = recovered.status;
        assert_eq!(recovered.cause, ResetCause::Crystal, "{:?}", status.resets);
        assert_eq!((status.resets.starts, status.resets.crystal), (2, 1));
        assert!(recovered.took_s < LIMIT_S, "{} s", recovered.took_s);
        assert!(!status.crystal, "{status:?}");
    }
    Ok(())
}

#[test]
#[ignore = "needs the firmware and the virtual board"]
fn a_crystal_that_failed_is_not_trusted_before_the_next_start() -> anyhow::Result<()> {
    let faults = [
        json!({"at_s": 0.5, "fault": "crystal", "returns": true}),
        json!({"at_s": 1.0, "fault": "pin_reset"}),
    ];
    let mut board = calibrated("crystal-returns", &faults)?;
    let line = &mut board.line;
    run_until_s(line, 0.7)?;
    assert_eq!(line.identity()?.reset, ResetCause::Crystal);
    assert!(!line.status()?.crystal, "it is on its crystal");
    run_until_s(line, 1.2)?;
    assert_eq!(line.identity()?.reset, ResetCause::Pin);
    assert!(line.status()?.crystal, "it is not on its crystal");
    Ok(())
}
