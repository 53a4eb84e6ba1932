//! Under which conditions the coefficients were found: base, board, sensors, date, temperature, identities, runs.

use hexsense_core::records::{CoefficientSet, MAX_ENCODED};

use super::page::{Page, code, row};
use super::{ReportInput, held_out};
use crate::analysis::AnalysisError;
use crate::base_figure;
use crate::date::utc;
use crate::figure::markup::text;
use crate::figure::number::{fixed, rounded, significant};
use crate::files;
use crate::plan::{Freedom, MultisineEntry, RampsEntry, Run, Shape, SineEntry};
use crate::sensor_file::SensorFile;

/// Title, what was calibrated, and the verdict.
///
/// # Errors
/// [`AnalysisError::Record`] for a set that cannot be encoded.
pub fn head(input: &ReportInput) -> Result<String, AnalysisError> {
    let campaign = input.campaign;
    let name = campaign.folder.file_name().map_or_else(
        || campaign.folder.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    );
    let (class, verdict) = held_out::verdict(input);
    Ok(format!(
        "<h1>Calibration of nine inertial sensors on a motion base</h1>\n\
         <p class=\"lead\">Base {} · board {} · {} · folder {}</p>\n\
         <div class=\"verdict {class}\">{verdict}<p>Coefficient set {}.</p></div>\n",
        text(&campaign.geometry.name),
        code(&input.board.board),
        date(input.set),
        text(&name),
        code(&identity(input.set)?),
    ))
}

fn date(set: &CoefficientSet) -> String {
    utc(set.unix_s).replace('T', " ").replace('Z', " UTC")
}

fn identity(set: &CoefficientSet) -> Result<String, AnalysisError> {
    let mut buffer = [0; MAX_ENCODED];
    Ok(CoefficientSet::id_of(set.encode(&mut buffer)?).to_string())
}

/// The section: a list of facts, and the runs.
///
/// # Errors
/// [`AnalysisError::Record`] for a set that cannot be encoded.
pub fn section(page: &mut Page, input: &ReportInput) -> Result<(), AnalysisError> {
    page.section("Conditions");
    let (campaign, set) = (input.campaign, input.set);
    let (geometry, sensors) = (&campaign.geometry, &campaign.sensors);
    let stroke = &geometry.geometry;
    let [x, y, z] = sensors.lever_arm_m.map(|metres| fixed(metres, 3));
    let facts = [
        ("Date", date(set)),
        (
            "Motion base",
            format!(
                "{}; jacks {} m to {} m hinge to hinge, home at {} m; hinges ±{} mm (1σ)",
                text(&geometry.name),
                fixed(stroke.length_min_m(), 3),
                fixed(stroke.length_max_m(), 3),
                fixed(stroke.home_height_m(), 4),
                significant(geometry.hinge_tolerance_m * 1e3, 2),
            ),
        ),
        ("Note on the base", text(&geometry.note).to_string()),
        (
            "Sensors",
            format!(
                "{}; block at X {x} m, Y {y} m, Z {z} m from O, ±{} mm",
                text(&sensors.name),
                fixed(sensors.lever_arm_tolerance_m * 1e3, 0),
            ),
        ),
        ("Local gravity", gravity(sensors)),
        (
            "Board",
            format!(
                "{}, id {}, firmware {}{}, wire version {}",
                text(&input.board.hardware),
                code(&input.board.board),
                text(&input.board.firmware),
                build(input),
                input.board.wire,
            ),
        ),
        ("Temperature of the board", temperature(input)),
        ("Supply of the board", supply(input)),
        ("Coefficient set", code(&identity(set)?)),
        (
            "SHA-256 of captures, programs, geometry and sensor file",
            code(&files::hex(&set.provenance)),
        ),
        (
            "SHA-256 of the geometry file",
            code(&files::hex(&geometry.hash)),
        ),
    ];
    page.markup("<dl>\n");
    for (name, value) in facts.iter().filter(|(_, value)| !value.is_empty()) {
        let class = if *name == "Note on the base" {
            " class=\"note\""
        } else {
            ""
        };
        page.markup(&format!("<dt>{name}</dt><dd{class}>{value}</dd>\n"));
    }
    page.markup("</dl>\n");
    page.figure(
        "The motion base at home with the numbers of its jacks: lower hinges square, upper hinges round.",
        &base_figure::figure(geometry),
    );
    runs(page, input);
    Ok(())
}

/// The build of the firmware that recorded the captures.
fn build(input: &ReportInput) -> String {
    let build = input.set.build.map(|build| build.to_string());
    build.map_or(String::new(), |build| format!(", build {}", code(&build)))
}

fn gravity(sensors: &SensorFile) -> String {
    let gravity = &sensors.gravity;
    let [value, uncertainty] = rounded(gravity.m_s2, gravity.uncertainty_m_s2);
    let source = gravity.source();
    let source = text(&source);
    format!("{value} ± {uncertainty} m/s² (1σ), {source}")
}

fn temperature(input: &ReportInput) -> String {
    let all = input.runs.iter().flat_map(|run| &run.capture.temperature_c);
    let mean = fixed(f64::from(input.set.temperature_c), 1);
    match range(all) {
        Some((low, high)) => format!(
            "{mean} °C on average, {} °C to {} °C",
            fixed(low, 1),
            fixed(high, 1)
        ),
        None => format!("{mean} °C"),
    }
}

fn supply(input: &ReportInput) -> String {
    let all = input.runs.iter().flat_map(|run| &run.capture.supply);
    let volts = |factor: f64| fixed(factor * f64::from(input.board.facts.nominal_supply_v), 4);
    range(all).map_or(String::new(), |(low, high)| {
        format!(
            "{} V to {} V, corrected scan by scan",
            volts(low),
            volts(high)
        )
    })
}

fn range<'a>(values: impl Iterator<Item = &'a f32>) -> Option<(f64, f64)> {
    values
        .map(|value| f64::from(*value))
        .fold(None, |range, value| {
            let (low, high) = range.unwrap_or((value, value));
            Some((f64::min(low, value), f64::max(high, value)))
        })
}

/// The runs of the plan, recorded or not.
fn runs(page: &mut Page, input: &ReportInput) {
    let mut body = String::new();
    for run in &input.campaign.plan.runs {
        let record = input.records.iter().find(|record| record.run == run.name);
        let [scans, lost, hash] = record.map_or(["–"; 3].map(str::to_owned), |record| {
            [
                record.scans.to_string(),
                record.scans_lost.to_string(),
                code(record.program_sha256.get(..16).unwrap_or_default()),
            ]
        });
        body += &row([
            ("name", text(&run.name).to_string()),
            ("", run.purpose.name().to_owned()),
            ("", movement(run)),
            ("n", fixed(run.duration_s(), 1)),
            ("n", scans),
            ("n", lost),
            ("id", hash),
        ]);
    }
    let head = "<tr><th>Run</th><th>Purpose</th><th>Movement from home</th><th class=\"n\">Length<small>s</small></th>\
                <th class=\"n\">Scans</th><th class=\"n\">Lost</th><th>SHA-256 of the jack program<small>first 16 \
                digits</small></th></tr>";
    page.table(
        "The runs. A dash stands for a run that is not recorded.",
        head,
        &body,
    );
}

fn movement(run: &Run) -> String {
    let rest = run.rest_s.map(|_| "rest at home".to_owned());
    let parts = rest
        .into_iter()
        .chain(run.ramps.iter().map(ramps))
        .chain(run.sine.iter().map(sine))
        .chain(run.multisine.iter().flat_map(multisine));
    parts.collect::<Vec<_>>().join("; ")
}

fn multisine(entry: &MultisineEntry) -> impl Iterator<Item = String> {
    entry.lines.iter().map(|lines| {
        let harmonics: Vec<String> = lines.harmonics.iter().map(u16::to_string).collect();
        let hz = entry.fundamental_hz;
        format!(
            "{} multisine, harmonics {} of {hz} Hz",
            name(lines.freedom),
            harmonics.join(", ")
        )
    })
}

fn name(freedom: Freedom) -> &'static str {
    hexsense_core::excitation::DegreeOfFreedom::from(freedom).name()
}

fn ramps(entry: &RampsEntry) -> String {
    let largest = |levels: &[f64]| {
        levels
            .iter()
            .fold(0.0, |most: f64, level| most.max(level.abs()))
    };
    let level = match (&entry.levels_deg, &entry.levels_m) {
        (Some(degrees), _) => format!("{}°", fixed(largest(degrees), 1)),
        (None, metres) => format!(
            "{} m",
            fixed(largest(metres.as_deref().unwrap_or_default()), 3)
        ),
    };
    let shape = match entry.shape {
        Shape::Linear => "linear",
        Shape::JerkLimited => "jerk-limited",
    };
    format!(
        "{} ramps and holds to ±{level}, Δt = {} s, {shape}",
        name(entry.freedom),
        entry.step_s
    )
}

fn sine(entry: &SineEntry) -> String {
    let amplitude = match (entry.amplitude_deg, entry.amplitude_m) {
        (Some(degrees), _) => format!("{}°", fixed(degrees, 1)),
        (None, metres) => format!("{} m", fixed(metres.unwrap_or_default(), 3)),
    };
    format!(
        "{} {amplitude} at {} Hz",
        name(entry.freedom),
        entry.frequency_hz
    )
}
