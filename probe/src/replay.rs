//! The board's harmonic sums and calibrated values, computed again from the scans of a capture.
//!
//! The sums are integers, so host and board must agree in every bit of every sum: offset, drift, square, and five
//! cosines and sines of all fifteen channels. A difference means that the capture does not hold what the board
//! measured, or that board and host compute differently, and nothing found from either is to be trusted.

use hexsense_core::channel::{NAMES, Scan};
use hexsense_core::harmonics::{Analyser, ChannelSums, HARMONICS};
use hexsense_core::records::CoefficientSet;
use hexsense_core::sampling::{BlockSums, Calibrator, Values};
use hexsense_core::wire::Drive;

use crate::campaign::BoardSums;
use crate::capture::Capture;

/// Integers in the sums of one analyser.
pub const INTEGERS: usize = NAMES.len() * (3 + 2 * HARMONICS);

/// Why sums could not be computed again.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReplayError {
    /// Scans are missing.
    #[error(
        "scans {first} to {last}, which the board summed, are not all in the capture; record the run again"
    )]
    Missing {
        /// First scan of the sums.
        first: u64,
        /// Last scan of the sums.
        last: u64,
    },
    /// A sum differs.
    #[error(
        "{channel}, sum {sum}: the board reports {board}, and the scans of the capture give {host}; firmware and \
         hexsense are of different builds, or the capture was changed: record the run again with a pair that fits"
    )]
    Different {
        /// Name of the channel.
        channel: &'static str,
        /// Name of the sum.
        sum: String,
        /// The board's.
        board: i128,
        /// That of the capture.
        host: i128,
    },
}

/// Computes the sums of one analyser again from the scans that it took.
///
/// # Errors
/// [`ReplayError`], with the first sum that differs.
pub fn replay(board: &BoardSums, capture: &Capture) -> Result<(), ReplayError> {
    let drive = board.drive;
    let counts = window(board, capture)?;
    let mut analyser = Analyser::new();
    analyser.start(Drive {
        settle_blocks: 0,
        ..drive
    });
    let first_scans = (board.first_scan..).step_by(drive.block.scans());
    for (scans, first_scan) in counts.chunks_exact(drive.block.scans()).zip(first_scans) {
        analyser.take(&BlockSums::of_scans(scans, first_scan));
    }
    for (channel, board) in board.channels.iter().enumerate() {
        let host = analyser.report(channel).map(|(_, _, sums)| sums);
        if let Some((sum, board, host)) = first_difference(board, &host.unwrap_or_default()) {
            return Err(ReplayError::Different {
                channel: NAMES[channel],
                sum,
                board,
                host,
            });
        }
    }
    Ok(())
}

/// The scans that the sums were made of.
fn window<'a>(board: &BoardSums, capture: &'a Capture) -> Result<&'a [Scan], ReplayError> {
    let scans = board.drive.blocks as usize * board.drive.block.scans();
    let window = capture.window(board.first_scan, scans);
    window
        .map(|window| &capture.counts[window])
        .ok_or(ReplayError::Missing {
            first: board.first_scan,
            last: board.first_scan + (scans as u64).saturating_sub(1),
        })
}

/// Values of one scan that the board streamed, and those that its counts and its set give.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WrongValues {
    /// Scan counter.
    pub scan: u64,
    /// The board's.
    pub board: Values,
    /// Those of the capture.
    pub host: Values,
}

/// The first scan in which the values that the board streamed are not, bit for bit, those that its counts and `set` give.
#[must_use]
pub fn first_wrong_values(capture: &Capture, set: &CoefficientSet) -> Option<WrongValues> {
    let calibrator = Calibrator::new(set);
    let bits = |values: Values| values.map(f32::to_bits);
    let streamed = capture.values.iter().flatten().enumerate();
    let mut compared = streamed.map(|(row, values)| WrongValues {
        scan: capture.scans[row],
        board: *values,
        host: calibrator.apply(&capture.counts[row], capture.supply[row]),
    });
    compared.find(|values| bits(values.board) != bits(values.host))
}

/// Name and values of the first sum that differs.
fn first_difference(board: &ChannelSums, host: &ChannelSums) -> Option<(String, i128, i128)> {
    let named = |sums: &ChannelSums| {
        let single = [
            ("offset".to_owned(), i128::from(sums.offset)),
            ("drift".to_owned(), sums.drift.into()),
            ("square".to_owned(), sums.square.into()),
        ];
        let waves = [("cosine", sums.cosine), ("sine", sums.sine)];
        let waves = waves.into_iter().flat_map(|(name, sums)| {
            let numbered = sums.into_iter().zip(1..);
            numbered.map(move |(sum, k)| (format!("{name} {k}"), sum.into()))
        });
        single.into_iter().chain(waves).collect::<Vec<_>>()
    };
    let pairs = named(board).into_iter().zip(named(host));
    let mut different = pairs.filter(|((_, board), (_, host))| board != host);
    different
        .next()
        .map(|((name, board), (_, host))| (name, board, host))
}
