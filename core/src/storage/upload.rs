//! An upload, from the change that announces it to the set that is active: announced length and digest, pieces in order,
//! a commit, all within [`UPLOAD_MS`].
//!
//! This file and `mod.rs` are two halves of [`Storage`]: it keeps the upload under way, and an upload is a series of its
//! commands.

use embedded_storage_async::nor_flash::NorFlash;

use super::{Made, Storage, UPLOAD_MS, refusal};
use crate::checksum::sha256;
use crate::facts::FlashLayout;
use crate::records::log::Reason;
use crate::records::{Archive, MAX_ENCODED, SetId};
use crate::wire::{Refusal, Response};

type Encoded = heapless::Vec<u8, MAX_ENCODED>;

/// An upload under way.
#[derive(Debug)]
pub(super) struct Upload {
    length: u16,
    digest: [u8; 32],
    unix_s: u64,
    begun_ms: u64,
    bytes: Encoded,
}

impl Upload {
    /// Checks that the announced bytes have arrived, and returns the identity of their set.
    fn check(&self) -> Result<SetId, Refusal> {
        let expected = self.bytes.len() as u16;
        if expected != self.length {
            return Err(Refusal::OutOfOrder { expected });
        }
        if sha256(&self.bytes) != self.digest {
            return Err(Refusal::WrongIdentity);
        }
        Ok(SetId::of_digest(&self.digest))
    }
}

impl<F: NorFlash> Storage<F> {
    pub(super) fn begin(
        &mut self,
        length: u16,
        digest: [u8; 32],
        unix_s: u64,
        begun_ms: u64,
    ) -> Result<Response, Refusal> {
        if length == 0 || usize::from(length) > MAX_ENCODED {
            let limit = MAX_ENCODED as u16;
            return Err(Refusal::Length { length, limit });
        }
        if self.active_id() == Some(SetId::of_digest(&digest)) {
            return Err(Refusal::AlreadyActive);
        }
        self.upload = Some(Upload {
            length,
            digest,
            unix_s,
            begun_ms,
            bytes: Encoded::new(),
        });
        Ok(Response::Done)
    }

    /// The upload under way, unless its time is over.
    fn upload(&mut self, now_ms: u64) -> Result<&mut Upload, Refusal> {
        let is_over = |upload: &mut Upload| now_ms.saturating_sub(upload.begun_ms) > UPLOAD_MS;
        if self.upload.take_if(is_over).is_some() {
            return Err(Refusal::Expired);
        }
        self.upload.as_mut().ok_or(Refusal::NoUpload)
    }

    pub(super) fn chunk(
        &mut self,
        offset: u16,
        bytes: &[u8],
        now_ms: u64,
    ) -> Result<Response, Refusal> {
        let upload = self.upload(now_ms)?;
        let expected = upload.bytes.len() as u16;
        let fits = upload.bytes.len() + bytes.len() <= usize::from(upload.length);
        if offset == expected && fits && upload.bytes.extend_from_slice(bytes).is_ok() {
            Ok(Response::Done)
        } else {
            Err(Refusal::OutOfOrder { expected })
        }
    }

    pub(super) async fn commit(&mut self, now_ms: u64) -> Result<Response, Refusal> {
        let committed = self.store(now_ms).await;
        self.upload = None;
        committed
    }

    /// Makes the uploaded set the newest in the archive and the active one.
    async fn store(&mut self, now_ms: u64) -> Result<Response, Refusal> {
        let upload = self.upload(now_ms)?;
        let (id, unix_s) = (upload.check()?, upload.unix_s);
        let entry = self.entry(Reason::Upload, Some(id), unix_s);
        let slot = self.active.as_ref().map(|active| active.slot);
        let upload = self.upload.as_ref().ok_or(Refusal::NoUpload)?;
        let mut archive = Archive::new(&mut self.flash, FlashLayout::ARCHIVE);
        let appended = archive.append(&entry, &upload.bytes, slot, &self.board);
        let (stored, content) = appended.await.map_err(refusal)?;
        self.activate(&stored, content);
        self.unlogged = Some(Made::of(&entry));
        self.enter_owed().await?;
        self.committed()
    }
}
