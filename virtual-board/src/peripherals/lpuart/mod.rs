//! LPUART1 (RM0440 chapter 38): receiver and transmitter with FIFOs, idle detection, overrun, DMA requests.
//!
//! ```text
//! bit time = LPUART_BRR · prescaler / (256 · f_ck)          (38.4.7)
//! ```
//!
//! A character on the line takes its full time. [`Lpuart::take_sent`] collects sent characters; [`Lpuart::line_in`]
//! takes characters that then arrive at line rate. The far end has the same rate. While the receiver is off, characters
//! pass at the last rate, or [`DEFAULT_BAUD`], and are lost. Modem lines, parity, wake-up, mute and half-duplex mode
//! are not modelled.

mod registers;

use std::collections::VecDeque;

use crate::injection::{Effect, Towards};

use super::{Cycles, NEVER, bit, field};

/// Rate at which characters pass a receiver that has not been set up, bit/s.
pub const DEFAULT_BAUD: u64 = 115_200;

const FIFO_DEPTH: usize = 8;

// CR1
const UE: u32 = 0;
const RE: u32 = 2;
const TE: u32 = 3;
const FIFOEN: u32 = 29;
// CR3
const OVRDIS: u32 = 12;
// ISR
const FE: u32 = 1 << 1;
const NE: u32 = 1 << 2;
const ORE: u32 = 1 << 3;
const IDLE: u32 = 1 << 4;
const TC: u32 = 1 << 6;

/// The port.
#[derive(Debug)]
pub struct Lpuart {
    kernel_hz: u64,
    core_hz: u64,
    cr1: u32,
    cr2: u32,
    cr3: u32,
    brr: u32,
    presc: u32,
    /// FE, NE, ORE, IDLE and TC; the other status bits follow from the FIFOs.
    latched: u32,
    rx: VecDeque<u8>,
    tx: VecDeque<u8>,
    last_received: u8,
    /// The character in the transmit shift register, and when it is out.
    shifting: Option<(u8, Cycles)>,
    /// Characters that wait at the far end.
    line: VecDeque<u8>,
    /// When the character that is arriving is complete.
    arriving: Option<Cycles>,
    /// When the line counts as idle if nothing arrives.
    idle_at: Cycles,
    sent: Vec<u8>,
    sent_at: Cycles,
    /// Effects on the next characters towards the board, and towards the host.
    disturbed: [VecDeque<Effect>; 2],
}

impl Lpuart {
    /// The port after reset.
    pub fn new() -> Self {
        Self {
            kernel_hz: 0,
            core_hz: 1,
            cr1: 0,
            cr2: 0,
            cr3: 0,
            brr: 0,
            presc: 0,
            latched: TC,
            rx: VecDeque::with_capacity(FIFO_DEPTH),
            tx: VecDeque::with_capacity(FIFO_DEPTH),
            last_received: 0,
            shifting: None,
            line: VecDeque::new(),
            arriving: None,
            idle_at: NEVER,
            sent: Vec::new(),
            sent_at: 0,
            disturbed: Default::default(),
        }
    }

    /// Back to the state after reset. The line goes on, except that a character under way is cut off.
    pub fn reset(&mut self) {
        let fresh = Self::new();
        let line = std::mem::take(&mut self.line);
        let sent = std::mem::take(&mut self.sent);
        let disturbed = std::mem::take(&mut self.disturbed);
        *self = Self {
            kernel_hz: self.kernel_hz,
            core_hz: self.core_hz,
            line,
            arriving: self.arriving,
            sent,
            sent_at: self.sent_at,
            disturbed,
            ..fresh
        };
    }

    /// Sets kernel clock and core clock, Hz.
    pub fn set_clock(&mut self, kernel_hz: u32, core_hz: u32) {
        self.kernel_hz = u64::from(kernel_hz);
        self.core_hz = u64::from(core_hz);
    }

    /// Puts characters on the line towards the receiver.
    pub fn line_in(&mut self, bytes: &[u8], now: Cycles) {
        self.line.extend(bytes);
        self.begin_arrival(now);
    }

    /// Characters on the line that have not arrived yet.
    pub fn line_backlog(&self) -> usize {
        self.line.len()
    }

    /// Disturbs the next characters on the line.
    pub fn disturb(&mut self, towards: Towards, effect: Effect, characters: u32) {
        self.disturbed[towards as usize].extend((0..characters).map(|_| effect));
    }

    /// Collects the characters that were sent since the last call.
    pub fn take_sent(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.sent)
    }

    /// Number of characters for [`Self::take_sent`].
    pub fn sent_len(&self) -> usize {
        self.sent.len()
    }

    /// The instant at which the transmitter will have been silent for two character times after its last character;
    /// `None` while it sends.
    pub fn silent_at(&self) -> Option<Cycles> {
        self.shifting
            .is_none()
            .then(|| self.sent_at + 2 * self.character_cycles())
    }

    /// When [`Self::advance`] must be called next.
    pub fn next_event(&self) -> Cycles {
        let shifted = self.shifting.map_or(NEVER, |(_, at)| at);
        shifted
            .min(self.arriving.unwrap_or(NEVER))
            .min(self.idle_at)
    }

    /// Carries out the events at `now`, the time of the earliest one.
    pub fn advance(&mut self, now: Cycles) {
        if let Some((character, at)) = self.shifting
            && at <= now
        {
            let disturbed = self.disturbed[Towards::Host as usize].pop_front();
            let arrived = disturbed.map_or(Some(character), |effect| spoil(character, effect));
            self.sent.extend(arrived);
            self.sent_at = at;
            self.shifting = None;
            self.begin_shift(at);
            if self.shifting.is_none() {
                self.latched |= TC;
            }
        }
        if let Some(at) = self.arriving
            && at <= now
        {
            self.arriving = None;
            self.arrive(at);
            self.begin_arrival(at);
        }
        if self.idle_at <= now {
            self.idle_at = NEVER;
            self.latched |= IDLE;
        }
    }

    fn depth(&self) -> usize {
        if bit(self.cr1, FIFOEN) { FIFO_DEPTH } else { 1 }
    }

    fn transmitting(&self) -> bool {
        bit(self.cr1, UE) && bit(self.cr1, TE)
    }

    fn receiving(&self) -> bool {
        bit(self.cr1, UE) && bit(self.cr1, RE)
    }

    /// Start bit, data (and parity) bits, stop bits, in cycles of the core.
    fn character_cycles(&self) -> Cycles {
        let data = match (bit(self.cr1, 28), bit(self.cr1, 12)) {
            (true, _) => 7,
            (false, true) => 9,
            (false, false) => 8,
        };
        let stop = if field(self.cr2, 12, 2) == 2 { 2 } else { 1 };
        let bits = 1 + data + stop;
        if self.kernel_hz == 0 || self.brr < 0x300 {
            return bits * self.core_hz / DEFAULT_BAUD;
        }
        const PRESCALERS: [u64; 16] = [
            1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256, 256, 256, 256, 256,
        ];
        let divisor = 256 * self.kernel_hz / PRESCALERS[self.presc as usize];
        (bits * u64::from(self.brr) * self.core_hz + divisor / 2) / divisor
    }

    fn transmit(&mut self, character: u8, now: Cycles) {
        // A write to a full register or FIFO is lost.
        if self.tx.len() < self.depth() {
            self.tx.push_back(character);
        }
        self.latched &= !TC;
        self.begin_shift(now);
    }

    fn begin_shift(&mut self, now: Cycles) {
        if self.shifting.is_none()
            && self.transmitting()
            && let Some(character) = self.tx.pop_front()
        {
            self.shifting = Some((character, now + self.character_cycles()));
        }
    }

    fn begin_arrival(&mut self, now: Cycles) {
        if self.arriving.is_none() && !self.line.is_empty() {
            self.arriving = Some(now + self.character_cycles());
            self.idle_at = NEVER;
        }
    }

    fn arrive(&mut self, now: Cycles) {
        let Some(character) = self.line.pop_front() else {
            return;
        };
        let effect = self.disturbed[Towards::Board as usize].pop_front();
        let arrived = effect.map_or(Some(character), |effect| spoil(character, effect));
        let Some(character) = arrived.filter(|_| self.receiving()) else {
            return;
        };
        self.latched |= match effect {
            Some(Effect::Noise) => NE,
            Some(Effect::Framing) => FE,
            _ => 0,
        };
        if self.rx.len() < self.depth() {
            self.rx.push_back(character);
        } else if bit(self.cr3, OVRDIS) {
            self.rx.pop_back();
            self.rx.push_back(character);
        } else {
            self.latched |= ORE;
        }
        self.idle_at = now + self.character_cycles();
    }

    fn receive(&mut self) -> u32 {
        if let Some(character) = self.rx.pop_front() {
            self.last_received = character;
        }
        u32::from(self.last_received)
    }
}

impl Default for Lpuart {
    fn default() -> Self {
        Self::new()
    }
}

/// A character after a disturbance; `None` if it is lost.
fn spoil(character: u8, effect: Effect) -> Option<u8> {
    (effect != Effect::Lost).then_some(character ^ 1 << 3)
}
