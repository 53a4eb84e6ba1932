//! The twin, which starts each run by itself.

use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::path::Path;
use std::time::Duration;

use serde::Deserialize;
use serde_json::json;

use super::{Motion, MotionError};
use crate::terminal::one_line;

/// Longest answer, bytes.
const MAX_ANSWER: u64 = 65_536;
/// How long the twin may take to answer.
const ANSWER: Duration = Duration::from_secs(4);

/// The twin's control socket; see docs/virtual-bench.md.
pub struct Twin {
    address: String,
    stream: BufReader<TcpStream>,
}

#[derive(Deserialize)]
struct Answer {
    ok: bool,
    error: Option<String>,
}

impl Twin {
    /// Connects to the control socket at `address`, HOST:PORT.
    ///
    /// # Errors
    /// [`MotionError::Unreachable`].
    pub fn connect(address: &str) -> Result<Self, MotionError> {
        let unreachable = |reason: String| MotionError::Unreachable {
            address: address.to_owned(),
            reason,
        };
        let place = address
            .to_socket_addrs()
            .ok()
            .and_then(|mut places| places.next())
            .ok_or_else(|| unreachable("not an address; write HOST:PORT".to_owned()))?;
        let connect = || {
            let stream = TcpStream::connect_timeout(&place, ANSWER)?;
            stream.set_nodelay(true)?;
            stream.set_read_timeout(Some(ANSWER))?;
            Ok::<_, std::io::Error>(stream)
        };
        let stream = connect().map_err(|error| unreachable(error.to_string()))?;
        Ok(Self {
            address: address.to_owned(),
            stream: BufReader::new(stream),
        })
    }

    fn request(&mut self, run: &str, request: &serde_json::Value) -> Result<(), MotionError> {
        let answer = self
            .exchange(request)
            .map_err(|error| MotionError::Unreachable {
                address: self.address.clone(),
                reason: error.to_string(),
            })?;
        if answer.ok {
            return Ok(());
        }
        let reason = answer.error.unwrap_or_else(|| "no reason given".to_owned());
        Err(MotionError::Refused {
            run: run.to_owned(),
            reason: one_line(&reason).to_string(),
        })
    }

    fn exchange(&mut self, request: &serde_json::Value) -> std::io::Result<Answer> {
        let line = format!("{request}\n");
        self.stream.get_mut().write_all(line.as_bytes())?;
        let mut answer = String::new();
        let length = (&mut self.stream).take(MAX_ANSWER).read_line(&mut answer)?;
        if length == 0 {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        if length as u64 == MAX_ANSWER {
            let problem = format!("its answer is longer than {MAX_ANSWER} bytes");
            return Err(std::io::Error::new(ErrorKind::InvalidData, problem));
        }
        Ok(serde_json::from_str(&answer)?)
    }
}

impl Motion for Twin {
    fn prepare(&mut self, _run: &str, _program: Option<&Path>) -> Result<(), MotionError> {
        Ok(())
    }

    fn start(&mut self, run: &str, program: &Path) -> Result<(), MotionError> {
        // The twin has a working folder of its own.
        let program = program
            .canonicalize()
            .unwrap_or_else(|_| program.to_owned());
        self.request(run, &json!({"run": {"name": run, "program": program}}))
    }

    fn stop(&mut self) {
        // Called when something else has failed already; there is nobody left to tell.
        let _ = self.request("stop", &json!({"stop": true}));
    }
}
