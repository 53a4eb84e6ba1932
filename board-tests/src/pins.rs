//! Voltages on the pins: for counting, of every kind that a branch on data could tell apart; or steady, and different for
//! each channel.
//!
//! Stands in for the twin at the board's pins (see docs/virtual-bench.md).

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use hexsense::FACTS;
use hexsense_core::channel::INERTIAL;
use serde_json::json;

/// Pins of the fifteen channels in the order of a scan.
pub const PINS: [&str; 15] = [
    "PA0", "PA1", "PB0", "PB1", "PB11", "PB12", "PB14", "PC0", "PC1", "PA4", "PA6", "PA7", "PB2",
    "PB15", "PC4",
];
/// The period of a scan at 4 kHz.
const STEP_S: f64 = 250e-6;
const CHUNK_STEPS: usize = 40;
/// One kind of voltage lasts for so many chunks: 0.1 s.
const CHUNKS_OF_A_KIND: usize = 10;
const SUPPLY_V: f32 = FACTS.nominal_supply_v;
/// Beyond the supply, so that every conversion gives the largest count.
const SATURATED_V: f32 = 4.0;

/// Steady voltages are multiples of this, one for the first channel.
pub const STEP_V: f64 = 0.2;

/// A bench of voltages, until it is dropped with its board.
pub struct Pins {
    address: String,
    /// Whether the jacks are like those of a base that moves, instead of any voltage.
    moves: Arc<AtomicBool>,
}

impl Pins {
    /// Listens for one board, with voltages of every kind.
    pub fn start() -> anyhow::Result<Self> {
        let moves = Arc::new(AtomicBool::new(true));
        let shared = Arc::clone(&moves);
        let mut random = 0x2545_F491_u32;
        let address = listen(1.5, move |step| {
            let kind = step / (CHUNK_STEPS * CHUNKS_OF_A_KIND) % 4;
            row(step, kind, shared.load(Ordering::Relaxed), &mut random)
        })?;
        Ok(Self { address, moves })
    }

    /// Listens for one board, with steady voltages and no noise: the channel with index n has (n + 1) times [`STEP_V`].
    pub fn steady() -> anyhow::Result<Self> {
        let steps = (1..=PINS.len()).map(|step| (step as f64 * STEP_V) as f32);
        let row: Vec<u8> = steps
            .chain([30.0, SUPPLY_V])
            .flat_map(f32::to_le_bytes)
            .collect();
        Ok(Self {
            address: listen(0.0, move |_| row.clone())?,
            moves: Arc::default(),
        })
    }

    /// Where the board finds it.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// From the next chunk on the jacks move as a base does, or have voltages of every kind.
    pub fn set_moves(&self, moves: bool) {
        self.moves.store(moves, Ordering::Relaxed);
    }
}

/// Serves one board; returns the address at which it does.
fn listen(
    noise_lsb: f64,
    mut row: impl FnMut(usize) -> Vec<u8> + Send + 'static,
) -> anyhow::Result<String> {
    let listener = TcpListener::bind("127.0.0.1:0")?;
    let address = format!("tcp:{}", listener.local_addr()?);
    thread::spawn(move || {
        if let Ok((board, _)) = listener.accept() {
            // It ends when the board goes away.
            let _ = serve(board, noise_lsb, &mut row);
        }
    });
    Ok(address)
}

/// Sends the row of each step.
fn serve(
    mut board: TcpStream,
    noise_lsb: f64,
    row: &mut dyn FnMut(usize) -> Vec<u8>,
) -> std::io::Result<()> {
    let columns: Vec<_> = PINS.into_iter().chain(["temp_c", "vdda_v"]).collect();
    let adc = json!({"gain_error": 0.0, "offset_lsb": 0.0, "noise_lsb": noise_lsb});
    let greeting = json!({
        "protocol": "hexsense-pins 1", "step_s": STEP_S, "chunk_steps": CHUNK_STEPS, "columns": columns,
        "board": {
            "seed": 1, "uid": "000102030405060708090a0b", "clock_ppm": 0.0, "vrefint_v": 1.212,
            "boot_unix_s": 1_780_000_000, "adc": [adc, adc, adc, adc, adc],
        },
    });
    board.set_nodelay(true)?;
    board.write_all(format!("{greeting}\n").as_bytes())?;
    let mut last = Vec::new();
    for chunk in 0.. {
        board.read_exact(&mut [0])?;
        // The last row of a chunk is the first of the next.
        let mut rows = std::mem::take(&mut last);
        let first = usize::from(!rows.is_empty());
        for step in chunk * CHUNK_STEPS + first..=(chunk + 1) * CHUNK_STEPS {
            last = row(step);
            rows.extend_from_slice(&last);
        }
        board.write_all(&rows)?;
    }
    Ok(())
}

/// One row: random, saturated, alternating or zero voltages.
fn row(step: usize, kind: usize, moves: bool, random: &mut u32) -> Vec<u8> {
    let voltage = |channel: usize| {
        if moves && channel >= INERTIAL {
            return jack_v(step as f64 * STEP_S, channel - INERTIAL);
        }
        // Xorshift, Marsaglia 2003.
        *random ^= *random << 13;
        *random ^= *random >> 17;
        *random ^= *random << 5;
        match kind {
            0 => *random as f32 / u32::MAX as f32 * SUPPLY_V,
            1 => SATURATED_V,
            2 if (step + channel).is_multiple_of(2) => SATURATED_V,
            _ => 0.0,
        }
    };
    (0..PINS.len())
        .map(voltage)
        .chain([30.0, SUPPLY_V])
        .flat_map(f32::to_le_bytes)
        .collect()
}

/// A jack that goes up and down by 0.2 V around the middle, each in its own rhythm.
fn jack_v(time_s: f64, jack: usize) -> f32 {
    let frequency_hz = 0.3 + 0.07 * jack as f64;
    let turn = core::f64::consts::TAU * frequency_hz * time_s;
    (f64::from(SUPPLY_V) / 2.0 + 0.2 * turn.sin()) as f32
}
