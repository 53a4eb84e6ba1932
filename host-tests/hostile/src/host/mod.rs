//! The host against a board that says anything: commands end with a text or a typed error, no value that is not finite is
//! recorded, and nothing is printed that a terminal obeys.
//!
//! The first byte chooses a command, the others steer what the board sends: good answers, changed ones, those of other
//! requests, blocks and poses, and bytes that are nothing.

mod line;

use hexsense_client::Client;
use hexsense_core::records::SetId;
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::telemetry::Block;
use hexsense_probe::capture::Gap;
use hexsense_probe::cli::proven::Proven;
use hexsense_probe::cli::{harmonics, history, info, log, show, status};
use hexsense_probe::files::FileError;
use hexsense_probe::interrupt::Interrupt;
use hexsense_probe::record::board::Streaming;
use hexsense_probe::record::recorder::Recorder;
use hexsense_probe::record::sink::{Notes, Recorded, Sink};
use hexsense_probe::terminal::{escaped, one_line};

use crate::key_holder::KEY;
use crate::{liar, sets};
use line::Line;

/// Blocks of a recording.
const BLOCKS: usize = 32;
/// Runs one command against one board.
///
/// # Panics
/// When a promise is broken.
pub fn run(data: &[u8]) {
    let Some((command, input)) = data.split_first() else {
        return;
    };
    let mut client = match Client::connect(Box::new(Line::new(input))) {
        Ok(client) => client,
        Err(error) => return shown(&error.to_string()),
    };
    // No board of random bytes has the key.
    let proven = Proven::No("no key is at hand".to_owned());
    let text = match command % 16 {
        0 => info::text(&mut client, false, &proven),
        1 => status::text(&mut client, false),
        2 => status::text(&mut client, true).inspect(|text| document(text)),
        3 => show::text(&mut client, false, &proven),
        4 => show::text(&mut client, true, &proven).inspect(|text| document(text)),
        5 => log::text(&mut client, false, &proven),
        6 => log::text(&mut client, true, &proven).inspect(|text| document(text)),
        7 => history::text(&mut client, false),
        8 => history::text(&mut client, true).inspect(|text| document(text)),
        9 => harmonics::text(&mut client, 0, false),
        10 => harmonics::text(&mut client, 0, true).inspect(|text| document(text)),
        11 => {
            let uploaded = client.upload(&sets::encoded(&sets::numbered(1)), &KEY);
            uploaded
                .map(|active| active.id.to_string())
                .map_err(Into::into)
        }
        12 => {
            let rolled_back = client.roll_back(&KEY, SetId([3; 8]));
            rolled_back
                .map(|active| active.id.to_string())
                .map_err(Into::into)
        }
        13 => {
            let erased = client.factory_reset(&KEY);
            erased
                .map(|sets| sets.len().to_string())
                .map_err(Into::into)
        }
        _ => record(&mut client),
    };
    match text {
        Ok(text) => shown(&text),
        Err(error) => shown(&error.to_string()),
    }
}

/// What is printed is not obeyed.
fn shown(text: &str) {
    let printed = escaped(text);
    let is_obeyed = |letter: char| letter.is_control() && !matches!(letter, '\n' | '\t');
    assert!(
        !printed.is_empty() && !printed.chars().any(is_obeyed),
        "{printed:?}"
    );
    assert!(!one_line(text).to_string().contains(char::is_control));
}

/// What is printed of a document is one, and the same.
fn document(text: &str) {
    let read = |text: &str| serde_json::from_str::<serde_json::Value>(text).expect("a document");
    assert_eq!(read(&escaped(text)), read(text));
}

/// Records some blocks.
fn record(client: &mut Client) -> anyhow::Result<String> {
    let interrupt = Interrupt::default();
    let streaming = Streaming {
        rate_hz: liar::RATE_HZ,
        block: BlockSize::One,
        content: liar::CONTENT,
    };
    let mut recorder = Recorder::start(client, streaming, &interrupt)?;
    recorder.begin(vec![Box::new(Judge::default())])?;
    for _ in 0..BLOCKS {
        recorder.next_block()?;
    }
    let recorded = recorder.end()?;
    Ok(format!("{} scans", recorded.scans))
}

/// A sink that nothing impossible reaches.
#[derive(Default)]
struct Judge {
    next_scan: u64,
}

impl Sink for Judge {
    fn begin(&mut self, _: &Notes) -> Result<(), FileError> {
        Ok(())
    }

    fn block(&mut self, block: &Block) -> Result<(), FileError> {
        let header = &block.header;
        let values = block.values.iter().flatten().flatten();
        let mut numbers = values.chain([&header.supply, &header.temperature_c]);
        assert!(numbers.all(|number| number.is_finite()), "{block:?}");
        assert!(header.first_scan >= self.next_scan && header.first_scan <= 1 << 53);
        self.next_scan = header.first_scan + u64::from(header.scans);
        Ok(())
    }

    fn gap(&mut self, gap: Gap) -> Result<(), FileError> {
        assert!(gap.scans > 0 && gap.first_scan == self.next_scan);
        Ok(())
    }

    fn end(&mut self, _: &Recorded) -> Result<(), FileError> {
        Ok(())
    }
}
