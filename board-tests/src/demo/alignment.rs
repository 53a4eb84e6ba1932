//! Where a capture lies in the twin's time.
//!
//! The twin's log of the truth has the twin's clock, a capture has the board's. Both hold the jacks: the time of the
//! capture's start and the ratio of the clocks are fitted so that the measured displacements lie on the true ones,
//!
//! ```text
//! measured(n) = true(start + n·period) + offset_k        k = 1..6, start, period and six offsets fitted
//! ```
//!
//! by a search in steps and then Gauss-Newton. Transducers have no delay, so this is exact to microseconds.

use anyhow::{bail, ensure};
use hexsense_core::channel::JACKS;
use hexsense_core::least_squares::NormalEquations;
use nalgebra::SVector;
use tables::Table;

const UNKNOWNS: usize = 2 + JACKS;
/// Step of the search, s.
const SEARCH_S: f64 = 0.02;

/// The truth of a run: rows of the twin's log at a constant period.
pub struct TruthLog {
    start_s: f64,
    period_s: f64,
    /// Specific force, angular acceleration, angular rate; then the six displacements, m.
    rows: Vec<[f64; Self::COLUMNS]>,
}

impl TruthLog {
    /// Nine sensor channels and six jacks.
    const COLUMNS: usize = 15;

    /// Reads the twin's log.
    pub fn parse(text: &str) -> anyhow::Result<Self> {
        let problem = |line, problem| anyhow::anyhow!("the truth log, line {line}: {problem}");
        let mut table = Table::of(text).map_err(|(line, found)| problem(line, found))?;
        let names = tables::names(table.format(), table.header.text);
        ensure!(
            names.len() == Self::COLUMNS + 1,
            "the truth log has the columns {names:?}"
        );
        let mut times = Vec::new();
        let mut rows = Vec::new();
        while let Some(line) = table.next() {
            let format = table.format();
            let cells = format.cells(line.text).map(|cell| format.finite(cell));
            let values: Vec<f64> = cells
                .collect::<Result<_, _>>()
                .map_err(|found| problem(line.number, found))?;
            let [time, values @ ..] = values.as_slice() else {
                bail!("the truth log, line {}: no cells", line.number)
            };
            times.push(*time);
            rows.push(
                values
                    .try_into()
                    .map_err(|_| anyhow::anyhow!("the truth log has the line {:?}", line.text))?,
            );
        }
        let [first, second, ..] = times[..] else {
            bail!("the truth log has no movement in it")
        };
        Ok(Self {
            start_s: first,
            period_s: second - first,
            rows,
        })
    }

    /// A column at a time, by a straight line between rows; `None` outside the log.
    pub fn at(&self, time_s: f64, column: usize) -> Option<f64> {
        let place = (time_s - self.start_s) / self.period_s;
        let row = (place >= 0.0).then_some(place as usize)?;
        let (from, to) = (self.rows.get(row)?[column], self.rows.get(row + 1)?[column]);
        Some(from + (to - from) * (place - row as f64))
    }

    fn jack(&self, time_s: f64, jack: usize) -> Option<f64> {
        self.at(time_s, Self::COLUMNS - JACKS + jack)
    }

    fn end_s(&self) -> f64 {
        self.start_s + self.period_s * (self.rows.len() - 1) as f64
    }
}

/// Time of a capture's value n in the twin's clock: start + n·period.
#[derive(Debug, Clone, Copy)]
pub struct Alignment {
    /// Time of value 0, s.
    pub start_s: f64,
    /// Time from value to value, s.
    pub period_s: f64,
}

/// Fits the alignment of `measured` displacements (m, one row every `period_s` by the board's clock).
pub fn align(
    measured: &[[f64; JACKS]],
    period_s: f64,
    log: &TruthLog,
) -> anyhow::Result<Alignment> {
    let mut alignment = Alignment {
        start_s: search(measured, period_s, log)?,
        period_s,
    };
    for _ in 0..10 {
        let mut equations = NormalEquations::<UNKNOWNS>::default();
        for (n, row) in measured.iter().enumerate() {
            let time_s = alignment.start_s + n as f64 * alignment.period_s;
            for (jack, value) in row.iter().enumerate() {
                let near = (
                    log.jack(time_s - log.period_s, jack),
                    log.jack(time_s, jack),
                    log.jack(time_s + log.period_s, jack),
                );
                let (Some(before), Some(here), Some(after)) = near else {
                    continue;
                };
                let speed = (after - before) / (2.0 * log.period_s);
                let mut columns = SVector::<f64, UNKNOWNS>::zeros();
                columns[0] = speed;
                columns[1] = speed * n as f64 / measured.len() as f64;
                columns[2 + jack] = 1.0;
                equations.add(&columns, value - here, 1.0);
            }
        }
        let solution = equations
            .solve()
            .context("the truth log and the capture do not overlap")?;
        alignment.start_s += solution.unknowns[0];
        alignment.period_s += solution.unknowns[1] / measured.len() as f64;
        if solution.unknowns[0].abs() < 1e-7 {
            return Ok(alignment);
        }
    }
    bail!("the jacks of the capture and of the truth log do not fit together")
}

/// The start that fits best, in steps: the one with the least mean square of the differences of jack 1 from their
/// mean. The log begins when the run was commanded, so the capture's rest before it may be missing there.
fn search(measured: &[[f64; JACKS]], period_s: f64, log: &TruthLog) -> anyhow::Result<f64> {
    let length_s = measured.len() as f64 * period_s;
    let first_s = log.start_s - 0.1 * length_s;
    let misfit = |start_s: f64| -> Option<f64> {
        let rows = measured.iter().enumerate();
        let differences: Vec<f64> = rows
            .filter_map(|(n, row)| Some(row[0] - log.jack(start_s + n as f64 * period_s, 0)?))
            .collect();
        let count = differences.len() as f64;
        let mean = differences.iter().sum::<f64>() / count;
        let square: f64 = differences
            .iter()
            .map(|difference| (difference - mean).powi(2))
            .sum();
        (count > 0.9 * measured.len() as f64).then_some(square / count)
    };
    let steps = ((log.end_s() - first_s) / SEARCH_S) as usize;
    (0..=steps)
        .map(|step| first_s + step as f64 * SEARCH_S)
        .filter_map(|start_s| Some((start_s, misfit(start_s)?)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(start_s, _)| start_s)
        .context("the truth log is shorter than the capture")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn displacement_m(time_s: f64, jack: usize) -> f64 {
        let pace = 2.0 + 0.3 * jack as f64;
        0.1 * (pace * time_s).sin() * (1.0 - (-time_s / 2.0).exp())
    }

    fn log() -> TruthLog {
        let names: Vec<String> = (0..=TruthLog::COLUMNS)
            .map(|column| format!("c{column}"))
            .collect();
        let mut text = names.join(",") + "\n";
        for row in 0..20_000 {
            let time_s = 100.0 + f64::from(row) * 0.002;
            let jacks = (0..JACKS).map(|jack| format!(",{}", displacement_m(time_s - 105.0, jack)));
            text += &format!("{time_s}{}{}\n", ",0".repeat(9), jacks.collect::<String>());
        }
        TruthLog::parse(&text).unwrap()
    }

    #[test]
    fn a_late_capture_by_a_wrong_clock_with_offset_transducers_is_placed_to_ten_microseconds() {
        let (start_s, period_s) = (104.321_987, 0.01 * (1.0 - 4e-5));
        let measured: Vec<[f64; JACKS]> = (0..3_000)
            .map(|n| {
                let time_s = start_s + f64::from(n) * period_s;
                core::array::from_fn(|jack| {
                    displacement_m(time_s - 105.0, jack) + 1e-4 * jack as f64
                })
            })
            .collect();
        let alignment = align(&measured, 0.01, &log()).unwrap();
        assert!((alignment.start_s - start_s).abs() < 1e-5, "{alignment:?}");
        assert!(
            (alignment.period_s / period_s - 1.0).abs() < 1e-6,
            "{alignment:?}"
        );
    }

    #[test]
    fn a_log_without_movement_or_with_other_columns_is_refused() {
        assert!(TruthLog::parse("time_s,a,b\\n").is_err());
        let header = (0..=TruthLog::COLUMNS)
            .map(|c| c.to_string())
            .collect::<Vec<_>>()
            .join(",");
        assert!(TruthLog::parse(&header).is_err());
    }
}
