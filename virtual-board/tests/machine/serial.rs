//! The whole way from a converter and to the serial port, by DMA: trigger, rank, ring, interrupt, line.

use virtual_board::injection::timeline::Timeline;

use super::Chip;
use super::code::Code;

const RCC: u32 = 0x4002_1000;
const LPUART1: u32 = 0x4000_8000;
const ADC1: u32 = 0x5000_0000;
const TIM6: u32 = 0x4000_1000;
const DMA1: u32 = 0x4002_0000;
const DMAMUX: u32 = 0x4002_0800;

fn uart_on() -> Code {
    // 16 MHz and BRR = 256 · 16e6 / 1e6: 1 Mbit/s, a character takes 160 cycles, 10 µs.
    Code::new()
        .store(RCC + 0x5C, 1)
        .store(LPUART1 + 0x0C, 4096)
        .store(LPUART1, 1 | 1 << 2 | 1 << 3)
}

#[test]
fn a_run_ends_when_the_transmitter_falls_silent() {
    let main = uart_on()
        .store(LPUART1 + 0x28, 0x55)
        .store(LPUART1 + 0x28, 0xAA)
        .spin();
    let mut chip = Chip::new(main, &[]);
    chip.machine.run_until_silent(1.0, 4096).unwrap();
    let ended_s = chip.machine.bus().now_s();
    assert_eq!(chip.machine.bus_mut().lpuart.take_sent(), [0x55, 0xAA]);
    // Two characters and two of silence, a few µs of code before.
    assert!((40e-6..50e-6).contains(&ended_s), "{ended_s}");
    chip.machine.run_until_silent(2.0, 4096).unwrap();
    assert!(
        (chip.machine.bus().now_s() - 2.0).abs() < 1e-4,
        "with nothing sent it runs its time"
    );
}

#[test]
fn a_run_ends_when_enough_waits() {
    // Sends for ever: str r7, [r6]; b back.
    let main = uart_on()
        .load(6, LPUART1 + 0x28)
        .load(7, 1)
        .raw(&[0x6037, 0xE7FD]);
    let mut chip = Chip::new(main, &[]);
    chip.machine.run_until_silent(1.0, 100).unwrap();
    assert_eq!(chip.machine.bus_mut().lpuart.take_sent().len(), 100);
}

/// Four characters by DMA between a register of the port and `result[0]`: enable bit of the port, request, mode.
fn with_dma(main: Code, enable: u32, request: u32, register: u32, mode: u32) -> Code {
    main.store(RCC + 0x48, 0b101 | 1 << 8) // DMA1, DMAMUX, flash
        .store(LPUART1 + 0x08, 1 << enable)
        .store(DMAMUX, request)
        .store(DMA1 + 0x0C, 4)
        .store(DMA1 + 0x10, LPUART1 + register)
        .store(DMA1 + 0x14, 0x2000_0100)
        .store(DMA1 + 0x08, 1 << 7 | mode | 1)
        .spin()
}

#[test]
fn dma_carries_what_arrives_into_a_ring() {
    let main = with_dma(uart_on(), 6, 34, 0x24, 1 << 5);
    let mut chip = Chip::new(main, &[]);
    chip.run(1e-3).unwrap();
    chip.machine.bus_mut().line_in(&[1, 2, 3, 4, 5]);
    chip.run(45e-6).unwrap();
    assert_eq!(chip.result(0), 0x0403_0201);
    chip.run(10e-6).unwrap();
    assert_eq!(chip.result(0), 0x0403_0205, "the ring began again");
}

#[test]
fn a_stall_of_the_transmitters_dma_delays_what_it_sends() {
    let main = uart_on().store(0x2000_0100, 0x0403_0201);
    let main = with_dma(main, 7, 35, 0x28, 1 << 4);
    let mut chip = Chip::new(main, &[]);
    let fault = r#"{"at_s":0,"fault":"dma_stall","of":"transmitter","duration_us":2000}"#;
    chip.machine.inject(Timeline::parse(fault).unwrap());
    chip.run(1.9e-3).unwrap();
    assert!(chip.machine.bus_mut().lpuart.take_sent().is_empty());
    chip.run(0.2e-3).unwrap();
    assert_eq!(chip.machine.bus_mut().lpuart.take_sent(), [1, 2, 3, 4]);
}

/// A timer that triggers a converter of two ranks a thousand times a second; the handler counts scans in `result[0]`.
fn scanning() -> (Code, Code) {
    let main = Code::new()
        .store(0x2000_0100, 0)
        .store(RCC + 0x48, 0b101 | 1 << 8)
        .store(RCC + 0x4C, 1 << 13)
        .store(RCC + 0x58, 1 << 4)
        .store(RCC + 0x88, 2 << 28)
        .store(DMAMUX, 5)
        .store(DMA1 + 0x0C, 2)
        .store(DMA1 + 0x10, ADC1 + 0x40)
        .store(DMA1 + 0x14, 0x2000_0200)
        .store(DMA1 + 0x08, 1 << 10 | 1 << 8 | 1 << 7 | 1 << 5 | 1 << 1 | 1)
        .enable(11, 0x40)
        .store(ADC1 + 0x08, 1 << 28)
        .store(ADC1 + 0x08, 1 << 28 | 1)
        // Wait for ADRDY: ldr r0, [r1]; lsls r0, r0, #31; beq back.
        .load(1, ADC1)
        .raw(&[0x6808, 0x07C0, 0xD0FC])
        .store(ADC1 + 0x30, 1 | 1 << 6 | 2 << 12) // channels 1 and 2
        .store(ADC1 + 0x10, 1 | 3 << 2)
        .store(ADC1 + 0x0C, 13 << 5 | 1 << 10 | 0b11)
        .store(ADC1 + 0x08, 1 << 28 | 1 << 2)
        .store(TIM6 + 0x2C, 15_999)
        .store(TIM6 + 0x04, 2 << 4)
        .store(TIM6, 1)
        .raw(&[0xBF20, 0xE7FD]);
    let handler = Code::new()
        .store(DMA1 + 0x04, 1)
        .fetch(0, 0x2000_0100)
        .raw(&[0x3001])
        .save(0, 0)
        .ret();
    (main, handler)
}

#[test]
fn a_timer_triggers_a_converter_whose_dma_interrupts() {
    let (main, handler) = scanning();
    let mut chip = Chip::new(main, &[(16 + 11, handler)]);
    chip.run(100.5e-3).unwrap();
    let scans = chip.result(0);
    assert!((98..=102).contains(&scans), "{scans} scans in 100 ms");
    // Both pins are at half the supply: 16 · 2048.
    let counts = chip.word(0x2000_0200);
    for count in [counts & 0xFFFF, counts >> 16] {
        assert!(count.abs_diff(16 * 2048) < 60, "{count}");
    }
}

/// The converter of the test above, whose program counts blocks in `result[0]`; its overrun flag.
fn scans_and_overrun(fault: &str) -> (u32, bool) {
    let (main, handler) = scanning();
    let mut chip = Chip::new(main, &[(16 + 11, handler)]);
    chip.machine.inject(Timeline::parse(fault).unwrap());
    chip.run(100.5e-3).unwrap();
    let scans = chip.result(0);
    let overrun = chip.machine.bus_mut().read(ADC1, 4) >> 4 & 1 == 1;
    (scans, overrun)
}

#[test]
fn a_stall_of_the_converters_dma_overruns_them_for_good() {
    let (scans, overrun) = scans_and_overrun(
        r#"{"at_s":0.05,"fault":"dma_stall","of":"converters","duration_us":2500}"#,
    );
    assert!(overrun && (45..=52).contains(&scans), "{scans}");
}

#[test]
fn triggers_that_are_missed_cost_their_scans_and_no_more() {
    let (scans, overrun) =
        scans_and_overrun(r#"{"at_s":0.05,"fault":"trigger_stall","duration_us":20000}"#);
    assert!(!overrun && (77..=82).contains(&scans), "{scans}");
}
