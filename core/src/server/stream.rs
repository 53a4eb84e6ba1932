//! The stream: blocks of the sample path and poses of the board, as far as the host wants them.
//!
//! Blocks leave the queue whether they are sent or not, because the pose needs the jacks of each.

use crate::channel::JACKS;
use crate::live_pose::JackBlock;
use crate::sample_path::Progress;
use crate::sample_path::queue::Piece;
use crate::sampling::add_up;
use crate::wire::telemetry::Header;
use crate::wire::{PoseReport, StreamContent, pose, telemetry};

use super::board::{Board, sendable};

/// What the host wants, and how far the stream has come.
#[derive(Default)]
pub struct Stream {
    /// What the host wants.
    pub content: StreamContent,
    /// Jacks of a block of which a piece is still to be sent.
    begun: Option<JackBlock>,
    sequence: u16,
}

impl Stream {
    /// Takes the next piece of the queue. Returns the length of the frame to send when the host wants blocks, and gives
    /// the board the jacks of the last block of the piece when the host wants poses.
    pub fn block(&mut self, board: &mut impl Board, out: &mut [u8]) -> Option<usize> {
        let content = self.content;
        let mut piece = Piece::new();
        let (due, progress) = board.path(|path| (path.queue.take(&mut piece), path.progress));
        if !due {
            return None;
        }
        if let Some(jacks) = jacks_of(&piece, &mut self.begun).filter(|_| content.pose) {
            board.find_pose(jacks);
        }
        if !content.has_blocks() {
            return None;
        }
        let header = header(&piece, &progress, content);
        let encoded = telemetry::encode(&header, piece.samples(), self.next_sequence(), out);
        sendable(board, encoded)
    }

    /// Takes a pose; returns the length of the frame to send, when the host still wants poses.
    pub fn pose(
        &mut self,
        board: &mut impl Board,
        report: &PoseReport,
        out: &mut [u8],
    ) -> Option<usize> {
        if !self.content.pose {
            return None;
        }
        let encoded = pose::encode(report, self.next_sequence(), out);
        sendable(board, encoded)
    }

    fn next_sequence(&mut self) -> u16 {
        let sequence = self.sequence;
        self.sequence = sequence.wrapping_add(1);
        sequence
    }
}

fn header(piece: &Piece, progress: &Progress, content: StreamContent) -> Header {
    Header {
        first_scan: piece.first_scan,
        scans: piece.scans as u8,
        rate_hz: progress.rate_hz,
        supply: piece.context.supply,
        temperature_c: piece.context.temperature_c,
        set: piece.context.set,
        dropped: progress.dropped,
        // After a factory reset the host learns that there are no values any more.
        content: StreamContent {
            values: content.values && piece.context.set.is_some(),
            ..content
        },
        supply_is_old: piece.context.supply_is_old,
    }
}

/// The jacks of the last block that ends with a piece; `begun` keeps those of a large block's first half.
fn jacks_of(piece: &Piece, begun: &mut Option<JackBlock>) -> Option<JackBlock> {
    let before = piece.scans.saturating_sub(piece.block.scans());
    let mut sums = [0; JACKS];
    add_up(piece.samples().jacks.get(before..)?, &mut sums);
    let mut jacks = JackBlock {
        first_scan: piece.first_scan + before as u64,
        supply: piece.context.supply,
        block: piece.block,
        sums,
    };
    if !piece.begins {
        let before = begun.take()?;
        jacks.first_scan = before.first_scan;
        for (sum, before) in jacks.sums.iter_mut().zip(before.sums) {
            *sum += before;
        }
        return Some(jacks);
    }
    if piece.scans >= piece.block.scans() {
        return Some(jacks);
    }
    *begun = Some(jacks);
    None
}
