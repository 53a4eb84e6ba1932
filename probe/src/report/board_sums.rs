//! The harmonics that the board found while it sampled, beside the host's from the capture.
//!
//! The board sums integers at the programmed frequencies, over whole blocks and a window that starts a little earlier;
//! the host fits in floating point at the frequency it found. The two agree within their noise, and a replay of the
//! capture through the same integer sums must give the board's sums to the last bit.

use hexsense_core::channel::{INERTIAL, NAMES};
use hexsense_core::harmonics::solve;

use super::ReportInput;
use super::board_gain::{BoardGain, gains};
use super::page::{Page, row};
use super::signals::driven;
use crate::analysis::assumptions::Assumptions;
use crate::analysis::condense::Sweep;
use crate::analysis::{AnalysisError, RecordedRun};
use crate::campaign::BoardSums;
use crate::figure::markup::text;
use crate::figure::number::{align, fixed, rounded, significant};
use crate::replay::{ReplayError, replay};

/// The section; it is left out when no run has sums of the board.
///
/// # Errors
/// [`AnalysisError`] when the jacks give no pose.
pub fn section(page: &mut Page, input: &ReportInput) -> Result<(), AnalysisError> {
    let recorded: Vec<(&RecordedRun, &BoardSums)> = recorded(input).collect();
    if recorded.is_empty() {
        return Ok(());
    }
    page.section("The board's own estimate");
    page.paragraph(
        "The board sums every channel at the programmed drive frequency while it samples. Its amplitudes stand beside \
         those that the host fits to the recorded scans, at the frequency that it finds and over a window of its own.",
    );
    let assumptions = Assumptions::new(&input.campaign.geometry, &input.campaign.sensors);
    let mut rows = Vec::new();
    for sweep in input.sweeps() {
        let of_sweep = recorded.iter().filter(|(run, _)| run.name == sweep.name);
        for (run, sums) in of_sweep {
            rows.extend(compare(sweep, sums, run, &assumptions)?);
        }
    }
    amplitudes(page, &rows);
    factors(page, input, &rows);
    replays(page, &recorded);
    Ok(())
}

/// Runs with each of their sums.
fn recorded<'a>(input: &'a ReportInput) -> impl Iterator<Item = (&'a RecordedRun, &'a BoardSums)> {
    let verified = input.verified.map(|verified| verified.run);
    let runs = input.runs.iter().chain(verified);
    runs.flat_map(|run| {
        let records = input.records.iter();
        let of_run = records.filter(move |record| record.run == run.name);
        of_run.flat_map(move |record| record.board_sums.iter().map(move |sums| (run, sums)))
    })
}

/// One channel in one run: amplitudes in counts at nominal supply with their standard uncertainties.
struct Comparison<'a> {
    run: &'a str,
    channel: usize,
    board: (f64, f64),
    host: (f64, f64),
    gain: BoardGain,
}

fn compare<'a>(
    sweep: &'a Sweep,
    sums: &BoardSums,
    run: &RecordedRun,
    assumptions: &Assumptions,
) -> Result<Vec<Comparison<'a>>, AnalysisError> {
    let supply = mean_supply(run, sums);
    let Some(gains) = gains(
        &run.name,
        sums,
        run.rate_hz,
        (supply, run.ratiometric),
        assumptions,
    )?
    else {
        return Ok(Vec::new());
    };
    let channels = driven(sweep)
        .into_iter()
        .filter(|channel| *channel < INERTIAL);
    let compared = channels.filter_map(|channel| {
        let board = solve(&sums.drive, &sums.channels[channel])?;
        let host = &sweep.sensors[channel];
        let supply = if run.ratiometric.has(channel) {
            1.0
        } else {
            supply
        };
        Some(Comparison {
            run: &sweep.name,
            channel,
            board: (
                board.first().amplitude() * supply,
                board.uncertainty.amplitude[0] * supply,
            ),
            host: (host.first().amplitude(), host.uncertainty.amplitude[0]),
            gain: gains[channel],
        })
    });
    Ok(compared.collect())
}

/// Mean supply factor over the board's window, or over the whole run where the capture does not hold it.
fn mean_supply(run: &RecordedRun, sums: &BoardSums) -> f64 {
    let supply = &run.capture.supply;
    let scans = sums.drive.blocks as usize * sums.drive.block.scans();
    let window = run.capture.window(sums.first_scan, scans);
    let factors = window.map_or(supply.as_slice(), |window| &supply[window]);
    factors.iter().map(|factor| f64::from(*factor)).sum::<f64>() / factors.len().max(1) as f64
}

fn amplitudes(page: &mut Page, rows: &[Comparison]) {
    let head = "<tr><th>Run</th><th>Channel</th>\
                <th class=\"n\" colspan=\"2\">Board<small>counts</small></th>\
                <th class=\"n\" colspan=\"2\">Host<small>counts</small></th>\
                <th class=\"n\">Board − host<small>%</small></th></tr>";
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
        row([
            ("", text(comparison.run).to_string()),
            ("name", NAMES[comparison.channel].to_owned()),
            ("n", board.0[index].clone()),
            ("u", board.1[index].clone()),
            ("n", host.0[index].clone()),
            ("u", host.1[index].clone()),
            ("n", fixed(100.0 * difference, 3)),
        ])
    });
    page.table(
        "First harmonics of the driven channels at nominal supply. ± is the standard uncertainty by each fit's own \
         residuals.",
        head,
        &cells.collect::<String>(),
    );
}

/// The calibration factors straight from the board's sums, beside the fitted ones.
fn factors(page: &mut Page, input: &ReportInput, rows: &[Comparison]) {
    let results = &input.analysis.results.channels;
    let cells = rows.iter().filter_map(|comparison| {
        let result = results.get(comparison.channel)?;
        let (gain, fitted) = (&comparison.gain, result.gain.estimate.abs());
        Some(row([
            ("", text(comparison.run).to_string()),
            ("name", NAMES[comparison.channel].to_owned()),
            ("n", significant(gain.truth, 5)),
            ("n", significant(gain.counts, 6)),
            ("n", significant(gain.ratio(), 5)),
            ("n", significant(fitted, 5)),
            ("n", fixed(100.0 * (gain.ratio() / fitted - 1.0), 3)),
            ("", text(&result.unit).to_string()),
        ]))
    });
    page.table(
        "Calibration factors from the board's sums alone: the amplitude that a channel should have felt, found from the \
         sums of the six jacks by forward kinematics, over the amplitude that it shows. Beside them the fitted gains, \
         from which they differ by the cross terms of the matrix, by noise, and by how far the base's frequency is \
         from the programmed one.",
        "<tr><th>Run</th><th>Channel</th><th class=\"n\">Jacks<small>unit</small></th>\
         <th class=\"n\">Sensor<small>counts</small></th>\
         <th class=\"n\">Jacks / sensor<small>unit per count</small></th>\
         <th class=\"n\">Fitted<small>unit per count</small></th>\
         <th class=\"n\">Difference<small>%</small></th><th>Unit</th></tr>",
        &cells.collect::<String>(),
    );
}

/// What was summed, and what summing the capture again gave.
fn replays(page: &mut Page, recorded: &[(&RecordedRun, &BoardSums)]) {
    let cells = recorded.iter().map(|(run, sums)| {
        let drive = &sums.drive;
        let (class, outcome) = match replay(sums, &run.capture) {
            Ok(()) => ("passes", "identical"),
            Err(ReplayError::Different { .. }) => ("fails", "different"),
            Err(ReplayError::Missing { .. }) => ("fails", "not in the capture"),
        };
        row([
            ("", text(&run.name).to_string()),
            ("n", fixed(drive.frequency_hz(run.rate_hz), 4)),
            ("n", drive.block.scans().to_string()),
            ("n", drive.blocks.to_string()),
            ("n", sums.first_scan.to_string()),
            (class, outcome.to_owned()),
        ])
    });
    page.table(
        "Replay: the recorded scans, summed again by the host in integers, give the board's sums of all fifteen \
         channels to the last bit. The block is the largest that keeps the known disturbances off the harmonics.",
        "<tr><th>Run</th><th class=\"n\">Drive<small>Hz</small></th><th class=\"n\">Block<small>scans</small></th>\
         <th class=\"n\">Blocks</th><th class=\"n\">First scan</th><th>Replay</th></tr>",
        &cells.collect::<String>(),
    );
}
