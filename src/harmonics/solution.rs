//! From the board's integer sums to harmonics.
//!
//! The table's values z that were used in the sums are not quite the sines x of the model. They serve as
//! *instruments*: the sums are Zᵀs, the model says s = Xβ + noise, so
//!
//! ```text
//! (Zᵀ X) β = Zᵀ s
//! ```
//!
//! holds exactly for every signal of the model's form, whatever the table's rounding. X holds block sums of the
//! regressors; that of harmonic k is cos(kθ)·D with D = sin(kω·B/2) / sin(kω/2), θ the phase at the block's centre.
//! Z is replayed from the drive, so nothing but the sums has to travel.

use nalgebra::{SMatrix, SVector};

use super::analyser::ChannelSums;
use super::drive::{Drive, radians};
use super::table::{self, Waves};
use super::{HARMONICS, Harmonics, REGRESSORS};
use crate::sampling::instant_s;

type Square = SMatrix<f64, REGRESSORS, REGRESSORS>;

/// Harmonics of one channel from its sums, in counts; `None` when the blocks do not determine twelve unknowns.
#[must_use]
pub fn solve(drive: &Drive, sums: &ChannelSums) -> Option<Harmonics> {
    drive.check().ok()?;
    let (crossed, instruments) = replay(drive);
    let moments = moments(drive, sums);
    let inverse = crossed.try_inverse()?;
    let unknowns = inverse * moments;
    let freedom = drive
        .blocks
        .checked_sub(REGRESSORS as u32)
        .filter(|freedom| *freedom > 0)?;
    let residual_square = residual_square(drive, sums, &instruments, &moments)?;
    let variance = residual_square / f64::from(freedom);
    let covariance = inverse * instruments * inverse.transpose() * variance;
    let rms = libm::sqrt(residual_square / f64::from(drive.blocks)) / drive.block.scans() as f64;
    Some(Harmonics::from_fit(&unknowns, &covariance, rms))
}

/// As [`solve`], with the phases at the trigger of the first scan: the delay of the channel's conversion (see
/// [`instant_s`]) is taken out, so that channels of different ranks can be compared.
#[must_use]
pub fn solve_channel(
    drive: &Drive,
    rate_hz: u32,
    channel: usize,
    sums: &ChannelSums,
) -> Option<Harmonics> {
    let late_scans = instant_s(channel) * f64::from(rate_hz);
    Some(solve(drive, sums)?.sampled_earlier(drive.omega() * late_scans))
}

/// ZᵀX and ZᵀZ over the blocks of the drive.
fn replay(drive: &Drive) -> (Square, Square) {
    let (mut crossed, mut instruments) = (Square::zeros(), Square::zeros());
    let (omega, scans) = (drive.omega(), drive.block.scans() as f64);
    let gain: [f64; HARMONICS] = core::array::from_fn(|k| {
        let half = (k + 1) as f64 * omega / 2.0;
        libm::sin(half * scans) / libm::sin(half)
    });
    for block in 0..drive.blocks {
        let centre = drive.centre_phase(block);
        let waves = Waves::at((centre >> 32) as u32);
        let (mut z, mut x) = (
            SVector::<f64, REGRESSORS>::zeros(),
            SVector::<f64, REGRESSORS>::zeros(),
        );
        (z[0], z[1]) = (1.0, weighed_place(drive, block));
        (x[0], x[1]) = (scans, place(drive, block) * scans);
        for k in 0..HARMONICS {
            let theta = radians(centre.wrapping_mul(k as u64 + 1));
            let (sine, cosine) = libm::sincos(theta);
            (z[2 + 2 * k], z[3 + 2 * k]) = (f64::from(waves.cosine[k]), f64::from(waves.sine[k]));
            (x[2 + 2 * k], x[3 + 2 * k]) = (gain[k] * cosine, gain[k] * sine);
        }
        z.fixed_rows_mut::<{ 2 * HARMONICS }>(2)
            .scale_mut(1.0 / f64::from(table::ONE));
        crossed.ger(1.0, &z, &x, 1.0);
        instruments.ger(1.0, &z, &z, 1.0);
    }
    (crossed, instruments)
}

/// Place of a block's centre in the window, −½ to ½.
fn place(drive: &Drive, block: u32) -> f64 {
    (f64::from(block) + 0.5) / f64::from(drive.blocks) - 0.5
}

/// The same as the drift sum weighs it: cut off to the places that it tells apart.
fn weighed_place(drive: &Drive, block: u32) -> f64 {
    (f64::from(drive.place(block)) + 0.5) / places(drive) as f64 - 0.5
}

/// Places that the drift sum tells apart.
fn places(drive: &Drive) -> i128 {
    i128::from(drive.place(drive.blocks - 1)) + 1
}

/// Zᵀs.
fn moments(drive: &Drive, sums: &ChannelSums) -> SVector<f64, REGRESSORS> {
    let places = places(drive);
    // Σ s·place = (2·Σ p·s − (P − 1)·Σ s) / 2P, exact in integers before it becomes a float.
    let drift = 2 * i128::from(sums.drift) - (places - 1) * i128::from(sums.offset);
    let mut moments = SVector::zeros();
    moments[0] = sums.offset as f64;
    moments[1] = drift as f64 / (2 * places) as f64;
    for k in 0..HARMONICS {
        moments[2 + 2 * k] = sums.cosine[k] as f64 / f64::from(table::ONE);
        moments[3 + 2 * k] = sums.sine[k] as f64 / f64::from(table::ONE);
    }
    moments
}

/// Σ of the squared residuals of the block sums, fitted by the instruments themselves; the mean is taken out in
/// integers first, since it is much larger than any residual.
fn residual_square(
    drive: &Drive,
    sums: &ChannelSums,
    instruments: &Square,
    moments: &SVector<f64, REGRESSORS>,
) -> Option<f64> {
    let blocks = i128::from(drive.blocks);
    let total = i128::from(sums.offset);
    let square = (blocks * i128::from(sums.square) - total * total) as f64 / blocks as f64;
    let mean = total as f64 / blocks as f64;
    let centred = moments - instruments.column(0) * mean;
    let fitted = instruments.cholesky()?.solve(&centred);
    Some((square - fitted.dot(&centred)).max(0.0))
}
