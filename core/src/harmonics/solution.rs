//! From integer sums to harmonics: one code for board and host, with the same bits for an answer.
//!
//! The sums use the table's values z, which are not quite the sines x of the model. They serve as *instruments*: the
//! sums are Zᵀs, the model says s = Xβ + noise, so
//!
//! ```text
//! (Zᵀ X) β = Zᵀ s
//! ```
//!
//! holds for every signal of the model's form, whatever the table's rounding. X holds block sums of the regressors;
//! that of harmonic k is cos(kθ)·D with D = sin(kω·B/2) / sin(kω/2), θ the phase at the block's centre. With β′ = Dβ and
//! X = (Z + E)·D, E being a millionth of Z, one factor of ZᵀZ is enough:
//!
//! ```text
//! β′ ← (ZᵀZ)⁻¹ (Zᵀs − ZᵀE·β′)      each turn a million times better
//! residual = sᵀs − Zᵀs·(ZᵀZ)⁻¹·Zᵀs      cov β′ = σ² (ZᵀZ)⁻¹
//! ```
//!
//! [`Replay`] makes ZᵀZ and ZᵀE from the drive, so only the sums have to travel. All channels share both.

use super::drive::Drive;
use super::factor::{Column, Factor};
use super::replay::{Replay, TRIANGLE, WAVES};
use super::sums::ChannelSums;
use super::table::{self, sine_cosine};
use super::{Cofactors, HARMONICS, Harmonic, Harmonics, REGRESSORS};

/// Steps of the correction for the table's rounding.
const CORRECTIONS: usize = 3;
/// Greatest factor by which the other columns may raise the variance of an unknown. Beyond it an uncertainty is a
/// thousand times that of the unknown alone, and the table's rounding is no longer small against the rest.
const MAX_INFLATION: f64 = 1e6;
/// The value of one in each column of Z.
const ONE: f64 = table::ONE as f64;

/// Harmonics of one channel from its sums, in counts; `None` when the blocks do not determine twelve unknowns.
#[must_use]
pub fn solve(drive: &Drive, sums: &ChannelSums) -> Option<Harmonics> {
    let mut replay = Replay::new(*drive).ok()?;
    replay.advance(drive.blocks);
    Some(Solver::new(&replay)?.solve(sums))
}

/// As [`solve`], with the phases at the trigger of the first scan: the channel is converted `late_scans` after it
/// ([`BoardFacts::instant_s`](crate::facts::BoardFacts::instant_s) times the scan rate). This delay is taken out, so that
/// channels of different ranks can be compared.
#[must_use]
pub fn solve_channel(drive: &Drive, late_scans: f64, sums: &ChannelSums) -> Option<Harmonics> {
    let mut replay = Replay::new(*drive).ok()?;
    replay.advance(drive.blocks);
    Some(Solver::new(&replay)?.solve_channel(late_scans, sums))
}

/// Solves the channels of one drive.
pub struct Solver<'a> {
    replay: &'a Replay,
    factor: Factor,
    /// Of one, of the place in the window and of the waves: factors from a column of Z to the model's block sum.
    gains: [f64; HARMONICS],
    cofactors: Cofactors,
}

impl<'a> Solver<'a> {
    /// From a complete replay; `None` when its blocks do not determine twelve unknowns and leave a residual.
    #[must_use]
    #[inline(never)]
    pub fn new(replay: &'a Replay) -> Option<Self> {
        if replay.drive().blocks <= REGRESSORS as u32 {
            return None;
        }
        let scale = scale(replay.drive());
        let mut squares = [0.0; TRIANGLE];
        let places = (0..REGRESSORS).flat_map(|row| (0..=row).map(move |column| (row, column)));
        for ((square, sum), (row, column)) in squares.iter_mut().zip(&replay.squares).zip(places) {
            *square = *sum as f64 * (scale[row] * scale[column]);
        }
        let factor = Factor::new(squares)?;
        let inflated = |column: usize| {
            squares[lower(column, column)] * factor.inverse(column)[column] > MAX_INFLATION
        };
        if (0..REGRESSORS).any(inflated) {
            return None;
        }
        let gains = gains(replay.drive());
        let cofactors = cofactors(&factor, replay.drive(), &gains);
        Some(Self {
            replay,
            factor,
            gains,
            cofactors,
        })
    }

    /// Harmonics of one channel, in counts.
    #[must_use]
    #[inline(never)]
    pub fn solve(&self, sums: &ChannelSums) -> Harmonics {
        let drive = self.replay.drive();
        let (blocks, scans) = (f64::from(drive.blocks), drive.block.scans() as f64);
        let moments = self.moments(sums);
        let fitted = self.factor.solve(moments);
        let residual_square = residual_square(drive, sums, &fitted, &moments);
        let mut unknowns = fitted;
        for _ in 0..CORRECTIONS {
            unknowns = self.factor.solve(self.without_rests(&moments, &unknowns));
        }
        let mean = sums.offset as f64 / blocks;
        let harmonics = core::array::from_fn(|k| Harmonic {
            cosine: unknowns[2 + 2 * k] / self.gains[k],
            sine: unknowns[3 + 2 * k] / self.gains[k],
        });
        let variance = residual_square / (blocks - REGRESSORS as f64);
        Harmonics {
            offset: (mean + unknowns[0]) / scans,
            drift: unknowns[1] / scans,
            harmonics,
            residual_rms: libm::sqrt(residual_square / blocks) / scans,
            uncertainty: self.cofactors.uncertainty(&harmonics, variance),
        }
    }

    /// The same with the phases at the trigger of the first scan, see [`solve_channel`].
    #[must_use]
    pub fn solve_channel(&self, late_scans: f64, sums: &ChannelSums) -> Harmonics {
        let early_rad = self.replay.drive().omega() * late_scans;
        self.solve(sums).sampled_earlier(early_rad)
    }

    /// Zᵀs of the block sums less their mean. Integers remove the mean, because it is much larger than the harmonics.
    #[inline(never)]
    fn moments(&self, sums: &ChannelSums) -> Column {
        let drive = self.replay.drive();
        let (blocks, places) = (i128::from(drive.blocks), i128::from(drive.places()));
        let total = i128::from(sums.offset);
        let scale = scale(drive);
        // Of 2p + 1 − P.
        let drift = 2 * i128::from(sums.drift) - (places - 1) * total;
        let mut moments = [0.0; REGRESSORS];
        let mut row_start = 0;
        for row in 1..REGRESSORS {
            row_start += row;
            let sum = match (row.checked_sub(2), row % 2) {
                (None, _) => drift,
                (Some(wave), 0) => i128::from(sums.cosine[wave / 2]),
                (Some(wave), _) => i128::from(sums.sine[wave / 2]),
            };
            let centred = blocks * sum - total * i128::from(self.replay.squares[row_start]);
            moments[row] = centred as f64 * scale[row] / f64::from(drive.blocks);
        }
        moments
    }

    /// Zᵀs − ZᵀE·β′.
    #[inline(never)]
    fn without_rests(&self, moments: &Column, unknowns: &Column) -> Column {
        let Replay {
            squares,
            places,
            rests,
            ..
        } = self.replay;
        let drive = self.replay.drive();
        let scale = scale(drive);
        let exact_place = 0.5 / f64::from(drive.blocks);
        core::array::from_fn(|row| {
            let of_place =
                places[row] as f64 * exact_place - squares[lower(row, 1)] as f64 * scale[1];
            let of_waves = (0..WAVES)
                .map(|wave| rests[row][wave] as f64 * unknowns[2 + wave])
                .sum::<f64>()
                / table::UNIT;
            moments[row] - (of_place * unknowns[1] + of_waves) * scale[row]
        })
    }
}

/// Where an element of a symmetric matrix is in its lower triangle.
const fn lower(row: usize, column: usize) -> usize {
    let (row, column) = if row < column {
        (column, row)
    } else {
        (row, column)
    };
    row * (row + 1) / 2 + column
}

/// From the integers of Z to columns of the size of one.
#[inline(never)]
fn scale(drive: &Drive) -> Column {
    let mut scale = [1.0 / ONE; REGRESSORS];
    (scale[0], scale[1]) = (1.0, 0.5 / f64::from(drive.places()));
    scale
}

/// D of each harmonic.
#[inline(never)]
fn gains(drive: &Drive) -> [f64; HARMONICS] {
    let scans = drive.block.scans() as f64;
    core::array::from_fn(|k| {
        let half = (k + 1) as f64 * drive.omega() / 2.0;
        sine_cosine(half * scans).0 / sine_cosine(half).0
    })
}

/// The elements of D⁻¹ (ZᵀZ)⁻¹ D⁻¹ that the covariance needs.
#[inline(never)]
fn cofactors(factor: &Factor, drive: &Drive, gains: &[f64; HARMONICS]) -> Cofactors {
    let column = |index: usize| factor.inverse(index);
    let scans = drive.block.scans() as f64;
    Cofactors {
        offset: column(0)[0] / (scans * scans),
        drift: column(1)[1] / (scans * scans),
        harmonics: core::array::from_fn(|k| {
            let (cosine, sine) = (column(2 + 2 * k), column(3 + 2 * k));
            [cosine[2 + 2 * k], cosine[3 + 2 * k], sine[3 + 2 * k]]
                .map(|cofactor| cofactor / (gains[k] * gains[k]))
        }),
    }
}

/// Σ of the squared residuals of the block sums.
#[inline(never)]
fn residual_square(drive: &Drive, sums: &ChannelSums, fitted: &Column, moments: &Column) -> f64 {
    let (blocks, total) = (i128::from(drive.blocks), i128::from(sums.offset));
    let square = blocks * i128::from(sums.square) - total * total;
    let explained: f64 = fitted.iter().zip(moments).map(|(a, b)| a * b).sum();
    (square as f64 / f64::from(drive.blocks) - explained).max(0.0)
}
