//! The file of faults and their times: one JSON object a line.
//!
//! ```text
//! # comment
//! {"at_s":2.5,"fault":"pin_reset"}
//! {"flash_operation":17,"progress":"half","fault":"power_cut"}
//! ```
//!
//! `at_s` is true time since power-on; `flash_operation` counts double words programmed and erasures begun since then,
//! from 1.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value};
use thiserror::Error;

use super::{Fault, Progress};
use crate::firmware::variables::Place;

/// Why a file is not a timeline.
#[derive(Debug, Error)]
pub enum TimelineError {
    /// It cannot be read.
    #[error("--faults {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A line of it is not a fault.
    #[error("--faults {path}, line {line}: {problem}")]
    Line {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong with it.
        problem: String,
    },
}

/// The faults that are still to come, in order.
#[derive(Debug, Default, PartialEq)]
pub struct Timeline {
    timed: VecDeque<(f64, Fault)>,
    by_operation: VecDeque<((u64, Progress), Fault)>,
}

impl Timeline {
    /// Reads a file.
    pub fn read(path: &Path) -> Result<Self, TimelineError> {
        let text = std::fs::read_to_string(path).map_err(|source| TimelineError::Io {
            path: path.to_owned(),
            source,
        })?;
        Self::parse(&text).map_err(|(line, problem)| TimelineError::Line {
            path: path.to_owned(),
            line,
            problem,
        })
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// The number of the line, from 1, and what is wrong with it.
    pub fn parse(text: &str) -> Result<Self, (usize, String)> {
        let mut timeline = Self::default();
        for (index, line) in text.lines().enumerate() {
            if !line.trim().is_empty() && !line.starts_with('#') {
                timeline.add(line).map_err(|problem| (index + 1, problem))?;
            }
        }
        let timed = timeline.timed.make_contiguous();
        timed.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        let by_operation = timeline.by_operation.make_contiguous();
        by_operation.sort_by_key(|(when, _)| *when);
        Ok(timeline)
    }

    /// Finds the variables that faults name, with `find`.
    ///
    /// # Errors
    /// What `find` says of a variable that there is not.
    pub fn locate(
        &mut self,
        find: impl Fn(&str, &str) -> Result<Place, String>,
    ) -> Result<(), String> {
        let timed = self.timed.iter_mut().map(|(_, fault)| fault);
        let faults = timed.chain(self.by_operation.iter_mut().map(|(_, fault)| fault));
        for fault in faults {
            if let Fault::Preset {
                variable,
                member,
                place,
                ..
            } = fault
            {
                let found = find(variable, member)?;
                if !matches!(found.size, 1..=8) {
                    return Err(format!(
                        "{variable} {member} has {} bytes, but must have 1 to 8",
                        found.size
                    ));
                }
                *place = Some(found);
            }
        }
        Ok(())
    }

    fn add(&mut self, line: &str) -> Result<(), String> {
        let say = |error: serde_json::Error| error.to_string();
        let mut object: Map<String, Value> = serde_json::from_str(line).map_err(say)?;
        let at_s = object.remove("at_s");
        let operation = object.remove("flash_operation");
        let progress = object.remove("progress");
        let fault: Fault = serde_json::from_value(Value::Object(object)).map_err(say)?;
        check(&fault)?;
        match (at_s, operation, progress) {
            (Some(at_s), None, None) => {
                let at_s: f64 = serde_json::from_value(at_s).map_err(say)?;
                if at_s < 0.0 {
                    return Err(format!("at_s is {at_s}, but time begins at 0"));
                }
                self.timed.push_back((at_s, fault));
            }
            (None, Some(operation), Some(progress)) => {
                let operation = serde_json::from_value(operation).map_err(say)?;
                let progress = serde_json::from_value(progress).map_err(say)?;
                self.by_operation.push_back(((operation, progress), fault));
            }
            _ => {
                return Err(
                    "expected either at_s, or flash_operation with progress (not_begun, half, done)"
                        .to_owned(),
                );
            }
        }
        Ok(())
    }

    /// Time of the next timed fault, if it is not after `until_s`.
    pub(crate) fn next_at(&self, until_s: f64) -> Option<f64> {
        let (at_s, _) = self.timed.front()?;
        (*at_s <= until_s).then_some(*at_s)
    }

    /// Takes that fault.
    pub(crate) fn take_timed(&mut self) -> Option<Fault> {
        self.timed.pop_front().map(|(_, fault)| fault)
    }

    /// Flash operation and progress of the next fault by operation.
    pub(crate) fn next_operation(&self) -> Option<(u64, Progress)> {
        self.by_operation.front().map(|(when, _)| *when)
    }

    /// Takes that fault.
    pub(crate) fn take_by_operation(&mut self) -> Option<Fault> {
        self.by_operation.pop_front().map(|(_, fault)| fault)
    }
}

/// Whether the board can have this fault.
fn check(fault: &Fault) -> Result<(), String> {
    match fault {
        Fault::BitError { bits, .. } if !matches!(bits, 1 | 2) => {
            Err(format!("bits is {bits}, but must be 1 or 2"))
        }
        Fault::DmaSlip { adc, .. } if !(1..=5).contains(adc) => {
            Err(format!("adc is {adc}, but must be 1 to 5"))
        }
        Fault::Crystal { drift, .. } if !(2..=12).contains(drift) => {
            Err(format!("drift is {drift}, but must be 2 to 12"))
        }
        Fault::BitError { address, .. } if !(0x0800_0000..=0x0807_FFFF).contains(address) => Err(
            format!("address is {address:#010x}, but flash is 0x08000000 to 0x0807ffff"),
        ),
        Fault::RamBits { address, .. } if !address.is_multiple_of(4) => Err(format!(
            "address is {address:#010x}, but a word begins at a multiple of 4"
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_come_in_the_order_of_their_times_and_operations() {
        let mut timeline = Timeline::parse(
            "# two resets\n\
             {\"at_s\":2.5,\"fault\":\"brown_out\",\"ram_kept\":false}\n\n\
             {\"at_s\":1,\"fault\":\"pin_reset\"}\n\
             {\"flash_operation\":3,\"progress\":\"done\",\"fault\":\"power_cut\"}\n\
             {\"flash_operation\":3,\"progress\":\"half\",\"fault\":\"pin_reset\"}\n",
        )
        .unwrap();
        assert_eq!(timeline.next_at(0.9), None);
        assert_eq!(timeline.next_at(1.0), Some(1.0));
        assert_eq!(timeline.take_timed(), Some(Fault::PinReset));
        assert_eq!(timeline.next_at(9.0), Some(2.5));
        assert_eq!(timeline.next_operation(), Some((3, Progress::Half)));
        assert_eq!(timeline.take_by_operation(), Some(Fault::PinReset));
        assert_eq!(timeline.next_operation(), Some((3, Progress::Done)));
        assert_eq!(timeline.take_by_operation(), Some(Fault::PowerCut));
    }

    #[test]
    fn a_variable_gets_its_place_and_one_that_is_not_there_is_told() {
        let line =
            "{\"at_s\":0,\"fault\":\"preset\",\"variable\":\"A\",\"member\":\"b.c\",\"value\":5}";
        let mut timeline = Timeline::parse(line).unwrap();
        let missing = |variable: &str, member: &str| Err(format!("no {variable} {member}"));
        assert_eq!(timeline.locate(missing), Err("no A b.c".to_owned()));
        let large = |_: &str, _: &str| {
            Ok(Place {
                address: 0x2000_0000,
                size: 9,
            })
        };
        assert!(timeline.locate(large).unwrap_err().contains("9 bytes"));
        let at = Place {
            address: 0x2000_0000,
            size: 8,
        };
        timeline.locate(|_, _| Ok(at)).unwrap();
        let placed = timeline.take_timed().unwrap();
        assert!(
            matches!(placed, Fault::Preset { value: 5, place: Some(place), .. } if place == at)
        );
    }

    #[test]
    fn addresses_are_hexadecimal() {
        let mut timeline = Timeline::parse(
            "{\"at_s\":0,\"fault\":\"bit_error\",\"address\":\"0x0804_0010\",\"bits\":1}",
        )
        .unwrap();
        let fault = Fault::BitError {
            address: 0x0804_0010,
            bits: 1,
        };
        assert_eq!(timeline.take_timed(), Some(fault));
    }

    #[test]
    fn what_is_wrong_with_a_line_is_said() {
        let problem = |line: &str| Timeline::parse(line).unwrap_err();
        let (line, said) = problem("# one\n{\"at_s\":1,\"fault\":\"earthquake\"}");
        assert!(line == 2 && said.contains("earthquake"), "{said}");
        for (line, hint) in [
            ("{\"fault\":\"pin_reset\"}", "expected either at_s"),
            ("{\"at_s\":1,\"fault\":\"crystal\",\"drift\":1}", "2 to 12"),
            ("{\"at_s\":-1,\"fault\":\"pin_reset\"}", "-1"),
            ("{\"at_s\":1,\"fault\":\"brown_out\"}", "ram_kept"),
            ("{\"at_s\":1,\"fault\":\"hang\",\"exeption\":0}", "exeption"),
            (
                "{\"at_s\":1,\"fault\":\"bit_error\",\"address\":\"0x08040000\",\"bits\":3}",
                "1 or 2",
            ),
            (
                "{\"at_s\":1,\"fault\":\"dma_slip\",\"adc\":6,\"result\":\"lost\"}",
                "1 to 5",
            ),
            (
                "{\"at_s\":1,\"fault\":\"bit_error\",\"address\":\"0x20000000\",\"bits\":1}",
                "0x20000000",
            ),
            (
                "{\"at_s\":1,\"fault\":\"ram_bits\",\"address\":\"0x20000001\",\"mask\":\"0x1\"}",
                "multiple of 4",
            ),
            (
                "{\"at_s\":1,\"fault\":\"jump\",\"address\":\"1234\"}",
                "no address",
            ),
        ] {
            let (_, said) = problem(line);
            assert!(said.contains(hint), "{line}: {said}");
        }
    }
}
