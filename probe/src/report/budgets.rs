//! Where the uncertainty of each channel comes from, the largest term first.

use std::fmt::Write as _;

use super::ReportInput;
use super::page::{Page, row};
use crate::analysis::results::{ChannelResult, Term};
use crate::figure::markup::text;
use crate::figure::number::fixed;

/// The section: two small tables for each channel.
pub fn section(page: &mut Page, input: &ReportInput) {
    page.section("Uncertainty budgets");
    page.paragraph(
        "A term is the standard uncertainty that one cause gives to the result: the estimate is repeated with that \
         cause changed by its standard uncertainty (GUM, JCGM 100:2008, 5.1.3 note 2). Independent terms add in \
         squares; the expanded uncertainty is twice the root of that sum. For each channel there are two lists, the largest \
         term first: the coefficient <i>k</i>, relative, and the offset <i>u</i><sub>0</sub>.",
    );
    let mut tables = String::from("<div class=\"budgets\">\n");
    for triad in input.analysis.results.channels.chunks(3) {
        for coefficient in [&GAIN, &OFFSET] {
            tables.extend(triad.iter().map(|channel| table(channel, coefficient)));
        }
    }
    page.markup(&(tables + "</div>\n"));
}

/// Terms of one coefficient: what it is and its unit, decimals, and its part of a term.
struct Coefficient {
    title: &'static str,
    decimals: usize,
    part: fn(&Term) -> f64,
}

const GAIN: Coefficient = Coefficient {
    title: "<i>k</i>, %",
    decimals: 3,
    part: |term| 100.0 * term.gain_relative,
};
const OFFSET: Coefficient = Coefficient {
    title: "<i>u</i><sub>0</sub>, counts",
    decimals: 1,
    part: |term| term.offset_counts,
};

fn table(channel: &ChannelResult, coefficient: &Coefficient) -> String {
    let Coefficient {
        title,
        decimals,
        part,
    } = *coefficient;
    let terms = channel.budget.iter().map(|term| (&term.cause, part(term)));
    let mut terms: Vec<_> = terms.filter(|(_, value)| *value > 0.0).collect();
    terms.sort_by(|a, b| b.1.total_cmp(&a.1));
    let largest = terms.first().map_or(1.0, |(_, value)| *value);
    let mut table = format!(
        "<table><thead><tr><th>{}</th><th></th><th class=\"n\">{title}</th></tr></thead><tbody>\n",
        text(&channel.name)
    );
    for (cause, value) in &terms {
        let share = 100.0 * value / largest;
        table += &row([
            ("", text(cause).to_string()),
            (
                "share",
                format!("<span style=\"width:{share:.1}%\"></span>"),
            ),
            ("n", small(*value, decimals)),
        ]);
    }
    let combined = combined(terms.iter().map(|(_, value)| *value));
    for (title, factor) in [("combined", 1.0), ("expanded, <i>U</i>", 2.0)] {
        let _ = writeln!(
            table,
            "<tr class=\"total\"><td colspan=\"2\">{title}</td><td class=\"n\">{}</td></tr>",
            small(factor * combined, decimals)
        );
    }
    table + "</tbody></table>\n"
}

/// Independent terms add in squares.
fn combined(terms: impl Iterator<Item = f64>) -> f64 {
    terms.map(|term| term * term).sum::<f64>().sqrt()
}

/// A term; what would be written as zero is written as less than the last digit.
fn small(value: f64, decimals: usize) -> String {
    let least = 10f64.powi(-(decimals as i32));
    if value < least / 2.0 {
        format!("&lt; {}", fixed(least, decimals))
    } else {
        fixed(value, decimals)
    }
}
