//! The processes that use a port, as far as the system tells: on Linux, from /proc.
//!
//! The processes of other users stay unknown to a user who is not root, and elsewhere nothing is found.

use std::fmt;
use std::fs::{self, File};
use std::io::Read;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::path::Path;

/// Processes that are looked at, descriptors of each, and sockets.
const MAX_PROCESSES: usize = 65_536;
const MAX_DESCRIPTORS: usize = 4_096;
const MAX_SOCKETS: usize = 65_536;
/// Processes that are named.
const MAX_USERS: usize = 4;
/// Bytes of a command line that are read.
const MAX_COMMAND: u64 = 200;
/// The state of a connection that is open, in /proc/net/tcp.
const ESTABLISHED: &str = "01";

/// A process that uses a port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PortUser {
    /// Its number.
    pub pid: u32,
    /// The beginning of its command line.
    pub command: String,
}

impl fmt::Display for PortUser {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "process {} ({})", self.pid, self.command)
    }
}

/// The middle of a sentence: by which processes.
pub(super) fn sentence(users: &[PortUser]) -> String {
    let users: Vec<String> = users.iter().map(PortUser::to_string).collect();
    match users.is_empty() {
        true => " by another process".to_owned(),
        false => format!(" by {}", users.join(" and ")),
    }
}

/// The other processes that have a device open.
#[must_use]
pub fn of_device(device: &Path) -> Vec<PortUser> {
    let device = device.canonicalize();
    device.map_or(Vec::new(), |device| holders(|open| open == device))
}

/// The other processes of this computer that are connected to `server`.
#[must_use]
pub fn of_socket(server: SocketAddr) -> Vec<PortUser> {
    let sockets: Vec<String> = ["/proc/net/tcp", "/proc/net/tcp6"]
        .into_iter()
        .filter_map(|table| fs::read_to_string(table).ok())
        .flat_map(|table| connected_to(&table, server))
        .collect();
    holders(|open| sockets.iter().any(|socket| open == Path::new(socket)))
}

/// The sockets of a table as in /proc/net/tcp that are connected to `server`, named as descriptors are.
fn connected_to(table: &str, server: SocketAddr) -> Vec<String> {
    let rows = table.lines().skip(1).take(MAX_SOCKETS);
    let sockets = rows.filter_map(|row| {
        let mut cells = row.split_whitespace().skip(2);
        let (remote, state) = (cells.next()?, cells.next()?);
        let inode = cells.nth(5)?;
        let is_it = state == ESTABLISHED && socket_address(remote)? == server;
        is_it.then(|| format!("socket:[{inode}]"))
    });
    sockets.collect()
}

/// An address such as 0100007F:1F90: words of 32 bits in the order of this computer, and the port.
fn socket_address(text: &str) -> Option<SocketAddr> {
    let (address, port) = text.split_once(':')?;
    let word = |at: usize| {
        let digits = address.get(8 * at..8 * at + 8)?;
        Some(u32::from_str_radix(digits, 16).ok()?.to_ne_bytes())
    };
    let address = match address.len() {
        8 => IpAddr::from(Ipv4Addr::from(word(0)?)),
        32 => {
            let mut bytes = [0; 16];
            for (at, bytes) in bytes.chunks_mut(4).enumerate() {
                bytes.copy_from_slice(&word(at)?);
            }
            IpAddr::from(Ipv6Addr::from(bytes)).to_canonical()
        }
        _ => return None,
    };
    Some(SocketAddr::new(
        address,
        u16::from_str_radix(port, 16).ok()?,
    ))
}

/// The other processes with an open descriptor that leads to what `is_it` accepts.
fn holders(is_it: impl Fn(&Path) -> bool) -> Vec<PortUser> {
    let processes = fs::read_dir("/proc").into_iter().flatten();
    let pids = processes
        .take(MAX_PROCESSES)
        .filter_map(|entry| entry.ok()?.file_name().to_str()?.parse::<u32>().ok());
    pids.filter(|pid| *pid != std::process::id() && has_open(*pid, &is_it))
        .take(MAX_USERS)
        .map(|pid| PortUser {
            pid,
            command: command(pid),
        })
        .collect()
}

fn has_open(pid: u32, is_it: impl Fn(&Path) -> bool) -> bool {
    let descriptors = fs::read_dir(format!("/proc/{pid}/fd"));
    descriptors
        .into_iter()
        .flatten()
        .take(MAX_DESCRIPTORS)
        .any(|entry| {
            let open = entry.and_then(|entry| fs::read_link(entry.path()));
            open.is_ok_and(|open| is_it(&open))
        })
}

/// The beginning of a command line, fit to be printed.
fn command(pid: u32) -> String {
    let mut bytes = Vec::new();
    let read = File::open(format!("/proc/{pid}/cmdline"))
        .and_then(|file| file.take(MAX_COMMAND).read_to_end(&mut bytes));
    if read.is_err() || bytes.is_empty() {
        return "command unknown".to_owned();
    }
    let text = String::from_utf8_lossy(&bytes).replace(char::is_control, " ");
    text.trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_of_sockets_is_searched_for_open_connections_to_a_server() {
        let table = "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n\
                     0: 0100007F:1F90 00000000:0000 0A 00000000:00000000 00:00000000 00000000 0 0 11 1\n\
                     1: 0100007F:A0DE 0100007F:1F90 01 00000000:00000000 00:00000000 00000000 0 0 12 1\n\
                     2: 0100007F:A0DE 0100007F:1F90 06 00000000:00000000 00:00000000 00000000 0 0 13 1\n\
                     3: nonsense\n";
        let server = "127.0.0.1:8080".parse().unwrap();
        if cfg!(target_endian = "little") {
            assert_eq!(connected_to(table, server), ["socket:[12]"]);
        }
        let mapped = "0000000000000000FFFF00000100007F:1F90";
        if cfg!(target_endian = "little") {
            assert_eq!(socket_address(mapped), Some(server));
        }
        for damaged in ["", ":", "0100007:1F90", "0100007G:1F90", "0100007F:11F90"] {
            assert_eq!(socket_address(damaged), None, "{damaged:?}");
        }
    }
}
