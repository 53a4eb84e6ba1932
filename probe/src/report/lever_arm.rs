//! The place of the sensor block, checked by the second harmonic in the angular sine runs.

use super::ReportInput;
use super::page::{Page, row};
use crate::analysis::lever_arm::{MAX_OFFSET_M, SecondHarmonic};
use crate::figure::markup::text;
use crate::figure::number::{align, fixed, rounded};

/// The section: the place, warnings, and a table of the check.
pub fn section(page: &mut Page, input: &ReportInput) {
    let results = &input.analysis.results;
    page.section("The place of the sensor block");
    page.paragraph(
        "The place is found from the first harmonic of the accelerometers in the angular sine runs, and the held-out \
         movement is judged with it.",
    );
    places(page, input);
    for warning in &results.warnings {
        page.paragraph(&format!("<strong>Warning:</strong> {}.", text(warning)));
    }
    page.paragraph(&format!(
        "The second harmonic, the centripetal acceleration, was not used for that; here it is compared with what pose, \
         gravity and that place predict. A difference passes up to four standard uncertainties of the noise, or \
         up to what {} mm would make.",
        fixed(1e3 * MAX_OFFSET_M, 0)
    ));
    harmonics(page, &results.second_harmonics);
}

/// The place by the sensor file, and as it was found.
fn places(page: &mut Page, input: &ReportInput) {
    let sensors = &input.campaign.sensors;
    let found = &input.analysis.results.lever_arm_m;
    let tolerance = fixed(1e3 * sensors.lever_arm_tolerance_m, 0);
    let (mut values, mut uncertainties): (Vec<String>, Vec<String>) = found
        .iter()
        .map(|place| rounded(1e3 * place.estimate, 1e3 * place.expanded_uncertainty).into())
        .unzip();
    align(&mut values);
    align(&mut uncertainties);
    let rows = ["X", "Y", "Z"].iter().enumerate().map(|(axis, name)| {
        row([
            ("name", (*name).to_owned()),
            ("n", fixed(1e3 * sensors.lever_arm_m[axis], 0)),
            ("u", tolerance.clone()),
            ("n", values[axis].clone()),
            ("u", uncertainties[axis].clone()),
        ])
    });
    let head = "<tr><th>Axis</th><th class=\"n\" colspan=\"2\">Sensor file</th>\
                <th class=\"n\" colspan=\"2\">Found</th></tr>";
    page.table(
        "Place of the sensor block from O in body axes, mm: by the sensor file with its tolerance, and as found with \
         its expanded uncertainty, coverage factor 2.",
        head,
        &rows.collect::<String>(),
    );
}

fn harmonics(page: &mut Page, harmonics: &[SecondHarmonic]) {
    let column = |cell: &dyn Fn(&SecondHarmonic) -> f64| {
        let mut cells: Vec<String> = harmonics
            .iter()
            .map(|harmonic| fixed(cell(harmonic), 4))
            .collect();
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
    let rows = harmonics.iter().enumerate().map(|(index, harmonic)| {
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
