//! Days from seconds, for provenance lines and axes.

/// The day of a time given in seconds since 1970, UTC, as 2026-11-22.
pub fn day_of(seconds: u64) -> String {
    let days = (seconds / 86_400) as i64;
    let is_leap = |year: i64| year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let (mut year, mut left) = (1970, days);
    while left >= 365 + i64::from(is_leap(year)) {
        left -= 365 + i64::from(is_leap(year));
        year += 1;
    }
    let lengths = [31, 28 + i64::from(is_leap(year)), 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let mut month = 0;
    while left >= lengths[month] {
        left -= lengths[month];
        month += 1;
    }
    format!("{year}-{:02}-{:02}", month + 1, left + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_becomes_its_day() {
        for (seconds, day) in [
            (0, "1970-01-01"),
            (951_782_400, "2000-02-29"),
            (1_795_186_754, "2026-11-20"),
            (4_107_542_399, "2100-02-28"),
        ] {
            assert_eq!(day_of(seconds), day);
        }
    }
}
