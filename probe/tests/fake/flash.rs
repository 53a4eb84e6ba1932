//! Flash in memory, with pages and words of the size of the chip's.

use std::sync::{Arc, Mutex};

use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};

/// Bytes: the 128 pages of a bank.
const SIZE: usize = 128 * 2_048;

/// Flash that remembers as long as one of its clones is kept: all are the same flash.
#[derive(Clone)]
pub struct Flash(pub Arc<Mutex<Vec<u8>>>);

impl Default for Flash {
    fn default() -> Self {
        Self(Arc::new(Mutex::new(vec![0xFF; SIZE])))
    }
}

impl ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        let from = offset as usize;
        bytes.copy_from_slice(&self.0.lock().unwrap()[from..from + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        SIZE
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = 2_048;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        self.0.lock().unwrap()[from as usize..to as usize].fill(0xFF);
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        let from = offset as usize;
        self.0.lock().unwrap()[from..from + bytes.len()].copy_from_slice(bytes);
        Ok(())
    }
}
