//! Coefficients, key and log in flash bank 2: the chip's side of the portable [`Storage`], which decides everything.
//!
//! This task alone touches the flash. To erase a page takes 22 ms; bank 2 cannot be read meanwhile, but the code in bank 1
//! runs on. So the task uses the asynchronous form of the driver, which waits by interrupt. It awaits the driver's futures
//! to their end and never drops one: a dropped erase leaves the flash set up to erase again. The driver also loses the
//! error flags of a write, so the storage reads every write back.

use core::sync::atomic::Ordering;

use embassy_stm32::Peri;
use embassy_stm32::flash::{Bank2Region, Flash};
use embassy_stm32::peripherals::{FLASH, RNG};
use embassy_stm32::{bind_interrupts, flash};
use embassy_time::{Instant, with_timeout};
use hexsense::FACTS;
use hexsense_core::records::SetId;
use hexsense_core::sampling::Calibrator;
use hexsense_core::storage::Storage;
use hexsense_core::wire::Response;
use hexsense_core::wire::status::OptionBytes;

use crate::chip::identity;
use crate::chip::random::Random;
use crate::chip::timing::{COEFFICIENT_CHECK, HEARTBEAT};
use crate::health::flash_errors::Corrections;
use crate::shared::{Active, Base, Shared, Task};

bind_interrupts!(
    struct Irqs {
        FLASH => Corrections, flash::InterruptHandler;
    }
);

/// Loads the active set, then answers commands for ever. `board` is this chip's unique id. Where its option bytes do not
/// allow changes, nothing is written: with a single bank an erasure would hit the code.
#[embassy_executor::task]
pub async fn store(
    flash: Peri<'static, FLASH>,
    random: Peri<'static, RNG>,
    board: [u8; 12],
    options: OptionBytes,
    shared: &'static Shared,
) -> ! {
    let region = Flash::new(flash, Irqs).into_regions().bank2_region;
    let mut storage = Storage::new(region, FACTS.flash, board);
    if !options.allow_changes() {
        storage.forbid_changes();
    }
    let mut published = None;
    let loaded = storage.load();
    publish(&mut storage, &mut published, shared);
    let build = identity::build().await;
    shared.build.lock(|known| known.set(Some(build)));
    if loaded.is_err() {
        defmt::error!("storage cannot read its flash");
    } else if storage.complete(build).await.is_err() {
        defmt::error!("storage cannot complete a change");
    }
    let mut random = Random::new(random);
    let mut check_at = Instant::now();
    loop {
        publish(&mut storage, &mut published, shared);
        shared.alive.sign(Task::Storage);
        if Instant::now() >= check_at {
            check_at = Instant::now() + COEFFICIENT_CHECK;
            storage.refresh();
            send_coefficients(&storage, shared);
        }
        if let Ok(command) = with_timeout(HEARTBEAT, shared.to_storage.receive()).await {
            let now_ms = Instant::now().as_millis();
            let fill = async |challenge: &mut [u8; 16]| random.fill(challenge).await;
            let answer = storage
                .carry_out(command, now_ms, fill)
                .await
                .unwrap_or_else(Response::Refused);
            publish(&mut storage, &mut published, shared);
            shared.answers.send(answer).await;
        }
    }
}

/// Gives the active set to the tasks that use it, when it is not the one that was `published`.
fn publish(
    storage: &mut Storage<Bank2Region<'static>>,
    published: &mut Option<SetId>,
    shared: &Shared,
) {
    let (provisioned, damaged) = (storage.is_provisioned(), storage.is_key_damaged());
    shared.provisioned.store(provisioned, Ordering::Relaxed);
    shared.key_damaged.store(damaged, Ordering::Relaxed);
    let log_used = storage.log_used().unwrap_or(u32::MAX);
    shared.log_used.store(log_used, Ordering::Relaxed);
    let active = storage.active();
    let id = active.map(|active| active.set.id);
    if id == *published {
        return;
    }
    *published = id;
    send_coefficients(storage, shared);
    shared.base.sender().send(active.map(|active| Base {
        set: active.set.id,
        base: active.content.base,
        jacks: active.content.jacks,
        ratiometric: active.content.ratiometric,
    }));
}

/// Gives the coefficients of the active set to the sampling task, which compares them with those at work.
#[inline(never)]
fn send_coefficients(storage: &Storage<Bank2Region<'static>>, shared: &Shared) {
    shared
        .active
        .sender()
        .send(storage.active().map(|active| Active {
            id: active.set.id,
            temperature_c: active.content.temperature_c,
            calibrator: Calibrator::new(&active.content),
        }));
}
