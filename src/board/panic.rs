//! Keeps a panic's message across the reset that follows it, so that the host can be told.
//!
//! The message lies in `.uninit`, RAM that the start-up code leaves alone; a magic word and its complement say
//! that it is there. After a power cut the RAM holds noise, which that pair tells from a message. A hard fault
//! ends here too, see [`super::stack`].

use core::fmt::{self, Write};
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use core::ptr::addr_of_mut;

use cortex_m_rt::exception;

/// Longest message that is kept, bytes; the rest is cut off.
pub const MAX_MESSAGE: usize = 128;
const MAGIC: u32 = 0x5041_4E21;

/// A panic's message, cut to [`MAX_MESSAGE`] bytes of UTF-8.
pub type Message = heapless::String<MAX_MESSAGE>;

#[repr(C)]
struct Record {
    magic: u32,
    complement: u32,
    length: u32,
    text: [u8; MAX_MESSAGE],
}

#[unsafe(link_section = ".uninit.panic")]
static mut RECORD: MaybeUninit<Record> = MaybeUninit::uninit();

/// Takes the message of the panic that caused the last reset, if one did.
pub fn take() -> Option<Message> {
    let record = addr_of_mut!(RECORD).cast::<Record>();
    // SAFETY: called once, before any task runs, and a panic never returns: nobody else has a reference. Every bit
    // pattern is a valid `Record`; it is read volatile, because the compiler knows of no write to it.
    let kept = unsafe {
        let kept = record.read_volatile();
        addr_of_mut!((*record).magic).write_volatile(0);
        kept
    };
    if kept.magic != MAGIC || kept.complement != !MAGIC {
        return None;
    }
    let text = kept.text.get(..kept.length as usize)?;
    let mut message = Message::new();
    for chunk in text.utf8_chunks() {
        message.push_str(chunk.valid()).ok()?;
    }
    Some(message)
}

/// Writes text until the room is used up, whole characters only.
struct Truncating<'a>(&'a mut Message);

impl Write for Truncating<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.chars()
            .try_for_each(|character| self.0.push(character))
            .map_err(|_| fmt::Error)
    }
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    let mut message = Message::new();
    let mut out = Truncating(&mut message);
    // A message that does not fit is cut: the error says no more than that.
    let _ = match info.location() {
        Some(at) => write!(out, "{}:{}: {}", at.file(), at.line(), info.message()),
        None => write!(out, "{}", info.message()),
    };
    let mut text = [0; MAX_MESSAGE];
    text[..message.len()].copy_from_slice(message.as_bytes());
    let record = Record {
        magic: MAGIC,
        complement: !MAGIC,
        length: message.len() as u32,
        text,
    };
    // SAFETY: interrupts are off and this function does not return, so nothing else touches the record.
    unsafe { addr_of_mut!(RECORD).cast::<Record>().write_volatile(record) };
    defmt::error!("panic: {}", message.as_str());
    cortex_m::peripheral::SCB::sys_reset()
}

#[exception]
unsafe fn DefaultHandler(vector: i16) -> ! {
    panic!("interrupt {vector} has no handler")
}
