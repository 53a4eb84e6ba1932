//! A first look at the motion system: how the measured pose follows the command in each degree of freedom driven.

use hexsense_core::calibration::truth::coordinates;
use hexsense_core::excitation::DegreeOfFreedom;

use super::ReportInput;
use super::page::{Page, row};
use crate::analysis::AnalysisError;
use crate::analysis::assumptions::Assumptions;
use crate::analysis::condense::Sweep;
use crate::analysis::poses::RunPoses;
use crate::characteristics::frequency_response::FrequencyResponse;
use crate::figure::curve::Point;
use crate::figure::drawing::{Drawing, Panel, Sample, WIDTH};
use crate::figure::markup::text;
use crate::figure::number::{align, fixed};
use crate::figure::pair::{Curve, Pair};
use crate::figure::scale::Scale;

const COLUMNS: usize = 2;
const LEFT: f64 = 66.0;
const GAP: f64 = 66.0;
const TOP: f64 = 50.0;
const CURVE_HEIGHT: f64 = 104.0;
const ERROR_HEIGHT: f64 = 54.0;
const ROW_HEIGHT: f64 = CURVE_HEIGHT + ERROR_HEIGHT + 72.0;

/// The section: a table and a figure.
///
/// # Errors
/// [`AnalysisError::Pose`] and [`AnalysisError::Tolerance`].
pub fn section(page: &mut Page, input: &ReportInput) -> Result<(), AnalysisError> {
    page.section("The motion system: a first look");
    page.paragraph(
        "The pose is that of the jacks through forward kinematics. Amplitude ratio and phase compare its first \
         harmonic with the command. The start of the command is itself found from the jacks, so a pure delay of the \
         base does not show in the phase.",
    );
    table(
        page,
        &input.characterisation.characteristics.frequency_response,
    );
    let assumptions = Assumptions::new(&input.campaign.geometry, &input.campaign.sensors);
    let sweeps = input.characterisation.sweeps.iter();
    let paths = sweeps
        .map(|sweep| Path::new(sweep, input, &assumptions))
        .collect::<Result<Vec<_>, _>>()?;
    page.figure(
        "Command and measured pose over the estimate, in the degree of freedom driven, and below each, pose minus \
         command.",
        &figure(&paths),
    );
    Ok(())
}

/// How an amplitude is written: factor from SI, unit, decimals.
fn unit(is_rotation: bool) -> (f64, &'static str, usize) {
    if is_rotation {
        (1f64.to_degrees(), "degrees", 4)
    } else {
        (1e3, "mm", 2)
    }
}

fn table(page: &mut Page, motion: &[FrequencyResponse]) {
    let of = |response: &FrequencyResponse| {
        let freedom = DegreeOfFreedom::ALL
            .into_iter()
            .find(|freedom| freedom.name() == response.freedom);
        unit(freedom.is_some_and(DegreeOfFreedom::is_rotation))
    };
    let column = |cell: &dyn Fn(&FrequencyResponse) -> String| {
        let mut cells: Vec<String> = motion.iter().map(cell).collect();
        align(&mut cells);
        cells
    };
    let amplitude = |response: &FrequencyResponse, si: f64| {
        let (factor, _, decimals) = of(response);
        fixed(factor * si, decimals)
    };
    let columns = [
        column(&|response| fixed(response.frequency_hz, 5)),
        column(&|response| amplitude(response, response.command)),
        column(&|response| amplitude(response, response.measured)),
        column(&|response| fixed(response.ratio, 4)),
        column(&|response| fixed(20.0 * response.ratio.log10(), 3)),
        column(&|response| fixed(response.phase_deg, 2)),
        column(&|response| fixed(100.0 * response.distortion, 2)),
    ];
    let rows = motion.iter().enumerate().map(|(index, response)| {
        let numbers = columns.iter().map(|column| ("n", column[index].clone()));
        let mut cells: Vec<_> = std::iter::once(("name", text(&response.freedom).to_string()))
            .chain(numbers)
            .collect();
        cells.insert(4, ("", of(response).1.to_owned()));
        row(cells)
    });
    let head = "<tr><th>Degree of freedom</th><th class=\"n\">Frequency<small>Hz</small></th>\
                <th class=\"n\">Command</th><th class=\"n\">Pose</th><th></th>\
                <th class=\"n\">Ratio</th><th class=\"n\">Ratio<small>dB</small></th>\
                <th class=\"n\">Phase<small>°</small></th><th class=\"n\">Distortion<small>%</small></th></tr>";
    page.table(
        "From command to pose: amplitudes of the first harmonic, their ratio and phase, and the total harmonic \
         distortion of the pose (harmonics 2 to 5). A negative phase is a lag.",
        head,
        &rows.collect::<String>(),
    );
}

/// Command and pose of one run over s from the onset, in the unit that people read.
struct Path {
    freedom: DegreeOfFreedom,
    command: Vec<Point>,
    pose: Vec<Point>,
    error: Vec<Point>,
}

impl Path {
    fn new(
        sweep: &Sweep,
        input: &ReportInput,
        assumptions: &Assumptions,
    ) -> Result<Self, AnalysisError> {
        let base = &input.campaign.geometry.geometry;
        let home = coordinates(&base.home())[sweep.freedom as usize];
        let rate = f64::from(sweep.rate_hz);
        let (factor, ..) = unit(sweep.freedom.is_rotation());
        let mut poses = RunPoses::new(assumptions, &sweep.name)?;
        let (mut command, mut pose, mut error) = (Vec::new(), Vec::new(), Vec::new());
        for (group, counts) in sweep.jacks.iter().enumerate() {
            let middle = group as f64 * sweep.group as f64 + (sweep.group as f64 - 1.0) / 2.0;
            let time_s = (sweep.first as f64 + middle) / rate - sweep.onset_s;
            let measured = coordinates(&poses.next(counts)?)[sweep.freedom as usize] - home;
            let told = sweep.sine.at(time_s);
            command.push((time_s, factor * told));
            pose.push((time_s, factor * measured));
            error.push((time_s, factor * (measured - told)));
        }
        Ok(Self {
            freedom: sweep.freedom,
            command,
            pose,
            error,
        })
    }

    fn draw(&self, drawing: &mut Drawing, left: f64, top: f64, width: f64) {
        let (start_s, end_s) = (
            self.pose.first().map_or(0.0, |point| point.0),
            self.pose.last().map_or(0.0, |point| point.0),
        );
        let (_, unit, _) = unit(self.freedom.is_rotation());
        let x = Scale::between(start_s, end_s, 4);
        let y = Scale::symmetric(self.pose.iter().chain(&self.command).map(|point| point.1));
        let error_y = Scale::symmetric(self.error.iter().map(|point| point.1));
        let upper = Panel {
            left,
            top,
            width,
            height: CURVE_HEIGHT,
            x: &x,
            y: &y,
        };
        let pair = Pair {
            upper,
            error_height: ERROR_HEIGHT,
            error_y: &error_y,
            name: self.freedom.name(),
            time: true,
            numbers: true,
            unit: Some((unit, 46.0)),
        };
        let curves = [
            Curve::Line("reference", &self.command),
            Curve::Line("measured", &self.pose),
        ];
        pair.draw(drawing, &curves, &[Curve::Line("error", &self.error)]);
    }
}

fn figure(paths: &[Path]) -> String {
    let rows = paths.len().div_ceil(COLUMNS);
    let mut drawing = Drawing::new("Command and pose", TOP + rows as f64 * ROW_HEIGHT - 30.0);
    drawing.legend(
        LEFT,
        14.0,
        &[
            (Sample::Line, "reference", "command"),
            (Sample::Line, "measured", "pose from the jacks"),
            (Sample::Line, "error", "pose − command"),
        ],
    );
    let width = (WIDTH - LEFT - GAP - 4.0) / COLUMNS as f64;
    for (index, path) in paths.iter().enumerate() {
        let left = LEFT + (index % COLUMNS) as f64 * (width + GAP);
        path.draw(
            &mut drawing,
            left,
            TOP + (index / COLUMNS) as f64 * ROW_HEIGHT,
            width,
        );
    }
    drawing.finish()
}
