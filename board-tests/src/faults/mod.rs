//! The fault campaign: for each promise of docs/guarantees.md, faults that could break it are injected into the firmware's
//! ELF on the virtual board.
//!
//! | promise | what is injected |
//! |---|---|
//! | `power_cut` | power cuts, at every flash operation of every change |
//! | `no_loss` | changes of the coefficients while everything streams at 4 kHz |
//! | `counted` | overruns, stalls, noise, lost characters, overload, bit errors, resets: each must be counted, and `captures` must show the gaps |
//! | `hostile` | requests and bytes that no correct host sends, singly and in floods |
//! | `recovery` | resets, hangs, tasks that are never woken again, jumps into nothing, stack overflows; flipped bits of the coefficients in RAM (`flips`); and the `soak`, an hour of faults of all kinds |
//! | `authority` | changes without the right tag |
//! | `audit` | the log after every one of the power cuts |
//! | `uptime` | the clock and the scan counter preset to years ahead and to just before each wrap, and full counts |
//! | `option_bytes` | each kind of change, on chips whose option bytes forbid or allow it |
//! | `clock` | failures of the crystal, at many moments, with a PLL that drifts to any fraction |
//! | `supply` | wrong readings of the reference, one, some, and for ever |
//! | `random` | a generator of random numbers that fails, for ever and while key and coefficients come |
//! | `key` | damaged key pages, power cuts in a replacement of the key, changes that are held back, boards that say they have no key |
//! | `host` | boards that lie to the host tool, hostile files, outputs that are not there |
//! | `log` | levels of the log, altered entries, forged exports, a flash of something else |
//!
//! `gaps` tells what is missing from a stream, `outcome` is the account of a promise.

mod authority;
mod captures;
mod clock;
mod counted;
mod flips;
mod gaps;
mod host;
mod hostile;
mod key;
mod log;
mod no_loss;
mod option_bytes;
mod outcome;
mod power_cut;
mod random;
mod recovery;
mod soak;
mod supply;
mod uptime;

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use anyhow::ensure;

use self::outcome::Outcome;
use self::power_cut::Extent;

/// `cargo xtask faults`
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Print one line of JSON for each promise
    #[arg(long)]
    json: bool,
    /// Seed of everything that is drawn
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The short form, which is a part of `cargo xtask test`
    #[arg(long)]
    short: bool,
    /// Try this promise only
    #[arg(long, value_name = "PROMISE")]
    only: Option<String>,
}

/// The promises, in the order in which they are printed.
const PROMISES: [&str; 15] = [
    "power_cut",
    "no_loss",
    "counted",
    "hostile",
    "recovery",
    "authority",
    "audit",
    "uptime",
    "option_bytes",
    "clock",
    "supply",
    "random",
    "key",
    "host",
    "log",
];
/// Trials that run at the same time.
const AT_ONCE: usize = 2;

/// Runs the campaign.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
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
    let outcomes = carry_out(trials);
    if !arguments.json {
        println!("promise      injected  minimum   lost");
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
    key_every: usize,
    key_faults: u64,
    altered: u64,
    soak_s: u64,
    /// One wrap in so many is passed.
    wraps: usize,
    options_every: usize,
    crystal: clock::Extent,
    masks: usize,
    every_supply: usize,
    generators: u64,
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
        key_every: 1,
        key_faults: 80,
        altered: 60,
        soak_s: 3_600,
        wraps: 1,
        options_every: 1,
        crystal: clock::Extent {
            starting: 30,
            streaming: 40,
            writing: 20,
        },
        masks: 4,
        every_supply: 1,
        generators: 4,
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
        key_every: 5,
        key_faults: 30,
        altered: 6,
        soak_s: 40,
        wraps: 7,
        options_every: 7,
        crystal: clock::Extent {
            starting: 5,
            streaming: 7,
            writing: 3,
        },
        masks: 1,
        every_supply: 5,
        generators: 1,
    };
}

type Tried = anyhow::Result<Vec<Outcome>>;

/// One piece of work that does not depend on another.
struct Trial {
    promises: &'static [&'static str],
    work: Box<dyn FnOnce() -> Tried + Send>,
}

impl Trial {
    /// Work that judges one promise.
    fn one(
        promise: &'static [&'static str; 1],
        work: impl FnOnce() -> anyhow::Result<Outcome> + Send + 'static,
    ) -> Self {
        Self {
            promises: promise,
            work: Box::new(move || Ok(vec![work()?])),
        }
    }
}

/// All trials, the longest first.
fn campaign(seed: u64, size: &'static Size) -> VecDeque<Trial> {
    let extent = Extent {
        uploads: size.uploads,
        every: size.every_operation,
        minimum: size.cuts,
    };
    let power_cut = Trial {
        promises: &["power_cut", "audit"],
        work: Box::new(move || power_cut::sweep(seed, &extent).map(Vec::from)),
    };
    VecDeque::from([
        Trial::one(&["recovery"], move || soak::soak(seed, size.soak_s)),
        power_cut,
        Trial::one(&["hostile"], move || hostile::attack(seed, size.flood_s)),
        Trial::one(&["recovery"], move || recovery::resets(seed, size.resets)),
        Trial::one(&["authority"], move || {
            authority::forge(seed, size.forgeries)
        }),
        Trial::one(&["key"], move || {
            key::guard(seed, size.key_every, size.key_faults)
        }),
        Trial::one(&["log"], move || log::attack(seed, size.altered)),
        Trial::one(&["counted"], move || counted::inject(seed, size.counts)),
        Trial::one(&["option_bytes"], move || {
            option_bytes::combine(seed, size.options_every)
        }),
        Trial::one(&["clock"], move || clock::fail(seed, &size.crystal)),
        Trial::one(&["counted"], move || captures::record(seed, size.counts)),
        Trial::one(&["uptime"], move || uptime::pass(seed, size.wraps)),
        Trial::one(&["recovery"], move || flips::flip(seed, size.masks)),
        Trial::one(&["supply"], move || {
            supply::disturb(seed, size.every_supply)
        }),
        Trial::one(&["random"], move || {
            random::break_down(seed, size.generators)
        }),
        Trial::one(&["host"], move || host::attack(size.flood_s)),
        Trial::one(&["no_loss"], move || {
            no_loss::stream_through(seed, size.changes)
        }),
    ])
}

/// Carries trials out, two at a time, and adds up their outcomes for each promise.
fn carry_out(trials: VecDeque<Trial>) -> Vec<Outcome> {
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
                    let outcomes = try_out(trial);
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

/// The outcomes of a trial; a trial that breaks off has broken its promises.
fn try_out(trial: Trial) -> Vec<Outcome> {
    (trial.work)().unwrap_or_else(|error| {
        let broken = |promise: &&'static str| {
            let mut outcome = Outcome::new(promise, 1);
            outcome.lose(1, || format!("the trial broke off: {error:#}"));
            outcome
        };
        trial.promises.iter().map(broken).collect()
    })
}
