//! A whole calibration on the virtual bench.
//!
//! The real firmware starts on the virtual board and gets its key. The twin is driven along the movements of the method. The
//! coefficients are uploaded, the power is cut and comes back, and a movement that no coefficient was fitted to judges them.
//!
//! - `arguments`: what is asked for.
//! - `story`: the programs and their order; every step is a command that a user types.
//! - `alignment`: where a capture lies in the twin's time.
//! - `judgement`: the only place where estimate and truth meet.
//! - `document`: what is printed, as JSON or as tables.

mod alignment;
mod arguments;
mod document;
mod judgement;
mod story;

use std::time::Instant;

pub use arguments::Arguments;

/// Runs the demo and prints its result.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let start = Instant::now();
    let folder = arguments.folder()?;
    let told = story::tell(arguments, &folder)?;
    let judged = judgement::judge(&told)?;
    let document = document::Document::new(arguments, &told, judged, start.elapsed())?;
    document.save(&folder)?;
    if arguments.json {
        println!("{}", serde_json::to_string(&document)?);
    } else {
        println!("{}", document.table());
        println!(
            "Captures, coefficients and report: {}",
            told.campaign.join("report.html").display()
        );
    }
    anyhow::ensure!(
        document.holds(),
        "the demo's result does not hold; see above"
    );
    Ok(())
}
