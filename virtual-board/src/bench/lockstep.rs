//! The link in lockstep: the machine runs only while the host waits for it, so that nothing depends on how fast either
//! of them is.
//!
//! ```text
//! host:   u32 run_us   u32 length   bytes for the receiver
//! board:  u64 now_us   u32 length   bytes from the transmitter
//! ```
//!
//! After a request the machine runs until the transmitter has been silent for two character times after at least one
//! byte, or [`MAX_BYTES`] wait, or `run_us` have passed. Times are true time, which the crystal's error does not
//! touch. While no host is connected, time stands still.

use std::io::{self, Read, Write};
use std::net::TcpListener;

use super::door::{Door, Host};
use super::link::{LinkError, print_counts};
use crate::machine::Machine;

/// The machine stops for the host when so many bytes wait.
pub const MAX_BYTES: usize = 4096;
/// A request may not carry more than this: it is a mistake, not a message.
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

/// Serves a host until it goes away.
fn serve_host(mut host: Host, machine: &mut Machine) -> Result<(), LinkError> {
    // A host that broke off is no failure of the board: the next one is waited for.
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

/// One request: bytes in, time on, bytes out.
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
