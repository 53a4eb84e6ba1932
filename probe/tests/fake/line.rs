//! Lines to a fake board: inside this process, and a lockstep socket.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use hexsense_client::{Transport, TransportError};

use super::FakeBoard;
use super::source;

/// A board on a line without a wire; its clock goes on while the host reads.
pub struct Line {
    pub board: Arc<Mutex<FakeBoard>>,
    waiting: Vec<u8>,
    now: Duration,
}

impl Line {
    /// A line to `board`.
    pub fn to(board: &Arc<Mutex<FakeBoard>>) -> Box<Self> {
        Box::new(Self {
            board: Arc::clone(board),
            waiting: Vec::new(),
            now: Duration::ZERO,
        })
    }
}

impl Transport for Line {
    fn write(&mut self, bytes: &[u8]) -> Result<(), TransportError> {
        let answer = self.board.lock().unwrap().take(bytes);
        self.waiting.extend(answer);
        Ok(())
    }

    fn read(&mut self, into: &mut Vec<u8>, timeout: Duration) -> Result<(), TransportError> {
        let mut board = self.board.lock().unwrap();
        let deadline = self.now + timeout;
        while self.waiting.is_empty() && !board.cut && self.now < deadline {
            self.now += board.block_time();
            self.waiting.extend(board.block().unwrap_or_default());
        }
        if board.cut {
            return Err(TransportError::Closed {
                port: "fake".to_owned(),
            });
        }
        into.append(&mut self.waiting);
        Ok(())
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn port(&self) -> &str {
        "fake"
    }
}

/// Serves a board in lockstep, to one host after another; the port to give to `--port`. A board whose line was cut
/// comes back when the next host comes.
pub fn lockstep(board: FakeBoard) -> String {
    shared(&Arc::new(Mutex::new(board)))
}

/// The same for a board that the test looks at meanwhile.
pub fn shared(board: &Arc<Mutex<FakeBoard>>) -> String {
    let listener = source::listener();
    let port = format!("lockstep:{}", source::address(&listener));
    let board = Arc::clone(board);
    std::thread::spawn(move || {
        let mut now = Duration::ZERO;
        while let Ok((stream, _)) = listener.accept() {
            let mut guard = board.lock().unwrap();
            if guard.cut {
                guard.come_back();
            }
            drop(guard);
            // A host that goes away is none of the board's business.
            let _ = serve(stream, &board, &mut now);
        }
    });
    port
}

fn serve(
    mut stream: TcpStream,
    board: &Mutex<FakeBoard>,
    now: &mut Duration,
) -> std::io::Result<()> {
    stream.set_nodelay(true)?;
    loop {
        let mut head = [0; 8];
        stream.read_exact(&mut head)?;
        let [run_us, length] =
            [0, 4].map(|at| u32::from_le_bytes(head[at..at + 4].try_into().unwrap()));
        let mut bytes = vec![0; length as usize];
        stream.read_exact(&mut bytes)?;
        let mut board = board.lock().unwrap();
        let mut out = board.take(&bytes);
        let end = *now + Duration::from_micros(run_us.into());
        while out.is_empty() && *now < end && !board.cut {
            *now += board.block_time();
            out = board.block().unwrap_or_default();
            std::thread::sleep(board.pace);
        }
        if board.cut {
            return Ok(());
        }
        drop(board);
        stream.write_all(&(now.as_micros() as u64).to_le_bytes())?;
        stream.write_all(&(out.len() as u32).to_le_bytes())?;
        stream.write_all(&out)?;
    }
}
