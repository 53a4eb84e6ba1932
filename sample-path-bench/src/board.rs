//! Start and end of the program.

use cortex_m_rt::entry;
use defmt_rtt as _;

use crate::{path, peers};

#[entry]
fn main() -> ! {
    path::run();
    peers::run();
    defmt::println!("finished");
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    defmt::println!("panic: {}", defmt::Display2Format(info));
    loop {
        cortex_m::asm::wfi();
    }
}
