//! CRC-32 as in Ethernet (IEEE 802.3; CRC-32/ISO-HDLC), half a byte at a time: the table for whole bytes would take a
//! kilobyte of flash.

/// What each half of a byte does to the checksum.
static HALVES: [u32; 16] = {
    /// The generator, its bits in the order in which they are sent.
    const GENERATOR: u32 = 0xEDB8_8320;
    let mut halves = [0; 16];
    let mut half = 0;
    while half < 16 {
        let mut rest = half;
        let mut bit = 0;
        while bit < 4 {
            rest = (rest >> 1) ^ (GENERATOR * (rest & 1));
            bit += 1;
        }
        halves[half as usize] = rest;
        half += 1;
    }
    halves
};

/// The checksum of `bytes`.
#[must_use]
pub fn checksum(bytes: &[u8]) -> u32 {
    let half = |sum: u32| (sum >> 4) ^ HALVES[(sum & 0xF) as usize];
    !bytes
        .iter()
        .fold(!0, |sum, byte| half(half(sum ^ u32::from(*byte))))
}
