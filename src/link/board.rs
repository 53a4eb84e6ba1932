//! The board behind the server of the link: where its answers come from on this chip.

use core::cell::Cell;
use core::sync::atomic::Ordering;

use embassy_sync::watch::Receiver;
use embassy_time::Instant;
use hexsense::FACTS;
use hexsense_core::facts::BoardFacts;
use hexsense_core::live_pose::JackBlock;
use hexsense_core::sample_path::Path;
use hexsense_core::sampling::SupplyReading;
use hexsense_core::server::{Board, Command, Health};
use hexsense_core::wire::Identity;
use hexsense_core::wire::hello::Greeting;
use hexsense_core::wire::status::{EventCount, Events};

use crate::chip::clock::Source;
use crate::chip::identity::Origin;
use crate::health::{counters, flash_errors, stack};
use crate::sampling::path;
use crate::shared::{Active, Guard, Shared};

/// The board, as the link knows it.
pub struct LinkBoard {
    origin: Origin,
    shared: &'static Shared,
    supply: Receiver<'static, Guard, SupplyReading, 3>,
    active: Receiver<'static, Guard, Option<Active>, 2>,
}

impl LinkBoard {
    /// Takes the link's receivers. There is one of each for the link, which starts once.
    pub fn new(origin: Origin, shared: &'static Shared) -> Self {
        Self {
            origin,
            shared,
            supply: shared.supply.receiver().expect("a receiver is left"),
            active: shared.active.receiver().expect("a receiver is left"),
        }
    }
}

impl Board for LinkBoard {
    fn facts(&self) -> &'static BoardFacts {
        &FACTS
    }

    fn greeting(&self) -> Greeting {
        self.origin.greeting()
    }

    fn identity(&self) -> Identity {
        self.origin.identity(self.shared.build.lock(Cell::get))
    }

    fn has_crystal(&self) -> bool {
        self.origin.clock == Source::Crystal
    }

    fn calibrated_at_c(&mut self) -> Option<f32> {
        let active = self.active.try_get().flatten();
        active.map(|active| active.temperature_c)
    }

    fn health(&mut self) -> Health {
        // Not with the rest of the struct behind `..`: the compiler copies that field by field.
        let mut events = counters::all();
        events.torn_words = flash_errors::torn_words();
        Health {
            uptime_ms: Instant::now().as_millis(),
            events,
            supply: self.supply.try_get().unwrap_or(SupplyReading::NONE),
            provisioned: self.shared.provisioned.load(Ordering::Relaxed),
            key_damaged: self.shared.key_damaged.load(Ordering::Relaxed),
            resets: self.origin.resets,
            stack: stack::usage(),
            panic: self.origin.panic.clone(),
            option_bytes: self.origin.options,
            log_used: match self.shared.log_used.load(Ordering::Relaxed) {
                u32::MAX => None,
                used => Some(used),
            },
        }
    }

    fn path<R>(&mut self, work: impl FnOnce(&mut Path) -> R) -> R {
        path::with(work)
    }

    fn order(&mut self, command: Command) -> bool {
        match command {
            Command::Sampling(command) => self.shared.to_sampling.try_send(command).is_ok(),
            Command::Storage(command) => self.shared.to_storage.try_send(command).is_ok(),
            Command::Harmonics(command) => self.shared.to_harmonics.try_send(command).is_ok(),
        }
    }

    fn find_pose(&mut self, jacks: JackBlock) {
        self.shared.jacks.signal(jacks);
    }

    fn count(&mut self, pick: fn(&mut Events) -> &mut EventCount) {
        counters::note(pick);
    }
}
