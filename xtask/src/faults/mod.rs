//! The fault campaign: each promise of docs/guarantees.md against the faults that could break it, on the firmware's ELF
//! on the virtual board.
//!
//! | promise | what is injected |
//! |---|---|
//! | [`power_cut`] | the end of the power, at every flash operation of every change |
//! | [`no_loss`] | changes of the coefficients while everything streams at 4 kHz |
//! | [`counted`] | overruns, stalls, noise, lost characters, overload, bit errors, resets: each must be counted, and [`captures`] must show the gaps |
//! | [`hostile`] | everything on the line that no host would send, singly and in floods |
//! | [`recovery`] | resets, hangs, jumps into nothing, stack overflows; and the [`soak`], an hour of all of it |
//! | [`authority`] | changes without the right tag |
//! | `audit` | the log after every one of the power cuts |
//!
//! [`bench`] is the board and its flash memory, [`line`] the serial line to it, [`key_holder`] who changes its coefficients,
//! [`gaps`] what is missing from a stream, [`outcome`] the account of a promise.

mod authority;
mod bench;
mod captures;
mod counted;
mod gaps;
mod hostile;
mod key_holder;
mod line;
mod no_loss;
mod outcome;
mod power_cut;
mod recovery;
mod soak;

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use anyhow::ensure;

use self::outcome::Outcome;
use self::power_cut::Extent;
use crate::build::{self, Parts};

#[derive(clap::Args)]
pub struct Arguments {
    /// Print one line of JSON for each promise
    #[arg(long)]
    json: bool,
    /// Seed of everything that is drawn
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The short form, as it is a part of `cargo xtask test`
    #[arg(long)]
    short: bool,
    /// Try this promise only
    #[arg(long, value_name = "PROMISE")]
    only: Option<String>,
}

/// The promises, in the order in which they are printed.
const PROMISES: [&str; 7] = [
    "power_cut",
    "no_loss",
    "counted",
    "hostile",
    "recovery",
    "authority",
    "audit",
];
/// Trials that run at the same time.
const AT_ONCE: usize = 2;

/// Runs the campaign; fails when anything was lost or too little was tried.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let parts = build::everything()?;
    let start = Instant::now();
    let size = if arguments.short {
        &Size::SHORT
    } else {
        &Size::WHOLE
    };
    let mut trials = campaign(arguments.seed, size);
    if let Some(only) = &arguments.only {
        trials.retain(|trial| trial.promises.contains(&only.as_str()));
        ensure!(
            !trials.is_empty(),
            "there is no promise {only}; there are {PROMISES:?}"
        );
    }
    let outcomes = carry_out(&parts, trials);
    if !arguments.json {
        println!("promise    injected  minimum   lost");
    }
    for outcome in &outcomes {
        println!(
            "{}",
            if arguments.json {
                outcome.json().to_string()
            } else {
                outcome.row()
            }
        );
    }
    eprintln!("the campaign took {:.0} s", start.elapsed().as_secs_f64());
    judge(&outcomes)
}

/// The short form, for `cargo xtask test`.
pub fn check() -> anyhow::Result<()> {
    let outcomes = carry_out(&Parts::find()?, campaign(1, &Size::SHORT));
    for outcome in &outcomes {
        eprintln!("{}", outcome.row());
    }
    judge(&outcomes)
}

fn judge(outcomes: &[Outcome]) -> anyhow::Result<()> {
    let broken = outcomes.iter().filter(|outcome| !outcome.holds()).count();
    ensure!(broken == 0, "{broken} promises do not hold");
    Ok(())
}

/// How much is tried.
struct Size {
    uploads: usize,
    every_operation: u64,
    cuts: u64,
    changes: u64,
    counts: u32,
    flood_s: u64,
    resets: u64,
    forgeries: u64,
    soak_s: u64,
}

impl Size {
    const WHOLE: Self = Self {
        uploads: 10,
        every_operation: 1,
        cuts: 100,
        changes: 120,
        counts: 12,
        flood_s: 45,
        resets: 12,
        forgeries: 80,
        soak_s: 3_600,
    };
    const SHORT: Self = Self {
        uploads: 2,
        every_operation: 9,
        cuts: 50,
        changes: 20,
        counts: 2,
        flood_s: 2,
        resets: 1,
        forgeries: 5,
        soak_s: 40,
    };
}

type Tried = anyhow::Result<Vec<Outcome>>;

/// One piece of work that does not depend on another.
struct Trial {
    promises: &'static [&'static str],
    work: Box<dyn FnOnce(&Parts) -> Tried + Send>,
}

/// All trials, the longest first.
fn campaign(seed: u64, size: &'static Size) -> VecDeque<Trial> {
    fn one(outcome: anyhow::Result<Outcome>) -> Tried {
        outcome.map(|outcome| vec![outcome])
    }
    let trial = |promises, work: Box<dyn FnOnce(&Parts) -> Tried + Send>| Trial { promises, work };
    VecDeque::from([
        trial(
            &["recovery"],
            Box::new(move |parts| one(soak::soak(parts, seed, size.soak_s))),
        ),
        trial(
            &["power_cut", "audit"],
            Box::new(move |parts| {
                let extent = Extent {
                    uploads: size.uploads,
                    every: size.every_operation,
                    minimum: size.cuts,
                };
                power_cut::sweep(parts, seed, &extent).map(Vec::from)
            }),
        ),
        trial(
            &["hostile"],
            Box::new(move |parts| one(hostile::attack(parts, seed, size.flood_s))),
        ),
        trial(
            &["recovery"],
            Box::new(move |parts| one(recovery::resets(parts, seed, size.resets))),
        ),
        trial(
            &["authority"],
            Box::new(move |parts| one(authority::forge(parts, seed, size.forgeries))),
        ),
        trial(
            &["counted"],
            Box::new(move |parts| one(counted::inject(parts, seed, size.counts))),
        ),
        trial(
            &["counted"],
            Box::new(move |parts| one(captures::record(parts, seed, size.counts))),
        ),
        trial(
            &["no_loss"],
            Box::new(move |parts| one(no_loss::stream_through(parts, seed, size.changes))),
        ),
    ])
}

/// Carries trials out, two at a time, and adds up what they found about each promise.
fn carry_out(parts: &Parts, trials: VecDeque<Trial>) -> Vec<Outcome> {
    let names: Vec<&str> = trials
        .iter()
        .flat_map(|trial| trial.promises)
        .copied()
        .collect();
    let waiting = Mutex::new(trials);
    let found: Mutex<Vec<Outcome>> = Mutex::default();
    let next = || {
        let mut waiting = waiting.lock().unwrap_or_else(PoisonError::into_inner);
        waiting.pop_front()
    };
    std::thread::scope(|scope| {
        for _ in 0..AT_ONCE {
            scope.spawn(|| {
                while let Some(trial) = next() {
                    let outcomes = try_out(parts, trial);
                    outcomes
                        .iter()
                        .for_each(|outcome| eprintln!("{}", outcome.row()));
                    let mut found = found.lock().unwrap_or_else(PoisonError::into_inner);
                    found.extend(outcomes);
                }
            });
        }
    });
    let mut found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    let promises = PROMISES.iter().filter(|name| names.contains(name));
    promises
        .map(|name| Outcome::of(name, 0, &mut found))
        .collect()
}

/// What a trial found; one that breaks off has broken its promises.
fn try_out(parts: &Parts, trial: Trial) -> Vec<Outcome> {
    (trial.work)(parts).unwrap_or_else(|error| {
        let broken = |promise: &&'static str| {
            let mut outcome = Outcome::new(promise, 1);
            outcome.lose(1, || format!("the trial broke off: {error:#}"));
            outcome
        };
        trial.promises.iter().map(broken).collect()
    })
}
