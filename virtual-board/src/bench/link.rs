//! Where the host is connected: `--link tcp:ADDR`, `--link pty` or `--link lockstep:ADDR`.

use std::io;
use std::net::{SocketAddr, TcpListener};
use std::str::FromStr;

use thiserror::Error;

use super::cable::{Cable, Pty};
use super::lockstep::Lockstep;
use crate::machine::{Machine, Stop};

/// Prints the counts of instructions, if any were asked for, as one line of JSON.
pub fn print_counts(machine: &Machine) {
    if let Some(counts) = machine.counts() {
        println!(
            "{}",
            serde_json::json!({
                "executed": machine.executed(),
                "counts": counts,
                "triggers": machine.bus().triggers.runs(),
            })
        );
    }
}

/// What `--link` says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LinkAddress {
    /// Bytes over TCP at the pace of real time.
    Tcp(String),
    /// A pseudo-terminal at the pace of real time.
    Pty,
    /// Virtual time coupled to the host.
    Lockstep(String),
}

impl FromStr for LinkAddress {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            Some(("tcp", address)) => Ok(Self::Tcp(address.to_owned())),
            Some(("lockstep", address)) => Ok(Self::Lockstep(address.to_owned())),
            None if text == "pty" => Ok(Self::Pty),
            _ => Err(
                "expected tcp:HOST:PORT, lockstep:HOST:PORT or pty (port 0 picks a free one)"
                    .to_owned(),
            ),
        }
    }
}

/// Why the link cannot be opened, or has failed.
#[derive(Debug, Error)]
pub enum LinkError {
    /// The address cannot be listened on.
    #[error(
        "--link {address}: {source} (another process may listen there; port 0 picks a free one)"
    )]
    Listen {
        /// The address.
        address: String,
        /// What the system said.
        source: io::Error,
    },
    /// No pseudo-terminal can be had.
    #[error("--link pty: {0}")]
    Pty(io::Error),
    /// The link broke in a way that waiting does not heal.
    #[error("the link failed: {0}")]
    Failed(#[from] io::Error),
    /// The machine stopped.
    #[error(transparent)]
    Machine(#[from] Stop),
}

/// An open link, waiting for its host.
#[derive(Debug)]
pub enum Link {
    /// See [`LinkAddress::Tcp`].
    Tcp(TcpListener),
    /// See [`LinkAddress::Pty`].
    Pty(Pty),
    /// See [`LinkAddress::Lockstep`].
    Lockstep(TcpListener),
}

impl Link {
    /// Opens the link.
    pub fn open(address: &LinkAddress) -> Result<Self, LinkError> {
        let listen = |address: &String| {
            TcpListener::bind(address).map_err(|source| LinkError::Listen {
                address: address.clone(),
                source,
            })
        };
        Ok(match address {
            LinkAddress::Tcp(address) => Self::Tcp(listen(address)?),
            LinkAddress::Lockstep(address) => Self::Lockstep(listen(address)?),
            LinkAddress::Pty => Self::Pty(Pty::open().map_err(LinkError::Pty)?),
        })
    }

    /// What the host must be told to find the link.
    pub fn name(&self) -> io::Result<String> {
        let of = |scheme: &str, address: SocketAddr| format!("{scheme}:{address}");
        Ok(match self {
            Self::Tcp(listener) => of("tcp", listener.local_addr()?),
            Self::Lockstep(listener) => of("lockstep", listener.local_addr()?),
            Self::Pty(pty) => pty.path().to_owned(),
        })
    }

    /// Serves hosts, one after another, until the machine stops.
    pub fn serve(self, machine: &mut Machine) -> Result<std::convert::Infallible, LinkError> {
        match self {
            Self::Tcp(listener) => Cable::over_tcp(listener)?.serve(machine),
            Self::Pty(pty) => Cable::over_pty(pty).serve(machine),
            Self::Lockstep(listener) => Lockstep::new(listener)?.serve(machine),
        }
    }
}
