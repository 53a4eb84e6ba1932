//! The identity of a firmware is a hash of its code and version, and nothing waits for long while it is computed.

use hexsense_core::records::BuildId;
use hexsense_core::records::build::BuildHash;

fn code() -> Vec<u8> {
    (0..2_500_u32)
        .map(|index| ((index * 7 + 3) % 251) as u8)
        .collect()
}

/// The identity, and the steps that its computing took.
fn of(code: &[u8], version: [u8; 3]) -> (BuildId, u32) {
    let mut hash = BuildHash::new(code, version);
    for step in 1.. {
        if let Some(build) = hash.advance() {
            return (build, step);
        }
    }
    unreachable!()
}

/// Computed with Python's `hashlib`.
#[test]
fn a_build_is_the_hash_that_others_compute() {
    let expected = BuildId([0x49, 0x87, 0x89, 0x63, 0x7d, 0x2b, 0x8e, 0xb4]);
    assert_eq!(of(&code(), [1, 2, 3]), (expected, 3));
    let empty = BuildId([0x03, 0x90, 0x58, 0xc6, 0xf2, 0xc0, 0xcb, 0x49]);
    assert_eq!(of(&[], [1, 2, 3]), (empty, 1));
}

#[test]
fn every_changed_bit_of_code_or_version_is_another_build() {
    let (own, _) = of(&code(), [1, 2, 3]);
    for bit in (0..8 * 2_500).step_by(613) {
        let mut changed = code();
        changed[bit / 8] ^= 1 << (bit % 8);
        assert_ne!(of(&changed, [1, 2, 3]).0, own, "bit {bit}");
    }
    for version in [[0, 2, 3], [1, 3, 3], [1, 2, 4]] {
        assert_ne!(of(&code(), version).0, own);
    }
    assert_ne!(of(&code()[..2_499], [1, 2, 3]).0, own);
}
