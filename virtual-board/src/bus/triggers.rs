//! The instants at which a timer triggered the converters. No program on the chip can see them, and every sample
//! depends on them.

use serde::Serialize;

use crate::peripherals::Cycles;

/// Triggers from one start of the timer to its stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct TriggerRun {
    /// True time of the first trigger, ns.
    pub first_ns: u64,
    /// Number of triggers.
    pub count: u64,
    /// Shortest interval, core cycles; meaningless with fewer than two triggers.
    pub min_cycles: Cycles,
    /// Longest interval, core cycles.
    pub max_cycles: Cycles,
    #[serde(skip)]
    last: Cycles,
    #[serde(skip)]
    start: u32,
}

/// All runs of triggers since power-on.
#[derive(Debug, Default)]
pub struct Triggers {
    runs: Vec<TriggerRun>,
}

impl Triggers {
    /// A trigger at cycle `now`, at `now_s` of true time, by a timer that was started `start` times.
    pub fn note(&mut self, now: Cycles, now_s: f64, start: u32) {
        if let Some(run) = self.runs.last_mut().filter(|run| run.start == start) {
            let interval = now.wrapping_sub(run.last);
            run.count += 1;
            run.last = now;
            run.min_cycles = run.min_cycles.min(interval);
            run.max_cycles = run.max_cycles.max(interval);
            return;
        }
        self.runs.push(TriggerRun {
            first_ns: (now_s * 1e9).round() as u64,
            count: 1,
            min_cycles: Cycles::MAX,
            max_cycles: 0,
            last: now,
            start,
        });
    }

    /// The runs, oldest first.
    pub fn runs(&self) -> &[TriggerRun] {
        &self.runs
    }
}
