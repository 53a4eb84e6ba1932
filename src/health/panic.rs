//! Keeps the place of a panic across the reset that follows it, for the host.
//!
//! The text lies in `.uninit`, RAM that the start-up code does not touch; a magic word and its complement say that it is
//! there. After a power cut the RAM holds noise, and the pair does not fit. Faults and damaged code end here too, see
//! [`super::stack`] and [`super::flash_errors`].
//!
//! The text gives the addresses of the callers, innermost first. Files, lines and messages of all places that can panic
//! would take an eighth of the flash; the ELF has them by the addresses:
//!
//! ```text
//! addr2line -pifCe target/thumbv7em-none-eabihf/firmware/firmware ADDRESS…
//! ```
//!
//! The addresses are found through the frame pointer: every function of this target that calls another one keeps, at
//! `r7`, its caller's `r7` and its own return address.

use core::arch::asm;
use core::array;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use core::ptr::{addr_of, addr_of_mut};

use cortex_m_rt::exception;
use hexsense_core::server::board::PanicMessage as Message;

/// Bytes of a message that are kept; the rest is cut off.
const MAX_MESSAGE: usize = 128;
const MAGIC: u32 = 0x5041_4E21;

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
    // SAFETY: called once, before any task runs, and a panic never returns, so there is no other reference. Every bit
    // pattern is a valid `Record`; it is read volatile, because the compiler knows of no write to it.
    let (magic, complement, length) = unsafe {
        (
            addr_of!((*record).magic).read_volatile(),
            addr_of!((*record).complement).read_volatile(),
            addr_of!((*record).length).read_volatile(),
        )
    };
    // SAFETY: as above. Byte for byte in a loop: of the whole record the compiler makes a load and a store for each byte,
    // which take a kilobyte of flash.
    let text: [u8; MAX_MESSAGE] = array::from_fn(|at| unsafe {
        addr_of!((*record).text)
            .cast::<u8>()
            .add(at)
            .read_volatile()
    });
    // SAFETY: as above.
    unsafe { addr_of_mut!((*record).magic).write_volatile(0) };
    if magic != MAGIC || complement != !MAGIC {
        return None;
    }
    let text = text.get(..length as usize)?;
    let mut message = Message::new();
    for chunk in text.utf8_chunks() {
        message.push_str(chunk.valid()).ok()?;
    }
    Some(message)
}

/// Addresses in a message: as many as fit.
const MAX_CALLS: usize = 12;

// RAM that the stack lies in: its end below and its start above, from the linker.
unsafe extern "C" {
    static _stack_end: u32;
    static _stack_start: u32;
}

/// Text that is put together without the formatting machinery, which would take a tenth of the flash: cut off, at a
/// whole character, where the room ends.
pub struct Text(Message);

impl Text {
    /// Text that begins so.
    pub fn new(begin: &str) -> Self {
        Self(Message::new()).then(begin)
    }

    /// Goes on with more text.
    pub fn then(mut self, text: &str) -> Self {
        // The error means that the text is cut, which is intended.
        let _ = text
            .chars()
            .try_for_each(|character| self.0.push(character));
        self
    }

    fn decimal(self, number: u32) -> Self {
        let before = if number > 9 {
            self.decimal(number / 10)
        } else {
            self
        };
        before.digit(number % 10)
    }

    /// Goes on with a number, without leading zeros.
    pub fn hexadecimal(self, number: u32) -> Self {
        let before = if number > 0xF {
            self.hexadecimal(number >> 4)
        } else {
            self
        };
        before.digit(number & 0xF)
    }

    fn digit(self, digit: u32) -> Self {
        let mut buffer = [0; 4];
        let digit = char::from_digit(digit, 16).unwrap_or('?');
        self.then(digit.encode_utf8(&mut buffer))
    }
}

/// Keeps the message and resets.
pub fn stop(Text(message): Text) -> ! {
    cortex_m::interrupt::disable();
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

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    let mut text = Text::new("panic called from");
    for address in Calls::here().take(MAX_CALLS) {
        text = text.then(" ").hexadecimal(address);
    }
    stop(text)
}

/// Return addresses on the stack, innermost first.
struct Calls {
    frame: usize,
}

impl Calls {
    #[inline(always)]
    fn here() -> Self {
        let frame;
        // SAFETY: reads a register.
        unsafe { asm!("mov {}, r7", out(reg) frame, options(nomem, nostack, preserves_flags)) };
        Self { frame }
    }
}

impl Iterator for Calls {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        let (end, start) = (
            &raw const _stack_end as usize,
            &raw const _stack_start as usize,
        );
        let frame = self.frame;
        if !frame.is_multiple_of(4) || frame < end || frame > start - 8 {
            return None;
        }
        // SAFETY: two aligned words of the stack's RAM, which is always there to be read.
        let [outer, back] = unsafe { (frame as *const [usize; 2]).read_volatile() };
        // The stack grows down, so the frame of a caller lies higher.
        self.frame = if outer > frame { outer } else { 0 };
        Some(back as u32 & !1)
    }
}

#[exception]
unsafe fn DefaultHandler(vector: i16) -> ! {
    stop(Text::new("no handler for interrupt ").decimal(vector.unsigned_abs().into()))
}
