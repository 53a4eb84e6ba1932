//! Simulates campaigns and prints whether their uncertainties are honest, as one JSON document;
//! `cargo xtask coverage` builds and runs it.
//!
//! `coverage CAMPAIGNS FIRST_SEED`

use std::sync::atomic::{AtomicU64, Ordering};

use host_tests::coverage::coverage;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut numbers = std::env::args().skip(1);
    let mut number = || numbers.next().ok_or("usage: coverage CAMPAIGNS FIRST_SEED");
    let (campaigns, first_seed) = (number()?.parse()?, number()?.parse()?);
    let done = AtomicU64::new(0);
    let figures = coverage(campaigns, first_seed, || {
        let count = done.fetch_add(1, Ordering::Relaxed) + 1;
        if count.is_multiple_of(50) {
            eprintln!("{count} of {campaigns} campaigns");
        }
    });
    println!("{}", serde_json::to_string(&figures)?);
    Ok(())
}
