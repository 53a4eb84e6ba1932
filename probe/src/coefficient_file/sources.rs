//! What a coefficient set was found from, as SHA-256.
//!
//! The set carries one digest of all of it, its provenance, which is a part of its identity. The coefficient file has the
//! digests one by one, so that it can be told which of the files beside it is another one.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::files;

/// The digests, in hexadecimal digits.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sources {
    /// Of the captures that coefficients were fitted to, as they were recorded.
    pub captures_sha256: String,
    /// Of the jack programs by which the plan moves in them.
    pub programs_sha256: String,
    /// Of the geometry file, with line ends as on Unix.
    pub geometry_sha256: String,
    /// Of the sensor file, with line ends as on Unix.
    pub sensors_sha256: String,
}

impl Sources {
    /// The digest of all of them that a set carries.
    #[must_use]
    pub fn provenance(&self) -> [u8; 32] {
        let digests = [
            &self.captures_sha256,
            &self.programs_sha256,
            &self.geometry_sha256,
            &self.sensors_sha256,
        ];
        let mut all = Sha256::new();
        for digest in digests {
            all.update(digest);
            all.update(b"\n");
        }
        all.finalize().into()
    }
}

/// Digest of a text file, whatever git made of its line ends.
#[must_use]
pub fn text_digest(text: &str) -> String {
    files::hex(&Sha256::digest(text.replace("\r\n", "\n")))
}
