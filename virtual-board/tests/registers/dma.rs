//! RM0440 chapters 12 and 13.

use virtual_board::peripherals::dma::{Dma, Transfer};
use virtual_board::peripherals::dmamux::Dmamux;

const ISR: u32 = 0x00;
const IFCR: u32 = 0x04;
const CCR3: u32 = 0x08 + 20 * 2;
const CNDTR3: u32 = CCR3 + 4;
const CPAR3: u32 = CCR3 + 8;
const CMAR3: u32 = CCR3 + 12;
/// Channel 3 has index 2; its flags begin at bit 8.
const CHANNEL: usize = 2;
const FLAGS: u32 = 8;

/// Half-words from a register into a ring of `count`.
fn ring(count: u32, extra: u32) -> Dma {
    let mut dma = Dma::default();
    dma.write(CNDTR3, count).unwrap();
    dma.write(CPAR3, 0x5000_0040).unwrap();
    dma.write(CMAR3, 0x2000_0100).unwrap();
    dma.write(CCR3, 1 << 10 | 1 << 8 | 1 << 7 | extra).unwrap();
    assert!(!dma.ready(CHANNEL));
    dma.write(CCR3, 1 << 10 | 1 << 8 | 1 << 7 | extra | 1)
        .unwrap();
    dma
}

#[test]
fn memory_address_steps_and_the_register_stays() {
    let mut dma = ring(4, 0);
    let transfer = |dma: &Dma| dma.transfer(CHANNEL);
    assert_eq!(
        transfer(&dma),
        Transfer {
            from: 0x5000_0040,
            from_size: 2,
            to: 0x2000_0100,
            to_size: 2
        }
    );
    dma.moved(CHANNEL);
    assert_eq!(transfer(&dma).to, 0x2000_0102);
    assert_eq!(dma.read(CNDTR3), Ok(3));
}

#[test]
fn direction_memory_to_peripheral_swaps_the_ends() {
    let mut dma = Dma::default();
    dma.write(CNDTR3, 1).unwrap();
    dma.write(CPAR3, 0x4000_8028).unwrap();
    dma.write(CMAR3, 0x2000_0000).unwrap();
    dma.write(CCR3, 1 << 7 | 1 << 4 | 1).unwrap();
    assert_eq!(
        dma.transfer(CHANNEL),
        Transfer {
            from: 0x2000_0000,
            from_size: 1,
            to: 0x4000_8028,
            to_size: 1
        }
    );
}

#[test]
fn half_and_complete_are_flagged_and_a_normal_channel_stops() {
    let mut dma = ring(4, 1 << 1 | 1 << 2);
    dma.moved(CHANNEL);
    assert_eq!(dma.read(ISR), Ok(0));
    dma.moved(CHANNEL);
    assert_eq!(dma.read(ISR), Ok((4 | 1) << FLAGS), "HTIF and GIF");
    assert!(dma.interrupt(CHANNEL));
    dma.write(IFCR, 4 << FLAGS).unwrap();
    assert_eq!(dma.read(ISR), Ok(0));
    dma.moved(CHANNEL);
    dma.moved(CHANNEL);
    assert_eq!(dma.read(ISR), Ok((2 | 1) << FLAGS), "TCIF and GIF");
    assert!(!dma.ready(CHANNEL));
    assert_eq!(dma.read(CNDTR3), Ok(0));
    assert!(
        dma.write(IFCR, 1 << FLAGS).is_err(),
        "an event that comes meanwhile can be lost"
    );
    assert_eq!(dma.read(ISR), Ok(0), "clearing the global flag clears all");
}

#[test]
fn a_circular_channel_reloads_count_and_addresses() {
    let mut dma = ring(3, 1 << 5);
    for _ in 0..3 {
        dma.moved(CHANNEL);
    }
    assert!(dma.ready(CHANNEL));
    assert_eq!(dma.read(CNDTR3), Ok(3));
    assert_eq!(dma.transfer(CHANNEL).to, 0x2000_0100);
}

#[test]
fn interrupts_need_their_enable_bits() {
    let mut dma = ring(2, 1 << 1);
    dma.moved(CHANNEL);
    assert!(!dma.interrupt(CHANNEL), "half transfer is not enabled");
    dma.moved(CHANNEL);
    assert!(dma.interrupt(CHANNEL));
}

#[test]
fn a_running_channel_keeps_count_and_addresses() {
    let mut dma = ring(4, 0);
    assert!(dma.write(CNDTR3, 9).is_err());
    assert!(dma.write(CMAR3, 0).is_err());
    assert_eq!(
        (dma.read(CNDTR3), dma.read(CMAR3)),
        (Ok(4), Ok(0x2000_0100))
    );
}

#[test]
fn a_bus_error_flags_and_switches_the_channel_off() {
    let mut dma = ring(4, 1 << 3);
    dma.failed(CHANNEL);
    assert_eq!(dma.read(ISR), Ok((8 | 1) << FLAGS));
    assert!(dma.interrupt(CHANNEL));
    assert!(!dma.ready(CHANNEL));
}

#[test]
fn the_multiplexer_keeps_a_request_per_channel() {
    let mut dmamux = Dmamux::default();
    dmamux.write(0x04, 36).unwrap();
    dmamux.write(0x3C, 35).unwrap();
    assert_eq!(
        (dmamux.request(1), dmamux.request(15), dmamux.request(0)),
        (36, 35, 0)
    );
    assert!(
        dmamux.write(0x08, 5 | 1 << 16).is_err(),
        "synchronisation is not modelled"
    );
}
