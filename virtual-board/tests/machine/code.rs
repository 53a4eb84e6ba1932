//! A few instructions of the Thumb encoding (ARMv7-M A7), enough for the programs of these tests.

use super::RESULTS;

/// A program under construction. Registers are given by number, 0 to 7.
#[derive(Clone, Default)]
pub struct Code {
    halves: Vec<u16>,
}

impl Code {
    /// An empty program.
    pub fn new() -> Self {
        Self::default()
    }

    /// The program's half-words.
    pub fn halves(&self) -> Vec<u16> {
        self.halves.clone()
    }

    /// The program's bytes.
    pub fn bytes(&self) -> Vec<u8> {
        self.halves
            .iter()
            .flat_map(|half| half.to_le_bytes())
            .collect()
    }

    /// Half-words as they are.
    pub fn raw(mut self, halves: &[u16]) -> Self {
        self.halves.extend(halves);
        self
    }

    /// `register = value` (MOVW, MOVT).
    pub fn load(self, register: u16, value: u32) -> Self {
        let halves = |opcode: u16, immediate: u16| {
            [
                opcode | (immediate >> 11 & 1) << 10 | immediate >> 12,
                (immediate >> 8 & 7) << 12 | register << 8 | immediate & 0xFF,
            ]
        };
        self.raw(&halves(0xF240, value as u16))
            .raw(&halves(0xF2C0, (value >> 16) as u16))
    }

    /// `*address = value`, by way of r6 and r7.
    pub fn store(self, address: u32, value: u32) -> Self {
        self.load(6, address).load(7, value).raw(&[0x6037])
    }

    /// `result[index] = register`, by way of r6.
    pub fn save(self, index: u32, register: u16) -> Self {
        self.load(6, RESULTS + 4 * index).raw(&[0x6030 | register])
    }

    /// `register = *address`, by way of r6.
    pub fn fetch(self, register: u16, address: u32) -> Self {
        self.load(6, address).raw(&[0x6830 | register])
    }

    /// `result[0] = 16 · result[0] + digit`: a trace of the order of events. Uses r4 to r6.
    pub fn trace(self, digit: u16) -> Self {
        // lsls r4, r4, #4; adds r4, #digit
        self.fetch(4, RESULTS)
            .raw(&[0x0124, 0x3400 | digit])
            .save(0, 4)
    }

    /// Enables interrupt `number` at `priority`.
    pub fn enable(self, number: u32, priority: u32) -> Self {
        let shift = 8 * (number % 4);
        let word = 0xE000_E400 + (number & !3);
        self.fetch(5, word)
            .load(7, priority << shift)
            .raw(&[0x433D]) // orrs r5, r7
            .load(6, word)
            .raw(&[0x6035]) // str r5, [r6]
            .store(0xE000_E100 + 4 * (number / 32), 1 << (number % 32))
    }

    /// Makes interrupt `number` pending (STIR), and waits for the effect (ISB).
    pub fn pend(self, number: u32) -> Self {
        self.store(0xE000_EF00, number).raw(&[0xF3BF, 0x8F6F])
    }

    /// Stays here for ever.
    pub fn spin(self) -> Self {
        self.raw(&[0xE7FE])
    }

    /// Returns from an exception (or a function).
    pub fn ret(self) -> Self {
        self.raw(&[0x4770])
    }

    /// Pushes r4 to r7 and lr, runs `body`, and returns with a pop.
    pub fn function(body: impl FnOnce(Self) -> Self) -> Self {
        body(Self::new().raw(&[0xB5F0])).raw(&[0xBDF0])
    }
}
