//! Amplitude and phase at the drive frequency, against independent least squares, published errors and theory.

mod accuracy;
mod board;
mod choice;
mod frequency;
mod limits;
mod reference;
mod scatter;
mod series;
mod table;
