//! What a fake board measures: constant counts, or the voltages of a twin.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};

use hexsense_core::channel::{CHANNELS, Scan};
use twin::Bench;
use twin::serve::Twin;

/// A source of scans.
pub trait Source: Send {
    /// The next scan, one period after the last.
    fn scan(&mut self, rate_hz: u32) -> Scan;
    /// Supply factor.
    fn supply(&self) -> f32 {
        1.0
    }
    /// Unique id of the chip.
    fn uid(&self) -> [u8; 12] {
        *b"fake board 1"
    }
}

/// Mid-scale on every channel: a base at mid-stroke that never moves.
pub struct Still;

impl Source for Still {
    fn scan(&mut self, _rate_hz: u32) -> Scan {
        [32_768; CHANNELS]
    }
}

/// The voltages of a twin behind its pins socket, converted without noise and without errors.
pub struct Pins {
    stream: BufReader<TcpStream>,
    columns: usize,
    chunk: Vec<f32>,
    /// Quarters of a millisecond in the chunk.
    place: usize,
    uid: [u8; 12],
    supply: f32,
}

impl Pins {
    /// Connects to the twin at `address`.
    pub fn connect(address: &str) -> Self {
        let mut stream = BufReader::new(TcpStream::connect(address).unwrap());
        let mut line = String::new();
        stream.read_line(&mut line).unwrap();
        let hello: serde_json::Value = serde_json::from_str(&line).unwrap();
        let uid = hello["board"]["uid"].as_str().unwrap();
        let columns = hello["columns"].as_array().unwrap().len();
        Self {
            stream,
            columns,
            chunk: Vec::new(),
            place: usize::MAX,
            uid: hexsense_probe::files::from_hex(uid).unwrap(),
            supply: 1.0,
        }
    }

    fn next_chunk(&mut self) {
        self.stream.get_mut().write_all(b"N").unwrap();
        let mut bytes = vec![0; 41 * self.columns * 4];
        self.stream.read_exact(&mut bytes).unwrap();
        self.chunk = bytes
            .as_chunks::<4>()
            .0
            .iter()
            .map(|bytes| f32::from_le_bytes(*bytes))
            .collect();
        self.place = 0;
    }
}

impl Source for Pins {
    fn scan(&mut self, rate_hz: u32) -> Scan {
        // A row is half a millisecond, and 40 of them are new in a chunk.
        if self.place >= 80 {
            self.next_chunk();
        }
        let row = &self.chunk[self.place / 2 * self.columns..][..self.columns];
        self.place += (4_000 / rate_hz) as usize;
        let supply_v = row[self.columns - 1];
        self.supply = supply_v / 3.3;
        std::array::from_fn(|channel| {
            (row[channel] / supply_v * 65_536.0).clamp(0.0, 65_520.0) as u16
        })
    }

    fn supply(&self) -> f32 {
        self.supply
    }

    fn uid(&self) -> [u8; 12] {
        self.uid
    }
}

/// Starts a twin in this process; addresses of its pins and its control.
pub fn twin(seed: u64, geometry: &str) -> (String, String) {
    let (pins, control) = (listener(), listener());
    let addresses = (address(&pins), address(&control));
    let (_, text) = geometries::PRESETS
        .iter()
        .find(|(name, _)| *name == geometry)
        .unwrap();
    let bench = Bench::new(seed, text).unwrap();
    std::thread::spawn(move || {
        twin::serve::serve(
            &pins,
            control,
            Twin {
                bench,
                truth_log: None,
            },
        )
    });
    addresses
}

/// A socket on a free port of this machine.
pub fn listener() -> TcpListener {
    TcpListener::bind("127.0.0.1:0").unwrap()
}

/// Its address, HOST:PORT.
pub fn address(listener: &TcpListener) -> String {
    listener.local_addr().unwrap().to_string()
}
