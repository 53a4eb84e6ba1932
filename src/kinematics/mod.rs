//! Kinematics of the motion base: jack lengths from a pose and a pose from jack lengths.
//!
//! | file | what |
//! |---|---|
//! | [`presets`] | geometry files that come with the product |
//! | [`geometry`] | hinges, stroke, home |
//! | [`pose`], [`convention`] | where the body is, and how people write it down |
//! | [`inverse`](mod@inverse) | jack lengths from a pose, equation (1) |
//! | [`jacobian`](mod@jacobian) | how lengths change with the pose, equation (2), and how well that can be undone |
//!
//! Frames: OXYZ is fixed to the body, its origin O in the plane of the upper hinges; the earth frame's origin lies
//! below O at home. Both have X forward, Y up, Z right. Lengths are in metres, angles in radians. Everything is
//! generic over `f32` and `f64`, needs no heap and never panics on numbers.

pub mod convention;
pub mod geometry;
pub mod inverse;
pub mod jacobian;
pub mod pose;
pub mod presets;

pub use convention::{Angles, Convention};
pub use geometry::{Geometry, GeometryError};
pub use inverse::{displacements, inverse};
pub use jacobian::jacobian;
pub use pose::Pose;
