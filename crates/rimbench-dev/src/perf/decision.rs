//! What is a regression: counters exactly, instructions against a fence, times only if sure twice.

use serde::Serialize;
use std::fmt;

/// What came of one comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// No more than the noise.
    Same,
    /// Less than before.
    Improved,
    /// More than before: an alarm.
    Regressed,
    /// More than before in one measurement, not confirmed by a second: no alarm.
    Suspected,
    /// More of one kind of work in exchange for fewer instructions in all: no alarm.
    Traded,
    /// Not meaningful, for the reason in the note.
    NotCompared,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// One quantity of one benchmark, before and after.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Name in the suite.
    pub benchmark: String,
    /// `instructions`, `time`, `answer` or the name of a counter.
    pub quantity: String,
    /// Before.
    pub base: Option<f64>,
    /// After.
    pub new: Option<f64>,
    /// The fence of a count, or the 95 % interval of the ratio of times.
    pub interval: Option<[f64; 2]>,
    /// What came of it.
    pub verdict: Verdict,
    /// Why, where it needs saying.
    pub note: String,
}

/// Decides a counter: every change counts, but more of a work that is a price (`priced`) is a bargain if the instructions of the
/// same benchmark, in which all work is counted, have improved.
pub fn decide_counter(base: u64, new: u64, priced: bool, instructions: Option<Verdict>) -> Verdict {
    match new.cmp(&base) {
        std::cmp::Ordering::Less => Verdict::Improved,
        std::cmp::Ordering::Equal => Verdict::Same,
        std::cmp::Ordering::Greater if priced && instructions == Some(Verdict::Improved) => Verdict::Traded,
        std::cmp::Ordering::Greater => Verdict::Regressed,
    }
}

/// Decides an instruction count against its fence.
pub fn decide_instructions([low, high]: [f64; 2], new: f64) -> Verdict {
    match new {
        _ if new > high => Verdict::Regressed,
        _ if new < low => Verdict::Improved,
        _ => Verdict::Same,
    }
}

/// Decides a time from the 95 % interval of its ratio, the placebo's interval, and the interval of a second,
/// independent measurement.
///
/// ```text
/// slower       the whole interval lies above 1 and above the placebo's interval
/// regressed    slower, and slower again
/// ```
/// A placebo whose interval leaves out 1 shows that the machine is not fit to tell: nothing is decided.
pub fn decide_time(interval: [f64; 2], placebo: [f64; 2], second: Option<[f64; 2]>) -> Verdict {
    let [low, high] = placebo;
    if !(low <= 1.0 && high >= 1.0) {
        return Verdict::NotCompared;
    }
    let slower = |interval: [f64; 2]| interval[0] > high.max(1.0);
    let faster = |interval: [f64; 2]| interval[1] < low.min(1.0);
    match second {
        Some(second) if slower(interval) && slower(second) => Verdict::Regressed,
        _ if slower(interval) => Verdict::Suspected,
        Some(second) if faster(interval) && faster(second) => Verdict::Improved,
        _ => Verdict::Same,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_change_of_a_counter_counts() {
        assert_eq!(
            [9, 10, 11].map(|new| decide_counter(10, new, true, None)),
            [Verdict::Improved, Verdict::Same, Verdict::Regressed]
        );
    }

    #[test]
    fn more_of_one_work_is_no_regression_where_all_work_together_is_less() {
        let more = |priced, instructions| decide_counter(10, 11, priced, Some(instructions));
        assert_eq!(more(true, Verdict::Improved), Verdict::Traded);
        for instructions in [Verdict::Same, Verdict::Regressed] {
            assert_eq!(more(true, instructions), Verdict::Regressed);
        }
        assert_eq!(more(false, Verdict::Improved), Verdict::Regressed, "a fallback is no price but a failure");
    }

    #[test]
    fn a_time_is_a_regression_only_if_sure_twice_and_beyond_the_placebo() {
        let placebo = [0.99, 1.02];
        assert_eq!(decide_time([1.03, 1.08], placebo, Some([1.025, 1.07])), Verdict::Regressed);
        assert_eq!(decide_time([1.03, 1.08], placebo, Some([0.99, 1.07])), Verdict::Suspected);
        assert_eq!(decide_time([1.03, 1.08], placebo, None), Verdict::Suspected);
        assert_eq!(decide_time([1.01, 1.08], placebo, Some([1.03, 1.07])), Verdict::Same);
        assert_eq!(decide_time([0.90, 0.95], placebo, Some([0.91, 0.94])), Verdict::Improved);
        assert_eq!(decide_time([0.90, 0.95], placebo, None), Verdict::Same);
        assert_eq!(decide_time([1.03, 1.08], [1.01, 1.02], Some([1.03, 1.08])), Verdict::NotCompared);
    }
}
