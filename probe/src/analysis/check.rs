//! A check of a campaign: what is judged, how it came out, and whom it accuses. [`crate::checks`] makes them.

use hexsense_core::channel::{INERTIAL, NAMES};
use serde::{Deserialize, Serialize};

/// How a check came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// Within the limit.
    #[serde(rename = "pass")]
    Pass,
    /// Beyond the limit.
    #[serde(rename = "fail")]
    Fail,
    /// The campaign holds nothing to judge by.
    #[serde(rename = "not observable")]
    NotObservable,
}

impl Verdict {
    /// The verdict in words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::NotObservable => "not observable",
        }
    }
}

/// One check of a campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// What is checked.
    pub name: String,
    /// How it came out.
    pub verdict: Verdict,
    /// The figure that is judged: the one that comes closest to its limit, or goes farthest beyond.
    pub statistic: Option<f64>,
    /// Its limit; larger figures fail.
    pub limit: Option<f64>,
    /// Unit of both.
    pub unit: String,
    /// The jacks and channels beyond the limit, the worst first; in a check that passes, the one that comes closest.
    pub names: Vec<String>,
    /// What the outcome means, and for a failure what to do; the likeliest cause first.
    pub means: String,
    /// Why somebody accepts this failure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accepted: Option<String>,
}

impl Check {
    /// Whether it fails and nobody accepts that.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.verdict == Verdict::Fail && self.accepted.is_none()
    }

    /// The figure that is judged, and its limit, as people read them.
    #[must_use]
    pub fn figures(&self) -> [String; 2] {
        [self.statistic, self.limit]
            .map(|value| value.map_or("–".to_owned(), |value| format!("{value:.2e}")))
    }
}

/// A figure of one jack or channel, and its limit.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Its name.
    pub name: String,
    /// The figure.
    pub value: f64,
    /// Its limit; larger figures fail.
    pub limit: f64,
}

impl Figure {
    /// Over one beyond the limit. A figure that is no number is beyond it.
    #[must_use]
    pub fn share(&self) -> f64 {
        let share = self.value / self.limit;
        if share.is_nan() { f64::INFINITY } else { share }
    }
}

/// A check of several jacks or channels: it fails when one of them is beyond its limit. `means` gets the names that are.
#[must_use]
pub fn judge(
    name: &str,
    unit: &str,
    mut figures: Vec<Figure>,
    passes: &str,
    means: impl FnOnce(&[String]) -> String,
) -> Check {
    figures.sort_by(|a, b| b.share().total_cmp(&a.share()));
    let Some(worst) = figures.first().cloned() else {
        return Check {
            name: name.to_owned(),
            verdict: Verdict::NotObservable,
            statistic: None,
            limit: None,
            unit: unit.to_owned(),
            names: Vec::new(),
            means: "the recordings hold nothing to judge this by".to_owned(),
            accepted: None,
        };
    };
    let mut beyond: Vec<String> = Vec::new();
    for figure in figures.iter().filter(|figure| figure.share() > 1.0) {
        if !beyond.contains(&figure.name) {
            beyond.push(figure.name.clone());
        }
    }
    let (verdict, means, names) = if beyond.is_empty() {
        (Verdict::Pass, passes.to_owned(), vec![worst.name])
    } else {
        (Verdict::Fail, means(&beyond), beyond)
    };
    Check {
        name: name.to_owned(),
        verdict,
        statistic: Some(worst.value),
        limit: Some(worst.limit),
        unit: unit.to_owned(),
        names,
        means,
        accepted: None,
    }
}

/// Name of a jack, 0 to 5.
#[must_use]
pub fn jack_name(jack: usize) -> String {
    NAMES[INERTIAL + jack].to_owned()
}
