//! Words of flash that do not match their error correction code (RM0440, 3.3.4).
//!
//! One wrong bit is corrected and raises the flash interrupt; the board counts it, because the flash ages. More wrong bits
//! raise the non-maskable interrupt. A loss of power while a double word is programmed leaves such a *torn word*. In bank
//! 2 the archive reads what an interrupted write left: the word is garbage, the checksum of the record rejects it, and the
//! board goes on. In bank 1 the code itself is damaged, and the board stops. On a chip with a single bank the two are not
//! told apart, and the board goes on.
//!
//! The non-maskable interrupt is also that of a crystal that fails ([`crate::chip::clock`]).

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m_rt::exception;
use embassy_stm32::interrupt::typelevel::{FLASH, Handler};
use embassy_stm32::pac;
use embassy_time::Instant;
use hexsense_core::wire::status::EventCount;

use super::panic::{self, Text};
use super::{counters, resets};
use crate::chip::clock;

/// Torn words that were read, and the uptime at the last, ms in two halves. Only the non-maskable interrupt writes them.
static TORN: AtomicU32 = AtomicU32::new(0);
static TORN_MS: [AtomicU32; 2] = [const { AtomicU32::new(0) }; 2];

/// Lets corrections raise the flash interrupt.
pub fn watch() {
    pac::FLASH.eccr().modify(|eccr| eccr.set_eccie(true));
}

/// How many torn words were read.
pub fn torn_words() -> EventCount {
    loop {
        let count = TORN.load(Ordering::SeqCst);
        let [low, high] = [0, 1].map(|half| TORN_MS[half].load(Ordering::SeqCst));
        // If the interrupt came in between, count and time may not belong together.
        if TORN.load(Ordering::SeqCst) == count {
            return EventCount {
                count,
                last_ms: u64::from(high) << 32 | u64::from(low),
            };
        }
    }
}

/// Counts corrections, in the flash interrupt.
pub struct Corrections;

impl Handler<FLASH> for Corrections {
    unsafe fn on_interrupt() {
        let eccr = pac::FLASH.eccr().read();
        if eccr.eccc() {
            counters::note(|events| &mut events.flash_corrections);
            // Written back as read, the flags clear themselves; the other one is for the non-maskable interrupt.
            let mut clear = eccr;
            clear.set_eccd(false);
            pac::FLASH.eccr().write_value(clear);
        }
    }
}

#[exception]
unsafe fn NonMaskableInt() {
    if clock::crystal_failed() {
        resets::without_crystal();
    }
    let eccr = pac::FLASH.eccr().read();
    if !eccr.eccd() {
        panic::stop(Text::new("non-maskable interrupt, not from the flash"));
    }
    if !eccr.bk_ecc() && pac::FLASH.optr().read().dbank() {
        panic::stop(Text::new("the code is damaged at 0x").hexadecimal(eccr.addr_ecc()));
    }
    let uptime_ms = Instant::now().as_millis();
    let halves = [uptime_ms as u32, (uptime_ms >> 32) as u32];
    for (kept, half) in TORN_MS.iter().zip(halves) {
        kept.store(half, Ordering::SeqCst);
    }
    let count = TORN.load(Ordering::SeqCst);
    TORN.store(count.saturating_add(1), Ordering::SeqCst);
    let mut clear = eccr;
    clear.set_eccc(false);
    pac::FLASH.eccr().write_value(clear);
}
