//! The checks of the campaign: whether the bench was what its files say.

use super::ReportInput;
use super::page::{Page, row};
use crate::analysis::check::Check;
use crate::figure::markup::text;

/// The section: accepted failures in words, and a table of all checks.
pub fn section(page: &mut Page, input: &ReportInput) {
    let checks = &input.analysis.results.checks;
    page.section("Checks of the bench");
    page.paragraph(
        "Each part of the bench is compared with something that it did not make itself. An error that jacks, programs and \
         sensors share cannot be seen: the scale of the geometry file, or a transducer that the servo reads too.",
    );
    for check in checks {
        if let Some(reason) = &check.accepted {
            page.paragraph(&format!(
                "<strong>Accepted failure:</strong> {}: {}. Reason given: {}.",
                text(&check.name),
                text(&check.means),
                text(reason)
            ));
        }
    }
    let head = "<tr><th>Check</th><th>Verdict</th><th class=\"n\">Figure</th><th class=\"n\">Limit</th><th>Unit</th>\
                <th>Closest or beyond</th></tr>";
    page.table(
        "Checks of the bench: the figure that comes closest to its limit or goes farthest beyond, and whose it is.",
        head,
        &checks.iter().map(line).collect::<String>(),
    );
}

fn line(check: &Check) -> String {
    let [statistic, limit] = check.figures();
    let verdict = match check.accepted {
        Some(_) => "fail, accepted",
        None => check.verdict.name(),
    };
    row([
        ("name", text(&check.name).to_string()),
        ("", verdict.to_owned()),
        ("n", statistic),
        ("n", limit),
        ("", text(&check.unit).to_string()),
        ("", text(&check.names.join(", ")).to_string()),
    ])
}
