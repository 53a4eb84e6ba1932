//! The sample path.
use embassy_time::Instant;
use hexsense::channel::CHANNELS;
use hexsense::sampling::BLOCK;

use super::acquisition::{Buffers, Run};
use super::pins;

/// Takes blocks from the converters for ever.
#[embassy_executor::task]
pub async fn sample(mut parts: pins::Acquisition) -> ! {
    let mut buffers = Buffers::take();
    let mut block = [[0; CHANNELS]; BLOCK];
    loop {
        let mut run = Run::start(&mut parts, &mut buffers, 1_000);
        let mut scans = 0u32;
        let fault = loop {
            if let Err(fault) = run.next(&mut block).await {
                break fault;
            }
            scans += BLOCK as u32;
            if scans.is_multiple_of(1024) {
                defmt::info!(
                    "{} scans in {} us, newest {}",
                    scans,
                    (Instant::now() - run.started()).as_micros(),
                    block[BLOCK - 1]
                );
            }
        };
        defmt::warn!("converters: {}", fault);
    }
}
