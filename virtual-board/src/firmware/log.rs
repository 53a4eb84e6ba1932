//! The firmware's log: read out of RAM as a debug probe does (RTT), decoded (defmt), written to stderr with the virtual
//! time in front.
//!
//! ```text
//! control block: "SEGGER RTT" in 16 bytes, u32 up channels, u32 down channels, then per channel
//!                name, buffer, size, write offset, read offset, flags (u32 each)
//! ```
//!
//! Only the first up channel is read. If the file has no defmt information, the log is plain text.

use defmt_decoder::{DecodeError, Locations, StreamDecoder, Table};

use crate::memory::RAM_BASE;
use crate::memory::block::Block;

const MAGIC: &[u8; 10] = b"SEGGER RTT";
const FIRST_CHANNEL: usize = 24;

/// Reader of the log.
pub struct FirmwareLog {
    /// Offset of the control block in RAM.
    control: Option<usize>,
    decoder: Option<Defmt>,
    line: Vec<u8>,
}

struct Defmt {
    table: &'static Table,
    locations: Option<Locations>,
    decoder: Box<dyn StreamDecoder>,
}

impl FirmwareLog {
    /// A reader for the firmware in `elf`, whose control block is at address `rtt`.
    pub fn new(elf: &[u8], rtt: Option<u32>) -> Self {
        let control = rtt
            .and_then(|address| address.checked_sub(RAM_BASE))
            .map(|offset| offset as usize);
        Self {
            control,
            decoder: Defmt::new(elf),
            line: Vec::new(),
        }
    }

    /// A reader for firmware without a log.
    pub fn none() -> Self {
        Self {
            control: None,
            decoder: None,
            line: Vec::new(),
        }
    }

    /// A new run of the firmware begins: incomplete entries are dropped.
    pub fn restart(&mut self) {
        self.line.clear();
        if let Some(defmt) = &mut self.decoder {
            defmt.decoder = defmt.table.new_stream_decoder();
        }
    }

    /// Sets the first channel to blocking, as a debug probe does that wants to lose nothing, and never reads it again.
    pub fn stop_reading(&mut self, ram: &mut Block) {
        const BLOCK_IF_FULL: u32 = 2;
        if let Some(control) = self.control.take() {
            // A firmware without this channel has no log that could block.
            let _ = ram.write(control + FIRST_CHANNEL + 20, &BLOCK_IF_FULL.to_le_bytes());
        }
    }

    /// Reads new bytes of the log and prints the complete entries.
    pub fn poll(&mut self, ram: &mut Block, now_s: f64) {
        let Some(bytes) = self.control.and_then(|control| drain(ram, control)) else {
            return;
        };
        match &mut self.decoder {
            Some(defmt) => defmt.print(&bytes, now_s),
            None => {
                for byte in bytes {
                    if byte == b'\n' {
                        eprintln!("[{now_s:12.6}] {}", String::from_utf8_lossy(&self.line));
                        self.line.clear();
                    } else {
                        self.line.push(byte);
                    }
                }
            }
        }
    }
}

/// Takes all bytes out of the first up channel; none if it is empty or not set up.
fn drain(ram: &mut Block, control: usize) -> Option<Vec<u8>> {
    let channel = control + FIRST_CHANNEL;
    let (write, read) = (
        ram.word(channel + 12)? as usize,
        ram.word(channel + 16)? as usize,
    );
    if write == read {
        return None;
    }
    let mut magic = [0; MAGIC.len()];
    let valid = ram.read(control, &mut magic) && &magic == MAGIC;
    let size = ram.word(channel + 8)? as usize;
    let buffer = (ram.word(channel + 4)?.checked_sub(RAM_BASE)?) as usize;
    if !valid || write >= size || read >= size {
        return None;
    }
    let mut bytes = vec![0; (write + size - read) % size];
    let before_wrap = bytes.len().min(size - read);
    let (first, second) = bytes.split_at_mut(before_wrap);
    let taken = ram.read(buffer + read, first) && ram.read(buffer, second);
    let acknowledged = taken && ram.write(channel + 16, &(write as u32).to_le_bytes());
    acknowledged.then_some(bytes)
}

impl Defmt {
    fn new(elf: &[u8]) -> Option<Self> {
        let table = match Table::parse(elf) {
            Ok(table) => table?,
            Err(error) => {
                eprintln!("board: the log cannot be decoded: {error:#}");
                return None;
            }
        };
        let locations = table
            .get_locations(elf)
            .ok()
            .filter(|locations| table.indices().all(|i| locations.contains_key(&(i as u64))));
        // The decoder borrows the table, and both live as long as the process.
        let table: &'static Table = Box::leak(Box::new(table));
        Some(Self {
            table,
            locations,
            decoder: table.new_stream_decoder(),
        })
    }

    fn print(&mut self, bytes: &[u8], now_s: f64) {
        self.decoder.received(bytes);
        loop {
            match self.decoder.decode() {
                Ok(frame) => {
                    let level = frame
                        .level()
                        .map_or("", |level| level.as_str())
                        .to_uppercase();
                    let place = self
                        .locations
                        .as_ref()
                        .and_then(|locations| locations.get(&frame.index()));
                    let place = place.map_or(String::new(), |at| {
                        let file = at
                            .file
                            .file_name()
                            .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
                        format!("  ({file}:{})", at.line)
                    });
                    eprintln!(
                        "[{now_s:12.6}] {level:5} {}{place}",
                        frame.display_message()
                    );
                }
                Err(DecodeError::UnexpectedEof) => return,
                Err(DecodeError::Malformed) if self.table.encoding().can_recover() => {
                    eprintln!("[{now_s:12.6}] board: a log entry was damaged");
                }
                Err(DecodeError::Malformed) => return,
            }
        }
    }
}
