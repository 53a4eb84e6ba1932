//! The host tool of hexsense: it plans the movements of a motion base, records them through the board, and keeps
//! coefficients, files and reports.
//!
//! | room | what happens there |
//! |---|---|
//! | [`geometry_file`], [`sensor_file`] | what is known of the base and the sensors before anything moves |
//! | [`capture`] | the recorded scans of one run, as CSV |
//! | [`files`] | reading and replacing files, with errors that say where |

pub mod analysis;
pub mod campaign;
pub mod capture;
pub mod coefficient_file;
pub mod files;
pub mod geometry_file;
pub mod link;
pub mod motion;
pub mod plan;
pub mod record;
pub mod sensor_file;
