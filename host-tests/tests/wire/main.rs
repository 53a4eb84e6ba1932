//! The link: what one side says, the other side reads, or notices that it cannot.

mod capacity;
mod frames;
mod hostile;
mod messages;
mod round_trip;
mod samples;
mod snapshot;
