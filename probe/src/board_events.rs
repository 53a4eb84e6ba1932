//! What went wrong on the board, in words and in JSON: events since the start, and starts since the power came on.

use hexsense_core::wire::status::{EventCount, Events, ResetCause, Resets};
use serde_json::{Map, Value, json};

/// Every event with its name in JSON and what it means to a reader.
fn named(events: &Events) -> [(&'static str, &'static str, EventCount); 19] {
    [
        ("overruns", "converter overruns", events.overruns),
        ("late_blocks", "blocks read too late", events.late_blocks),
        ("stuck", "stops of the converters", events.stuck),
        (
            "blocks_dropped",
            "blocks that the link had no room for",
            events.blocks_dropped,
        ),
        (
            "frames_unsent",
            "frames that could not be sent",
            events.frames_unsent,
        ),
        (
            "frames_not_cobs",
            "received frames that were not COBS",
            events.frames_not_cobs,
        ),
        (
            "frames_of_wrong_length",
            "received frames of a wrong length",
            events.frames_of_wrong_length,
        ),
        (
            "frames_of_wrong_checksum",
            "received frames with a wrong checksum",
            events.frames_of_wrong_checksum,
        ),
        (
            "frames_of_wrong_kind",
            "received frames of a wrong kind",
            events.frames_of_wrong_kind,
        ),
        (
            "receiver_overruns",
            "overruns of the receiver",
            events.receiver_overruns,
        ),
        (
            "receiver_errors",
            "framing errors or noise on the line",
            events.receiver_errors,
        ),
        (
            "flash_corrections",
            "bits of flash corrected",
            events.flash_corrections,
        ),
        ("torn_words", "torn words of flash read", events.torn_words),
        (
            "slips",
            "results of converters lost or doubled",
            events.slips,
        ),
        (
            "supply_refused",
            "readings of supply and temperature refused",
            events.supply_refused,
        ),
        (
            "coefficients_restored",
            "times that the coefficients at work were damaged and read from flash again",
            events.coefficients_restored,
        ),
        (
            "wrong_tags",
            "changes refused because they came without the board's key",
            events.wrong_tags,
        ),
        (
            "changes_refused",
            "changes refused for another reason",
            events.changes_refused,
        ),
        (
            "requests_refused",
            "other requests refused",
            events.requests_refused,
        ),
    ]
}

/// One text for each kind of event that happened.
#[must_use]
pub fn texts(events: &Events) -> Vec<String> {
    let happened = named(events)
        .into_iter()
        .filter(|(.., event)| event.count > 0);
    happened
        .map(|(_, name, EventCount { count, last_ms })| {
            format!(
                "{count} {name}, last {:.3} s after the start",
                last_ms as f64 / 1e3
            )
        })
        .collect()
}

/// Every event with its count and the uptime at the last; `null` when it has not happened.
#[must_use]
pub fn to_json(events: &Events) -> Value {
    let entry = |(key, _, event): (&str, &str, EventCount)| {
        let last_s = (event.count > 0).then_some(event.last_ms as f64 / 1e3);
        (
            key.to_owned(),
            json!({"count": event.count, "last_uptime_s": last_s}),
        )
    };
    Value::Object(named(events).into_iter().map(entry).collect::<Map<_, _>>())
}

/// Name of a cause, for JSON.
fn key(cause: ResetCause) -> &'static str {
    match cause {
        ResetCause::PowerOn => "power_on",
        ResetCause::BrownOut => "brown_out",
        ResetCause::Pin => "pin",
        ResetCause::Software => "software",
        ResetCause::Panic => "panic",
        ResetCause::Watchdog => "watchdog",
        ResetCause::Other => "other",
        ResetCause::Crystal => "crystal",
    }
}

/// A cause in words.
#[must_use]
pub fn cause(cause: ResetCause) -> &'static str {
    match cause {
        ResetCause::PowerOn => "the power came on",
        ResetCause::BrownOut => "the supply dipped",
        ResetCause::Pin => "reset pin",
        ResetCause::Software => "software, without a panic",
        ResetCause::Panic => "panic",
        ResetCause::Watchdog => "watchdog: a part of the board made no progress",
        ResetCause::Other => "another cause that the chip does not tell apart",
        ResetCause::Crystal => {
            "the crystal failed, and the board runs on its internal oscillator until the next start; check the crystal and its solder bridges"
        }
    }
}

/// Why the board started last, and how long it had run before.
#[must_use]
pub fn last_start(last: ResetCause, resets: &Resets) -> String {
    let before = resets.previous_uptime_ms.map_or(String::new(), |ms| {
        format!(", after {:.1} s", ms as f64 / 1e3)
    });
    format!("{}{before}", cause(last))
}

/// How often the board started, and why.
#[must_use]
pub fn starts(resets: &Resets) -> String {
    let counts = [
        (resets.brown_outs, "by dips of the supply"),
        (resets.pin, "by the pin"),
        (resets.software, "by software"),
        (resets.panics, "by panics"),
        (resets.watchdog, "by the watchdog"),
        (resets.other, "by others"),
        (resets.crystal, "by failures of the crystal"),
    ];
    let happened = counts.iter().filter(|(count, _)| *count > 0);
    let causes: Vec<String> = happened
        .map(|(count, by)| format!("{count} {by}"))
        .collect();
    let causes = match causes.is_empty() {
        true => "no reset".to_owned(),
        false => format!("resets: {}", causes.join(", ")),
    };
    format!("{} since power-on; {causes}", resets.starts)
}

/// Why the board started last, and how often it started, in JSON.
#[must_use]
pub fn starts_to_json(last: ResetCause, resets: &Resets) -> Value {
    json!({
        "cause": key(last),
        "starts": resets.starts,
        "brown_outs": resets.brown_outs,
        "pin": resets.pin,
        "software": resets.software,
        "panics": resets.panics,
        "watchdog": resets.watchdog,
        "other": resets.other,
        "crystal": resets.crystal,
        "previous_uptime_s": resets.previous_uptime_ms.map(|ms| ms as f64 / 1e3),
    })
}
