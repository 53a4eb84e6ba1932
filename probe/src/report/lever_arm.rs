//! The place of the sensor block, checked by the second harmonic in the angular sine runs.

use super::ReportInput;
use super::number::{align, fixed};
use super::page::{Page, row, text};
use crate::analysis::lever_arm::{LIMIT_M, SecondHarmonic};

/// The section: warnings, and a table.
pub fn section(page: &mut Page, input: &ReportInput) {
    let results = &input.analysis.results;
    page.section("The place of the sensor block");
    page.paragraph(&format!(
        "The place is estimated from the first harmonic of the accelerometers in the angular sine runs. Their second \
         harmonic, the centripetal acceleration, was not used; here it is compared with what pose, gravity and that \
         place predict. A difference is let pass up to four standard uncertainties of the noise, or up to what {} mm \
         would make.",
        fixed(1e3 * LIMIT_M, 0)
    ));
    for warning in &results.warnings {
        page.paragraph(&format!("<strong>Warning:</strong> {}.", text(warning)));
    }
    let column = |cell: &dyn Fn(&SecondHarmonic) -> f64| {
        let all = results.second_harmonics.iter();
        let mut cells: Vec<String> = all.map(|harmonic| fixed(cell(harmonic), 4)).collect();
        align(&mut cells);
        cells
    };
    let columns = [
        column(&|harmonic| harmonic.predicted),
        column(&|harmonic| harmonic.measured),
        column(&|harmonic| harmonic.difference),
        column(&|harmonic| harmonic.uncertainty),
        column(&|harmonic| harmonic.limit),
    ];
    let rows = results
        .second_harmonics
        .iter()
        .enumerate()
        .map(|(index, harmonic)| {
            let numbers = columns.iter().map(|column| ("n", column[index].clone()));
            let names = [
                ("name", text(&harmonic.freedom).to_string()),
                ("", text(&harmonic.channel).to_string()),
            ];
            let verdict = if harmonic.agrees() {
                "agrees"
            } else {
                "differs"
            };
            row(names
                .into_iter()
                .chain(numbers)
                .chain([("", verdict.to_owned())]))
        });
    let head = "<tr><th>Sine run</th><th>Channel</th><th class=\"n\">Predicted</th><th class=\"n\">Measured</th>\
                <th class=\"n\">Difference</th><th class=\"n\"><i>u</i></th><th class=\"n\">Limit</th><th></th></tr>";
    page.table(
        "Second harmonic of the specific force at the sensor block, m/s²; the difference is that of the complex \
         amplitudes.",
        head,
        &rows.collect::<String>(),
    );
}
