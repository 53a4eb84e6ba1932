//! The table's values over a window, in integers: the sums that a solution needs besides the channel's own.
//!
//! Let z be the values in the sums (1, place, cosines and sines of the table) and x those of the model. A fit needs ZᵀZ
//! and Zᵀ(X − Z). They depend on the drive alone, and the replay makes them from it, block by block:
//!
//! ```text
//! x = z + e      e: the rounding of a wave, and the difference of the exact place from the drift's 4096 places
//! ZᵀZ += z·zᵀ    ZᵀE += z·eᵀ
//! ```
//!
//! All are exact in 62 bits for the longest window. A block takes some 700 instructions on the board, so a long window
//! is replayed in slices, and other tasks run between them.

use super::REGRESSORS;
use super::drive::{Drive, DriveError};
use super::table::{Rest, Waves};

/// Elements of the lower triangle of ZᵀZ, row after row.
pub(super) const TRIANGLE: usize = REGRESSORS * (REGRESSORS + 1) / 2;
/// Columns that are waves.
pub(super) const WAVES: usize = REGRESSORS - 2;

/// The sums over the blocks of one drive, up to the present block.
#[derive(Debug, Clone)]
pub struct Replay {
    drive: Drive,
    done: u32,
    /// ZᵀZ; a place is doubled and centred, 2p + 1 − P.
    pub(super) squares: [i64; TRIANGLE],
    /// Zᵀ times the exact place, doubled and centred, 2b + 1 − N.
    pub(super) places: [i64; REGRESSORS],
    /// Zᵀ times the rounding of the waves.
    pub(super) rests: [[i64; WAVES]; REGRESSORS],
}

impl Replay {
    /// A replay before its first block.
    ///
    /// # Errors
    /// [`DriveError`] for a drive that no analyser accepts.
    pub fn new(drive: Drive) -> Result<Self, DriveError> {
        drive.check()?;
        Ok(Self {
            drive,
            done: 0,
            squares: [0; TRIANGLE],
            places: [0; REGRESSORS],
            rests: [[0; WAVES]; REGRESSORS],
        })
    }

    /// The drive of these blocks.
    #[must_use]
    pub fn drive(&self) -> &Drive {
        &self.drive
    }

    /// Replays at most `blocks` more; true when the window is complete.
    pub fn advance(&mut self, blocks: u32) -> bool {
        let end = self.done.saturating_add(blocks).min(self.drive.blocks);
        for block in self.done..end {
            self.add(block);
        }
        self.done = end;
        end == self.drive.blocks
    }

    #[inline(never)]
    fn add(&mut self, block: u32) {
        let drive = &self.drive;
        let phase = drive.centre_phase(block);
        let waves = Waves::at((phase >> 32) as u32);
        let rest = Rest::of(&waves, phase);
        let centred = |place: u32, places: u32| 2 * place as i32 + 1 - places as i32;
        let mut z = [1; REGRESSORS];
        z[1] = centred(drive.place(block), drive.places());
        let mut e = [0; WAVES];
        for k in 0..super::HARMONICS {
            (z[2 + 2 * k], z[3 + 2 * k]) = (waves.cosine[k], waves.sine[k]);
            (e[2 * k], e[2 * k + 1]) = (rest.cosine[k], rest.sine[k]);
        }
        let place = i64::from(centred(block, drive.blocks));
        let mut square = self.squares.iter_mut();
        for (row, value) in z.iter().enumerate() {
            let value = i64::from(*value);
            for (other, square) in z[..=row].iter().zip(&mut square) {
                *square += value * i64::from(*other);
            }
            self.places[row] += value * place;
            for (rest, sum) in e.iter().zip(&mut self.rests[row]) {
                *sum += value * i64::from(*rest);
            }
        }
    }
}
