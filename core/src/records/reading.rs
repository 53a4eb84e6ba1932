//! Reading of flash without waiting.
//!
//! Flash lies in memory: a read of it is complete when it returns, although the trait that programs and erases it is
//! asynchronous. Code that only reads is then plain code, which takes half of the room of code that might wait.

use core::pin::pin;
use core::task::{Context, Poll, Waker};

use embedded_storage_async::nor_flash::ReadNorFlash;

/// The bytes at `offset`; `None` when the flash fails or would have to be waited for.
pub fn read<const N: usize>(flash: &mut impl ReadNorFlash, offset: u32) -> Option<[u8; N]> {
    let mut bytes = [0; N];
    fill(flash, offset, &mut bytes).then_some(bytes)
}

/// Reads into `bytes`; whether that succeeded. It is one function for all lengths, which saves flash.
#[inline(never)]
fn fill(flash: &mut impl ReadNorFlash, offset: u32, bytes: &mut [u8]) -> bool {
    let poll = pin!(flash.read(offset, bytes)).poll(&mut Context::from_waker(Waker::noop()));
    matches!(poll, Poll::Ready(Ok(())))
}
