//! Blocks of host memory that the emulated core and the peripheral models share.

use std::alloc::{Layout, alloc_zeroed, dealloc, handle_alloc_error};
use std::ptr::NonNull;

const HOST_PAGE: usize = 4096;

/// A block of zeroed host memory, aligned to a page, whose address never changes.
///
/// The emulator shares it and writes to it while the core runs; so this program reaches it only through copies, never
/// through references.
#[derive(Debug)]
pub struct Block {
    start: NonNull<u8>,
    layout: Layout,
}

impl Block {
    /// A block of `size` bytes, a multiple of the page size.
    ///
    /// # Panics
    /// If `size` is zero or not a multiple of 4096: sizes are constants of the chip.
    pub fn new(size: usize) -> Self {
        assert!(
            size > 0 && size.is_multiple_of(HOST_PAGE),
            "memory of {size} bytes"
        );
        let layout = Layout::from_size_align(size, HOST_PAGE).expect("a constant size");
        // SAFETY: the layout's size is not zero.
        let start = unsafe { alloc_zeroed(layout) };
        let start = NonNull::new(start).unwrap_or_else(|| handle_alloc_error(layout));
        Self { start, layout }
    }

    /// Size in bytes.
    pub fn size(&self) -> usize {
        self.layout.size()
    }

    /// Address of the byte at `offset`, for mapping into the emulator.
    ///
    /// # Panics
    /// If `offset` is outside of the block.
    pub fn address(&self, offset: usize) -> *mut u8 {
        assert!(offset < self.size());
        // SAFETY: the offset is inside of the allocation.
        unsafe { self.start.as_ptr().add(offset) }
    }

    fn holds(&self, offset: usize, length: usize) -> bool {
        offset
            .checked_add(length)
            .is_some_and(|end| end <= self.size())
    }

    /// Copies bytes out of the block; false (and nothing copied) if they are not all inside of it.
    #[must_use]
    pub fn read(&self, offset: usize, into: &mut [u8]) -> bool {
        let inside = self.holds(offset, into.len());
        if inside {
            // SAFETY: the range is inside of the allocation, and `into` is memory of its own: no reference to the
            // block's bytes exists.
            unsafe {
                self.start
                    .as_ptr()
                    .add(offset)
                    .copy_to_nonoverlapping(into.as_mut_ptr(), into.len())
            };
        }
        inside
    }

    /// Copies bytes into the block; false (and nothing copied) if they do not all fit.
    #[must_use]
    pub fn write(&mut self, offset: usize, bytes: &[u8]) -> bool {
        let inside = self.holds(offset, bytes.len());
        if inside {
            // SAFETY: as in `read`.
            unsafe {
                self.start
                    .as_ptr()
                    .add(offset)
                    .copy_from_nonoverlapping(bytes.as_ptr(), bytes.len())
            };
        }
        inside
    }

    /// A little-endian word, if it is inside of the block.
    pub fn word(&self, offset: usize) -> Option<u32> {
        let mut bytes = [0; 4];
        self.read(offset, &mut bytes)
            .then(|| u32::from_le_bytes(bytes))
    }
}

impl Drop for Block {
    fn drop(&mut self) {
        // SAFETY: allocated in `new` with this very layout.
        unsafe { dealloc(self.start.as_ptr(), self.layout) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_refuses_what_is_not_inside_of_it() {
        let mut block = Block::new(4096);
        assert!(block.write(4092, &[1, 2, 3, 4]));
        assert_eq!(block.word(4092), Some(0x0403_0201));
        assert!(!block.write(4093, &[0; 4]));
        assert_eq!(block.word(4093), None);
        assert_eq!(block.word(usize::MAX), None);
    }
}
