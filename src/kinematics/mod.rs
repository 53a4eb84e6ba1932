//! Kinematics of the motion base: jack lengths from a pose and a pose from jack lengths.

pub mod presets;
