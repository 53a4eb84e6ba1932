//! The longest stretch for which the core masked interrupts.
//!
//! A stretch begins with the first block that runs at a priority which PRIMASK, BASEPRI or FAULTMASK raises above that of
//! the active exceptions. It ends with the first block at which nothing raises it any more. In a handler of the highest
//! priority a mask raises nothing and keeps nothing waiting, so that is no stretch. The cycles include those in which the
//! core waits for the flash.

use serde::Serialize;

use crate::peripherals::Cycles;

/// A function: where its code begins, and its name.
pub type Named = (u32, String);

/// A stretch of code with masked interrupts.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Stretch {
    /// Its length, cycles of the core.
    pub cycles: Cycles,
    /// The function in which it begins, and the address, for `addr2line`.
    #[serde(rename = "where")]
    pub function: String,
}

/// Looks for the longest stretch.
#[derive(Debug, Default)]
pub struct Masking {
    /// All functions in the order of their addresses.
    functions: Vec<Named>,
    longest: Stretch,
    /// Begin of the stretch under way, and where it began.
    open: Option<(Cycles, u32)>,
    /// Whether the block that ran last may have changed a mask.
    pub(super) stale: bool,
}

impl Masking {
    /// Knows the firmware's functions, in the order of their addresses.
    pub fn new(functions: Vec<Named>) -> Self {
        Self {
            functions,
            ..Self::default()
        }
    }

    /// The longest stretch that has ended.
    pub fn longest(&self) -> &Stretch {
        &self.longest
    }

    /// Forgets the longest stretch; one that is under way counts when it ends.
    pub(super) fn begin(&mut self) {
        self.longest = Stretch::default();
    }

    /// The core restarts: no mask is set any more.
    pub(super) fn reset(&mut self) {
        (self.open, self.stale) = (None, false);
    }

    /// A block at `address` begins at `now`; a mask keeps interrupts waiting or not.
    pub(super) fn arrive(&mut self, masked: bool, address: u32, now: Cycles) {
        match (masked, self.open) {
            (true, None) => self.open = Some((now, address)),
            (false, Some((began, at))) => {
                self.open = None;
                if now - began > self.longest.cycles {
                    self.longest = Stretch {
                        cycles: now - began,
                        function: format!("{} at {at:#010x}", self.function_at(at)),
                    };
                }
            }
            _ => {}
        }
    }

    fn function_at(&self, address: u32) -> String {
        let after = self
            .functions
            .partition_point(|(begin, _)| *begin <= address);
        let found = after.checked_sub(1).map(|index| &self.functions[index].1);
        found.cloned().unwrap_or_default()
    }
}
