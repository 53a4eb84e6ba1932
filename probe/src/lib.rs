//! The host tool of hexsense: it plans the movements of a motion base, records them through the board, and keeps
//! coefficients, files and reports.
//!
//! | room | what happens there |
//! |---|---|
//! | [`geometry_file`], [`sensor_file`] | what is known of base and sensors before anything moves |
//! | [`plan`] | the movements, as large as the base allows, and the refusal of unsafe ones |
//! | [`known_board`] | the board that is assumed where none can be asked |
//! | [`key_file`], [`fresh_key`] | the key without which nothing on the board can be changed, and a new one |
//! | [`log_file`] | a volume of the board's log that anybody with the key can check |
//! | [`motion`] | the drive of the base: a person at its controller, or the twin |
//! | [`record`] | from the board's stream to a [`capture`], run by run |
//! | [`campaign`] | the folder that all this is kept in |
//! | [`replay`] | the board's harmonic sums made again from a capture |
//! | [`analysis`] | from captures to coefficients with their uncertainties |
//! | [`characteristics`] | from captures to what the motion system does |
//! | [`evaluation`] | both, of a whole campaign |
//! | [`board_pose`] | the board's own poses compared with double precision |
//! | [`coefficient_file`] | a coefficient set that people can read |
//! | [`report`] | all of it on one page, for the reader who must trust the coefficients |
//! | [`board_events`] | what went wrong on the board, in words and in JSON |
//! | [`option_bytes`] | the option bytes of its chip, in words and in JSON |
//! | [`interrupt`] | Ctrl-C, which stops a recording in order |
//! | [`cli`] | the commands |
//! | [`date`] | dates as people read them |
//! | [`base_figure`] | the motion base with the numbers of its jacks |
//! | [`figure`] | figures and the numbers in them |
//! | [`templates`] | files to start from |
//! | [`terminal`] | what is printed, without control characters |
//! | [`columns`] | names and units of the columns of tables |
//! | [`files`] | reading and replacing files, with errors that say where |

#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod analysis;
pub mod base_figure;
pub mod board_events;
pub mod board_pose;
pub mod campaign;
pub mod capture;
pub mod characteristics;
pub mod checks;
pub mod cli;
pub mod coefficient_file;
pub mod columns;
pub mod date;
pub mod evaluation;
pub mod figure;
pub mod files;
pub mod fresh_key;
pub mod geometry_file;
pub mod interrupt;
pub mod key_file;
pub mod known_board;
pub mod log_file;
pub mod motion;
pub mod option_bytes;
pub mod plan;
pub mod record;
pub mod replay;
pub mod report;
pub mod sensor_file;
pub mod templates;
pub mod terminal;
