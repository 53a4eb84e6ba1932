//! What the board remembers over resets: how often it started, why, and how long the last run was.
//!
//! The record lies in `.uninit`, RAM that the start-up code does not touch. Each part has a check. RAM that lost its power
//! holds noise, and the check does not fit. So a reset by the supply is a power-on when the record is gone, and a
//! brown-out when it is there. The length of a run is written whenever the watchdog is fed. A reset in the middle of that
//! write leaves the counts intact, because they are written at the start only.

use core::mem::MaybeUninit;
use core::ptr::addr_of_mut;

use embassy_stm32::pac;
use hexsense_core::wire::status::{ResetCause, Resets};

/// Begins every check, so that zeros are no record.
const MAGIC: u32 = 0x5245_5345;

/// Words in RAM that outlive a reset, with a check that is computed from them.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Sealed<const N: usize> {
    words: [u32; N],
    check: u32,
}

impl<const N: usize> Sealed<N> {
    /// Words with their check.
    pub fn new(words: [u32; N]) -> Self {
        let mix = |sum: u32, word: &u32| (sum.rotate_left(5) ^ word).wrapping_mul(0x9E37_79B1);
        let check = words.iter().fold(MAGIC, mix);
        Self { words, check }
    }

    /// The words, if the check fits.
    pub fn open(self) -> Option<[u32; N]> {
        (Self::new(self.words).check == self.check).then_some(self.words)
    }
}

struct Record {
    counts: Sealed<8>,
    uptime: Sealed<2>,
    /// [`MAGIC`] when the crystal has failed.
    without_crystal: u32,
}

#[unsafe(link_section = ".uninit.resets")]
static mut RECORD: MaybeUninit<Record> = MaybeUninit::uninit();

/// The right to write to the record.
pub struct Memory(());

impl Memory {
    /// Remembers how long this run has been, ms.
    pub fn keep_uptime(&mut self, uptime_ms: u64) {
        let halves = Sealed::new([uptime_ms as u32, (uptime_ms >> 32) as u32]);
        // SAFETY: there is one `Memory`, and only its owner writes here; volatile because only the next start reads it.
        unsafe { addr_of_mut!((*record()).uptime).write_volatile(halves) }
    }
}

fn record() -> *mut Record {
    addr_of_mut!(RECORD).cast()
}

/// Resets the board because its crystal has failed, which the next start reports.
pub fn without_crystal() -> ! {
    // SAFETY: only this word is written, volatile because only the next start reads it.
    unsafe { addr_of_mut!((*record()).without_crystal).write_volatile(MAGIC) };
    cortex_m::peripheral::SCB::sys_reset()
}

/// Why the board started, and what it remembers, with this start counted. To be called once.
pub fn take(panicked: bool) -> (ResetCause, Resets, Memory) {
    // SAFETY: called once, before any task runs, so there is no other reference. Every bit pattern is a valid `Record`; it
    // is read volatile, because the compiler knows of no write to it.
    let kept = unsafe { record().read_volatile() };
    let counts = kept.counts.open();
    let cause = match take_cause(counts.is_some(), panicked) {
        ResetCause::Software if kept.without_crystal == MAGIC => ResetCause::Crystal,
        cause => cause,
    };
    let mut resets = counts.map_or(Resets::default(), from_words);
    if counts.is_some() {
        resets.previous_uptime_ms = kept
            .uptime
            .open()
            .map(|[low, high]| u64::from(high) << 32 | u64::from(low));
    }
    resets.count(cause);
    // SAFETY: as above. A run that is reset before it says how long it was has no length.
    unsafe {
        addr_of_mut!((*record()).uptime.check).write_volatile(!kept.uptime.check);
        addr_of_mut!((*record()).counts).write_volatile(Sealed::new(to_words(&resets)));
        addr_of_mut!((*record()).without_crystal).write_volatile(0);
    }
    (cause, resets, Memory(()))
}

fn to_words(resets: &Resets) -> [u32; 8] {
    [
        resets.starts,
        resets.brown_outs,
        resets.pin,
        resets.software,
        resets.panics,
        resets.watchdog,
        resets.other,
        resets.crystal,
    ]
}

fn from_words(
    [
        starts,
        brown_outs,
        pin,
        software,
        panics,
        watchdog,
        other,
        crystal,
    ]: [u32; 8],
) -> Resets {
    Resets {
        starts,
        brown_outs,
        pin,
        software,
        panics,
        watchdog,
        other,
        previous_uptime_ms: None,
        crystal,
    }
}

/// Cause of the last reset. The flags add up until they are cleared, and any reset sets that of the pin.
fn take_cause(kept: bool, panicked: bool) -> ResetCause {
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|csr| csr.set_rmvf(true));
    if flags.iwdgrstf() {
        ResetCause::Watchdog
    } else if flags.sftrstf() {
        if panicked {
            ResetCause::Panic
        } else {
            ResetCause::Software
        }
    } else if flags.borrstf() {
        if kept {
            ResetCause::BrownOut
        } else {
            ResetCause::PowerOn
        }
    } else if flags.pinrstf() {
        ResetCause::Pin
    } else {
        ResetCause::Other
    }
}
