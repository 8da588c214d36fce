//! Two records, or two programs, held against each other: what changed, and what cannot be compared.

use super::decision::{Finding, Verdict, decide_counter, decide_instructions, decide_time};
use super::history::{COUNTERS, History, Row};
use rimbench_core::error::Result;
use rimbench_statistics::{TimeSummary, ratio_interval};
use serde::Serialize;
use std::collections::BTreeSet;

/// Part of a count that two builds of one source may differ by: what alignment, paths and the environment do to it.
const FLOOR: f64 = 0.002;

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
    /// The verdict, and the interval it rests on.
    pub fn decide(&self) -> Verdict {
        decide_time(self.ratio.interval(), self.placebo.interval(), self.second.map(|second| second.interval()))
    }
}

/// Part of a count by which it differs when the same program is recorded again.
const REPEAT: f64 = 1e-6;

/// Compares two records, each of its own history or both of the same.
///
/// # Errors
/// [`Error::InvalidValue`](rimbench_core::error::Error::InvalidValue) if a selector names no record.
pub fn compare_records(base: (&History, &str), new: (&History, &str)) -> Result<Comparison> {
    let (base_record, new_record) = (base.0.select(base.1)?, new.0.select(new.1)?);
    let (base_rows, new_rows) = (base.0.of_record(base_record), new.0.of_record(new_record));
    let mut comparison = compare_counts(&base_rows, &new_rows, REPEAT);
    if base_rows[0].machine == new_rows[0].machine {
        for (base, row) in common(&base_rows, &new_rows) {
            let other = |other: &&&Row| {
                other.benchmark == row.benchmark
                    && other.record != row.record
                    && other.record != base.record
                    && (&other.git_revision, &other.git_dirty, &other.machine)
                        == (&row.git_revision, &row.git_dirty, &row.machine)
            };
            let others: Vec<&Row> = new.0.rows.iter().collect();
            let second = others.iter().rev().find(other).copied();
            comparison.findings.extend(recorded_time(base, row, second));
        }
    } else {
        comparison.notes.push("recorded on two machines: times are not compared".to_owned());
    }
    comparison.finish();
    Ok(comparison)
}

/// Compares two programs measured side by side, each built in a folder of its own.
pub fn compare_pairs(base: &[Row], new: &[Row], paired: &[Paired]) -> Comparison {
    let (base, new): (Vec<&Row>, Vec<&Row>) = (base.iter().collect(), new.iter().collect());
    let mut comparison = compare_counts(&base, &new, FLOOR);
    for pair in paired {
        let verdict = pair.decide();
        let unfit = "the placebo's interval leaves out 1: this machine is too uneven now";
        comparison.findings.push(Finding {
            benchmark: pair.benchmark.clone(),
            quantity: "time".to_owned(),
            base: Some(1.0),
            new: Some(pair.ratio.ratio),
            interval: Some(pair.ratio.interval()),
            verdict,
            note: note_on_time(verdict, unfit),
        });
    }
    comparison.finish();
    comparison
}

fn note_on_time(verdict: Verdict, unfit: &str) -> String {
    match verdict {
        Verdict::NotCompared => unfit.to_owned(),
        Verdict::Suspected => "slower once, not confirmed by a second measurement".to_owned(),
        _ => String::new(),
    }
}

/// Rows of one benchmark on both sides, both with the right answer.
fn common<'a>(base: &[&'a Row], new: &[&'a Row]) -> Vec<(&'a Row, &'a Row)> {
    let partner = |row: &&'a Row| base.iter().find(|base| base.benchmark == row.benchmark).map(|base| (*base, *row));
    new.iter().filter_map(partner).filter(|(base, row)| base.is_ok() && row.is_ok()).collect()
}

/// Answers, counters and instructions, of which this part is nothing.
fn compare_counts(base: &[&Row], new: &[&Row], nothing: f64) -> Comparison {
    let name = |rows: &[&Row]| {
        rows.first().map_or("nothing".to_owned(), |row| format!("{} ({})", row.git_revision, row.record))
    };
    let mut comparison = Comparison { base: name(base), new: name(new), findings: Vec::new(), notes: Vec::new() };
    comparison.note_differences(base, new);
    for row in new {
        let known = base.iter().find(|base| base.benchmark == row.benchmark);
        if let Some(base) = known.filter(|base| base.is_ok() && !row.is_ok()) {
            comparison.findings.push(Finding {
                benchmark: base.benchmark.clone(),
                quantity: "answer".to_owned(),
                base: None,
                new: None,
                interval: None,
                verdict: Verdict::Regressed,
                note: row.status.clone(),
            });
        }
    }
    for (base, row) in common(base, new) {
        let alike = (&base.target, &base.rustc) == (&row.target, &row.rustc);
        let counted = if alike { instructions(base, row, nothing) } else { None };
        for (name, counter) in COUNTERS {
            let (before, after) = (counter(base), counter(row));
            let priced = name != "lcp_fallbacks";
            let verdict = decide_counter(before, after, priced, counted.as_ref().map(|finding| finding.verdict));
            comparison.findings.push(Finding {
                benchmark: row.benchmark.clone(),
                quantity: name.to_owned(),
                base: Some(before as f64),
                new: Some(after as f64),
                interval: None,
                verdict,
                note: if verdict == Verdict::Traded { "fewer instructions in all".to_owned() } else { String::new() },
            });
        }
        comparison.findings.extend(counted);
    }
    comparison
}

/// Instructions, of which a part is nothing.
fn instructions(base: &Row, row: &Row, nothing: f64) -> Option<Finding> {
    let (before, after) = (base.instructions? as f64, row.instructions? as f64);
    let fence = [-nothing, nothing].map(|part| (1.0 + part) * before);
    Some(Finding {
        benchmark: row.benchmark.clone(),
        quantity: "instructions".to_owned(),
        base: Some(before),
        new: Some(after),
        interval: Some(fence),
        verdict: decide_instructions(fence, after),
        note: String::new(),
    })
}

/// Recorded times: each was paired with the fixed work; another record of the same revision confirms.
fn recorded_time(base: &Row, row: &Row, second: Option<&Row>) -> Option<Finding> {
    let (before, after) = (base.time()?, row.time()?);
    let interval = ratio_interval(&before, &after);
    let ([a, b], [c, d]) = (base.placebo()?, row.placebo()?);
    let fit = |[low, high]: [f64; 2]| low <= 1.0 && high >= 1.0;
    // The wider of both placebos; one that leaves out 1 shows in either.
    let placebo = if fit([a, b]) && fit([c, d]) { [a.min(c), b.max(d)] } else { [f64::NAN; 2] };
    let second = second.and_then(Row::time).map(|second| ratio_interval(&before, &second));
    let verdict = decide_time(interval, placebo, second);
    let unfit = "the placebo's interval leaves out 1: the machine was too uneven";
    Some(Finding {
        benchmark: row.benchmark.clone(),
        quantity: "time".to_owned(),
        base: Some(before.ratio),
        new: Some(after.ratio),
        interval: Some(interval),
        verdict,
        note: note_on_time(verdict, unfit),
    })
}

impl Comparison {
    /// Says what the two sides do not share.
    fn note_differences(&mut self, base: &[&Row], new: &[&Row]) {
        let (Some(first), Some(second)) = (base.first(), new.first()) else { return };
        let names = |rows: &[&Row]| rows.iter().map(|row| row.benchmark.clone()).collect::<BTreeSet<_>>();
        let (before, after) = (names(base), names(new));
        let listed = |names: Vec<&String>| names.iter().map(|name| name.as_str()).collect::<Vec<_>>().join(", ");
        for (side, names) in [("base", before.difference(&after)), ("new", after.difference(&before))] {
            let names: Vec<&String> = names.collect();
            if !names.is_empty() {
                self.notes.push(format!("only in {side}: {}", listed(names)));
            }
        }
        let broken: Vec<&String> = base.iter().filter(|row| !row.is_ok()).map(|row| &row.benchmark).collect();
        if !broken.is_empty() {
            self.notes.push(format!("wrong answer already in base, not compared: {}", listed(broken)));
        }
        if first.target != second.target {
            self.notes.push(format!("targets {} and {}: instructions are not compared", first.target, second.target));
        } else if first.rustc != second.rustc {
            self.notes.push(format!("compilers {} and {}: instructions are not compared", first.rustc, second.rustc));
        } else if first.cpu != second.cpu {
            self.notes.push(format!(
                "processors {} and {}: libraries that choose code by processor may differ in instructions",
                first.cpu, second.cpu
            ));
        }
        for (side, rows) in [("base", base), ("new", new)] {
            if rows.iter().all(|row| row.instructions.is_none()) {
                self.notes.push(format!("{side} has no instruction counts (recorded without valgrind)"));
            }
            if rows.iter().any(|row| row.git_dirty != "false") {
                self.notes.push(format!("{side} was not recorded from a clean revision"));
            }
        }
    }

    /// Orders the findings by benchmark, as in the suite of the new side.
    fn finish(&mut self) {
        let mut order: Vec<String> = Vec::new();
        for finding in &self.findings {
            if !order.contains(&finding.benchmark) {
                order.push(finding.benchmark.clone());
            }
        }
        self.findings.sort_by_key(|finding| order.iter().position(|name| *name == finding.benchmark));
    }

    /// Names of what regressed: `benchmark: quantity`.
    pub fn regressions(&self) -> Vec<String> {
        let regressed = self.findings.iter().filter(|finding| finding.verdict == Verdict::Regressed);
        regressed.map(|finding| format!("{}: {}", finding.benchmark, finding.quantity)).collect()
    }
}
