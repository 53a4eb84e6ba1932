//! A volume of the board's log as a file: JSON, one line for each entry, with the board's signature.
//!
//! ```text
//! entries ──hash, hash, …──▶ head ──▶ mac = HMAC(key, … nonce, board, first, last, head, build)
//! ```
//!
//! Without the key the file shows that its entries belong together: none is altered, missing or put in unless all later
//! hashes were computed anew. With the key it also shows that the board signed them, or somebody else who has the key.

mod check;
mod file;
mod line;

pub use check::{flaws, volume_flaws};
pub use file::LogFile;
pub use line::{name, time};
