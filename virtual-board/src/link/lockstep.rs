//! The link in lockstep: the machine runs only while the host waits for it, so that the result does not depend on the
//! speed of either.
//!
//! ```text
//! host:   u32 run_us   u32 length   bytes for the receiver
//! board:  u64 now_us   u32 length   bytes from the transmitter
//! ```
//!
//! After a request the machine runs until one of these: the transmitter has been silent for two character times after
//! at least one byte; [`MAX_BYTES`] wait; `run_us` have passed. Times are true time, without the crystal's error. While
//! no host is connected, time stands still.

use std::io::{self, Read, Write};
use std::net::TcpListener;

use super::door::{Door, Host};
use super::error::LinkError;
use crate::machine::Machine;

/// Number of waiting bytes at which the machine stops for the host.
pub const MAX_BYTES: usize = 4096;
/// Longest request; a longer one is a mistake.
const MAX_REQUEST: u32 = 1 << 20;

/// The listening side.
#[derive(Debug)]
pub struct Lockstep {
    door: Door,
}

impl Lockstep {
    /// Serves hosts that connect here.
    pub fn new(listener: TcpListener) -> io::Result<Self> {
        Ok(Self {
            door: Door::new(listener)?,
        })
    }

    /// Serves one host after another.
    pub fn serve(self, machine: &mut Machine) -> Result<std::convert::Infallible, LinkError> {
        loop {
            serve_host(self.door.wait()?, machine)?;
            print_counts(machine);
            machine.begin_counting();
        }
    }
}

/// Prints the counts of instructions, if any were asked for, as one line of JSON.
pub fn print_counts(machine: &Machine) {
    if let Some(counts) = machine.counts() {
        println!(
            "{}",
            serde_json::json!({
                "executed": machine.executed(),
                "counts": counts,
                "masked": machine.masked(),
                "triggers": machine.bus().triggers.runs(),
            })
        );
    }
}

/// Serves a host until it disconnects.
fn serve_host(mut host: Host, machine: &mut Machine) -> Result<(), LinkError> {
    // A broken connection is no failure of the board, which waits for the next host.
    if host.set_nodelay(true).is_err() {
        return Ok(());
    }
    while let Ok((run_us, bytes)) = read_request(&mut *host) {
        let answer = run(machine, run_us, &bytes)?;
        if host.write_all(&answer).is_err() {
            break;
        }
    }
    Ok(())
}

fn read_request(stream: &mut impl Read) -> io::Result<(u32, Vec<u8>)> {
    let mut head = [0; 8];
    stream.read_exact(&mut head)?;
    let [r0, r1, r2, r3, l0, l1, l2, l3] = head;
    let (run_us, length) = (
        u32::from_le_bytes([r0, r1, r2, r3]),
        u32::from_le_bytes([l0, l1, l2, l3]),
    );
    if length > MAX_REQUEST {
        eprintln!(
            "board: the host announced {length} bytes, at most {MAX_REQUEST} are allowed; it is let go"
        );
        return Err(io::ErrorKind::InvalidData.into());
    }
    let mut bytes = vec![0; length as usize];
    stream.read_exact(&mut bytes)?;
    Ok((run_us, bytes))
}

/// Carries out one request: bytes in, time on, bytes out.
fn run(machine: &mut Machine, run_us: u32, bytes: &[u8]) -> Result<Vec<u8>, LinkError> {
    machine.bus_mut().line_in(bytes);
    let end_s = machine.bus().now_s() + f64::from(run_us) * 1e-6;
    machine.run_until_silent(end_s, MAX_BYTES)?;
    let sent = machine.bus_mut().lpuart.take_sent();
    let now_us = (machine.bus().now_s() * 1e6) as u64;
    let mut answer = Vec::with_capacity(12 + sent.len());
    answer.extend(now_us.to_le_bytes());
    answer.extend((sent.len() as u32).to_le_bytes());
    answer.extend(sent);
    Ok(answer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_two_words_and_bytes() {
        let wire = [0x10, 0x27, 0, 0, 2, 0, 0, 0, 0xAB, 0xCD];
        let (run_us, bytes) = read_request(&mut wire.as_slice()).unwrap();
        assert_eq!((run_us, bytes.as_slice()), (10_000, &[0xAB, 0xCD][..]));
    }

    #[test]
    fn a_request_of_absurd_length_is_refused() {
        let wire = [0, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF];
        assert!(read_request(&mut wire.as_slice()).is_err());
    }
}
