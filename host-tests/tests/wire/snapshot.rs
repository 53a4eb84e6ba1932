//! The bytes of one message of every kind, as they were when this version of the wire was made.

use hexsense_core::wire::hello::Greeting;
use hexsense_core::wire::telemetry::{self, Samples};
use hexsense_core::wire::{Kind, MAX_FRAME, StreamContent, VERSION, frame};

use crate::samples::{self, SEQUENCE, hex};

#[test]
fn the_wire_is_the_one_its_version_stands_for() {
    let path = format!(
        "{}/tests/data/wire_v{VERSION}.txt",
        env!("CARGO_MANIFEST_DIR")
    );
    let (expected, found) = (
        std::fs::read_to_string(&path).unwrap_or_default(),
        samples::everything(),
    );
    let drifted: Vec<_> = found
        .lines()
        .filter(|line| !expected.lines().any(|old| old == *line))
        .collect();
    assert!(
        expected == found,
        "the wire drifted: bump wire::VERSION and write tests/data/wire_vN.txt for it.\n\
         These messages are not as {path} says:\n{}\nThe whole file would be:\n{found}",
        drifted.join("\n")
    );
}

#[test]
fn hello_and_greeting_never_change() {
    let hello = hex(|out| frame::encode(Kind::Hello, SEQUENCE, out, |_| Some(0)));
    let greeting = Greeting {
        wire: 0x0102,
        firmware: [3, 4, 5],
    };
    let greeting = hex(|out| greeting.encode(SEQUENCE, out));
    let sorry = "hosts and boards of every version depend on these bytes; a new version of the wire must not touch them";
    assert_eq!(hello, "01070a0b10e87c9200", "{sorry}");
    assert_eq!(
        greeting, "15010a0b68657873656e73650201030405d39a6a5500",
        "{sorry}"
    );
}

#[test]
fn samples_of_a_block_follow_its_header_in_the_order_of_scans() {
    let payload = |content| {
        let header = telemetry::Header {
            content,
            ..samples::header()
        };
        let place = |scan: usize, channel: usize| scan * 256 + channel;
        let inertial =
            [0, 1, 2].map(|scan| std::array::from_fn(|channel| place(scan, channel) as u16));
        let jacks = [0, 1, 2].map(|scan| std::array::from_fn(|jack| place(scan, 9 + jack) as u16));
        let values =
            [0, 1, 2].map(|scan| std::array::from_fn(|channel| place(scan, channel) as f32 + 0.5));
        let samples = Samples {
            inertial: &inertial,
            jacks: &jacks,
            values: &values,
        };
        let mut out = [0; MAX_FRAME];
        let length = telemetry::encode(&header, samples, SEQUENCE, &mut out).unwrap();
        frame::decode(&mut out[..length - 1])
            .unwrap()
            .payload
            .to_vec()
    };
    let places = |channels: usize| {
        (0..3).flat_map(move |scan| (0..channels).map(move |channel| scan * 256 + channel))
    };
    let counts: Vec<u8> = places(15)
        .flat_map(|place| (place as u16).to_le_bytes())
        .collect();
    let values: Vec<u8> = places(9)
        .flat_map(|place| (place as f32 + 0.5).to_le_bytes())
        .collect();
    let [none, only_counts, only_values, both] =
        [(false, false), (true, false), (false, true), (true, true)].map(|(counts, values)| {
            payload(StreamContent {
                counts,
                values,
                pose: false,
            })
        });
    let header = none.len();
    assert_eq!(only_counts[header..], counts);
    assert_eq!(only_values[header..], values);
    assert_eq!(both[header..], [counts, values].concat());
}
