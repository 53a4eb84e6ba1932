//! What passes between the tasks: everything that they share.
//!
//! ```text
//!           supply ──────────────┐ c, temperature
//!                                ▼
//!                            sampling
//!                         starts │ ▲ faults
//!  converters ─blocks─▶ sample path ─blocks─▶ link ◀─bytes─▶ host
//!                         ▲      └──drives, sums──┤
//!             active set ─┘ sampling ◀──commands──┤
//!                           storage  ◀──commands──┤     answers of all ─▶ link
//!                         harmonics  ◀──commands──┘
//!                  └──base──▶ harmonics, pose ◀──jacks── link ◀──poses── pose
//! ```
//!
//! What the sample path shares is in [`crate::sampling::path`]. A *latest* value has one writer and overwrites itself; a
//! command is answered exactly once.

use core::cell::Cell;
use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering};

use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use embassy_sync::watch::Watch;
use hexsense_core::channel::Ratiometric;
use hexsense_core::live_pose::JackBlock;
use hexsense_core::records::{BuildId, JackCoefficients, MotionBase, SetId};
use hexsense_core::sampling::{Calibrator, SupplyReading};
use hexsense_core::server::{HarmonicsCommand, SamplingCommand};
use hexsense_core::storage::StorageCommand;
use hexsense_core::wire::{PoseReport, Response};

/// Guards what tasks of different priorities share.
pub type Guard = CriticalSectionRawMutex;

/// The coefficient set in use.
#[derive(Clone)]
pub struct Active {
    /// Which one it is.
    pub id: SetId,
    /// Temperature of the die during its calibration, °C.
    pub temperature_c: f32,
    /// The set in the form that the sample path uses.
    pub calibrator: Calibrator,
}

/// The part of the active set that poses are found with.
#[derive(Clone)]
pub struct Base {
    /// Which set it belongs to.
    pub set: SetId,
    /// The motion base.
    pub base: MotionBase,
    /// Its transducers.
    pub jacks: JackCoefficients,
    /// The channels on which the supply factor does not act.
    pub ratiometric: Ratiometric,
}

/// The tasks that the watchdog looks after: all but its own. Each has a bit.
#[derive(Clone, Copy)]
pub enum Task {
    /// Blocks come.
    Sampling = 1,
    /// The others took their turns.
    Link = 2,
    Storage = 4,
    Supply = 8,
    Pose = 16,
    Harmonics = 32,
}

/// Signs of life since the watchdog was last fed.
pub struct Alive(AtomicU8);

impl Alive {
    const ALL: u8 = 63;

    /// A task makes progress.
    pub fn sign(&self, task: Task) {
        self.0.fetch_or(task as u8, Ordering::Relaxed);
    }

    /// Whether all tasks have made progress since the last time that this was true.
    pub fn all(&self) -> bool {
        let all = self.0.load(Ordering::Relaxed) == Self::ALL;
        if all {
            self.0.store(0, Ordering::Relaxed);
        }
        all
    }
}

/// Everything that passes between the tasks, except blocks.
pub struct Shared {
    /// Latest supply and temperature: to sampling, link and harmonics.
    pub supply: Watch<Guard, SupplyReading, 3>,
    /// Latest active set, once there was one: to sampling and link.
    pub active: Watch<Guard, Option<Active>, 2>,
    /// Whether the board has a key: storage to link.
    pub provisioned: AtomicBool,
    /// Whether it had one and cannot read it any more: storage to link.
    pub key_damaged: AtomicBool,
    /// Places of the log that are used, `u32::MAX` for a flash of something else: storage to link.
    pub log_used: AtomicU32,
    /// Identity of the firmware, once it is computed: storage to link.
    pub build: Mutex<Guard, Cell<Option<BuildId>>>,
    /// Base of the active set, once there was one: storage to pose and harmonics.
    pub base: Watch<Guard, Option<Base>, 2>,
    /// Jacks of the latest block that the link has sent: to pose.
    pub jacks: Signal<Guard, JackBlock>,
    /// Latest pose, or why there is none: to the link.
    pub pose: Signal<Guard, PoseReport>,
    /// Link to the sampling task.
    pub to_sampling: Channel<Guard, SamplingCommand, 1>,
    /// Link to storage.
    pub to_storage: Channel<Guard, StorageCommand, 1>,
    /// Link to harmonics.
    pub to_harmonics: Channel<Guard, HarmonicsCommand, 1>,
    /// Sampling task, storage and harmonics to link: one answer for each command.
    pub answers: Channel<Guard, Response, 1>,
    /// To the watchdog.
    pub alive: Alive,
}

impl Shared {
    /// Nothing is known yet, and no task waits.
    pub const fn new() -> Self {
        Self {
            supply: Watch::new(),
            active: Watch::new(),
            provisioned: AtomicBool::new(false),
            key_damaged: AtomicBool::new(false),
            log_used: AtomicU32::new(0),
            build: Mutex::new(Cell::new(None)),
            base: Watch::new(),
            jacks: Signal::new(),
            pose: Signal::new(),
            to_sampling: Channel::new(),
            to_storage: Channel::new(),
            to_harmonics: Channel::new(),
            answers: Channel::new(),
            alive: Alive(AtomicU8::new(0)),
        }
    }
}
