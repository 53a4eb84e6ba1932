//! Kinematics against published platforms, automatic and numerical differentiation, and random poses by the thousand.

mod bases;
mod conventions;
mod differentiation;
mod failures;
mod home;
mod published;
mod random_poses;
mod single_precision;
mod tracking;
