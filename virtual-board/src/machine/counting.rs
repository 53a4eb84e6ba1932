//! Counts the instructions of a function or an exception handler, from its first instruction to its return.
//!
//! A call begins with the block at the function's first address. It ends with the first block at its return address
//! with the stack pointer of its entry, at the same depth of nested exceptions. A handler begins when its exception is
//! entered and ends with the exception's return. So calls by `b` and by `bl` are seen, but inlined calls are not.
//! Instructions of exceptions that come in between are counted apart: `instructions` is the call alone,
//! `with_interruptions` all instructions until it returned. Stacking and unstacking take no instructions.

use serde::Serialize;

use super::masking::{Masking, Named, Stretch};

/// The object of a count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// The function whose first instruction is at this address.
    Function(u32),
    /// The handler of the exception with this number (16 + n for interrupt n).
    Exception(usize),
}

/// Fewest and most instructions of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Range {
    /// Fewest.
    pub min: u64,
    /// Most.
    pub max: u64,
}

impl Range {
    const EMPTY: Self = Self {
        min: u64::MAX,
        max: 0,
    };

    fn take(&mut self, instructions: u64) {
        self.min = self.min.min(instructions);
        self.max = self.max.max(instructions);
    }
}

/// The calls of one target so far.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Count {
    /// Name as in the command line.
    pub name: String,
    /// Symbol of that name, or the name itself.
    pub symbol: String,
    /// Calls that have returned; while it is zero the ranges have no meaning.
    pub calls: u64,
    /// Of the call alone, functions that it called included.
    pub instructions: Range,
    /// Of the call and of every exception that came in between.
    pub with_interruptions: Range,
    /// Sum of the calls' own instructions.
    pub total: u64,
}

/// A call that has not returned.
#[derive(Debug)]
struct Call {
    index: usize,
    /// Return address and stack pointer of a function; none for a handler.
    back: Option<(u32, u32)>,
    depth: usize,
    began: u64,
    away_before: u64,
}

/// Counts the calls of some targets.
#[derive(Debug, Default)]
pub struct Counting {
    targets: Vec<Target>,
    counts: Vec<Count>,
    calls: Vec<Call>,
    /// Instructions so far.
    executed: u64,
    /// Instructions before the counts were last set to zero.
    executed_before: u64,
    /// When each active exception was entered.
    entered: Vec<u64>,
    /// Instructions of exceptions that interrupted each depth; depth 0 is thread mode.
    away: Vec<u64>,
    /// Stretches with masked interrupts.
    pub(super) masking: Masking,
}

impl Counting {
    /// Counts in a firmware with these functions, in the order of their addresses.
    pub fn new(functions: Vec<Named>) -> Self {
        Self {
            masking: Masking::new(functions),
            ..Self::default()
        }
    }

    /// The longest stretch with masked interrupts since counting was last begun.
    pub fn masked(&self) -> &Stretch {
        self.masking.longest()
    }

    /// Counts a target from now on.
    pub fn add(&mut self, target: Target, name: &str, symbol: &str) {
        self.targets.push(target);
        self.counts.push(Count {
            name: name.to_owned(),
            symbol: symbol.to_owned(),
            calls: 0,
            instructions: Range::EMPTY,
            with_interruptions: Range::EMPTY,
            total: 0,
        });
    }

    /// The counts, in the order in which they were asked for.
    pub fn counts(&self) -> &[Count] {
        &self.counts
    }

    /// Instructions since counting was last begun, of every function and handler.
    pub fn executed(&self) -> u64 {
        self.executed - self.executed_before
    }

    /// Sets the counts to zero; a call under way counts when it returns.
    pub fn begin(&mut self) {
        self.executed_before = self.executed;
        self.masking.begin();
        for count in &mut self.counts {
            (count.calls, count.total) = (0, 0);
            (count.instructions, count.with_interruptions) = (Range::EMPTY, Range::EMPTY);
        }
    }

    /// Whether stack pointer and link register matter for the block at `address`.
    pub(super) fn looks_at(&self, address: u32) -> bool {
        let returns = self
            .calls
            .last()
            .is_some_and(|call| call.back.is_some_and(|(to, _)| to == address));
        returns || self.targets.contains(&Target::Function(address))
    }

    /// A block that [`Self::looks_at`] begins.
    pub(super) fn arrive(&mut self, address: u32, stack: u32, link: u32) {
        let depth = self.entered.len();
        while let Some(call) = self
            .calls
            .pop_if(|call| call.depth == depth && call.back == Some((address, stack)))
        {
            self.close(&call);
        }
        let back = Some((link & !1, stack));
        for index in 0..self.targets.len() {
            // A loop back to the first instruction is not a call.
            let open = self
                .calls
                .iter()
                .any(|call| (call.index, call.depth, call.back) == (index, depth, back));
            if self.targets[index] == Target::Function(address) && !open {
                self.open(index, back);
            }
        }
    }

    /// A block runs.
    #[inline]
    pub(super) fn execute(&mut self, instructions: u32) {
        self.executed += u64::from(instructions);
    }

    /// An exception is entered.
    pub(super) fn enter(&mut self, exception: usize) {
        self.entered.push(self.executed);
        let found = self
            .targets
            .iter()
            .position(|target| *target == Target::Exception(exception));
        if let Some(index) = found {
            self.open(index, None);
        }
    }

    /// The exception that was entered last returns.
    pub(super) fn leave(&mut self) {
        let depth = self.entered.len();
        while let Some(call) = self.calls.pop_if(|call| call.depth == depth) {
            // A function that has not returned before its handler never returns.
            if call.back.is_none() {
                self.close(&call);
            }
        }
        if let Some(began) = self.entered.pop() {
            *self.away_at(depth - 1) += self.executed - began;
        }
    }

    /// The core restarts: no call returns any more.
    pub(super) fn reset(&mut self) {
        self.calls.clear();
        self.entered.clear();
        self.masking.reset();
    }

    fn away_at(&mut self, depth: usize) -> &mut u64 {
        if self.away.len() <= depth {
            self.away.resize(depth + 1, 0);
        }
        &mut self.away[depth]
    }

    fn open(&mut self, index: usize, back: Option<(u32, u32)>) {
        let depth = self.entered.len();
        let call = Call {
            index,
            back,
            depth,
            began: self.executed,
            away_before: *self.away_at(depth),
        };
        self.calls.push(call);
    }

    fn close(&mut self, call: &Call) {
        let all = self.executed - call.began;
        let own = all - (*self.away_at(call.depth) - call.away_before);
        let count = &mut self.counts[call.index];
        count.calls += 1;
        count.total += own;
        count.instructions.take(own);
        count.with_interruptions.take(all);
    }
}
