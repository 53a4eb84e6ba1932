//! The storage of the coefficients: only the key holder changes anything, every change is whole and in the log, and a
//! loss of power at any operation leaves the state before or after the change.

mod authority;
mod changes;
mod key_holder;
mod keys;
mod log;
mod power_cuts;
mod proofs;
mod read_only;
mod uploads;
