//! How a pose and a row of lengths are written.
//!
//! A pose is six numbers, `x,y,z,roll,pitch,yaw` (m, rad), in the axes and with the angles of a [`Convention`]. With
//! `zyx` and `xyz` those axes have z up, as those of a geometry file with `axes = "z-up"`. The tool turns neither the
//! numbers of such files nor those of such tables. Other files are in the frames of the core.

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use hexsense_core::kinematics::{Angles, Convention, Pose};
use nalgebra::Vector3;

/// Columns of a pose.
pub const POSE: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];
/// Columns of the lengths of the six jacks.
pub const LENGTHS: [&str; 6] = ["l1", "l2", "l3", "l4", "l5", "l6"];

/// How poses are written.
#[derive(Args)]
pub struct Writing {
    /// Axes and angles of the poses. gost: X forward, Y up, Z right, A = Ry(yaw)·Rz(pitch)·Rx(roll). zyx: z up,
    /// R = Rz(yaw)·Ry(pitch)·Rx(roll). xyz: z up, R = Rx(roll)·Ry(pitch)·Rz(yaw)
    #[arg(long, default_value = "gost", value_parser = convention())]
    pub convention: Convention,
}

fn convention() -> impl TypedValueParser<Value = Convention> {
    PossibleValuesParser::new(["gost", "zyx", "xyz"]).map(|name| match name.as_str() {
        "zyx" => Convention::Zyx,
        "xyz" => Convention::Xyz,
        _ => Convention::Gost,
    })
}

/// The pose that six numbers are.
#[must_use]
pub fn pose(convention: Convention, numbers: &[f64; 6]) -> Pose<f64> {
    let &[x, y, z, roll, pitch, yaw] = numbers;
    convention.pose(Vector3::new(x, y, z), Angles { roll, pitch, yaw })
}
