//! The harmonics that the board found while it sampled, beside the host's from the capture.
//!
//! The board sums integers at the programmed frequency, over whole blocks and a window that starts a little earlier;
//! the host fits in floating point at the frequency it found. The two agree within their noise, and a replay of the
//! capture through the same integer sums must give the board's sums to the last bit.

use hexsense::channel::{INERTIAL, NAMES};
use hexsense::harmonics::{Analyser, solve};
use hexsense::sampling::BlockSums;
use hexsense::wire::Drive;

use super::ReportInput;
use super::number::{align, fixed, rounded};
use super::page::{Page, row, text};
use super::signals::driven;
use crate::analysis::Run;
use crate::analysis::condense::Sweep;
use crate::campaign::BoardSums;

/// The section; none when no run has sums of the board.
pub fn section(page: &mut Page, input: &ReportInput) {
    let mut rows = Vec::new();
    for sweep in input.sweeps() {
        let record = input.records.iter().find(|record| record.run == sweep.name);
        let sums = record.and_then(|record| record.board_sums.as_ref());
        if let (Some(sums), Some(run)) = (sums, input.run(&sweep.name)) {
            rows.extend(compare(sweep, sums, run));
        }
    }
    if rows.is_empty() {
        return;
    }
    page.section("The board's own estimate");
    page.paragraph(
        "The board sums every channel at the programmed drive frequency while it samples. Its amplitudes stand beside \
         those that the host fits to the recorded scans, at the frequency that it finds and over a window of its own. \
         Replay means that the recorded scans, summed again by the host in integers, give the board's sums of all \
         fifteen channels to the last bit.",
    );
    let head = "<tr><th>Run</th><th>Channel</th>\
                <th class=\"n\" colspan=\"2\">Board<small>counts</small></th>\
                <th class=\"n\" colspan=\"2\">Host<small>counts</small></th>\
                <th class=\"n\">Board − host<small>%</small></th><th>Replay</th></tr>";
    page.table(
        "First harmonics of the driven channels at nominal supply. ± is the standard uncertainty by each fit's own \
         residuals.",
        head,
        &body(&rows),
    );
}

/// One channel in one run: amplitudes in counts at nominal supply with their standard uncertainties.
struct Comparison<'a> {
    run: &'a str,
    channel: usize,
    board: (f64, f64),
    host: (f64, f64),
    replay: Replay,
}

/// What summing the capture again gave.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Replay {
    Identical,
    Different,
    NotRecorded,
}

fn compare<'a>(sweep: &'a Sweep, sums: &BoardSums, run: &Run) -> Vec<Comparison<'a>> {
    let first = run
        .capture
        .scans
        .iter()
        .position(|scan| *scan == sums.first_scan);
    let replay = replay(sums, run, first);
    let supply = mean_supply(run, first, &sums.drive);
    let channels = driven(sweep)
        .into_iter()
        .filter(|channel| *channel < INERTIAL);
    let compared = channels.filter_map(|channel| {
        let board = solve(&sums.drive, &sums.channels[channel])?;
        let host = &sweep.sensors[channel];
        Some(Comparison {
            run: &sweep.name,
            channel,
            board: (
                board.first().amplitude() * supply,
                board.amplitude_uncertainty * supply,
            ),
            host: (host.first().amplitude(), host.amplitude_uncertainty),
            replay,
        })
    });
    compared.collect()
}

/// Mean supply factor over the board's window, or over the whole run where the capture does not hold it.
fn mean_supply(run: &Run, first: Option<usize>, drive: &Drive) -> f64 {
    let supply = &run.capture.supply;
    let window = first
        .and_then(|first| supply.get(first..first + drive.blocks as usize * drive.block.scans()));
    let factors = window.unwrap_or(supply);
    factors.iter().map(|factor| f64::from(*factor)).sum::<f64>() / factors.len().max(1) as f64
}

fn replay(sums: &BoardSums, run: &Run, first: Option<usize>) -> Replay {
    let block = sums.drive.block.scans();
    let scans = sums.drive.blocks as usize * block;
    let Some(counts) = first.and_then(|first| run.capture.counts.get(first..first + scans)) else {
        return Replay::NotRecorded;
    };
    let mut analyser = Analyser::new();
    analyser.start(Drive {
        settle_blocks: 0,
        ..sums.drive
    });
    let first_scans = (sums.first_scan..).step_by(block);
    for (scans, first_scan) in counts.chunks_exact(block).zip(first_scans) {
        analyser.take(&BlockSums::of_scans(scans, first_scan));
    }
    let same = sums.channels.iter().enumerate().all(|(channel, board)| {
        analyser
            .report(channel)
            .is_some_and(|(_, _, host)| host == *board)
    });
    if same {
        Replay::Identical
    } else {
        Replay::Different
    }
}

fn body(rows: &[Comparison]) -> String {
    let columns = |part: fn(&Comparison) -> (f64, f64)| {
        let pairs = rows.iter().map(|comparison| {
            let (value, uncertainty) = part(comparison);
            <(String, String)>::from(rounded(value, uncertainty))
        });
        let (mut values, mut uncertainties): (Vec<String>, Vec<String>) = pairs.unzip();
        align(&mut values);
        align(&mut uncertainties);
        (values, uncertainties)
    };
    let (board, host) = (columns(|row| row.board), columns(|row| row.host));
    let cells = rows.iter().enumerate().map(|(index, comparison)| {
        let difference = comparison.board.0 / comparison.host.0 - 1.0;
        let (class, replay) = match comparison.replay {
            Replay::Identical => ("passes", "identical"),
            Replay::Different => ("fails", "different"),
            Replay::NotRecorded => ("", "not in the capture"),
        };
        row([
            ("", text(comparison.run).to_string()),
            ("name", NAMES[comparison.channel].to_owned()),
            ("n", board.0[index].clone()),
            ("u", board.1[index].clone()),
            ("n", host.0[index].clone()),
            ("u", host.1[index].clone()),
            ("n", fixed(100.0 * difference, 3)),
            (class, replay.to_owned()),
        ])
    });
    cells.collect()
}
