//! Arrays of bytes, read in a loop: `#[serde(deserialize_with = "crate::bytes::read")]`.
//!
//! The code that serde makes for an array has no loop, and 32 bytes take a kilobyte of flash. The form on the wire is the
//! same.

use core::fmt;

use serde::Deserializer;
use serde::de::{Error, SeqAccess, Visitor};

/// Reads an array of bytes, which was written as a tuple.
///
/// # Errors
/// What the deserializer reports, and an array that is too short.
pub fn read<'de, const N: usize, D: Deserializer<'de>>(from: D) -> Result<[u8; N], D::Error> {
    from.deserialize_tuple(N, Bytes)
}

struct Bytes<const N: usize>;

impl<'de, const N: usize> Visitor<'de> for Bytes<N> {
    type Value = [u8; N];

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{N} bytes")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut bytes: A) -> Result<[u8; N], A::Error> {
        let mut read = [0; N];
        for (index, byte) in read.iter_mut().enumerate() {
            let next = bytes.next_element()?;
            *byte = next.ok_or_else(|| A::Error::invalid_length(index, &self))?;
        }
        Ok(read)
    }
}
