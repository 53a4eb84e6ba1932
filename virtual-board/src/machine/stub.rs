//! The model's own instructions, in a page that the chip does not have.

use crate::memory::block::Block;

/// A page of the code area that does not exist on the chip. It holds the model's own instructions.
pub(super) const STUB_BASE: u32 = 0x1E00_0000;
/// `clrex; ldr.w pc, [pc, #0]; .word target`: clears the exclusive monitor, then jumps. The emulator offers no other
/// way to clear it, and an exception must.
const CLEAR_MONITOR: [u8; 8] = [0xBF, 0xF3, 0x2F, 0x8F, 0xDF, 0xF8, 0x00, 0xF0];
const STUB_TARGET: usize = CLEAR_MONITOR.len();
const STUB_SIZE: usize = 2 * 4096;
/// An endless loop, beside the stub, for a core that hangs. It is 127 instructions long, because every round is one
/// basic block, and the cost of a block does not depend on its length.
const LOOP: usize = 4096;
const NOPS: usize = 126;
const NOP: [u8; 2] = [0x00, 0xBF];
/// A branch back over all of them.
const BRANCH_BACK: [u8; 2] = [0x80, 0xE7];
/// Address of that loop.
pub(super) const LOOP_AT: u32 = STUB_BASE + LOOP as u32;
/// End of the stub page, which is never reached: the emulator needs an address at which to stop.
pub(super) const NOWHERE: u32 = STUB_BASE + STUB_SIZE as u32 - 2;

/// The page of these instructions.
pub(super) struct Stub(Block);

impl Stub {
    pub(super) fn new() -> Self {
        let mut block = Block::new(STUB_SIZE);
        assert!(block.write(0, &CLEAR_MONITOR), "it fits");
        let mut endless = NOP.repeat(NOPS);
        endless.extend(BRANCH_BACK);
        assert!(block.write(LOOP, &endless), "it fits");
        Self(block)
    }

    pub(super) fn block(&self) -> &Block {
        &self.0
    }

    /// Sets the address to which the stub jumps.
    pub(super) fn set_target(&mut self, address: u32) {
        let thumb_address = address | 1;
        assert!(
            self.0.write(STUB_TARGET, &thumb_address.to_le_bytes()),
            "it fits"
        );
    }
}
