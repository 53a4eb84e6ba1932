//! The link: each side reads the messages of the other, or detects that it cannot.

mod capacity;
mod frames;
mod hostile;
mod messages;
mod round_trip;
mod samples;
mod snapshot;
