//! What a recording does, on the terminal: lines of text, and a bar for the run under way.

use hexsense_client::Client;
use indicatif::{ProgressBar, ProgressStyle};

use super::broken_off::of_sequence;
use crate::motion::Motion;
use crate::record::event::Event;
use crate::record::sequence::SequenceJob;
use crate::terminal::tell;

/// Records the runs of `job` and shows how it goes; `again` is the command that goes on after a failure.
///
/// # Errors
/// A run that broke off, with what is complete.
pub fn record(
    job: &SequenceJob,
    client: &mut Client,
    motion: &mut dyn Motion,
    again: &str,
) -> anyhow::Result<()> {
    let mut progress = Progress::default();
    let recorded = job.record(client, motion, &mut |event| progress.show(event));
    recorded.map_err(|error| of_sequence(error, job.campaign, again))
}

/// Shows the events of recordings.
#[derive(Default)]
pub struct Progress {
    bar: Option<ProgressBar>,
}

impl Progress {
    /// Shows one.
    pub fn show(&mut self, event: &Event) {
        if let Some(text) = event.text() {
            tell!("{text}");
        }
        match (event, &self.bar) {
            (Event::Begins { run, duration_s }, _) => self.bar = Some(bar(run, *duration_s)),
            (Event::Phase(phase), Some(bar)) => bar.set_message(*phase),
            (Event::Progress(done_s), Some(bar)) => bar.set_position((1e3 * done_s) as u64),
            (Event::Ends, Some(bar)) => bar.finish_and_clear(),
            _ => {}
        }
    }
}

/// A bar that shows the run's seconds; hidden when standard error is not a terminal.
fn bar(run: &str, duration_s: f64) -> ProgressBar {
    let style = ProgressStyle::with_template("{prefix:>12} [{bar:40}] {msg} {eta}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new((1e3 * duration_s) as u64)
        .with_style(style)
        .with_prefix(run.to_owned())
}
