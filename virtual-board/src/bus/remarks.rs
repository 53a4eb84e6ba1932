//! Remarks on actions of the firmware that the model does not support: each is written to stderr once.

use std::collections::HashSet;

/// The remarks made so far.
#[derive(Debug, Default)]
pub struct Remarks {
    made: HashSet<(u32, bool, &'static str)>,
}

impl Remarks {
    /// Remarks on an access to `address` by the code at `pc`, once for each access and reason.
    pub fn access(
        &mut self,
        now_s: f64,
        pc: u32,
        address: u32,
        write: Option<u32>,
        what: &str,
        why: &'static str,
    ) {
        if !self.made.insert((address, write.is_some(), why)) {
            return;
        }
        let access = match write {
            Some(value) => format!("write of {value:#010x} to"),
            None => "read of".to_owned(),
        };
        eprintln!(
            "[{now_s:12.6}] board: {access} {what} ({address:#010x}) near PC {pc:#010x}: {why}"
        );
    }

    /// Remarks on the state of the chip, once per text.
    pub fn state(&mut self, now_s: f64, why: &'static str, detail: &str) {
        if self.made.insert((0, false, why)) {
            eprintln!("[{now_s:12.6}] board: {why}: {detail}");
        }
    }
}
