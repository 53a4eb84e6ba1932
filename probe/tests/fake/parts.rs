//! What is fake behind the server: a flash in memory, made-up counts, and a chip that is always well.

use std::collections::VecDeque;
use std::time::Duration;

use embassy_futures::block_on;
use hexsense::FACTS;
use hexsense_core::channel::{INERTIAL, JACKS, Scan};
use hexsense_core::facts::BoardFacts;
use hexsense_core::live_pose::{JackBlock, Tracker};
use hexsense_core::records::{BuildId, SetId};
use hexsense_core::sample_path::queue::Context;
use hexsense_core::sample_path::{Path, Progress};
use hexsense_core::sampling::{BlockSize, Calibrator, Prepared, SupplyReading};
use hexsense_core::server::solving::{MotionInput, Solving};
use hexsense_core::server::{Board, Command, HarmonicsCommand, Health, SamplingCommand};
use hexsense_core::storage::{Active, Storage, StorageCommand};
use hexsense_core::wire::change::Challenge;
use hexsense_core::wire::hello::Greeting;
use hexsense_core::wire::status::{EventCount, Events, OptionBytes, ResetCause, Resets, StackUse};
use hexsense_core::wire::{BoardPose, Identity, PoseReport, Refusal, Response, VERSION};

use super::Fault;
use super::flash::Flash;
use super::source::Source;

/// What the first blocks of a run take, core cycles.
const CYCLES: [u32; 3] = [4_400, 4_800, 4_500];
/// Temperature of the die, °C.
const TEMPERATURE_C: f32 = 31.5;

/// The build that the board says it is of.
const BUILD: BuildId = BuildId([9, 8, 7, 6, 5, 4, 3, 2]);

/// The parts of the board.
pub struct Parts {
    pub wire: u16,
    pub uid: [u8; 12],
    pub crystal: bool,
    pub flash: Flash,
    pub fault: Fault,
    pub uptime: Duration,
    pub storage: Storage<Flash>,
    source: Box<dyn Source>,
    path: Box<Path>,
    blocks_of_run: usize,
    challenges: u128,
    tracker: Option<Tracker<f32>>,
    events: Events,
    /// Answers of commands that were carried out.
    pub answers: VecDeque<Response>,
    /// Poses that were found.
    pub poses: VecDeque<PoseReport>,
}

impl Parts {
    pub fn new(source: Box<dyn Source>) -> Self {
        let (uid, flash) = (source.uid(), Flash::default());
        let mut parts = Self {
            wire: VERSION,
            uid,
            crystal: true,
            storage: Storage::new(flash.clone(), FACTS.flash, uid),
            flash,
            fault: Fault::None,
            uptime: Duration::ZERO,
            source,
            path: Box::default(),
            blocks_of_run: 0,
            challenges: 0,
            tracker: None,
            events: Events::NONE,
            answers: VecDeque::new(),
            poses: VecDeque::new(),
        };
        parts.start();
        parts
    }

    /// Starts anew on what the flash has.
    pub fn start(&mut self) {
        self.uptime = Duration::ZERO;
        *self.path = Path::default();
        self.begin(FACTS.rates_hz[0], BlockSize::default());
        self.storage = Storage::new(self.flash.clone(), FACTS.flash, self.uid);
        self.storage.load().unwrap();
        block_on(self.storage.complete(BUILD)).unwrap();
        self.track();
    }

    /// The sample path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Time of one block.
    pub fn block_time(&self) -> Duration {
        let progress = &self.path.progress;
        Duration::from_micros(1_000_000 / u64::from(progress.rate_hz))
            * progress.block.scans() as u32
    }

    /// Samples a block.
    pub fn sample(&mut self) {
        self.uptime += self.block_time();
        let (rate_hz, block) = (self.path.progress.rate_hz, self.path.progress.block);
        let scans: Vec<Scan> = (0..block.scans())
            .map(|_| self.source.scan(rate_hz))
            .collect();
        let inertial: Vec<[u16; INERTIAL]> = scans
            .iter()
            .map(|scan| *scan.first_chunk().unwrap())
            .collect();
        let jacks: Vec<[u16; JACKS]> = scans
            .iter()
            .map(|scan| *scan.last_chunk().unwrap())
            .collect();
        self.set_context();
        self.path.sample(&inertial, &jacks);
        let made_up = CYCLES.get(self.blocks_of_run).copied().unwrap_or(4_500);
        self.blocks_of_run += 1;
        self.path.finish(|| made_up);
        self.path.note_times(self.uptime.as_millis() as u64);
    }

    fn set_context(&mut self) {
        let supply = self.source.supply();
        let active = self.storage.active();
        let context = Context {
            supply: match self.fault {
                Fault::NoSupplyFactor => f32::NAN,
                _ => supply,
            },
            temperature_c: match self.fault {
                Fault::NoTemperature => f32::INFINITY,
                _ => TEMPERATURE_C,
            },
            set: active.map(|active| active.set.id),
            supply_is_old: self.fault == Fault::OldSupply,
        };
        let prepared = active.map_or(Prepared::NONE, |active| {
            let at_supply = match self.fault {
                Fault::NoValues => f32::NAN,
                _ => supply,
            };
            Calibrator::new(&active.content).at_supply(at_supply)
        });
        let taken = self.path.set_context(context, &prepared);
        assert!(taken, "every block is sent before the next one comes");
    }

    fn begin(&mut self, rate_hz: u32, block: BlockSize) {
        self.path.begin(&FACTS, rate_hz, block, 0);
        self.blocks_of_run = 0;
    }

    fn store(&mut self, command: StorageCommand) -> Result<Response, Refusal> {
        let is_read = matches!(command, StorageCommand::Read(_));
        let mut response = self.keep(command)?;
        if let (Response::SetBytes { bytes, .. }, true, Fault::WornFlash) =
            (&mut response, is_read, self.fault)
        {
            bytes[0] ^= 1;
        }
        Ok(response)
    }

    /// Has the storage carry out a command.
    pub fn keep(&mut self, command: StorageCommand) -> Result<Response, Refusal> {
        let now_ms = self.uptime.as_millis() as u64;
        let challenges = &mut self.challenges;
        let random = async |challenge: &mut Challenge| {
            *challenges += 1;
            *challenge = challenges.to_le_bytes();
            true
        };
        let id = |storage: &Storage<Flash>| -> Option<SetId> {
            storage.active().map(|active| active.set.id)
        };
        let before = id(&self.storage);
        let response = block_on(self.storage.carry_out(command, now_ms, random));
        if before != id(&self.storage) {
            self.track();
        }
        response
    }

    fn track(&mut self) {
        let active = self.storage.active().map(|active| &active.content);
        self.tracker =
            active.map(|set| Tracker::new(&set.base, &set.jacks, set.ratiometric).unwrap());
    }

    fn solve(&mut self, command: HarmonicsCommand) -> Result<Response, Refusal> {
        let (HarmonicsCommand::Channel { analyser, .. } | HarmonicsCommand::Motion { analyser }) =
            command;
        let path = &self.path;
        let mut sums = |analyser, channel| path.complete_sums(analyser, channel);
        let channel = match command {
            HarmonicsCommand::Channel { channel, .. } => channel,
            HarmonicsCommand::Motion { .. } => 0,
        };
        let first = sums(analyser, channel).ok_or(Refusal::Incomplete { analyser })?;
        let mut solving = Solving::new();
        while !solving.advance(first.drive, u32::MAX)? {}
        match command {
            HarmonicsCommand::Channel { .. } => solving.harmonics(&FACTS, &first, channel),
            HarmonicsCommand::Motion { .. } => {
                let Active { content, .. } = self.storage.active().ok_or(Refusal::NoSet)?;
                let input = MotionInput {
                    base: &content.base,
                    jacks: &content.jacks,
                    ratiometric: content.ratiometric,
                    supply: self.source.supply(),
                };
                solving.motion(&FACTS, input, analyser, &first, &mut sums)
            }
        }
    }
}

impl Board for Parts {
    fn facts(&self) -> &'static BoardFacts {
        &FACTS
    }

    fn greeting(&self) -> Greeting {
        Greeting {
            wire: self.wire,
            firmware: [9, 8, 7],
        }
    }

    fn identity(&self) -> Identity {
        Identity {
            board: self.uid,
            hardware: "fake board".try_into().unwrap(),
            reset: ResetCause::PowerOn,
            facts: FACTS,
            build: Some(BUILD),
        }
    }

    fn has_crystal(&self) -> bool {
        self.crystal
    }

    fn calibrated_at_c(&mut self) -> Option<f32> {
        let active = self.storage.active();
        active.map(|active| active.content.temperature_c)
    }

    fn health(&mut self) -> Health {
        Health {
            uptime_ms: self.uptime.as_millis() as u64,
            events: self.events,
            supply: SupplyReading {
                factor: self.source.supply(),
                temperature_c: TEMPERATURE_C,
                readings: 16,
                is_old: self.fault == Fault::OldSupply,
            },
            provisioned: self.storage.is_provisioned(),
            key_damaged: self.storage.is_key_damaged(),
            resets: Resets::default(),
            stack: StackUse {
                deepest: 6_000,
                size: 24_576,
            },
            panic: None,
            option_bytes: OptionBytes::FACTORY,
            log_used: self.storage.log_used(),
        }
    }

    fn path<R>(&mut self, work: impl FnOnce(&mut Path) -> R) -> R {
        work(&mut self.path)
    }

    fn order(&mut self, command: Command) -> bool {
        let answer = match command {
            Command::Sampling(command) => {
                let Progress { rate_hz, block, .. } = self.path.progress;
                match command {
                    SamplingCommand::Rate(hz) => self.begin(hz, block),
                    SamplingCommand::Block(block) => self.begin(rate_hz, block),
                }
                // As on the real board the answer comes when blocks do.
                CYCLES.iter().for_each(|_| self.sample());
                Ok(Response::Done)
            }
            Command::Storage(command) => self.store(command),
            Command::Harmonics(command) => self.solve(command),
        };
        self.answers
            .push_back(answer.unwrap_or_else(Response::Refused));
        true
    }

    fn find_pose(&mut self, jacks: JackBlock) {
        let Some(Active { set, .. }) = self.storage.active() else {
            return;
        };
        let tracker = self.tracker.as_mut().expect("an active set has a tracker");
        let mut outcome = tracker
            .next(&jacks)
            .map(BoardPose::from)
            .map_err(Into::into);
        if let (Ok(pose), Fault::PoseOff(off_m)) = (&mut outcome, self.fault) {
            pose.position_m[0] += off_m;
        }
        self.poses.push_back(PoseReport {
            first_scan: jacks.first_scan,
            block: jacks.block,
            set: set.id,
            outcome,
        });
    }

    fn count(&mut self, pick: fn(&mut Events) -> &mut EventCount) {
        pick(&mut self.events).note(self.uptime.as_millis() as u64);
    }
}
