//! The connection to the host: `--link tcp:ADDR`, `--link pty` or `--link lockstep:ADDR`.

pub mod cable;
pub mod counts;
mod door;
pub mod error;
pub mod lockstep;
pub mod pty;

use std::io;
use std::net::{SocketAddr, TcpListener};
use std::str::FromStr;

pub use self::counts::print_counts;
pub use self::error::LinkError;

use self::cable::Cable;
use self::lockstep::Lockstep;
use self::pty::Pty;
use crate::machine::Machine;

/// The value of `--link`.
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

    /// The address that the host needs to find the link.
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
