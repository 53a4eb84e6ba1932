//! `cargo xtask timing`: instructions of the sample path, counted on the firmware's own ELF on the virtual board.
//!
//! The board is driven through its link as a host drives it: it streams and solves poses at every rate, while its pins get
//! random, saturated, alternating and no voltages, drives of random frequency begin and coefficients are uploaded. The
//! firmware has no function that makes the sums of nine channels without their calibrated values; these sums are counted
//! in the program of [`crate::sample_path`], with input of the same kinds.
//!
//! A function that takes one number of instructions for one input and another for the next is refused, and so is one that
//! exceeds its budget. What the numbers mean is in docs/timing.md.
//!
//! The board is asked in `sessions`.

mod sessions;

use std::collections::BTreeMap;

use anyhow::{Context, ensure};
use hexsense::CORE_HZ;
use hexsense_core::channel::{CHANNELS, INERTIAL};
use serde::Serialize;

use self::sessions::{Session, Sessions};
use crate::counts::Counts;
use crate::figures::Figures;
use crate::folders;
use crate::pins::Pins;
use crate::power::Power;
use crate::programs::Program;
use crate::sample_path;

/// Nine channels and the analysers, from the filled half of a ring to values and sums.
const PATH: &str = "hexsense_core::sample_path::sample_inertial";
/// The same with the jacks, and the counts handed over to the link.
const PATH_WITH_JACKS: &str = "sample_path";
/// Interrupt of the converters' DMA, in which all of it happens: DMA1 channel 1.
const INTERRUPT: &str = "irq:11";
const POSE: &str = "solve_pose";
/// Harmonics of one channel at report time, once the window has been gone through.
const FIT: &str = "solve_harmonics";
/// A block of the window that is gone through.
const REPLAY: &str = "hexsense_core::harmonics::replay::Replay::add";
const SUMS: &str = "sums_16";

/// Scans of a block.
const BLOCK: u64 = 16;
/// Rates, Hz, and blocks that are streamed at each.
const LOADS: [(u32, u64); 3] = [(1_000, 200), (2_000, 400), (4_000, 800)];
/// Blocks with pins of every kind.
const BLOCKS: u64 = 10_000;

/// Most instructions for a block of sixteen scans: nine channels calibrated and summed, their sums alone, and the whole
/// interrupt with the jacks.
const PATH_BUDGET: u64 = 2_420;
const SUMS_BUDGET: u64 = 1_016;
const INTERRUPT_BUDGET: u64 = 3_707;
/// Most instructions of a pose that is found from the last one.
const POSE_BUDGET: u64 = 7_000;
/// Most of the processor's time at the fastest rate, %.
const LOAD_BUDGET: f64 = 15.0;
/// Most cycles for which interrupts may be masked: 20 µs, so that the sample interrupt comes before the next scan has its
/// first result.
const MASKED_BUDGET: u64 = 3_000;

/// Instructions of each block.
#[derive(Debug, Clone, Copy, Serialize)]
struct Span {
    instructions_per_block_min: u64,
    instructions_per_block_max: u64,
    per_sample: f64,
}

#[derive(Debug, Serialize)]
struct Pose {
    instructions_min: u64,
    instructions_max: u64,
    poses: u64,
}

/// What the board solves at report time, in thread mode: soft `f64`, whose instructions depend on the data.
#[derive(Debug, Serialize)]
struct Fit {
    /// One channel, when the window has been gone through.
    channel_instructions_max: u64,
    /// A block of the window, once for all channels.
    block_instructions_max: u64,
}

/// The longest stretch for which code below the sample interrupt masked it.
#[derive(Debug, Serialize)]
struct Masked {
    cycles_max: u64,
    budget: u64,
    /// The function in which it began.
    #[serde(rename = "where")]
    function: String,
}

/// What was counted.
#[derive(Debug, Serialize)]
pub struct Timing {
    block: u64,
    channels: usize,
    path: Span,
    sums: Span,
    interrupt: Span,
    blocks: u64,
    /// Share of the core's time at 150 MHz if every instruction took one cycle, by rate in Hz.
    load_percent: BTreeMap<u32, f64>,
    /// The path with the jacks' sums and all counts handed over to the link.
    path_with_jacks: Span,
    channels_with_jacks: usize,
    pose: Pose,
    fit: Fit,
    masked: Masked,
}

/// Counts.
pub fn measure() -> anyhow::Result<Timing> {
    let sums = sums()?;
    let pins = Pins::start()?;
    let power = Power {
        pins: Some(pins.address()),
        count: &[PATH, PATH_WITH_JACKS, INTERRUPT, POSE, FIT, REPLAY],
        ..Power::default()
    };
    let board = power.on(Program::Firmware, &folders::emptied("timing")?)?;
    let mut sessions = Sessions::new(board)?;
    let mut load_percent = BTreeMap::new();
    let mut all = Vec::new();
    for (rate_hz, blocks) in LOADS {
        let session = sessions.run(rate_hz, blocks)?;
        let instructions = session.counts.executed as f64;
        let percent = 100.0 * instructions / (session.lasted_s * f64::from(CORE_HZ));
        load_percent.insert(rate_hz, (100.0 * percent).round() / 100.0);
        all.push(session);
    }
    let pose = pose(&all)?;
    pins.set_moves(false);
    all.push(sessions.run(LOADS[2].0, BLOCKS)?);
    let fits = sessions.fits()?;
    sessions.floods()?;
    Ok(Timing {
        block: BLOCK,
        channels: INERTIAL,
        path: span(&all, PATH)?,
        sums,
        interrupt: span(&all, INTERRUPT)?,
        blocks: calls(&all, PATH),
        load_percent,
        path_with_jacks: span(&all, PATH_WITH_JACKS)?,
        channels_with_jacks: CHANNELS,
        pose,
        fit: Fit {
            channel_instructions_max: most(&fits, FIT)?,
            block_instructions_max: most(&fits, REPLAY)?,
        },
        masked: Masked {
            cycles_max: sessions.masked.cycles,
            budget: MASKED_BUDGET,
            function: sessions.masked.function,
        },
    })
}

/// The sums of nine channels alone.
fn sums() -> anyhow::Result<Span> {
    let (counts, _) = sample_path::run(&[SUMS], "amplitude hexsense")?;
    Span::of([&counts], SUMS)
}

fn span(sessions: &[Session], name: &str) -> anyhow::Result<Span> {
    Span::of(sessions.iter().map(|session| &session.counts), name)
}

fn most(counts: &Counts, name: &str) -> anyhow::Result<u64> {
    let most = counts.of(name).map(|count| count.instructions.max).max();
    most.with_context(|| format!("{name} was never called"))
}

fn calls(sessions: &[Session], name: &str) -> u64 {
    let counts = sessions.iter().flat_map(|session| session.counts.of(name));
    counts.map(|count| count.calls).sum()
}

fn pose(sessions: &[Session]) -> anyhow::Result<Pose> {
    let span = span(sessions, POSE)?;
    Ok(Pose {
        instructions_min: span.instructions_per_block_min,
        instructions_max: span.instructions_per_block_max,
        poses: calls(sessions, POSE),
    })
}

impl Span {
    /// Fewest and most over all of `counts`.
    fn of<'a>(counts: impl IntoIterator<Item = &'a Counts>, name: &str) -> anyhow::Result<Self> {
        let found: Vec<_> = counts
            .into_iter()
            .flat_map(|counts| counts.of(name))
            .filter(|count| count.calls > 0)
            .map(|count| count.instructions)
            .collect();
        let min = found.iter().map(|range| range.min).min();
        let max = found.iter().map(|range| range.max).max();
        let max = max.with_context(|| format!("{name} was never called"))?;
        Ok(Self {
            instructions_per_block_min: min.unwrap_or(max),
            instructions_per_block_max: max,
            per_sample: max as f64 / BLOCK as f64,
        })
    }

    fn check(&self, name: &str, budget: u64) -> anyhow::Result<()> {
        let (min, max) = (
            self.instructions_per_block_min,
            self.instructions_per_block_max,
        );
        ensure!(
            min == max,
            "{name}: {min} to {max} instructions a block: its time depends on data"
        );
        ensure!(
            max <= budget,
            "{name}: {max} instructions a block of {BLOCK}, the budget is {budget}"
        );
        Ok(())
    }
}

impl Figures for Timing {
    fn check(&self) -> anyhow::Result<()> {
        self.path.check("path", PATH_BUDGET)?;
        self.sums.check("sums", SUMS_BUDGET)?;
        self.path_with_jacks
            .check("path with jacks", INTERRUPT_BUDGET)?;
        self.interrupt.check("interrupt", INTERRUPT_BUDGET)?;
        ensure!(
            self.blocks >= BLOCKS,
            "{} blocks were counted, expected {BLOCKS}",
            self.blocks
        );
        ensure!(
            self.pose.instructions_max <= POSE_BUDGET,
            "a pose took {} instructions, the budget is {POSE_BUDGET}",
            self.pose.instructions_max
        );
        let Masked {
            cycles_max,
            function,
            ..
        } = &self.masked;
        ensure!(
            (1..=MASKED_BUDGET).contains(cycles_max),
            "{function} masks interrupts for {cycles_max} cycles, the budget is {MASKED_BUDGET}: copy out what you need, \
             and work on the copy"
        );
        for (rate_hz, percent) in &self.load_percent {
            ensure!(
                *percent <= LOAD_BUDGET,
                "at {rate_hz} Hz the firmware takes {percent} % of the core, the budget is {LOAD_BUDGET} %"
            );
        }
        Ok(())
    }

    fn print_table(&self) {
        println!(
            "instructions on the Cortex-M4, blocks of {}, {} blocks",
            self.block, self.blocks
        );
        let rows = [
            ("path, nine channels", self.path),
            ("its sums alone", self.sums),
            ("path, fifteen channels", self.path_with_jacks),
            ("interrupt", self.interrupt),
        ];
        for (name, span) in rows {
            println!(
                "{name:<24} {:>6} to {:>6} a block, {:>6.1} a sample",
                span.instructions_per_block_min, span.instructions_per_block_max, span.per_sample
            );
        }
        println!(
            "{:<24} {:>6} to {:>6} a pose, {} poses",
            "pose", self.pose.instructions_min, self.pose.instructions_max, self.pose.poses
        );
        println!(
            "{:<24} {:>6} a channel, and {} a block of the window once for all channels, at most",
            "harmonics, solved", self.fit.channel_instructions_max, self.fit.block_instructions_max
        );
        println!(
            "{:<24} {:>6} cycles at most, in {}",
            "interrupts masked", self.masked.cycles_max, self.masked.function
        );
        for (rate_hz, percent) in &self.load_percent {
            println!("core at {rate_hz} Hz: {percent:.2} %");
        }
    }
}
