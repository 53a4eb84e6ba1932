//! Figures and the numbers in them, as the report and the plan show them.
//!
//! - [`drawing`]: a figure as SVG: panels with axes, and what is drawn into them.
//! - [`pair`]: two panels over one time.
//! - [`scale`]: the scale of one axis.
//! - [`curve`]: long recordings made short enough to draw.
//! - [`path`]: curves as SVG paths.
//! - [`markup`]: text that cannot become markup.
//! - [`number`]: no more digits than the uncertainty allows.

pub mod curve;
pub mod drawing;
pub mod markup;
pub mod number;
pub mod pair;
pub mod path;
pub mod scale;
