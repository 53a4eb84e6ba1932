//! What boards lie.

use hexsense_core::facts::BoardFacts;
use hexsense_core::wire::message::{ActiveSet, CHUNK, Kept, LOG_ENTRIES};
use hexsense_core::wire::telemetry::Header;
use hexsense_core::wire::{PoseReport, Request, Response, Status, StreamContent};
use hostile::liar::{
    active, answer, answer_frame, block_frame, header, identity, pose_frame, pose_report, status,
    zeroed,
};

use super::server::{CONTENT, Lie, good_board, good_wave};

/// What a terminal obeys: it is cleared, and gets another title and a line of its own.
const OBEYED: &str = "\u{1b}[2J\u{1b}]0;x\u{7}\n\u{9b}A\u{7f}";
/// The same as it must be printed.
const SHOWN: &str = r"\u001b[2J\u001b]0;x\u0007\u000a\u009bA\u007f";

fn says(
    arguments: &[&'static str],
    told: &'static str,
    answer: impl Fn(&Request) -> Option<Response> + Send + 'static,
) -> Lie {
    Lie {
        arguments: arguments.to_vec(),
        told,
        answer: Box::new(answer),
        ..good_board()
    }
}

fn state(told: &'static str, lie: fn(&mut Status)) -> Lie {
    says(&["status"], told, move |request| {
        let mut status = status();
        lie(&mut status);
        matches!(request, Request::Status).then_some(Response::Status(status))
    })
}

fn facts(told: &'static str, lie: fn(&mut BoardFacts)) -> Lie {
    says(&["status", "--json"], told, move |request| {
        let mut identity = identity();
        lie(&mut identity.facts);
        matches!(request, Request::Identity).then_some(Response::Identity(identity))
    })
}

fn set(told: &'static str, lie: fn(&Request) -> Option<Response>) -> Lie {
    says(&["show"], told, lie)
}

fn pose(told: &'static str, lie: fn(&mut PoseReport)) -> Lie {
    Lie {
        stream: Box::new(move |_| {
            let mut report = pose_report();
            lie(&mut report);
            pose_frame(&report, 0)
        }),
        ..says(&["show", "--json"], told, |_| None)
    }
}

fn stream(
    seconds: &'static str,
    told: &'static str,
    wave: impl Fn(u64) -> Vec<u8> + Send + 'static,
) -> Lie {
    let capture = [
        "capture",
        "--values",
        "--out",
        "scans.csv",
        "--board-wait",
        "0",
    ];
    Lie {
        stream: Box::new(wave),
        ..says(
            &[&capture[..], &["--seconds", seconds]].concat(),
            told,
            |_| None,
        )
    }
}

/// A stream whose headers lie.
fn blocks(told: &'static str, lie: fn(&mut Header)) -> Lie {
    stream("1", told, move |number| {
        let mut header = header(number, CONTENT);
        lie(&mut header);
        block_frame(&header, 1.5, 0)
    })
}

/// All of them.
pub fn all(flood_s: u64) -> Vec<Lie> {
    let mut lies = vec![
        says(&["info"], SHOWN, |request| {
            let mut identity = identity();
            identity.hardware = OBEYED.try_into().unwrap_or_default();
            matches!(request, Request::Identity).then_some(Response::Identity(identity))
        }),
        state(SHOWN, |status| status.panic = OBEYED.try_into().ok()),
        says(&["status", "--json"], r"\u009bA\u007f", |request| {
            let mut status = status();
            status.panic = OBEYED.try_into().ok();
            matches!(request, Request::Status).then_some(Response::Status(status))
        }),
        state("the scan rate in Hz is 4294967295", |status| {
            status.rate_hz = u32::MAX
        }),
        state("the scan rate in Hz is 0", |status| status.rate_hz = 0),
        state("the number of scans is 18446744073709551615", |status| {
            (status.scans, status.scans_lost) = (u64::MAX, u64::MAX);
        }),
        state("the uptime in ms is", |status| status.uptime_ms = u64::MAX),
        state("NaN", |status| {
            (status.supply, status.temperature_c) = (f32::NAN, f32::NAN)
        }),
        facts("the scan rate in Hz is 0", |facts| facts.rates_hz[1] = 0),
        facts("the nominal supply in V is NaN", |facts| {
            facts.nominal_supply_v = f32::NAN
        }),
        facts("the line's speed in bit/s is 0", |facts| facts.baud = 0),
        facts("the number of flash pages is", |facts| {
            facts.flash.pages = u32::MAX
        }),
        says(
            &["history"],
            "the number of sets is 9",
            |request| match request {
                Request::History { .. } => Some(Response::Kept(Some(zeroed::<Kept>()))),
                _ => None,
            },
        ),
        says(&["log"], "the number of entries is 16388", |request| {
            endless(request, 1)
        }),
        says(
            &["log", "--json"],
            "the number of an entry is 1",
            |request| endless(request, 0),
        ),
        set("the length in bytes is 65535", |request| {
            let told = ActiveSet {
                length: u16::MAX,
                ..active()
            };
            matches!(request, Request::ActiveSet).then_some(Response::ActiveSet(Some(told)))
        }),
        set(
            "answer to bytes of the set cannot be understood",
            |request| {
                let Request::ReadSet { offset } = *request else {
                    return None;
                };
                let bytes = [7; CHUNK].into_iter().collect();
                Some(Response::SetBytes { offset, bytes })
            },
        ),
        set("the checksum is", |request| {
            let Response::SetBytes { offset, mut bytes } = answer(request) else {
                return None;
            };
            bytes.iter_mut().for_each(|byte| *byte ^= 1);
            Some(Response::SetBytes { offset, bytes })
        }),
        set("cannot be understood", |request| {
            matches!(request, Request::ReadSet { .. }).then_some(Response::Done)
        }),
        pose("a coordinate in m is NaN", |report| {
            report.outcome.as_mut().unwrap().position_m[2] = f32::NAN;
        }),
        pose("the length of the quaternion is 0", |report| {
            report.outcome.as_mut().unwrap().rotation = [0.0; 4];
        }),
        pose("the first scan is", |report| report.first_scan = u64::MAX),
        says(&["harmonics"], "not finite", not_numbers),
        says(&["harmonics", "--json"], "null", not_numbers),
        blocks("the first scan is 18446744073709551", |header| {
            header.first_scan = u64::MAX - 9
        }),
        blocks("the scan rate in Hz is 4294967295", |header| {
            header.rate_hz = u32::MAX
        }),
        blocks("the supply factor of scan", |header| {
            header.supply = f32::NAN
        }),
        blocks("the temperature of scan", |header| {
            header.temperature_c = f32::INFINITY
        }),
        blocks("has restarted during the run", |header| {
            header.first_scan = 9 - header.first_scan % 9
        }),
        stream("1", "ax of scan", |number| {
            block_frame(&header(number, CONTENT), f32::NEG_INFINITY, 0)
        }),
        stream("600", "gaps are in the recording", |number| {
            let scans = (0..64).map(|scan| header(number * 128 + 2 * scan, CONTENT));
            scans
                .flat_map(|header| block_frame(&header, 1.5, 0))
                .collect()
        }),
        stream("60", "blocks in a row do not hold", |number| {
            let nothing = StreamContent::default();
            let scans = (0..64).map(|scan| header(number * 64 + scan, nothing));
            scans
                .flat_map(|header| block_frame(&header, 1.5, 0))
                .collect()
        }),
        stream("1", "no samples have come", |_| vec![0x55; 1_000]),
        stream("1", "no samples have come", |_| Vec::new()),
    ];
    // More than half a minute at best, so that it is a part of the whole form only.
    if flood_s > 10 {
        lies.push(stream("60", "were due in each", |number| {
            match number % 200 {
                0 => block_frame(&header(number / 200, CONTENT), 1.5, 0),
                _ => Vec::new(),
            }
        }));
    }
    let seconds: &'static str = if flood_s > 10 { "15" } else { "2" };
    let mut flood = stream(seconds, "", |number| {
        let unasked = answer_frame(&Response::Status(status()), number as u16);
        [unasked.repeat(60), good_wave(number)].concat()
    });
    flood.unasked = true;
    lies.push(flood);
    lies
}

/// A log that goes on for ever, in which the numbers rise by `step`.
fn endless(request: &Request, step: u32) -> Option<Response> {
    let Request::Log { counter } = *request else {
        return None;
    };
    let entry = |number| {
        let mut entry: hexsense_core::records::Entry = zeroed();
        entry.counter = counter.max(1) + step * number;
        entry
    };
    Some(Response::Log {
        last: u32::MAX,
        entries: (0..LOG_ENTRIES as u32).map(entry).collect(),
    })
}

/// Harmonics and a motion that are no numbers.
fn not_numbers(request: &Request) -> Option<Response> {
    let mut response = answer(request);
    match &mut response {
        Response::Harmonics { harmonics, .. } => {
            harmonics.amplitude = [f64::NAN; 5];
            (harmonics.offset, harmonics.drift) = (f64::INFINITY, f64::MAX);
        }
        Response::Motion {
            motion: Ok(motion), ..
        } => motion.amplitude = [f32::NAN; 6],
        _ => return None,
    }
    Some(response)
}
