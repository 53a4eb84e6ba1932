//! The two sockets of the bench: the board's pins and the requests to the controller.
//!
//! docs/virtual-bench.md describes both protocols. One board at a time is connected. When it disconnects, the bench
//! stands still until the next board connects, and then goes on. Requests to the controller come from any number of
//! connections; each takes effect between two chunks.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::Serialize;
use thiserror::Error;

use crate::bench::{Bench, BenchError, CHUNK_STEPS, STEP_S};
use crate::board::{BoardTruth, COLUMNS};
use crate::control;

pub use crate::control::Twin;

/// The byte that asks for the next chunk: `N`.
pub const NEXT: u8 = 0x4E;
/// Longest request to the controller, bytes.
const MAX_REQUEST: u64 = 65_536;

/// Why the twin stops serving.
#[derive(Debug, Error)]
pub enum ServeError {
    /// The platform cannot follow its jacks.
    #[error(transparent)]
    Bench(#[from] BenchError),
    /// The truth log cannot be written.
    #[error("truth log: {0}")]
    TruthLog(#[source] io::Error),
    /// The listening socket of the pins is gone.
    #[error("pins: {0}")]
    Pins(#[source] io::Error),
}

/// The first line that a board reads.
#[derive(Serialize)]
struct Hello<'a> {
    protocol: &'static str,
    step_s: f64,
    chunk_steps: usize,
    columns: [&'static str; COLUMNS.len()],
    board: &'a BoardTruth,
}

/// Serves pins and control until an error.
///
/// # Errors
/// [`ServeError`], when the bench cannot go on. A board or host that disconnects or sends nonsense is no error.
pub fn serve(pins: &TcpListener, control: TcpListener, twin: Twin) -> Result<(), ServeError> {
    let twin = Arc::new(Mutex::new(twin));
    let for_control = Arc::clone(&twin);
    std::thread::spawn(move || accept_control(&control, &for_control));
    loop {
        let (board, _) = pins.accept().map_err(ServeError::Pins)?;
        let served = serve_board(board, &twin);
        if let Some(log) = &mut lock(&twin).truth_log {
            log.pins_closed();
        }
        match served {
            Err(Interrupted::Twin(error)) => return Err(error),
            Err(Interrupted::Board(reason)) => eprintln!("twin: board disconnected: {reason}"),
            Ok(()) => {}
        }
    }
}

/// Locks the twin. A panic of another thread leaves nothing half done behind this lock.
fn lock(twin: &Mutex<Twin>) -> MutexGuard<'_, Twin> {
    twin.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Why the connection to a board ended before the board closed it.
enum Interrupted {
    Board(io::Error),
    Twin(ServeError),
}

impl From<io::Error> for Interrupted {
    fn from(error: io::Error) -> Self {
        Self::Board(error)
    }
}

fn serve_board(mut board: TcpStream, twin: &Mutex<Twin>) -> Result<(), Interrupted> {
    board.set_nodelay(true)?;
    board.write_all(&hello(&mut lock(twin).bench)?)?;
    let (mut request, mut rows, mut bytes) = ([0], Vec::new(), Vec::new());
    while board.read(&mut request)? == 1 {
        if request[0] != NEXT {
            let reason = format!("asked with 0x{:02X}, must be 0x{NEXT:02X}", request[0]);
            return Err(io::Error::new(io::ErrorKind::InvalidData, reason).into());
        }
        make_chunk(&mut lock(twin), &mut rows).map_err(Interrupted::Twin)?;
        bytes.clear();
        bytes.extend(rows.iter().flat_map(|volts| volts.to_le_bytes()));
        board.write_all(&bytes)?;
    }
    Ok(())
}

fn hello(bench: &mut Bench) -> io::Result<Vec<u8>> {
    bench.connect();
    let mut line = serde_json::to_vec(&Hello {
        protocol: "hexsense-pins 1",
        step_s: STEP_S,
        chunk_steps: CHUNK_STEPS,
        columns: COLUMNS,
        board: bench.board(),
    })?;
    line.push(b'\n');
    Ok(line)
}

fn make_chunk(twin: &mut Twin, rows: &mut Vec<f32>) -> Result<(), ServeError> {
    let mut written = Ok(());
    let log = &mut twin.truth_log;
    twin.bench.next_chunk(rows, |motion| {
        if let (Some(log), Ok(())) = (log.as_mut(), &written) {
            written = log.step(motion);
        }
    })?;
    written.map_err(ServeError::TruthLog)
}

fn accept_control(control: &TcpListener, twin: &Arc<Mutex<Twin>>) {
    for host in control.incoming().flatten() {
        let twin = Arc::clone(twin);
        std::thread::spawn(move || {
            if let Err(reason) = serve_host(&host, &twin) {
                eprintln!("twin: host disconnected: {reason}");
            }
        });
    }
}

fn serve_host(host: &TcpStream, twin: &Mutex<Twin>) -> io::Result<()> {
    host.set_nodelay(true)?;
    let (mut reader, mut writer) = (BufReader::new(host), host);
    let mut line = Vec::new();
    loop {
        line.clear();
        let length = reader
            .by_ref()
            .take(MAX_REQUEST)
            .read_until(b'\n', &mut line)?;
        if length == 0 {
            return Ok(());
        }
        let answer = control::answer(&line, || lock(twin));
        writer.write_all(answer.as_bytes())?;
        if length as u64 == MAX_REQUEST {
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                format!("request longer than {MAX_REQUEST} bytes"),
            ));
        }
    }
}
