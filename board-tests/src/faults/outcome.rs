//! The account of a promise: how many faults were injected, and how much was lost.

use anyhow::bail;
use hexsense_core::wire::{Refusal, Request, Response};
use serde_json::{Map, Value, json};

use crate::line::Line;

/// Violations that are described; the others are only counted.
const TOLD: usize = 5;

/// The account of one promise.
#[derive(Debug)]
pub struct Outcome {
    promise: &'static str,
    minimum: u64,
    injected: u64,
    lost: u64,
    violations: Vec<String>,
    figures: Map<String, Value>,
}

impl Outcome {
    /// Nothing injected yet; at least `minimum` faults must be.
    pub fn new(promise: &'static str, minimum: u64) -> Self {
        Self {
            promise,
            minimum,
            injected: 0,
            lost: 0,
            violations: Vec::new(),
            figures: Map::new(),
        }
    }

    /// A fault was injected.
    pub fn inject(&mut self) {
        self.injected += 1;
    }

    /// So many faults were injected.
    pub fn inject_many(&mut self, count: u64) {
        self.injected += count;
    }

    /// Injects a request that must be refused for the right reason.
    pub fn refused(
        &mut self,
        line: &mut Line,
        request: &Request,
        right: impl Fn(Refusal) -> bool,
    ) -> anyhow::Result<()> {
        self.inject();
        match line.ask(request)? {
            Response::Refused(refusal) if right(refusal) => Ok(()),
            other => bail!("{request:?} was answered by {other:?}"),
        }
    }

    /// Counts a loss unless the promise `held`; `what` describes the violation.
    pub fn check(&mut self, held: bool, what: impl FnOnce() -> String) {
        self.lose(u64::from(!held), what);
    }

    /// Counts what was lost.
    pub fn lose(&mut self, count: u64, what: impl FnOnce() -> String) {
        if count > 0 && self.violations.len() < TOLD {
            self.violations.push(what());
        }
        self.lost += count;
    }

    /// A figure about the trials that is worth knowing.
    pub fn figure(&mut self, name: &str, value: impl Into<Value>) {
        self.figures.insert(name.to_owned(), value.into());
    }

    /// Counts a loss when the trial could not be carried out to its end.
    pub fn settle(&mut self, trial: anyhow::Result<()>) {
        if let Err(error) = trial {
            self.lose(1, || format!("{error:#}"));
        }
    }

    /// Takes all outcomes of a promise out of `found` and adds them up; `minimum` is added to the faults that must be injected.
    pub fn of(promise: &'static str, minimum: u64, found: &mut Vec<Self>) -> Self {
        let mut whole = Self::new(promise, minimum);
        for outcome in found.extract_if(.., |outcome| outcome.promise == promise) {
            whole.add(outcome);
        }
        whole
    }

    fn add(&mut self, other: Self) {
        self.minimum += other.minimum;
        self.injected += other.injected;
        self.lost += other.lost;
        self.violations.extend(other.violations);
        self.violations.truncate(TOLD);
        self.figures.extend(other.figures);
    }

    /// Whether nothing was lost and enough was tried.
    pub fn holds(&self) -> bool {
        self.lost == 0 && self.injected >= self.minimum
    }

    /// One line of JSON.
    pub fn json(&self) -> Value {
        let mut line = json!({
            "promise": self.promise,
            "injected": self.injected,
            "minimum": self.minimum,
            "lost": self.lost,
        });
        for (name, value) in &self.figures {
            line[name] = value.clone();
        }
        if !self.violations.is_empty() {
            line["violations"] = json!(self.violations);
        }
        line
    }

    /// The same as a row of the table, with its violations beneath.
    pub fn row(&self) -> String {
        let verdict = if self.holds() { "holds" } else { "BROKEN" };
        let mut row = format!(
            "{:<12} {:>8} {:>8} {:>6}  {verdict}",
            self.promise, self.injected, self.minimum, self.lost
        );
        for violation in &self.violations {
            row += &format!("\n             {violation}");
        }
        row
    }
}
