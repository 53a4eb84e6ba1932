//! Jack programs: what a motion controller loads for one run.
//!
//! CSV with the header `time_s,jack1_m,…,jack6_m`, rows at a constant period, displacements from mid-stroke in
//! metres, written to the nanometre: at 2 ms, a micrometre would be a jolt of 0.25 m/s².

use std::fmt::Write as _;

use super::Run;
use crate::geometry_file::GeometryFile;

/// The six jack programs of a run as the text of a CSV file.
#[must_use]
pub fn jack_program(run: &Run, geometry: &GeometryFile, period_s: f64) -> String {
    let program = run.program();
    let rows = program.jack_rows(&geometry.geometry, period_s);
    let mut text = String::from("time_s,jack1_m,jack2_m,jack3_m,jack4_m,jack5_m,jack6_m\n");
    for (row, jacks) in rows.enumerate() {
        // Writing to a string cannot fail.
        let _ = write!(text, "{:.4}", row as f64 * period_s);
        for jack in jacks {
            let _ = write!(text, ",{jack:.9}");
        }
        text.push('\n');
    }
    text
}
