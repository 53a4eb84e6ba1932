//! What the server needs of the board behind it: the trait that the firmware implements, and the commands that take time.
//!
//! A question is answered at once from what the board gives. A command goes to the task that can carry it out; the answer
//! follows when it comes.

use crate::facts::BoardFacts;
use crate::live_pose::JackBlock;
use crate::sample_path::Path;
use crate::sampling::{BlockSize, SupplyReading};
use crate::storage::StorageCommand;
use crate::wire::hello::Greeting;
use crate::wire::status::{EventCount, Events, OptionBytes, Resets, StackUse};
use crate::wire::{FrameError, Identity};

/// Message of a panic before the start.
pub type PanicMessage = heapless::String<128>;

/// The board behind the server.
pub trait Board {
    /// The numbers of this kind of board.
    fn facts(&self) -> &'static BoardFacts;

    /// What the board says of itself before anything else.
    fn greeting(&self) -> Greeting;

    /// Who the board is.
    fn identity(&self) -> Identity;

    /// Whether the crystal drives the clock.
    fn has_crystal(&self) -> bool;

    /// Temperature of the die during the calibration of the active set, °C; `None` without a set.
    fn calibrated_at_c(&mut self) -> Option<f32>;

    /// What the parts of the board that are no sample path say of themselves.
    fn health(&mut self) -> Health;

    /// Lets `work` read and change the sample path between two blocks. No block is taken meanwhile, so `work` is short.
    fn path<R>(&mut self, work: impl FnOnce(&mut Path) -> R) -> R;

    /// Gives a command to the task that carries it out; `false` when that task still has another one.
    fn order(&mut self, command: Command) -> bool;

    /// Takes the jacks of a block whose pose the host wants.
    fn find_pose(&mut self, jacks: JackBlock);

    /// Counts one more of the events that `pick` chooses.
    fn count(&mut self, pick: fn(&mut Events) -> &mut EventCount);
}

/// A request that takes time, for the task that carries it out.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// For the sampling task.
    Sampling(SamplingCommand),
    /// For the storage task.
    Storage(StorageCommand),
    /// For the harmonics task.
    Harmonics(HarmonicsCommand),
}

/// What the sampling task carries out. Each is answered once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SamplingCommand {
    /// Scan at this rate, Hz, one of [`BoardFacts::rates_hz`].
    Rate(u32),
    /// Take so many scans at a time.
    Block(BlockSize),
}

/// What the harmonics task solves. Each is answered once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HarmonicsCommand {
    /// Harmonics of one channel, 0 to 14, of one analyser.
    Channel {
        /// Index of the analyser, 0 to 2.
        analyser: u8,
        /// Index of the channel in a scan, 0 to 14.
        channel: u8,
    },
    /// The motion at the drive frequency of one analyser.
    Motion {
        /// Index of the analyser, 0 to 2.
        analyser: u8,
    },
}

/// What the board says of itself besides its sample path.
#[derive(Debug, Clone, PartialEq)]
pub struct Health {
    /// Time since start, ms.
    pub uptime_ms: u64,
    /// What went wrong; blocks that the link had no room for are counted by the sample path.
    pub events: Events,
    /// The latest supply and temperature.
    pub supply: SupplyReading,
    /// Whether the board has a key.
    pub provisioned: bool,
    /// Whether it had one and cannot read it any more.
    pub key_damaged: bool,
    /// Why the board started, and how often.
    pub resets: Resets,
    /// How much of the stack is used.
    pub stack: StackUse,
    /// Message of a panic before the start.
    pub panic: Option<PanicMessage>,
    /// Option bytes of the chip.
    pub option_bytes: OptionBytes,
    /// Places of the log's volume that are used; `None` for a flash of something else.
    pub log_used: Option<u32>,
}

/// Length of a frame. Everything that is sent fits one, so an error here is a mistake of the build; the host asks again.
pub(super) fn sendable(
    board: &mut impl Board,
    encoded: Result<usize, FrameError>,
) -> Option<usize> {
    encoded
        .inspect_err(|_| board.count(|events| &mut events.frames_unsent))
        .ok()
}
