//! CRC-32 as in Ethernet (IEEE 802.3; CRC-32/ISO-HDLC) and SHA-256, once for all users.

use crc::{CRC_32_ISO_HDLC, Crc};
use sha2::{Digest, Sha256};

static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// The checksum of `bytes`.
#[must_use]
pub fn checksum(bytes: &[u8]) -> u32 {
    CRC.checksum(bytes)
}

/// The SHA-256 of `bytes`.
#[must_use]
#[inline(never)]
pub fn sha256(bytes: &[u8]) -> [u8; 32] {
    Sha256::digest(bytes).into()
}
