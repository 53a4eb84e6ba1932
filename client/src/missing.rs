//! Telemetry frames that did not arrive, found by their sequence numbers.

/// Counts them.
#[derive(Debug, Default)]
pub struct Missing {
    expected: Option<u16>,
    frames: u64,
}

impl Missing {
    /// Takes the number of a frame that arrived. The board numbers blocks and poses together, whichever stream they are of,
    /// and a number comes again after 65,536 frames: a longer loss shows in the scan counters only.
    pub fn take(&mut self, sequence: u16) {
        if let Some(expected) = self.expected {
            self.frames += u64::from(sequence.wrapping_sub(expected));
        }
        self.expected = Some(sequence.wrapping_add(1));
    }

    /// How many did not arrive.
    pub fn frames(&self) -> u64 {
        self.frames
    }
}

#[cfg(test)]
mod tests {
    use super::Missing;

    fn after(sequences: &[u16]) -> u64 {
        let mut missing = Missing::default();
        sequences.iter().for_each(|number| missing.take(*number));
        missing.frames()
    }

    #[test]
    fn the_first_frame_may_have_any_number_and_numbers_wrap_around() {
        assert_eq!(after(&[]), 0);
        assert_eq!(after(&[4_711, 4_712]), 0);
        assert_eq!(after(&[65_534, 65_535, 0, 1]), 0);
    }

    #[test]
    fn what_lies_between_two_frames_is_missing() {
        assert_eq!(after(&[7, 9]), 1);
        assert_eq!(after(&[7, 9, 12, 13]), 3);
        assert_eq!(after(&[65_535, 2]), 2);
    }
}
