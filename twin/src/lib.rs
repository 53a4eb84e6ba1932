//! The twin: a six-degree-of-freedom motion base with its controller, its jacks and the sensors on its cockpit, simulated
//! so that a sensor board can be calibrated on it and the result compared with a truth that the board never sees.
//!
//! The modules, in the order in which cause becomes voltage:
//!
//! | module | contents |
//! |---|---|
//! | [`geometry`] | hinges, stroke and home from a geometry file |
//! | [`program`] | the jack program that an operator loads |
//! | [`controller`], [`limits`] | check the program, start it late, run it on their own clock |
//! | [`jack`] | six servos that follow softly, late, and with friction |
//! | [`vibration`] | the structure, which rings while it moves |
//! | [`mechanism`] | jacks → pose, velocity, acceleration of the platform |
//! | [`motion`] | what sensors on the platform feel |
//! | [`sensor`], [`transducer`] | from that motion to volts |
//! | [`board`] | pins, converters, crystal, supply, hum |
//! | [`mod@bench`] | all of it together, step by step |
//! | [`serve`], [`control`], [`truth_log`] | the sockets, and the file for the comparison |
//! | [`truth`], [`papers`] | what a perfect calibration would find; what a laboratory knows before |
//! | [`sheet`], [`random`], [`algebra`] | data-sheet figures, random numbers, vectors |
//!
//! Everything is drawn from a seed. The twin takes the texts of the geometry presets from the `hexsense` crate and
//! nothing else: an error of sign there cannot cancel against the same error here.
//!
//! Axes are X forward, Y up, Z right; units are SI.
//!
//! ```
//! let (_, geometry_toml) = geometries::PRESETS[0];
//! let mut bench = twin::Bench::new(1, geometry_toml)?;
//! let mut rows = Vec::new();
//! bench.next_chunk(&mut rows, |motion| assert!(motion.felt.specific_force.0[1] > 9.7))?;
//! assert_eq!(rows.len(), 41 * twin::board::COLUMNS.len());
//! # Ok::<(), twin::bench::BenchError>(())
//! ```
#![forbid(unsafe_code)]

pub mod algebra;
pub mod bench;
pub mod board;
pub mod control;
pub mod controller;
pub mod geometry;
pub mod jack;
pub mod limits;
pub mod mechanism;
pub mod motion;
pub mod papers;
pub mod program;
pub mod random;
pub mod sensor;
pub mod serve;
pub mod sheet;
pub mod transducer;
pub mod truth;
pub mod truth_log;
pub mod vibration;

pub use bench::Bench;
pub use program::Program;
