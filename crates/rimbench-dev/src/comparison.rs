//! What is a regression: counters exactly, instructions against a fence, times only if sure twice.

use super::history::{COUNTERS, Row};
use rimbench_statistics::TimeSummary;
use serde::Serialize;
use std::collections::BTreeSet;
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

/// By how much instructions of unchanged sources differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fence {
    /// One program, recorded again: a millionth.
    Repeated,
    /// Built again in another folder, where alignment, paths and the environment differ: 0.2 %.
    Rebuilt,
}

impl Fence {
    /// Decides instructions: the fence around those before, and what those after are.
    fn decide(self, before: f64, after: f64) -> ([f64; 2], Verdict) {
        let part = match self {
            Fence::Repeated => 1e-6,
            Fence::Rebuilt => 0.002,
        };
        let fence = [-part, part].map(|part| (1.0 + part) * before);
        let verdict = match after {
            _ if after > fence[1] => Verdict::Regressed,
            _ if after < fence[0] => Verdict::Improved,
            _ => Verdict::Same,
        };
        (fence, verdict)
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

/// Everything a comparison has to say.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// What was before.
    pub base: String,
    /// What is now.
    pub new: String,
    /// One per benchmark and quantity that could be compared.
    pub findings: Vec<Finding>,
    /// What could not be compared, and why.
    pub notes: Vec<String>,
}

/// Times of two programs measured side by side.
#[derive(Debug, Clone, PartialEq)]
pub struct Paired {
    /// Name in the suite.
    pub benchmark: String,
    /// New over base.
    pub ratio: TimeSummary,
    /// Base over base.
    pub placebo: TimeSummary,
    /// New over base, measured once more; only where the first was suspicious.
    pub second: Option<TimeSummary>,
}

impl Paired {
    /// Decides from the 95 % interval of the ratio, the placebo's interval, and the interval of a second, independent measurement.
    ///
    /// ```text
    /// slower       the whole interval lies above 1 and above the placebo's interval
    /// regressed    slower, and slower again
    /// ```
    /// A placebo whose interval leaves out 1 shows that the machine is not fit to tell: nothing is decided.
    pub fn decide(&self) -> Verdict {
        decide_time(self.ratio.interval(), self.placebo.interval(), self.second.map(|second| second.interval()))
    }
}

fn decide_time(interval: [f64; 2], [low, high]: [f64; 2], second: Option<[f64; 2]>) -> Verdict {
    if !(low <= 1.0 && high >= 1.0) {
        return Verdict::NotCompared;
    }
    let slower = |interval: [f64; 2]| interval[0] > high;
    let faster = |interval: [f64; 2]| interval[1] < low;
    match second {
        Some(second) if slower(interval) && slower(second) => Verdict::Regressed,
        _ if slower(interval) => Verdict::Suspected,
        Some(second) if faster(interval) && faster(second) => Verdict::Improved,
        _ => Verdict::Same,
    }
}

/// Decides a counter: every change counts, but more of a work that is a price (`priced`) is a bargain if the instructions of the
/// same benchmark, in which all work is counted, have improved.
fn decide_counter(base: u64, new: u64, priced: bool, instructions: Option<Verdict>) -> Verdict {
    match new.cmp(&base) {
        std::cmp::Ordering::Less => Verdict::Improved,
        std::cmp::Ordering::Equal => Verdict::Same,
        std::cmp::Ordering::Greater if priced && instructions == Some(Verdict::Improved) => Verdict::Traded,
        std::cmp::Ordering::Greater => Verdict::Regressed,
    }
}

/// Compares the rows of two records, or of two programs whose times were measured side by side.
pub fn compare(base: &[Row], new: &[Row], fence: Fence, times: &[Paired]) -> Comparison {
    let name =
        |rows: &[Row]| rows.first().map_or_else(String::new, |row| format!("{} ({})", row.git_revision, row.record));
    let mut findings = Vec::new();
    for row in new {
        let Some(base) = base.iter().find(|base| base.benchmark == row.benchmark && base.is_ok()) else { continue };
        let finding = |quantity: &str, verdict: Verdict, note: &str| Finding {
            benchmark: row.benchmark.clone(),
            quantity: quantity.to_owned(),
            base: None,
            new: None,
            interval: None,
            verdict,
            note: note.to_owned(),
        };
        if !row.is_ok() {
            findings.push(finding("answer", Verdict::Regressed, &row.status));
            continue;
        }
        let alike = (&base.target, &base.rustc) == (&row.target, &row.rustc);
        let counts = base.instructions.zip(row.instructions).filter(|_| alike).map(|(a, b)| (a as f64, b as f64));
        let counted = counts.map(|(before, after)| {
            let (interval, verdict) = fence.decide(before, after);
            let interval = Some(interval);
            Finding { base: Some(before), new: Some(after), interval, ..finding("instructions", verdict, "") }
        });
        for (name, (before, after)) in COUNTERS.into_iter().zip(base.counters.into_iter().zip(row.counters)) {
            let instructions = counted.as_ref().map(|finding| finding.verdict);
            let verdict = decide_counter(before, after, name != "lcp_fallbacks", instructions);
            let note = if verdict == Verdict::Traded { "fewer instructions in all" } else { "" };
            let (base, new) = (Some(before as f64), Some(after as f64));
            findings.push(Finding { base, new, ..finding(name, verdict, note) });
        }
        findings.extend(counted);
        findings.extend(times.iter().find(|pair| pair.benchmark == row.benchmark).map(|pair| {
            let verdict = pair.decide();
            let note = match verdict {
                Verdict::NotCompared => "the placebo's interval leaves out 1: this machine is too uneven now",
                Verdict::Suspected => "slower once, not confirmed by a second measurement",
                _ => "",
            };
            let (new, interval) = (Some(pair.ratio.ratio), Some(pair.ratio.interval()));
            Finding { base: Some(1.0), new, interval, ..finding("time", verdict, note) }
        }));
    }
    Comparison { base: name(base), new: name(new), findings, notes: differences(base, new) }
}

/// Says what the two sides do not share.
fn differences(base: &[Row], new: &[Row]) -> Vec<String> {
    let mut notes = Vec::new();
    let names = |rows: &[Row]| rows.iter().map(|row| row.benchmark.clone()).collect::<BTreeSet<_>>();
    let (before, after) = (names(base), names(new));
    let broken: Vec<String> = base.iter().filter(|row| !row.is_ok()).map(|row| row.benchmark.clone()).collect();
    for (what, names) in [
        ("only in base", before.difference(&after).cloned().collect()),
        ("only in new", after.difference(&before).cloned().collect()),
        ("wrong answer already in base, not compared", broken),
    ] {
        if !names.is_empty() {
            notes.push(format!("{what}: {}", names.join(", ")));
        }
    }
    if let (Some(first), Some(second)) = (base.first(), new.first()) {
        let lost = "instructions are not compared";
        let doubt = "libraries that choose code by processor may differ in instructions";
        let pairs = [
            ("targets", &first.target, &second.target, lost),
            ("compilers", &first.rustc, &second.rustc, lost),
            ("processors", &first.cpu, &second.cpu, doubt),
        ];
        let other = pairs.into_iter().find(|(_, first, second, _)| first != second);
        notes.extend(other.map(|(what, first, second, then)| format!("{what} {first} and {second}: {then}")));
    }
    for (side, rows) in [("base", base), ("new", new)] {
        if rows.iter().all(|row| row.instructions.is_none()) {
            notes.push(format!("{side} has no instruction counts (recorded without valgrind)"));
        }
        if rows.iter().any(|row| row.git_dirty != "false") {
            notes.push(format!("{side} was not recorded from a clean revision"));
        }
    }
    notes
}

impl Comparison {
    /// Names of what regressed: `benchmark: quantity`.
    pub fn regressions(&self) -> Vec<String> {
        let regressed = self.findings.iter().filter(|finding| finding.verdict == Verdict::Regressed);
        regressed.map(|finding| format!("{}: {}", finding.benchmark, finding.quantity)).collect()
    }

    /// The comparison as a table; of the counters only those that changed.
    pub fn markdown(&self) -> String {
        let mut text = format!("Base {}, new {}.\n\n", self.base, self.new);
        text += "| benchmark | quantity | base | new | new / base | fence or 95 % interval | verdict |\n";
        text += "|---|---|---|---|---|---|---|\n";
        let is_counter = |finding: &&Finding| COUNTERS.contains(&finding.quantity.as_str());
        let is_same = |finding: &&Finding| finding.verdict == Verdict::Same;
        for finding in self.findings.iter().filter(|finding| !(is_counter(finding) && is_same(finding))) {
            text += &finding.markdown();
        }
        let counters = self.findings.iter().filter(is_counter);
        let (same, all) = (counters.clone().filter(is_same).count(), counters.count());
        text += &format!("\n{same} of {all} counters are the same.\n");
        self.notes.iter().for_each(|note| text += &format!("- {note}\n"));
        text += &match self.regressions() {
            names if names.is_empty() => "\nNo regression.".to_owned(),
            names => format!("\nRegressed: {}.", names.join("; ")),
        };
        text
    }
}

impl Finding {
    fn markdown(&self) -> String {
        let is_time = self.quantity == "time";
        let absent = || "–".to_owned();
        let number = |value: Option<f64>, digits: usize| value.map_or_else(absent, |value| format!("{value:.digits$}"));
        let [base, new] = [self.base, self.new].map(|value| number(value, if is_time { 4 } else { 0 }));
        let ratio = self.base.zip(self.new).filter(|(base, _)| *base > 0.0).map(|(base, new)| new / base);
        let digits = if is_time { 3 } else { 0 };
        let interval = self.interval.map_or_else(absent, |[low, high]| format!("{low:.digits$} … {high:.digits$}"));
        let note = if self.note.is_empty() { String::new() } else { format!(" ({})", self.note) };
        let [benchmark, quantity, verdict] = [&self.benchmark, &self.quantity, &self.verdict.to_string()];
        let ratio = number(ratio, 4);
        format!("| {benchmark} | {quantity} | {base} | {new} | {ratio} | {interval} | {verdict}{note} |\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_of_one_work_is_no_regression_where_all_work_together_is_less() {
        let of = |new, priced, instructions| decide_counter(10, new, priced, Some(instructions));
        assert_eq!([9, 10].map(|new| of(new, true, Verdict::Same)), [Verdict::Improved, Verdict::Same]);
        assert_eq!(of(11, true, Verdict::Improved), Verdict::Traded);
        assert_eq!([Verdict::Same, Verdict::Regressed].map(|all| of(11, true, all)), [Verdict::Regressed; 2]);
        assert_eq!(of(11, false, Verdict::Improved), Verdict::Regressed, "a fallback is no price but a failure");
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
