//! How a pose and a row of lengths are written.
//!
//! A pose is six numbers, `x,y,z,roll,pitch,yaw` (m, rad), in the axes and with the angles of a [`Convention`]. With
//! `zyx` and `xyz` those axes have z up, as those of a geometry file with `axes = "z-up"`, with `z-down` they are those
//! of `axes = "z-down"`. Axes of tables and of the geometry file need not be the same.

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use hexsense_core::kinematics::{Angles, Convention, Pose};
use nalgebra::Vector3;

use super::table;
use crate::columns::Column;

/// Columns of a pose.
pub const POSE: [Column; 6] = [
    Column::length("x"),
    Column::length("y"),
    Column::length("z"),
    Column::angle("roll"),
    Column::angle("pitch"),
    Column::angle("yaw"),
];
/// Columns of the lengths of the six jacks.
pub const LENGTHS: [Column; 6] = [
    Column::length("l1"),
    Column::length("l2"),
    Column::length("l3"),
    Column::length("l4"),
    Column::length("l5"),
    Column::length("l6"),
];

/// The names of columns in a header that is printed.
#[must_use]
pub fn header(columns: &[Column; 6]) -> String {
    columns.map(Column::printed).join(",")
}

/// How poses are written.
#[derive(Args)]
pub struct Writing {
    /// Axes and angles of the poses. gost: X forward, Y up, Z right, A = Ry(yaw)·Rz(pitch)·Rx(roll). zyx: z up,
    /// R = Rz(yaw)·Ry(pitch)·Rx(roll). xyz: z up, R = Rx(roll)·Ry(pitch)·Rz(yaw). z-down: x forward, y right, z down,
    /// R = Rz(yaw)·Ry(pitch)·Rx(roll)
    #[arg(long, default_value = "gost", value_parser = convention())]
    pub convention: Convention,
}

fn convention() -> impl TypedValueParser<Value = Convention> {
    PossibleValuesParser::new(["gost", "zyx", "xyz", "z-down"]).map(|name| match name.as_str() {
        "zyx" => Convention::Zyx,
        "xyz" => Convention::Xyz,
        "z-down" => Convention::ZDown,
        _ => Convention::Gost,
    })
}

/// The pose that six numbers are.
#[must_use]
pub fn pose(convention: Convention, numbers: &[f64; 6]) -> Pose<f64> {
    let &[x, y, z, roll, pitch, yaw] = numbers;
    convention.pose(Vector3::new(x, y, z), Angles { roll, pitch, yaw })
}

/// Six numbers of a pose, m and rad, as on a command line.
///
/// # Errors
/// What is wrong, in words.
pub fn numbers(text: &str) -> Result<[f64; 6], String> {
    table::six(text, &POSE)
}
