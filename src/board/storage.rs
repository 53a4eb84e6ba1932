//! The coefficients in flash bank 2: loaded at the start, replaced by an upload, never half.
//!
//! This task alone touches the flash. Erasing a page takes 22 ms, in which bank 2 cannot be read but the code in
//! bank 1 runs on; that is why the driver's asynchronous form is used, which waits by interrupt. Its futures are
//! awaited to their end and never dropped: a dropped erase leaves the flash set up to erase again. It also loses
//! the error flags of a write, so every write is read back (the archive does that).
//!
//! An upload is one transaction: begin, chunks, commit. Until the commit everything is in RAM; whatever goes wrong,
//! or if the power goes, the set that was active stays active.

use core::ops::Range;

use embassy_stm32::Peri;
use embassy_stm32::flash::{Bank2Region, Flash};
use embassy_stm32::peripherals::FLASH;
use embassy_time::with_timeout;
use hexsense::sampling::Calibrator;
use hexsense::store::{Archive, ArchiveError, CoefficientSet, MAX_ENCODED, SetId, Stored};
use hexsense::wire::message::{ActiveSet, CHUNK, Chunk, Refusal, Response};

use super::exchange::{Active, Exchange};
use super::pins::Irqs;
use super::pose::Base;
use super::timing::STORAGE_HEARTBEAT;

/// Bytes of bank 2 that hold the sets: eight pages of three sets each, so that 10,000 erasures of a page last for
/// 200,000 uploads.
const ARCHIVE: Range<u32> = 0..8 * 2_048;

/// What the link may ask of the storage. Each is answered once.
pub enum Command {
    /// Which set is active?
    ActiveSet,
    /// Bytes of the active set from this offset on.
    Read(u16),
    /// Start an upload of so many bytes with this identity.
    Begin(u16, SetId),
    /// The next piece, and where it belongs.
    Chunk(u16, Chunk),
    /// Check, store, read back, activate.
    Commit,
    /// Forget the upload.
    Abort,
}

type Encoded = heapless::Vec<u8, MAX_ENCODED>;

/// An upload under way.
struct Upload {
    length: u16,
    id: SetId,
    bytes: Encoded,
}

/// Loads the active set, then answers commands for ever. `board` is this chip's unique id.
#[embassy_executor::task]
pub async fn store(flash: Peri<'static, FLASH>, board: [u8; 12], exchange: &'static Exchange) -> ! {
    let region = Flash::new(flash, Irqs).into_regions().bank2_region;
    let Ok(archive) = Archive::new(region, ARCHIVE) else {
        panic!("the archive's range is not a whole number of pages");
    };
    let mut storage = Storage {
        archive,
        board,
        exchange,
        active: None,
        upload: None,
    };
    match storage.archive.newest().await {
        Ok(Some(stored)) => storage.activate(&stored),
        Ok(None) => defmt::info!("no coefficients yet"),
        Err(error) => defmt::error!("archive: {}", defmt::Debug2Format(&error)),
    }
    loop {
        exchange.alive.storage.signal(());
        if let Ok(command) = with_timeout(STORAGE_HEARTBEAT, exchange.to_storage.receive()).await {
            let answer = storage
                .carry_out(command)
                .await
                .unwrap_or_else(Response::Refused);
            exchange.answers.send(answer).await;
        }
    }
}

/// State of the storage task.
struct Storage {
    archive: Archive<Bank2Region<'static>>,
    board: [u8; 12],
    exchange: &'static Exchange,
    /// The active set, with its bytes as they are in flash.
    active: Option<(ActiveSet, Encoded)>,
    upload: Option<Upload>,
}

impl Storage {
    async fn carry_out(&mut self, command: Command) -> Result<Response, Refusal> {
        match command {
            Command::ActiveSet => {
                let active = self.active.as_ref().map(|(active, _)| *active);
                Ok(Response::ActiveSet(active))
            }
            Command::Read(offset) => self.read(offset),
            Command::Begin(length, id) => self.begin(length, id),
            Command::Chunk(offset, bytes) => self.chunk(offset, &bytes),
            Command::Commit => self.commit().await,
            Command::Abort => {
                self.upload = None;
                Ok(Response::Done)
            }
        }
    }

    fn read(&self, offset: u16) -> Result<Response, Refusal> {
        let (active, encoded) = self.active.as_ref().ok_or(Refusal::NoSet)?;
        let rest = encoded.get(usize::from(offset)..).ok_or(Refusal::Offset {
            offset,
            length: active.length,
        })?;
        let bytes = rest.iter().copied().take(CHUNK).collect();
        Ok(Response::SetBytes { offset, bytes })
    }

    fn begin(&mut self, length: u16, id: SetId) -> Result<Response, Refusal> {
        if length == 0 || usize::from(length) > MAX_ENCODED {
            let limit = MAX_ENCODED as u16;
            return Err(Refusal::Length { length, limit });
        }
        self.upload = Some(Upload {
            length,
            id,
            bytes: Encoded::new(),
        });
        Ok(Response::Done)
    }

    fn chunk(&mut self, offset: u16, bytes: &[u8]) -> Result<Response, Refusal> {
        let upload = self.upload.as_mut().ok_or(Refusal::NoUpload)?;
        let expected = upload.bytes.len() as u16;
        let room = usize::from(upload.length - expected);
        if offset != expected || bytes.len() > room {
            return Err(Refusal::OutOfOrder { expected });
        }
        // `length` is at most the vector's capacity, so what has room in the one has room in the other.
        upload
            .bytes
            .extend_from_slice(bytes)
            .map_err(|_| Refusal::OutOfOrder { expected })?;
        Ok(Response::Done)
    }

    async fn commit(&mut self) -> Result<Response, Refusal> {
        let upload = self.upload.take().ok_or(Refusal::NoUpload)?;
        let expected = upload.bytes.len() as u16;
        if expected != upload.length {
            return Err(Refusal::OutOfOrder { expected });
        }
        if CoefficientSet::id_of(&upload.bytes) != upload.id {
            return Err(Refusal::WrongIdentity);
        }
        let set = CoefficientSet::decode(&upload.bytes).map_err(Refusal::Record)?;
        if set.board != self.board {
            return Err(Refusal::OtherBoard);
        }
        let stored = self
            .archive
            .append(&upload.bytes)
            .await
            .map_err(|error| match error {
                ArchiveError::Record(error) => Refusal::Record(error),
                error => {
                    defmt::error!("archive: {}", defmt::Debug2Format(&error));
                    Refusal::Flash
                }
            })?;
        self.activate(&stored);
        let (active, _) = self.active.as_ref().ok_or(Refusal::Flash)?;
        Ok(Response::Committed(*active))
    }

    /// Puts a set that was read from flash to use.
    fn activate(&mut self, stored: &Stored) {
        if stored.set.board != self.board {
            defmt::warn!("the stored coefficients belong to another board");
            return;
        }
        let mut buffer = [0; MAX_ENCODED];
        let Some(encoded) = stored
            .set
            .encode(&mut buffer)
            .ok()
            .and_then(|bytes| Encoded::from_slice(bytes).ok())
        else {
            return;
        };
        let set = ActiveSet {
            id: stored.id,
            sequence: stored.sequence,
            length: encoded.len() as u16,
        };
        self.exchange.active.sender().send(Active {
            set,
            temperature_c: stored.set.temperature_c,
            calibrator: Calibrator::new(&stored.set),
        });
        self.exchange.base.signal(Base {
            set: stored.id,
            base: stored.set.base,
            jacks: stored.set.jacks,
        });
        self.active = Some((set, encoded));
    }
}
