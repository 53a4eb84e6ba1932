//! The result: offsets, coefficients and sensitivities of the nine channels, then the matrices and delays in full.

use hexsense_core::channel::Triad;

use super::ReportInput;
use super::page::{Page, row};
use crate::analysis::results::{ChannelResult, Measured};
use crate::figure::markup::text;
use crate::figure::number::{align, common_exponent, power_of_ten, rounded, significant};

/// Name of a triad as people write it.
#[must_use]
pub fn triad_name(triad: Triad) -> &'static str {
    match triad {
        Triad::LinearAcceleration => "Linear acceleration",
        Triad::AngularAcceleration => "Angular acceleration",
        Triad::AngularRate => "Angular rate",
    }
}

/// The channels of a triad; fewer than three when the results hold fewer.
fn of_triad<'a>(input: &'a ReportInput, triad: Triad) -> &'a [ChannelResult] {
    let channels = &input.analysis.results.channels;
    let first = triad.first_channel().min(channels.len());
    &channels[first..(first + 3).min(channels.len())]
}

/// The section with the table of nine channels.
pub fn results(page: &mut Page, input: &ReportInput) {
    page.section("Coefficients");
    page.paragraph(
        "A channel's value is <i>M</i>·(<i>u</i> − <i>u</i><sub>0</sub>): <i>u</i> are the counts of its triad at \
         nominal supply (65536 at 3.3 V), <i>u</i><sub>0</sub> the counts at zero input, <i>M</i> a 3×3 matrix. \
         The table shows the diagonal, <i>k</i> = <i>M<sub>ii</sub></i>, and the sensitivity <i>S</i> = 1/<i>k</i> \
         that data sheets give.",
    );
    let mut body = String::new();
    for triad in Triad::ALL {
        body += &triad_rows(triad, of_triad(input, triad));
    }
    let head = "<tr><th>Channel</th>\
                <th class=\"n\" colspan=\"2\">Offset <i>u</i><sub>0</sub><small>counts</small></th>\
                <th class=\"n\" colspan=\"2\">Coefficient <i>k</i></th>\
                <th class=\"n\"><i>U</i>(<i>k</i>)/<i>k</i><small>%</small></th>\
                <th class=\"n\">95 %<small>± % of <i>k</i></small></th>\
                <th class=\"n\" colspan=\"2\">Sensitivity <i>S</i></th>\
                <th class=\"n\">Noise density</th></tr>";
    page.table(
        "The nine channels. ± is the expanded uncertainty <i>U</i>, coverage factor 2. The column 95 % is half the \
         interval that holds the true <i>k</i> with that probability; it is narrower where tolerances, which have an \
         end, are the largest terms. The noise density is that of the rests before the movements.",
        head,
        &body,
    );
}

fn group(columns: usize, title: &str) -> String {
    format!("<tr><td class=\"group\" colspan=\"{columns}\">{title}</td></tr>\n")
}

/// Columns of values and their uncertainties, aligned.
fn pairs(measured: impl Iterator<Item = (f64, f64)>) -> (Vec<String>, Vec<String>) {
    let (mut values, mut uncertainties): (Vec<String>, Vec<String>) = measured
        .map(|(value, uncertainty)| <(String, String)>::from(rounded(value, uncertainty)))
        .unzip();
    align(&mut values);
    align(&mut uncertainties);
    (values, uncertainties)
}

fn triad_rows(triad: Triad, channels: &[ChannelResult]) -> String {
    let exponent = common_exponent(channels.iter().map(|channel| channel.gain.estimate));
    let noise_exponent = common_exponent(channels.iter().map(|channel| channel.noise_density));
    let (scale, noise_scale) = (10f64.powi(exponent), 10f64.powi(noise_exponent));
    let of = |measured: &Measured| (measured.estimate, measured.expanded_uncertainty);
    let relative =
        |channel: &ChannelResult| channel.gain.expanded_uncertainty / channel.gain.estimate.abs();
    let offsets = pairs(channels.iter().map(|channel| of(&channel.offset)));
    let gains = pairs(channels.iter().map(|channel| {
        let (value, uncertainty) = of(&channel.gain);
        (value / scale, uncertainty / scale)
    }));
    let sensitivities = pairs(channels.iter().map(|channel| {
        (
            channel.sensitivity,
            channel.sensitivity.abs() * relative(channel),
        )
    }));
    let percents = column(channels, |channel| {
        significant(100.0 * relative(channel), 2)
    });
    let intervals = column(channels, |channel| {
        significant(
            100.0 * channel.gain.interval_95 / channel.gain.estimate.abs(),
            2,
        )
    });
    let noises = column(channels, |channel| {
        significant(channel.noise_density / noise_scale, 3)
    });
    let unit = triad.unit();
    let title = format!(
        "{}: <i>k</i> in {} {unit} per count, <i>S</i> in counts per {unit}, noise density in {} ({unit})/√Hz",
        triad_name(triad),
        power_of_ten(exponent),
        power_of_ten(noise_exponent),
    );
    let rows = channels.iter().enumerate().map(|(index, channel)| {
        row([
            ("name", text(&channel.name).to_string()),
            ("n", offsets.0[index].clone()),
            ("u", offsets.1[index].clone()),
            ("n", gains.0[index].clone()),
            ("u", gains.1[index].clone()),
            ("n", percents[index].clone()),
            ("n", intervals[index].clone()),
            ("n", sensitivities.0[index].clone()),
            ("u", sensitivities.1[index].clone()),
            ("n", noises[index].clone()),
        ])
    });
    group(10, &title) + &rows.collect::<String>()
}

fn column(channels: &[ChannelResult], cell: impl Fn(&ChannelResult) -> String) -> Vec<String> {
    let mut cells: Vec<_> = channels.iter().map(cell).collect();
    align(&mut cells);
    cells
}

/// The section with the full matrices and the delays.
pub fn matrices(page: &mut Page, input: &ReportInput) {
    page.section("Matrices and delays");
    let mut body = String::new();
    for triad in Triad::ALL {
        body += &matrix_rows(input, triad);
    }
    let head = "<tr><th>Row</th><th class=\"n\" colspan=\"2\">by counts of X</th>\
                <th class=\"n\" colspan=\"2\">by counts of Y</th><th class=\"n\" colspan=\"2\">by counts of Z</th></tr>";
    page.table(
        "The matrices <i>M</i> in full: the diagonal is <i>k</i>, the rest are the cross terms that sensors a degree or \
         two off their axes have. ± as above.",
        head,
        &body,
    );
}

fn matrix_rows(input: &ReportInput, triad: Triad) -> String {
    let channels = of_triad(input, triad);
    let exponent = common_exponent(channels.iter().map(|channel| channel.gain.estimate));
    let scale = 10f64.powi(exponent);
    let columns: [_; 3] = std::array::from_fn(|column| {
        pairs(channels.iter().map(|channel| {
            let element = &channel.cross[column];
            (
                element.estimate / scale,
                element.expanded_uncertainty / scale,
            )
        }))
    });
    let mut rows = group(
        7,
        &format!(
            "{}, {} {} per count; {} behind the jacks",
            triad_name(triad),
            power_of_ten(exponent),
            triad.unit(),
            delay(&input.analysis.results.delays_s[triad.index()]),
        ),
    );
    for (index, channel) in channels.iter().enumerate() {
        let mut cells = vec![("name", text(&channel.name).to_string())];
        for (column, (values, uncertainties)) in columns.iter().enumerate() {
            let class = if column == index { "n diagonal" } else { "n" };
            cells.push((class, values[index].clone()));
            cells.push(("u", uncertainties[index].clone()));
        }
        rows += &row(cells);
    }
    rows
}

fn delay(delay_s: &Measured) -> String {
    let [value, uncertainty] = rounded(1e3 * delay_s.estimate, 1e3 * delay_s.expanded_uncertainty);
    format!("{value} ± {uncertainty} ms")
}
