//! The coefficient record and the archive: a set is whole or refused, and a power cut leaves the old or the new one.

mod appends;
mod archive;
mod build;
mod limits;
mod power_cuts;
mod record;
mod sets;
