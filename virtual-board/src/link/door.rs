//! The door for hosts on a socket: one host at a time, as on a serial line.
//!
//! A host that comes while another is connected is turned away: its connection is closed before any byte. A host that has
//! just gone is given [`GRACE`] to be noticed, so that the next one is not turned away because of it.

use std::io;
use std::net::{TcpListener, TcpStream};
use std::ops::{Deref, DerefMut};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

/// How long a newcomer waits for the host before it to be gone.
const GRACE: Duration = Duration::from_millis(500);
/// Pause between two looks whether it is gone.
const LOOK: Duration = Duration::from_millis(5);

/// The listening side.
#[derive(Debug)]
pub struct Door {
    hosts: Receiver<Host>,
}

/// The one host that is connected; when it is dropped, the next may come.
#[derive(Debug)]
pub struct Host {
    stream: TcpStream,
    taken: Arc<AtomicBool>,
}

impl Door {
    /// Lets hosts in that connect to `listener`.
    pub fn new(listener: TcpListener) -> io::Result<Self> {
        let (sender, hosts) = mpsc::channel();
        let taken = Arc::new(AtomicBool::new(false));
        thread::Builder::new().spawn(move || {
            for stream in listener.incoming() {
                let Ok(stream) = stream else { continue };
                if !is_free(&taken) {
                    continue;
                }
                let taken = Arc::clone(&taken);
                taken.store(true, Ordering::SeqCst);
                if sender.send(Host { stream, taken }).is_err() {
                    return;
                }
            }
        })?;
        Ok(Self { hosts })
    }

    /// Waits for the next host.
    pub fn wait(&self) -> io::Result<Host> {
        let gone = |_| io::Error::other("the thread that listens for hosts has ended");
        self.hosts.recv().map_err(gone)
    }

    /// The next host, if one has come.
    pub fn look(&self) -> Option<Host> {
        self.hosts.try_recv().ok()
    }
}

fn is_free(taken: &AtomicBool) -> bool {
    let deadline = Instant::now() + GRACE;
    while taken.load(Ordering::SeqCst) {
        if Instant::now() >= deadline {
            return false;
        }
        thread::sleep(LOOK);
    }
    true
}

impl Deref for Host {
    type Target = TcpStream;

    fn deref(&self) -> &TcpStream {
        &self.stream
    }
}

impl DerefMut for Host {
    fn deref_mut(&mut self) -> &mut TcpStream {
        &mut self.stream
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        self.taken.store(false, Ordering::SeqCst);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Write};

    #[test]
    fn a_second_host_is_turned_away_at_once_and_comes_in_when_the_first_is_gone() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let door = Door::new(listener).unwrap();
        let mut first = TcpStream::connect(address).unwrap();
        let mut host = door.wait().unwrap();
        let start = Instant::now();
        let mut second = TcpStream::connect(address).unwrap();
        assert_eq!(second.read(&mut [0]).unwrap(), 0, "bytes for the second");
        assert!(start.elapsed() < 4 * GRACE);
        first.write_all(b"x").unwrap();
        host.read_exact(&mut [0]).unwrap();
        assert!(door.look().is_none());
        drop(host);
        let _third = TcpStream::connect(address).unwrap();
        door.wait().unwrap();
    }
}
