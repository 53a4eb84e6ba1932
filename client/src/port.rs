//! Opening a port by its name.
//!
//! | port | what it is |
//! |---|---|
//! | a device, `/dev/ttyACM0` or `COM3` | a serial line at 2 Mbit/s |
//! | `tcp:HOST:PORT` | the same bytes through a socket |
//! | `lockstep:HOST:PORT` | a virtual board that runs only while the host waits for it |

use super::lockstep::Lockstep;
use super::transport::{Transport, TransportError};
use super::{serial, tcp};

/// Opens a port: a serial device, `tcp:HOST:PORT` or `lockstep:HOST:PORT`.
///
/// # Errors
/// [`TransportError`]: a port that is not there, or that another process uses.
pub fn open(port: &str) -> Result<Box<dyn Transport>, TransportError> {
    if let Some(address) = port.strip_prefix("tcp:") {
        return Ok(Box::new(tcp::open(port, address)?));
    }
    if let Some(address) = port.strip_prefix("lockstep:") {
        return Ok(Box::new(Lockstep::open(port, address)?));
    }
    Ok(Box::new(serial::open(port)?))
}
