//! A coefficient set as tables for people.

use hexsense_core::channel::{JACKS, Triad};
use hexsense_core::records::CoefficientSet;

use crate::terminal::one_line;

/// The set as a table for people: each channel with offset, gain, sensitivity and expanded uncertainty (k = 2).
#[must_use]
pub fn table(set: &CoefficientSet) -> String {
    let mut text = String::from(
        "channel   offset u0, counts          gain M_ii, unit/count                 sensitivity, counts/unit\n",
    );
    for triad in Triad::ALL {
        let coefficients = &set.triads[triad.index()];
        for axis in 0..3 {
            let (gain, uncertainty) = (
                coefficients.matrix[axis][axis],
                coefficients.matrix_uncertainty[axis][axis],
            );
            text += &format!(
                "{:<7} {:>10.2} ± {:<8.2}   {:>13.6e} ± {:<9.2e} {:<7}   {:>10.3}\n",
                hexsense_core::channel::NAMES[triad.first_channel() + axis],
                coefficients.offset[axis],
                2.0 * coefficients.offset_uncertainty[axis],
                gain,
                2.0 * uncertainty,
                triad.unit(),
                1.0 / gain,
            );
        }
    }
    text + "± is the expanded uncertainty, coverage factor 2\n\n" + &base_table(set)
}

/// Base and jack transducers as a table for people.
fn base_table(set: &CoefficientSet) -> String {
    let (base, jacks) = (&set.base, &set.jacks);
    let mut text = format!(
        "base {}: jacks {:.4} m to {:.4} m, O at {:.4} m at home\n\
         jack   lower hinge x, y, z, m          upper hinge x, y, z, m          {:.4} m at, counts   mm per count\n",
        one_line(&set.geometry),
        base.length_min_m,
        base.length_max_m,
        base.home_height_m,
        jacks.zero_length_m,
    );
    for jack in 0..JACKS {
        let [lower, upper] = [base.lower[jack], base.upper[jack]]
            .map(|[x, y, z]| format!("{x:>9.4} {y:>9.4} {z:>9.4}"));
        text += &format!(
            "jack{}  {lower}   {upper}   {:>16.2} {:>14.6}\n",
            jack + 1,
            jacks.zero_counts[jack],
            1e3 * jacks.metres_per_count[jack],
        );
    }
    text
}
