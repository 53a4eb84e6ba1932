//! The serial link: bytes in, frames out. What is said is decided at the [`desk`](super::desk).
//!
//! One task owns the port. It waits for whatever comes first: bytes from the host, a block from the sample path, an
//! answer from a task that was given a command, or a pose. Frames go out one after another; while one is on the line the
//! receiver's ring takes what comes in. Nothing here can hold up the sample path, which drops a block when the queue
//! is full and counts it.

use embassy_futures::select::{Either4, select4};
use embassy_stm32::mode::Async;
use embassy_stm32::usart::{Config, Error, Uart, UartTx};
use embassy_time::with_timeout;
use hexsense::wire::frame::Deframer;
use hexsense::wire::{BAUD, MAX_FRAME};
use static_cell::ConstStaticCell;

use super::desk::{Desk, MAX_REQUEST_FRAME};
use super::exchange::Exchange;
use super::identity::Origin;
use super::path;
use super::pins::{self, Irqs};
use super::tallies;
use super::timing::{LINK_HEARTBEAT, RECEIVE_RING};

/// Talks to the host for ever.
#[embassy_executor::task]
pub async fn talk(parts: pins::Serial, origin: Origin, exchange: &'static Exchange) -> ! {
    static RING: ConstStaticCell<[u8; RECEIVE_RING]> = ConstStaticCell::new([0; RECEIVE_RING]);
    let mut config = Config::default();
    config.baudrate = BAUD;
    let port = Uart::new(
        parts.uart,
        parts.rx,
        parts.tx,
        parts.tx_dma,
        parts.rx_dma,
        Irqs,
        config,
    );
    // The bit rate is a constant that the clock can make.
    let (tx, rx) = port.expect("the port's settings are constants").split();
    let mut rx = rx.into_ring_buffered(RING.take());
    let mut sender = Sender {
        tx,
        frame: [0; MAX_FRAME],
    };
    let mut desk = Desk::new(origin, exchange);
    let mut deframer = Deframer::<MAX_REQUEST_FRAME>::default();
    let mut input = [0; 64];
    loop {
        exchange.alive.link.signal(());
        let next = select4(
            rx.read(&mut input),
            path::block_waits(),
            exchange.answers.receive(),
            exchange.pose.wait(),
        );
        let Ok(next) = with_timeout(LINK_HEARTBEAT, next).await else {
            continue;
        };
        match next {
            Either4::First(Ok(length)) => {
                for byte in &input[..length] {
                    if let Some(closed) = deframer.push(*byte) {
                        let length = desk.take_in(closed, &mut sender.frame);
                        sender.send(length).await;
                    }
                }
            }
            Either4::First(Err(error)) => {
                defmt::debug!("receiver: {}", error);
                tallies::note(match error {
                    Error::Overrun => |events| &mut events.receiver_overruns,
                    _ => |events| &mut events.receiver_errors,
                });
                rx.start_uart();
            }
            Either4::Second(()) => {
                let length = desk.pass_on(&mut sender.frame);
                sender.send(length).await;
            }
            Either4::Third(answer) => {
                let length = desk.hand_out(&answer, &mut sender.frame);
                sender.send(length).await;
            }
            Either4::Fourth(report) => {
                let length = desk.pass_on_pose(&report, &mut sender.frame);
                sender.send(length).await;
            }
        }
    }
}

/// The transmitter and the frame it sends.
struct Sender {
    tx: UartTx<'static, Async>,
    frame: [u8; MAX_FRAME],
}

impl Sender {
    /// Sends the first `length` bytes of the frame, if there are any.
    async fn send(&mut self, length: Option<usize>) {
        let Some(bytes) = length.and_then(|length| self.frame.get(..length)) else {
            return;
        };
        if let Err(error) = self.tx.write(bytes).await {
            defmt::warn!("transmitter: {}", error);
            tallies::note(|events| &mut events.frames_unsent);
        }
    }
}
