//! The serial link: bytes in, frames out. The [`Server`] decides what is said; [`board`] is the board behind it.
//!
//! One task owns the port. It waits for the first of these: a block from the sample path, an answer from a task that was
//! given a command, a pose, or bytes from the host. Frames go out one after another; while one is on the line the
//! receiver's ring takes what comes in. A block goes before an answer, however many requests come: a host asks again, and
//! a scan is lost for good. Nothing here can hold up the sample path, which drops a block when the queue
//! is full and counts it. Nor can a line full of noise hold up the tasks in thread mode: the link takes bytes in pieces.

mod board;

use embassy_futures::select::{Either4, select4};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH4, DMA1_CH5, LPUART1};
use embassy_stm32::usart::{Config, Error, RingBufferedUartRx, Uart, UartTx};
use embassy_stm32::{bind_interrupts, dma, usart};
use embassy_time::{Instant, Timer, with_timeout};
use hexsense::FACTS;
use hexsense_core::server::{MAX_REQUEST_FRAME, Server};
use hexsense_core::wire::MAX_FRAME;
use hexsense_core::wire::frame::Deframer;
use static_cell::ConstStaticCell;

use self::board::LinkBoard;
use crate::chip::identity::Origin;
use crate::chip::pins;
use crate::chip::timing::{DEAF_AFTER_ERROR, GATHER, HEARTBEAT, LAST_CHARACTERS, RECEIVE_RING};
use crate::health::counters;
use crate::sampling::path;
use crate::shared::{Shared, Task};

bind_interrupts!(
    struct Irqs {
        DMA1_CHANNEL4 => dma::InterruptHandler<DMA1_CH4>;
        DMA1_CHANNEL5 => dma::InterruptHandler<DMA1_CH5>;
        LPUART1 => usart::InterruptHandler<LPUART1>;
    }
);

/// Talks to the host for ever.
#[embassy_executor::task]
pub async fn talk(mut parts: pins::Serial, origin: Origin, shared: &'static Shared) -> ! {
    static RING: ConstStaticCell<[u8; RECEIVE_RING]> = ConstStaticCell::new([0; RECEIVE_RING]);
    let ring = RING.take();
    let mut talk = Talk {
        server: Server::new(LinkBoard::new(origin, shared)),
        deframer: Deframer::default(),
        frame: [0; MAX_FRAME],
        shared,
    };
    loop {
        let mut config = Config::default();
        config.baudrate = FACTS.baud;
        let port = Uart::new(
            parts.uart.reborrow(),
            parts.rx.reborrow(),
            parts.tx.reborrow(),
            parts.tx_dma.reborrow(),
            parts.rx_dma.reborrow(),
            Irqs,
            config,
        );
        // The bit rate is a constant that the clock can make.
        let (mut tx, rx) = port.expect("the port's settings are constants").split();
        talk.until_error(&mut tx, &mut rx.into_ring_buffered(ring))
            .await;
        // The last characters may still be on the line. The driver's flush would wait for ever: its receiver clears the flag.
        Timer::after(LAST_CHARACTERS).await;
    }
}

/// The link without its port.
struct Talk {
    server: Server<LinkBoard>,
    deframer: Deframer<MAX_REQUEST_FRAME>,
    frame: [u8; MAX_FRAME],
    shared: &'static Shared,
}

impl Talk {
    /// Talks until the receiver has had an error, and for a while after that only sends. Then the port must be set up
    /// anew: a DMA channel that was stopped does not go on where it was (RM0440, 12.4.5), as the driver assumes.
    async fn until_error(&mut self, tx: &mut UartTx<'_, Async>, rx: &mut RingBufferedUartRx<'_>) {
        let (mut input, mut taken, mut filled) = ([0; 64], 0, 0);
        let (mut listens_at, mut failed) = (Instant::MIN, false);
        loop {
            self.shared.alive.sign(Task::Link);
            let receive = async {
                if taken < filled {
                    return Ok(filled);
                }
                if Instant::now() < listens_at {
                    Timer::at(listens_at).await;
                }
                if failed {
                    return Err(None);
                }
                rx.read(&mut input).await.map_err(Some)
            };
            let next = select4(
                path::block_waits(),
                self.shared.answers.receive(),
                self.shared.pose.wait(),
                receive,
            );
            let Ok(next) = with_timeout(HEARTBEAT, next).await else {
                continue;
            };
            let length = match next {
                Either4::First(()) => self.server.pass_on(&mut self.frame),
                Either4::Second(answer) => self.server.hand_out(&answer, &mut self.frame),
                Either4::Third(report) => self.server.pass_on_pose(&report, &mut self.frame),
                Either4::Fourth(Ok(length)) => {
                    let (used, answer) = self.take_in(input.get(taken..length).unwrap_or_default());
                    (taken, filled) = (taken + used, length);
                    if taken == filled {
                        if filled < input.len() {
                            listens_at = Instant::now() + GATHER;
                        }
                        (taken, filled) = (0, 0);
                    }
                    answer
                }
                Either4::Fourth(Err(Some(error))) => {
                    count(error);
                    failed = true;
                    listens_at = Instant::now() + DEAF_AFTER_ERROR;
                    continue;
                }
                Either4::Fourth(Err(None)) => return,
            };
            self.send(length, tx).await;
        }
    }

    /// Takes bytes up to the end of a frame: how many, and the length of the answer. What is left waits for the blocks
    /// that are due by then.
    fn take_in(&mut self, bytes: &[u8]) -> (usize, Option<usize>) {
        for (byte, used) in bytes.iter().zip(1..) {
            if let Some(closed) = self.deframer.push(*byte) {
                return (used, self.server.take_in(closed, &mut self.frame));
            }
        }
        (bytes.len(), None)
    }

    /// Sends the first `length` bytes of the frame, if there are any.
    async fn send(&mut self, length: Option<usize>, tx: &mut UartTx<'_, Async>) {
        let Some(bytes) = length.and_then(|length| self.frame.get(..length)) else {
            return;
        };
        if tx.write(bytes).await.is_err() {
            counters::note(|events| &mut events.frames_unsent);
        }
    }
}

/// Counts an error of the receiver.
fn count(error: Error) {
    counters::note(match error {
        Error::Overrun => |events| &mut events.receiver_overruns,
        _ => |events| &mut events.receiver_errors,
    });
}
