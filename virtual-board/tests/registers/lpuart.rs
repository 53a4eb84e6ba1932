//! RM0440 chapter 38. Kernel and core clock 150 MHz, 2 Mbit/s: BRR = 256 · 150e6 / 2e6 = 19200, a bit is 75 cycles.

use virtual_board::injection::{Effect, Towards};
use virtual_board::peripherals::NEVER;
use virtual_board::peripherals::lpuart::Lpuart;

const CR1: u32 = 0x00;
const CR3: u32 = 0x08;
const BRR: u32 = 0x0C;
const RQR: u32 = 0x18;
const ISR: u32 = 0x1C;
const ICR: u32 = 0x20;
const RDR: u32 = 0x24;
const TDR: u32 = 0x28;

const ON: u32 = 1 | 1 << 2 | 1 << 3;
const FIFO: u32 = 1 << 29;
const ORE: u32 = 1 << 3;
const IDLE: u32 = 1 << 4;
const RXNE: u32 = 1 << 5;
const TC: u32 = 1 << 6;
const TXE: u32 = 1 << 7;
/// Start bit, eight data bits, stop bit.
const CHARACTER: u64 = 10 * 75;

fn port(cr1: u32) -> Lpuart {
    let mut port = Lpuart::new();
    port.set_clock(150_000_000, 150_000_000);
    port.write(BRR, 19_200, 0).unwrap();
    port.write(CR1, cr1, 0).unwrap();
    port
}

fn run(port: &mut Lpuart, until: u64) {
    while port.next_event() <= until {
        port.advance(port.next_event());
    }
}

#[test]
fn after_reset_the_transmitter_is_empty() {
    assert_eq!(Lpuart::new().read(ISR), Ok(TXE | TC));
}

#[test]
fn characters_leave_at_the_baud_rate_and_tc_follows_the_last() {
    let mut port = port(ON);
    port.write(TDR, 0x41, 1000).unwrap();
    assert_eq!(
        port.read(ISR).unwrap() & (TXE | TC),
        TXE,
        "the shift register has taken it"
    );
    port.write(TDR, 0x42, 1000).unwrap();
    assert_eq!(port.read(ISR).unwrap() & TXE, 0);
    assert_eq!(port.next_event(), 1000 + CHARACTER);
    run(&mut port, 1000 + CHARACTER);
    assert_eq!(port.take_sent(), [0x41]);
    assert_eq!(port.read(ISR).unwrap() & (TXE | TC), TXE);
    run(&mut port, 1000 + 2 * CHARACTER);
    assert_eq!(port.take_sent(), [0x42]);
    assert_eq!(port.read(ISR).unwrap() & TC, TC);
    assert_eq!(
        port.silent_at(),
        Some(1000 + 4 * CHARACTER),
        "silence is two character times"
    );
}

#[test]
fn reception_takes_a_character_time_each() {
    let mut port = port(ON);
    port.line_in(&[1, 2], 500);
    assert_eq!(port.next_event(), 500 + CHARACTER);
    run(&mut port, 500 + CHARACTER);
    assert_eq!(port.read(ISR).unwrap() & RXNE, RXNE);
    assert_eq!(port.read(RDR), Ok(1));
    assert_eq!(port.read(ISR).unwrap() & RXNE, 0);
    run(&mut port, 500 + 2 * CHARACTER);
    assert_eq!(port.read(RDR), Ok(2));
}

#[test]
fn idle_comes_one_character_time_after_the_last() {
    let mut port = port(ON | 1 << 4);
    port.line_in(&[1, 2], 0);
    run(&mut port, 3 * CHARACTER - 1);
    assert_eq!(port.read(ISR).unwrap() & IDLE, 0);
    assert_eq!(
        port.read(RDR),
        Ok(1),
        "without FIFO the second was lost to overrun"
    );
    run(&mut port, 3 * CHARACTER);
    assert_eq!(port.read(ISR).unwrap() & IDLE, IDLE);
    assert!(port.interrupt());
    port.write(ICR, IDLE | ORE, 0).unwrap();
    assert!(!port.interrupt());
    run(&mut port, 100 * CHARACTER);
    assert_eq!(
        port.read(ISR).unwrap() & IDLE,
        0,
        "IDLE comes once after a reception"
    );
}

#[test]
fn overrun_loses_the_new_character_and_says_so() {
    let mut port = port(ON | 1 << 5);
    port.line_in(&[1, 2], 0);
    run(&mut port, 2 * CHARACTER);
    assert_eq!(port.read(ISR).unwrap() & ORE, ORE);
    assert!(port.interrupt());
    assert_eq!(port.read(RDR), Ok(1));
    port.write(ICR, ORE, 0).unwrap();
    assert_eq!(port.read(ISR).unwrap() & (ORE | RXNE), 0);
}

#[test]
fn the_fifos_hold_eight() {
    let mut port = port(ON | FIFO);
    let bytes: Vec<u8> = (1..=10).collect();
    port.line_in(&bytes, 0);
    run(&mut port, 8 * CHARACTER);
    assert_eq!(
        port.read(ISR).unwrap() & (1 << 24 | ORE),
        1 << 24,
        "RXFF, no overrun yet"
    );
    run(&mut port, 10 * CHARACTER);
    assert_eq!(port.read(ISR).unwrap() & ORE, ORE);
    let received: Vec<u32> = (0..8).map(|_| port.read(RDR).unwrap()).collect();
    assert_eq!(received, [1, 2, 3, 4, 5, 6, 7, 8]);
    for byte in 0..9 {
        assert_eq!(port.read(ISR).unwrap() & TXE, TXE, "room for {byte}");
        port.write(TDR, byte, 0).unwrap();
    }
    assert_eq!(
        port.read(ISR).unwrap() & TXE,
        0,
        "one in the shift register, eight in the FIFO"
    );
    port.write(RQR, 1 << 4, 0).unwrap();
    assert_eq!(
        port.read(ISR).unwrap() & (1 << 23),
        1 << 23,
        "TXFRQ empties it"
    );
}

#[test]
fn dma_requests_follow_the_fifos() {
    let mut port = port(ON);
    assert!(!port.tx_request() && !port.rx_request());
    port.write(CR3, 1 << 6 | 1 << 7, 0).unwrap();
    assert!(port.tx_request());
    port.write(TDR, 1, 0).unwrap();
    port.write(TDR, 2, 0).unwrap();
    assert!(!port.tx_request());
    port.line_in(&[9], 0);
    run(&mut port, CHARACTER);
    assert!(port.rx_request());
    port.read(RDR).unwrap();
    assert!(!port.rx_request());
}

#[test]
fn a_receiver_that_is_off_loses_what_passes() {
    let mut port = port(0);
    port.line_in(&[1, 2, 3], 0);
    run(&mut port, 2 * CHARACTER);
    port.write(CR1, ON, 2 * CHARACTER).unwrap();
    run(&mut port, 3 * CHARACTER);
    assert_eq!(port.read(RDR), Ok(3));
}

#[test]
fn switching_off_empties_everything() {
    let mut port = port(ON | FIFO);
    port.write(TDR, 1, 0).unwrap();
    port.write(TDR, 2, 0).unwrap();
    port.write(CR1, 0, 10).unwrap();
    assert_eq!(port.next_event(), NEVER);
    assert_eq!(port.read(ISR), Ok(TXE | TC));
}

#[test]
fn noise_and_a_missing_stop_bit_are_flagged_beside_the_character() {
    for (effect, flag) in [(Effect::Framing, 1 << 1), (Effect::Noise, 1 << 2)] {
        let mut port = port(ON);
        port.write(CR3, 1, 0).unwrap(); // EIE
        port.disturb(Towards::Board, effect, 1);
        port.line_in(&[0x41, 0x42], 0);
        run(&mut port, CHARACTER);
        assert_eq!(port.read(ISR).unwrap() & (flag | RXNE), flag | RXNE);
        assert!(port.interrupt());
        assert_eq!(port.read(RDR).unwrap(), 0x49, "one bit is wrong");
        port.write(ICR, flag, CHARACTER).unwrap();
        assert_eq!(port.read(ISR).unwrap() & flag, 0);
        assert!(!port.interrupt());
        run(&mut port, 2 * CHARACTER);
        assert_eq!(port.read(RDR).unwrap(), 0x42);
    }
}

#[test]
fn characters_are_lost_or_damaged_without_a_sign_in_both_directions() {
    let mut port = port(ON);
    port.disturb(Towards::Board, Effect::Lost, 1);
    port.line_in(&[0x41, 0x42], 0);
    run(&mut port, 2 * CHARACTER);
    assert_eq!(port.read(RDR).unwrap(), 0x42);
    port.disturb(Towards::Host, Effect::Damaged, 1);
    port.disturb(Towards::Host, Effect::Lost, 1);
    for character in [1, 2, 3] {
        let now = 10_000 * u64::from(character);
        port.write(TDR, character, now).unwrap();
        run(&mut port, now + CHARACTER);
    }
    assert_eq!(port.take_sent(), [1 ^ 8, 3]);
}
