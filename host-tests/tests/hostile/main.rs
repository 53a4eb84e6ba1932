//! No input makes the board fail: the kept findings of fuzzers, random bytes, and refusals by name.
//!
//! `cargo xtask fuzz` looks further, with the same targets.

mod corpus;
mod refusals;
