//! What passes between the tasks: everything they share, and nothing else is shared.
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
//! What the sample path shares is in [`super::path`]. A *latest* value has one writer and overwrites itself; a command is
//! answered exactly once.

use core::sync::atomic::AtomicBool;

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use embassy_sync::watch::Watch;
use hexsense_core::storage;
use hexsense_core::live_pose::JackBlock;
use hexsense_core::sampling::Calibrator;
use hexsense_core::records::SetId;
use hexsense_core::wire::{PoseReport, Response};

use super::{harmonics, pose, sampling, supply};

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

/// Signs of life; the watchdog is fed when all three have come.
pub struct Alive {
    /// Blocks come.
    pub sampling: Signal<Guard, ()>,
    /// The link took its turn.
    pub link: Signal<Guard, ()>,
    /// The storage took its turn.
    pub storage: Signal<Guard, ()>,
}

/// Everything that passes between the tasks but blocks.
pub struct Exchange {
    /// Latest supply and temperature: to sampling, link and harmonics.
    pub supply: Watch<Guard, supply::Reading, 3>,
    /// Latest active set, once there was one: to sampling and link.
    pub active: Watch<Guard, Option<Active>, 2>,
    /// Whether the board has a key: storage to link.
    pub provisioned: AtomicBool,
    /// Base of the active set, once there was one: storage to pose and harmonics.
    pub base: Watch<Guard, Option<pose::Base>, 2>,
    /// Jacks of the latest block that the link has sent: to pose.
    pub jacks: Signal<Guard, JackBlock>,
    /// Latest pose, or why there is none: to the link.
    pub pose: Signal<Guard, PoseReport>,
    /// Link to the sampling task.
    pub to_sampling: Channel<Guard, sampling::Command, 1>,
    /// Link to storage.
    pub to_storage: Channel<Guard, storage::Command, 1>,
    /// Link to harmonics.
    pub to_harmonics: Channel<Guard, harmonics::Command, 1>,
    /// Sampling task, storage and harmonics to link: one answer for each command.
    pub answers: Channel<Guard, Response, 1>,
    /// To the supervisor.
    pub alive: Alive,
}

impl Exchange {
    /// Nothing known yet, nobody waiting.
    pub const fn new() -> Self {
        Self {
            supply: Watch::new(),
            active: Watch::new(),
            provisioned: AtomicBool::new(false),
            base: Watch::new(),
            jacks: Signal::new(),
            pose: Signal::new(),
            to_sampling: Channel::new(),
            to_storage: Channel::new(),
            to_harmonics: Channel::new(),
            answers: Channel::new(),
            alive: Alive {
                sampling: Signal::new(),
                link: Signal::new(),
                storage: Signal::new(),
            },
        }
    }
}
