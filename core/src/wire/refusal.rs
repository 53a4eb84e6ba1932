//! The refusals of requests: the problem, the limit, and the remedy.

use serde::{Deserialize, Serialize};

use crate::harmonics::DriveError;
use crate::records::RecordError;

/// Why a request was refused. Each message names a remedy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum Refusal {
    /// The request does not decode.
    #[error(
        "the board could not read the request; host and firmware are of different builds: update one of them"
    )]
    Malformed,
    /// Not a rate the board offers.
    #[error("the board cannot scan at {hz} Hz; choose 1000, 2000 or 4000")]
    Rate {
        /// As asked.
        hz: u32,
    },
    /// The link cannot carry this much.
    #[error(
        "the link cannot carry {bits_per_s} bit/s of telemetry (limit {limit}); ask for less content or a lower rate"
    )]
    LinkCapacity {
        /// Capacity that the stream needs.
        bits_per_s: u32,
        /// Capacity of the line.
        limit: u32,
    },
    /// The board runs on its internal oscillator.
    #[error(
        "the board runs without its crystal, about 1 % off in time; fit or connect the 24 MHz crystal to calibrate"
    )]
    NoCrystal,
    /// The drive is out of range.
    #[error("{0}")]
    Drive(DriveError),
    /// The block of the drive is not the board's present block.
    #[error(
        "the drive is made for blocks of {drive} scans, and the board takes {board} at a time; set the block first"
    )]
    OtherBlock {
        /// Scans of the drive's blocks.
        drive: u8,
        /// Scans of the board's blocks.
        board: u8,
    },
    /// No such analyser.
    #[error("there is no analyser {analyser}; analysers are 0 to 2")]
    Analyser {
        /// As asked.
        analyser: u8,
    },
    /// No such channel.
    #[error("there is no channel {channel}; channels are 0 to 14")]
    Channel {
        /// As asked.
        channel: u8,
    },
    /// There is no active set.
    #[error("the board has no coefficients; calibrate and upload a set first")]
    NoSet,
    /// A read beyond the end of the set.
    #[error("offset {offset} is beyond the end of the set ({length} bytes)")]
    Offset {
        /// As asked.
        offset: u16,
        /// Length of the set.
        length: u16,
    },
    /// A chunk or commit without a begin.
    #[error("no upload is under way; begin again")]
    NoUpload,
    /// No set has the announced length.
    #[error(
        "a set of {length} bytes is not possible (1 to {limit}); the coefficient file is not one"
    )]
    Length {
        /// As announced.
        length: u16,
        /// Longest set.
        limit: u16,
    },
    /// A chunk at the wrong place.
    #[error("the upload expected offset {expected}; begin again")]
    OutOfOrder {
        /// Where the next chunk must start.
        expected: u16,
    },
    /// The set that arrived is not the one announced.
    #[error("the set that arrived is not the one announced; begin again")]
    WrongIdentity,
    /// The set that arrived is not usable.
    #[error("the set is not usable: {0}")]
    Record(RecordError),
    /// The set was made for another board.
    #[error("the set was made for another board; calibrate this one")]
    OtherBoard,
    /// The flash failed; set and key are the old ones.
    #[error(
        "the board's flash failed; its set and its key are still the old ones; try again, and replace the board if it \
         happens twice"
    )]
    Flash,
    /// A change on a board that has no key.
    #[error("the board has no key and takes no changes; give it one with `hexsense provision`")]
    Unprovisioned,
    /// A tag without a challenge that it answers.
    #[error("no challenge is open: each serves for one change within ten seconds; ask for another")]
    NoChallenge,
    /// The tag does not match.
    #[error(
        "the key is not that of this board; nothing has changed. Use the key file it was provisioned with"
    )]
    WrongTag,
    /// A change too soon after a wrong tag.
    #[error(
        "after a wrong key the board takes no change for another {ms} ms; wait, then use the right key file"
    )]
    BackOff {
        /// Remaining wait, ms.
        ms: u32,
    },
    /// The upload took longer than allowed.
    #[error("the upload took longer than a minute, and its unlock has expired; begin again")]
    Expired,
    /// No kept set has this identity.
    #[error("the board keeps no set of this identity; see those it keeps with `hexsense history`")]
    NoSuchSet,
    /// A rollback to the set that is active, or an upload of it.
    #[error("this set is the active one already")]
    AlreadyActive,
    /// No place is left in the log.
    #[error(
        "the log of changes is full, and a change that could not be logged is not made; export the log and begin its next volume with `hexsense log --export FILE --new-volume`"
    )]
    LogFull,
    /// The change is made, but its entry is not in the log.
    #[error(
        "the change was made, but the flash did not take its log entry, which is tried again at the next start; replace the board if that fails too"
    )]
    Log,
    /// The sets are out of use and could not be erased.
    #[error(
        "no set is active any more, but the flash could not be erased, which is tried again at the next start; replace the board if that fails too"
    )]
    Erasure,
    /// The chip's generator of random numbers failed.
    #[error(
        "the chip's random numbers failed their test, so that no challenge can be made; try again, and replace the board if it happens twice"
    )]
    Random,
    /// An operation that needs time is under way.
    #[error("the board is busy with an earlier request; ask again")]
    Busy,
    /// The sums of an analyser are not complete.
    #[error(
        "the sums of analyser {analyser} are not complete; set a drive, and ask when the analyser is complete"
    )]
    Incomplete {
        /// As asked.
        analyser: u8,
    },
    /// The window does not determine offset, drift and five harmonics.
    #[error(
        "{blocks} blocks do not determine twelve unknowns at this frequency; sum over a whole period and more than twelve blocks"
    )]
    Undetermined {
        /// Blocks of the drive.
        blocks: u32,
    },
    /// An earlier change still waits for its entry in the log; this one was not made.
    #[error(
        "nothing was changed: the flash does not take the log entry of an earlier change; start the board anew, and replace it if that does not help"
    )]
    EarlierLog,
    /// The option bytes of the chip do not let the board write what it keeps.
    #[error(
        "nothing was changed: the chip's option bytes give its flash a single bank (DBANK = 0) or protect pages of bank 2 from writing (WRP2); `hexsense status` says which, and what to do"
    )]
    OptionBytes,
    /// The board had a key, and no copy of it is good.
    #[error(
        "the board had a key and can no longer read it, so it takes no change from anybody and measures on with the \
         coefficients that it has; to give it another key, erase flash bank 2 with a debug probe, which erases sets and \
         log too, then provision it and upload again"
    )]
    KeyDamaged,
    /// The new key is the one that is in force.
    #[error(
        "the board has this key already, and nothing has changed; make another for it with `hexsense provision`"
    )]
    SameKey,
    /// A new volume of a log that has got entries since the host read it.
    #[error(
        "the log has got another entry since it was read, so no new volume was begun; export the log again"
    )]
    LogMoved,
}
