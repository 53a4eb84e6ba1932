//! A board that lies, behind a socket, and the command that it is told to.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use hexsense_core::wire::{Request, Response, StreamContent};
use hostile::liar::{
    self, Ear, Heard, answer_frame, block_frame, greeting_frame, header, pose_frame, pose_report,
};

use super::command::{Ended, Hexsense};

/// What the stream of a good board carries.
pub const CONTENT: StreamContent = StreamContent {
    counts: true,
    values: true,
    pose: false,
};
/// Pause between two waves of a stream.
const PAUSE: Duration = Duration::from_millis(1);

type Answer = Box<dyn Fn(&Request) -> Option<Response> + Send>;
/// What is sent at the pace of a stream, by the number of the wave.
type Stream = Box<dyn Fn(u64) -> Vec<u8> + Send>;

/// A board that lies.
pub struct Lie {
    /// The command that it is told to.
    pub arguments: Vec<&'static str>,
    /// What the command must say.
    pub told: &'static str,
    /// What it answers; `None` is what a good board answers.
    pub answer: Answer,
    /// What it streams.
    pub stream: Stream,
    /// Whether it sends its stream unasked.
    pub unasked: bool,
}

/// A board without a lie.
pub fn good_board() -> Lie {
    Lie {
        arguments: Vec::new(),
        told: "",
        answer: Box::new(|_| None),
        stream: Box::new(good_wave),
        unasked: false,
    }
}

/// One scan in each millisecond.
pub fn good_wave(number: u64) -> Vec<u8> {
    let mut report = pose_report();
    report.first_scan = number;
    let pose = pose_frame(&report, 0);
    [block_frame(&header(number, CONTENT), 1.5, 0), pose].concat()
}

/// Runs the lie's command against its board.
pub fn answer_with(mut lie: Lie, folder: &Path) -> anyhow::Result<Ended> {
    let arguments = std::mem::take(&mut lie.arguments);
    with_board(lie, folder, &arguments, |_| {})
}

/// Runs a command, changed by `change`, against a board.
pub fn with_board(
    board: Lie,
    folder: &Path,
    arguments: &[&str],
    change: impl FnOnce(&mut Hexsense),
) -> anyhow::Result<Ended> {
    let listener = TcpListener::bind("127.0.0.1:0")?;
    let port = format!("tcp:{}", listener.local_addr()?);
    thread::spawn(move || {
        if let Ok((line, _)) = listener.accept() {
            // A host that goes away ends the board.
            let _ = serve(line, &board);
        }
    });
    let mut command = Hexsense::new(folder, &[arguments, &["--port", &port]].concat());
    change(&mut command);
    command.run()
}

fn serve(mut line: TcpStream, board: &Lie) -> std::io::Result<()> {
    line.set_nodelay(true)?;
    line.set_read_timeout(Some(PAUSE))?;
    let (mut ear, mut streams, mut waves) = (Ear::default(), board.unasked, 0);
    let mut due = Instant::now();
    loop {
        let mut bytes = [0; 4_096];
        let count = match line.read(&mut bytes) {
            Ok(0) => return Ok(()),
            Ok(count) => count,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
            Err(error) => return Err(error),
        };
        for heard in ear.hear(&bytes[..count]) {
            match heard {
                Heard::Hello => line.write_all(&greeting_frame())?,
                Heard::Request(sequence, request) => {
                    if let Request::Stream(content) = request {
                        streams = board.unasked || content != StreamContent::default();
                    }
                    let said = (board.answer)(&request);
                    let said = said.unwrap_or_else(|| liar::answer(&request));
                    line.write_all(&answer_frame(&said, sequence))?;
                }
            }
        }
        while streams && due <= Instant::now() {
            due += PAUSE;
            line.write_all(&(board.stream)(waves))?;
            waves += 1;
        }
        if !streams {
            due = Instant::now();
        }
    }
}
