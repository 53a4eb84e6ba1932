//! Measures the accuracy of the board's estimator and prints it as one JSON document; `cargo xtask accuracy` builds and
//! runs it.
//!
//! `accuracy MAX_SCANS`

use host_tests::accuracy::{cases, measure};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let most = std::env::args().nth(1).ok_or("usage: accuracy MAX_SCANS")?;
    println!(
        "{}",
        serde_json::to_string(&measure(&cases(most.parse()?)))?
    );
    Ok(())
}
