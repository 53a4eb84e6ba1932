//! Points in time as people read them.

use std::time::{Duration, UNIX_EPOCH};

/// 9999-12-31T23:59:59Z, the last that has a date of four digits.
const LAST: u64 = 253_402_300_799;

/// Date and time in UTC of seconds since 1970-01-01 UTC, such as 2026-01-31T12:00:00Z; a number that is no date, which
/// a host with another clock may have written, as it is.
#[must_use]
pub fn utc(unix_s: u64) -> String {
    if unix_s > LAST {
        return format!("{unix_s} s");
    }
    humantime::format_rfc3339_seconds(UNIX_EPOCH + Duration::from_secs(unix_s)).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_number_of_seconds_is_printed() {
        assert_eq!(utc(0), "1970-01-01T00:00:00Z");
        assert_eq!(utc(1_769_860_800), "2026-01-31T12:00:00Z");
        assert_eq!(utc(LAST), "9999-12-31T23:59:59Z");
        assert_eq!(utc(u64::MAX), "18446744073709551615 s");
    }
}
