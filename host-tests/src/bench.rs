//! The twin read by a short model of a converter: the same counts as the board's, in distribution.
//!
//! The converter has the gain, offset, noise and supply that the twin gives to every board. It converts at the instants
//! of the scan by the board's inexact clock. No other part of the board is modelled.

use hexsense::FACTS;
use hexsense_core::channel::{CHANNELS, INERTIAL, Scan};
use hexsense_core::excitation::Program;
use hexsense_probe::analysis::RecordedRun;
use hexsense_probe::capture::Capture;
use hexsense_probe::geometry_file::GeometryFile;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use twin::Bench;
use twin::bench::CHUNK_STEPS;
use twin::board::COLUMNS;
use twin::geometry::Geometry;

/// Step of the twin, s: twice that of the virtual bench, still far beyond the bandwidth of the sensors.
const STEP_S: f64 = 0.001;
/// Scan rate, Hz.
pub const RATE_HZ: u32 = 1_000;
/// Recorded after the end of a movement, s.
const AFTER_S: f64 = 1.0;
/// Time between the rows of a jack program, s.
const PROGRAM_PERIOD_S: f64 = 0.002;
const TEMPERATURE: usize = COLUMNS.len() - 2;
const SUPPLY: usize = COLUMNS.len() - 1;

/// A run of a plan, ready for the motion controller.
pub struct Movement {
    name: String,
    program: Program,
    /// The jack program; none when the base rests.
    jacks: Option<twin::Program>,
    /// Recorded at rest at the end, s.
    rest_s: f64,
}

impl Movement {
    /// The movement of `program` on a base, or a rest of `rest_s`.
    ///
    /// # Panics
    /// When the program has no rows: these are tests.
    #[must_use]
    pub fn new(name: &str, program: Program, rest_s: Option<f64>, base: &GeometryFile) -> Self {
        let geometry = &base.geometry;
        let jacks = rest_s.is_none().then(|| {
            let rows = program.jack_rows(geometry, PROGRAM_PERIOD_S);
            twin::Program::new(PROGRAM_PERIOD_S, rows.collect())
                .expect("a program with an even period")
        });
        Self {
            name: name.to_owned(),
            program,
            jacks,
            rest_s: rest_s.unwrap_or(AFTER_S),
        }
    }
}

/// A twin with a converter.
pub struct Laboratory {
    bench: Bench,
    noise: ChaCha8Rng,
    /// The chunk in use and the one before: channels of a scan may lie on both sides of their border.
    rows: [Vec<f32>; 2],
    chunk: usize,
    scan: u64,
}

impl Laboratory {
    /// The twin of a seed on a base.
    ///
    /// # Panics
    /// When the base is not usable: these are tests.
    #[must_use]
    pub fn new(seed: u64, base: &GeometryFile) -> Self {
        let geometry = Geometry::parse(&base.text).expect("a usable geometry");
        let mut bench = Bench::with_step(seed, &geometry, STEP_S).expect("a base that stands");
        let mut rows = [Vec::new(), Vec::new()];
        bench
            .next_chunk(&mut rows[0], |_| ())
            .expect("a base at rest");
        Self {
            bench,
            noise: ChaCha8Rng::seed_from_u64(seed),
            rows,
            chunk: 0,
            scan: 0,
        }
    }

    /// Records a movement: tells the controller, and scans until the movement is over.
    ///
    /// # Panics
    /// When the controller refuses it: these are tests.
    pub fn record(&mut self, movement: &Movement) -> RecordedRun {
        let Movement { name, program, .. } = movement;
        let mut capture = Capture::default();
        if let Some(jacks) = &movement.jacks {
            self.bench
                .run(name, jacks.clone())
                .expect("a program inside the stroke");
            while self.bench.is_busy() {
                self.scan_once(&mut capture);
            }
        }
        for _ in 0..(movement.rest_s * f64::from(RATE_HZ)) as usize {
            self.scan_once(&mut capture);
        }
        RecordedRun {
            name: name.clone(),
            program: program.clone(),
            capture,
            rate_hz: RATE_HZ,
            ratiometric: Default::default(),
        }
    }

    fn scan_once(&mut self, capture: &mut Capture) {
        let clock = 1.0 + self.bench.board().clock_ppm * 1e-6;
        let trigger_s = self.scan as f64 / (f64::from(RATE_HZ) * clock);
        let mut scan: Scan = [0; CHANNELS];
        let supply_v = self.at(trigger_s, SUPPLY);
        for (channel, count) in scan.iter_mut().enumerate() {
            let adc = self.bench.board().adc[usize::from(channel >= INERTIAL)];
            let volts = self.at(trigger_s + FACTS.instant_s(channel), channel);
            let noise: f64 = StandardNormal.sample(&mut self.noise);
            // Sixteen conversions: the noise of a sum is four times that of one.
            let codes =
                16.0 * (volts / supply_v * 4096.0 * (1.0 + adc.gain_error) + adc.offset_lsb);
            *count = (codes + 4.0 * adc.noise_lsb * noise)
                .round()
                .clamp(0.0, 65_520.0) as u16;
        }
        capture.scans.push(self.scan);
        capture.counts.push(scan);
        capture.supply.push(self.supply_factor(supply_v) as f32);
        capture
            .temperature_c
            .push(self.at(trigger_s, TEMPERATURE) as f32);
        self.scan += 1;
    }

    /// The supply as the board measures it: by its reference, whose reading at 3 V the factory rounded.
    fn supply_factor(&self, supply_v: f64) -> f64 {
        let board = self.bench.board();
        let factory = (board.vrefint_v / 3.0 * 4096.0).round();
        let code = board.vrefint_v / supply_v * 4096.0 * (1.0 + board.adc[4].gain_error)
            + board.adc[4].offset_lsb;
        3.0 * factory / code / 3.3
    }

    /// A column at a true time, linear between rows; makes chunks as needed.
    fn at(&mut self, time_s: f64, column: usize) -> f64 {
        let place = time_s / STEP_S;
        let chunk = place as usize / CHUNK_STEPS;
        while chunk > self.chunk {
            self.chunk += 1;
            let rows = &mut self.rows[self.chunk % 2];
            self.bench
                .next_chunk(rows, |_| ())
                .expect("a platform that follows its jacks");
        }
        let (rows, row) = (&self.rows[chunk % 2], place as usize % CHUNK_STEPS);
        let value = |row: usize| f64::from(rows[row * COLUMNS.len() + column]);
        value(row) + place.fract() * (value(row + 1) - value(row))
    }
}
