//! The number of instructions of a basic block, whether it sends an event, and whether it may change a mask.
//!
//! The emulator reports a block by address and size in bytes. Thumb instructions are two or four bytes long, so each
//! block is decoded once and remembered. The decoder also looks for SEV, which the emulator treats as no operation. A
//! SEV that a condition skips counts too; the core then wakes once without an event, as the architecture allows. CPS and
//! MSR, which end their block, are the instructions that change the masks.

/// The facts about a block that the processor model needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockInfo {
    /// Number of instructions.
    pub instructions: u32,
    /// Whether one of them is SEV.
    pub sends_event: bool,
    /// Whether one of them is CPS or MSR.
    pub changes_masks: bool,
}

const KNOWN: u32 = 1 << 31;
const EVENT: u32 = 1 << 30;
const MASKS: u32 = 1 << 29;
const COUNT_SHIFT: u32 = 14;
const FIELD: u32 = (1 << COUNT_SHIFT) - 1;

/// Decoded blocks of one memory, indexed by the half-word at which they begin.
#[derive(Debug)]
pub struct BlockTable {
    base: u32,
    entries: Vec<u32>,
}

impl BlockTable {
    /// An empty table for the memory of `size` bytes at `base`.
    pub fn new(base: u32, size: usize) -> Self {
        Self {
            base,
            entries: vec![0; size / 2],
        }
    }

    /// The block at `address`, `size` bytes long, if it has been decoded.
    #[inline]
    pub fn get(&self, address: u32, size: u32) -> Option<BlockInfo> {
        let entry = *self
            .entries
            .get((address.wrapping_sub(self.base) / 2) as usize)?;
        (entry & (KNOWN | FIELD) == KNOWN | size).then_some(BlockInfo {
            instructions: (entry >> COUNT_SHIFT) & FIELD,
            sends_event: entry & EVENT != 0,
            changes_masks: entry & MASKS != 0,
        })
    }

    /// Remembers a block.
    pub fn insert(&mut self, address: u32, size: u32, info: BlockInfo) {
        if let Some(entry) = self
            .entries
            .get_mut((address.wrapping_sub(self.base) / 2) as usize)
        {
            *entry = KNOWN
                | u32::from(info.sends_event) << 30
                | u32::from(info.changes_masks) << 29
                | info.instructions << COUNT_SHIFT
                | (size & FIELD);
        }
    }

    /// Forgets all blocks: the code has changed.
    pub fn clear(&mut self) {
        self.entries.fill(0);
    }
}

/// Decodes the bytes of a block.
pub fn decode(code: &[u8]) -> BlockInfo {
    const SEV: u16 = 0xBF40;
    const SEV_WIDE: [u16; 2] = [0xF3AF, 0x8004];
    let mut info = BlockInfo {
        instructions: 0,
        sends_event: false,
        changes_masks: false,
    };
    let mut halves = code
        .chunks_exact(2)
        .map(|half| u16::from_le_bytes([half[0], half[1]]));
    while let Some(first) = halves.next() {
        info.instructions += 1;
        info.sends_event |= first == SEV;
        // CPSIE and CPSID; the second half of MSR is 0b1000 and the mask, then the number of the register.
        info.changes_masks |= first & 0xFFE8 == 0xB660;
        // 0b11101, 0b11110 and 0b11111 begin a 32-bit instruction (ARMv7-M A5.1).
        if first >> 11 >= 0b11101 {
            let second = halves.next();
            info.sends_event |= second == Some(SEV_WIDE[1]) && first == SEV_WIDE[0];
            info.changes_masks |=
                first & 0xFFF0 == 0xF380 && second.is_some_and(|second| second >> 12 == 0b1000);
        }
    }
    info
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_narrow_and_wide_instructions() {
        // movs r0, #1; ldr.w r0, [r1]; bx lr
        let code = [0x01, 0x20, 0xD1, 0xF8, 0x00, 0x00, 0x70, 0x47];
        assert_eq!(
            decode(&code),
            BlockInfo {
                instructions: 3,
                sends_event: false,
                changes_masks: false,
            }
        );
    }

    #[test]
    fn finds_sev_but_not_in_the_second_half_of_another_instruction() {
        assert!(decode(&[0x40, 0xBF]).sends_event);
        assert!(decode(&[0xAF, 0xF3, 0x04, 0x80]).sends_event);
        // movw r0, #imm whose second half-word happens to be that of a SEV
        assert!(!decode(&[0x40, 0xF2, 0x40, 0xBF]).sends_event);
    }

    #[test]
    fn finds_cps_and_msr_but_not_mrs() {
        // cpsid i; cpsie i; msr primask, r4; msr basepri_max, r0
        for code in [
            &[0x72, 0xB6][..],
            &[0x62, 0xB6],
            &[0x84, 0xF3, 0x10, 0x88],
            &[0x80, 0xF3, 0x12, 0x88],
        ] {
            assert!(decode(code).changes_masks, "{code:x?}");
        }
        // mrs r4, primask
        assert!(!decode(&[0xEF, 0xF3, 0x10, 0x84]).changes_masks);
    }

    #[test]
    fn a_block_of_another_length_is_not_the_one_remembered() {
        let mut table = BlockTable::new(0x0800_0000, 1024);
        let info = BlockInfo {
            instructions: 5,
            sends_event: true,
            changes_masks: true,
        };
        table.insert(0x0800_0010, 12, info);
        assert_eq!(table.get(0x0800_0010, 12), Some(info));
        assert_eq!(table.get(0x0800_0010, 10), None);
        assert_eq!(table.get(0x2000_0000, 12), None);
    }
}
