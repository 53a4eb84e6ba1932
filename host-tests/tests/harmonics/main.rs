//! Amplitude and phase at the drive frequency, against independent least squares, published errors and theory.

mod board;
mod frequency;
mod limits;
mod reference;
mod scatter;
mod series;
mod table;
