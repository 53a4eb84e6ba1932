//! Where the uncertainty of each channel comes from, the largest term first.

use std::fmt::Write as _;

use super::ReportInput;
use super::number::fixed;
use super::page::{Page, row, text};
use crate::analysis::results::{ChannelResult, Term};

/// The section: one small table for each channel.
pub fn section(page: &mut Page, input: &ReportInput) {
    page.section("Uncertainty budgets");
    page.paragraph(
        "A term is the standard uncertainty that one cause gives to the result: the estimate is repeated with that \
         cause changed by its standard uncertainty (GUM, JCGM 100:2008, 5.1.3 note 2). Independent terms add in \
         squares; the expanded uncertainty is twice their sum. The terms are in order of what they do to <i>k</i>.",
    );
    let mut tables = String::from("<div class=\"budgets\">\n");
    for channel in &input.analysis.results.channels {
        tables += &table(channel);
    }
    page.markup(&(tables + "</div>\n"));
}

fn table(channel: &ChannelResult) -> String {
    let largest = channel
        .budget
        .iter()
        .fold(0.0, |most: f64, term| most.max(term.gain_relative));
    let mut table = format!(
        "<table><thead><tr><th>{}</th><th></th><th class=\"n\"><i>k</i>, %</th>\
         <th class=\"n\"><i>u</i><sub>0</sub>, counts</th></tr></thead><tbody>\n",
        text(&channel.name)
    );
    for term in &channel.budget {
        let share = if largest > 0.0 {
            100.0 * term.gain_relative / largest
        } else {
            0.0
        };
        table += &row([
            ("", text(&term.cause).to_string()),
            (
                "share",
                format!("<span style=\"width:{share:.1}%\"></span>"),
            ),
            ("n", small(100.0 * term.gain_relative, 3)),
            ("n", small(term.offset_counts, 1)),
        ]);
    }
    let gain = combined(&channel.budget, |term| 100.0 * term.gain_relative);
    let offset = combined(&channel.budget, |term| term.offset_counts);
    for (title, factor) in [("combined", 1.0), ("expanded, <i>U</i>", 2.0)] {
        let _ = writeln!(
            table,
            "<tr class=\"total\"><td colspan=\"2\">{title}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
            small(factor * gain, 3),
            small(factor * offset, 1)
        );
    }
    table + "</tbody></table>\n"
}

/// Independent terms add in squares.
fn combined(budget: &[Term], part: impl Fn(&Term) -> f64) -> f64 {
    budget
        .iter()
        .map(|term| part(term).powi(2))
        .sum::<f64>()
        .sqrt()
}

/// A term; what is there but would be written as zero is written as less than the last digit.
fn small(value: f64, decimals: usize) -> String {
    let least = 10f64.powi(-(decimals as i32));
    if value == 0.0 {
        "–".to_owned()
    } else if value < least / 2.0 {
        format!("&lt; {}", fixed(least, decimals))
    } else {
        fixed(value, decimals)
    }
}
