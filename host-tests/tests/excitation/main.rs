//! Program signals: their shape, and the pose that they give the base.

mod multisine;
mod programs;
mod signals;
