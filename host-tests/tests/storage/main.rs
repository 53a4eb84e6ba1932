//! The storage of the coefficients: only who has the key changes anything, every change is whole and in the log, and a
//! loss of power at any operation leaves what was before or what was to be.

mod authority;
mod changes;
mod key_holder;
mod log;
mod power_cuts;
