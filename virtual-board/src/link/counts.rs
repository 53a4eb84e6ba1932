//! The counts of instructions on stdout.

use crate::machine::Machine;

/// Prints the counts of instructions, if any were asked for, as one line of JSON.
pub fn print_counts(machine: &Machine) {
    if let Some(counts) = machine.counts() {
        println!(
            "{}",
            serde_json::json!({
                "executed": machine.executed(),
                "counts": counts,
                "triggers": machine.bus().triggers.runs(),
            })
        );
    }
}
