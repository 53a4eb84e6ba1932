//! The pins protocol of docs/virtual-bench.md, with a twin made of a few lines.

use std::io::{Read, Write};
use std::net::TcpListener;
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use virtual_board::pins::pinout::Pin;
use virtual_board::pins::{Pins, PinsError};

/// Greets with `greeting`; then answers each `N` with the next chunk of two steps of 0.5 ms, in which PB12 is the true
/// time in volts, and temperature and supply are constant. It reports every request and disconnects after `chunks` of
/// them.
fn twin(greeting: String, chunks: usize) -> (String, mpsc::Receiver<u8>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let (sender, requests) = mpsc::channel();
    thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        stream.write_all(greeting.as_bytes()).unwrap();
        for chunk in 0..chunks {
            let mut request = [0];
            if stream.read_exact(&mut request).is_err() {
                return;
            }
            let _ = sender.send(request[0]);
            for row in 0..3 {
                let time_s = (2 * chunk + row) as f32 * 0.5e-3;
                for value in [time_s, 25.0, 3.25] {
                    stream.write_all(&value.to_le_bytes()).unwrap();
                }
            }
        }
    });
    (address, requests)
}

fn greeting() -> String {
    let adc = r#"{"gain_error":0.0004,"offset_lsb":0.7,"noise_lsb":1.5}"#;
    format!(
        r#"{{"protocol":"hexsense-pins 1","step_s":0.0005,"chunk_steps":2,"columns":["PB12","temp_c","vdda_v"],
        "board":{{"seed":9,"uid":"000102030405060708090a0b","clock_ppm":12.5,"vrefint_v":1.2131,
        "boot_unix_s":1780000000,"adc":[{adc},{adc},{adc},{adc},{adc}]}}}}"#
    )
    .replace('\n', " ")
        + "\n"
}

fn refusal(greeting: String) -> PinsError {
    Pins::connect(&twin(greeting, 0).0).unwrap_err()
}

const PB12: Pin = Pin {
    port: 1,
    number: 12,
};

#[test]
fn the_greeting_says_what_board_this_is() {
    let (_, board) = Pins::connect(&twin(greeting(), 0).0).unwrap();
    assert_eq!(
        (board.seed, board.clock_ppm, board.vrefint_v),
        (9, 12.5, 1.2131)
    );
    assert_eq!(board.unique_id, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]);
    assert_eq!(
        (board.adc[4].gain_error, board.adc[4].offset_lsb),
        (0.0004, 0.7)
    );
}

#[test]
fn voltages_are_interpolated_and_chunks_asked_for_when_needed() {
    let (address, requests) = twin(greeting(), 100);
    let (mut pins, _) = Pins::connect(&address).unwrap();
    assert!(
        requests.try_recv().is_err(),
        "nothing is asked for before it is needed"
    );
    for (at_s, chunks) in [
        (0.0, 1),
        (0.000_123, 1),
        (0.001, 1),
        (0.001_001, 1),
        (0.002_9, 1),
        (0.012_34, 10),
    ] {
        let volt = pins.voltage(PB12, at_s);
        assert!((volt - at_s).abs() < 1e-8, "{volt} V at {at_s} s");
        if at_s > 0.0 && at_s <= 0.001 {
            assert!(
                requests.try_recv().is_err(),
                "{at_s} s is within the chunk that is there"
            );
            continue;
        }
        let asked: Vec<u8> = (0..chunks)
            .map(|_| requests.recv_timeout(Duration::from_secs(5)).unwrap())
            .collect();
        assert!(asked.iter().all(|request| *request == b'N'));
    }
}

#[test]
fn an_instant_in_the_chunk_before_is_still_known() {
    let (mut pins, _) = Pins::connect(&twin(greeting(), 100).0).unwrap();
    pins.voltage(PB12, 0.010_1);
    let volt = pins.voltage(PB12, 0.009_2);
    assert!((volt - 0.009_2).abs() < 1e-8, "{volt}");
}

#[test]
fn a_pin_that_nothing_is_soldered_to_floats_at_half_the_supply() {
    let (mut pins, _) = Pins::connect(&twin(greeting(), 10).0).unwrap();
    assert_eq!(pins.voltage(Pin { port: 0, number: 0 }, 0.0), 3.25 / 2.0);
    assert_eq!((pins.temperature_c(0.0), pins.supply_v(0.0)), (25.0, 3.25));
}

#[test]
fn a_twin_that_leaves_is_noticed() {
    let (mut pins, _) = Pins::connect(&twin(greeting(), 1).0).unwrap();
    pins.voltage(PB12, 0.000_5);
    assert!(!pins.failed());
    pins.voltage(PB12, 0.004);
    assert!(pins.failed());
    assert!(matches!(pins.take_failure(), Some(PinsError::Lost { .. })));
}

#[test]
fn a_twin_of_another_version_is_refused_by_name() {
    let error = refusal(r#"{"protocol":"hexsense-pins 2","anything":"else"}"#.to_owned() + "\n");
    assert!(
        matches!(&error, PinsError::Protocol { found } if found == "hexsense-pins 2"),
        "{error}"
    );
}

#[test]
fn nonsense_in_the_greeting_is_refused_by_key() {
    for (from, to, key) in [
        ("0.0005", "0.0", "step_s"),
        (r#""chunk_steps":2"#, r#""chunk_steps":0"#, "chunk_steps"),
        (
            r#""chunk_steps":2"#,
            r#""chunk_steps":18446744073709551615"#,
            "chunk_steps",
        ),
        ("000102030405060708090a0b", "xyz", "board.uid"),
        ("1.2131", "12.131", "board.vrefint_v"),
        (r#""temp_c","#, "", "columns"),
    ] {
        let error = refusal(greeting().replace(from, to));
        assert!(
            matches!(&error, PinsError::Value { name, .. } if *name == key),
            "{from}: {error}"
        );
    }
    assert!(matches!(
        refusal("hello\n".to_owned()),
        PinsError::Malformed(_)
    ));
    assert!(matches!(
        refusal("cut off".to_owned()),
        PinsError::Greeting { .. }
    ));
}
