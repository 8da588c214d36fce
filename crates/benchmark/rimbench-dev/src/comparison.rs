//! What is a regression: counters exactly, instructions against a fence.

use super::history::{COUNTERS, Row};
use super::measuring::ChangedFunction;
use rimbench_core::error::{Error, Result};
use std::cmp::Ordering;
use std::fmt;

/// What came of one comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// No more than the noise.
    Same,
    /// Less than before.
    Improved,
    /// More than before: an alarm.
    Regressed,
    /// More of one kind of work in exchange for fewer instructions in all: no alarm.
    Traded,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Verdict::Same => "same",
            Verdict::Improved => "improved",
            Verdict::Regressed => "regressed",
            Verdict::Traded => "traded (fewer instructions in all)",
        })
    }
}

/// Share by which instructions of one program differ that is recorded again.
pub const REPEATED: f64 = 1e-6;

/// Share by which instructions differ of the same source, built again in another folder: alignment, paths and the
/// environment differ.
pub const REBUILT: f64 = 0.002;

/// Finds the fence for two records: of one program, or of two builds.
pub fn fence_of(base: &[Row], new: &[Row]) -> f64 {
    let of = |rows: &[Row]| rows.first().filter(|row| row.git_dirty == "false").map(|row| row.git_revision.clone());
    if of(base).is_some_and(|revision| of(new) == Some(revision)) { REPEATED } else { REBUILT }
}

const INSTRUCTIONS: &str = "instructions";

/// One quantity of one benchmark, before and after.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Name in the suite.
    pub benchmark: String,
    /// `instructions`, the name of a counter, or the answer that is wrong.
    pub quantity: String,
    /// Before and after.
    pub counts: [u64; 2],
    /// What came of it.
    pub verdict: Verdict,
}

/// Everything a comparison has to say.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Comparison {
    /// What was before, and what is now.
    pub records: [String; 2],
    /// One per benchmark and quantity that could be compared.
    pub findings: Vec<Finding>,
    /// What could not be compared, and why.
    pub notes: Vec<String>,
    /// Functions whose instructions changed most, of benchmarks whose instructions changed, where they are known.
    pub functions: Vec<(String, ChangedFunction)>,
}

/// Compares the rows of two records; `fence` is the share by which instructions differ where nothing has changed.
///
/// # Errors
/// [`Error::Incompatible`] for builds with other settings, which say nothing of what was written.
pub fn compare(base: &[Row], new: &[Row], fence: f64) -> Result<Comparison> {
    refuse_other_settings(base, new)?;
    let name =
        |rows: &[Row]| rows.first().map_or_else(String::new, |row| format!("{} ({})", row.git_revision, row.record));
    let mut comparison =
        Comparison { records: [base, new].map(name), notes: notes(base, new), ..Comparison::default() };
    for row in new {
        let Some(before) = base.iter().find(|base| base.benchmark == row.benchmark && base.is_ok()) else { continue };
        let mut found = |quantity: &str, counts: [u64; 2], verdict: Verdict| {
            let (benchmark, quantity) = (row.benchmark.clone(), quantity.to_owned());
            comparison.findings.push(Finding { benchmark, quantity, counts, verdict });
        };
        if !row.is_ok() {
            found(&row.status, [0; 2], Verdict::Regressed);
            continue;
        }
        let instructions = before.instructions.zip(row.instructions).filter(|_| built_alike(before, row));
        let in_all = instructions.map(|(before, after)| match after as f64 / before as f64 - 1.0 {
            change if change > fence => Verdict::Regressed,
            change if change < -fence => Verdict::Improved,
            _ => Verdict::Same,
        });
        for (name, (before, after)) in COUNTERS.into_iter().zip(before.counters.into_iter().zip(row.counters)) {
            // More of a work that is a price is a bargain if all work together is less; a fallback is a failure.
            let is_bargain = in_all == Some(Verdict::Improved) && name != "lcp_fallbacks";
            let verdict = match after.cmp(&before) {
                Ordering::Less => Verdict::Improved,
                Ordering::Equal => Verdict::Same,
                Ordering::Greater if is_bargain => Verdict::Traded,
                Ordering::Greater => Verdict::Regressed,
            };
            found(name, [before, after], verdict);
        }
        if let Some(((before, after), verdict)) = instructions.zip(in_all) {
            found(INSTRUCTIONS, [before, after], verdict);
        }
    }
    Ok(comparison)
}

/// The settings of a build to which nothing was changed: those of older records, which do not say.
const USUAL_SETTINGS: &str = "release";

/// Refuses two records whose builds had other settings; of an older one, which does not say, those are taken to be the
/// usual ones.
fn refuse_other_settings(base: &[Row], new: &[Row]) -> Result<()> {
    let (Some(base), Some(new)) = (base.first(), new.first()) else { return Ok(()) };
    let settings = |row: &Row| Some(row.build.clone()).filter(|build| !build.is_empty());
    let usual = || USUAL_SETTINGS.to_owned();
    if settings(base).unwrap_or_else(usual) == settings(new).unwrap_or_else(usual) {
        return Ok(());
    }
    let said =
        |row: &Row| format!("{} has {}", row.record, settings(row).unwrap_or_else(|| "none that are known".to_owned()));
    Err(Error::Incompatible(format!(
        "these records are of builds with other settings: {}, {}; the same program may take several times as many instructions. Valid: two \
         records of builds alike, as `rimbench perf compare --rev BASE --rev NEW` makes them",
        said(base),
        said(new)
    )))
}

/// Whether instructions compare.
fn built_alike(a: &Row, b: &Row) -> bool {
    (&a.rustc, &a.target) == (&b.rustc, &b.target)
}

/// Says what the two sides do not share.
fn notes(base: &[Row], new: &[Row]) -> Vec<String> {
    let without = |rows: &[Row], others: &[Row]| -> Vec<String> {
        let is_lone = |row: &&Row| others.iter().all(|other| other.benchmark != row.benchmark);
        rows.iter().filter(is_lone).map(|row| row.benchmark.clone()).collect()
    };
    let broken = base.iter().filter(|row| !row.is_ok()).map(|row| row.benchmark.clone()).collect();
    let mut notes = Vec::new();
    for (what, names) in [
        ("only in base", without(base, new)),
        ("only in new", without(new, base)),
        ("wrong answer already in base, not compared", broken),
    ] {
        if !names.is_empty() {
            notes.push(format!("{what}: {}", names.join(", ")));
        }
    }
    if let (Some(first), Some(second)) = (base.first(), new.first()) {
        let lost = "instructions are not compared";
        let doubt = "libraries that choose code by processor may differ in instructions";
        let is_unknown = first.build.is_empty() || second.build.is_empty();
        for (what, first, second, then) in [
            ("targets", &first.target, &second.target, lost),
            ("compilers", &first.rustc, &second.rustc, lost),
            ("processors", &first.cpu, &second.cpu, doubt),
        ] {
            if first != second {
                notes.push(format!("{what} {first} and {second}: {then}"));
            }
        }
        if is_unknown {
            let usual = "the usual ones are assumed";
            notes.push(format!("settings of a build are not known: {usual}, or instructions do not compare"));
        }
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

    /// Names of the benchmarks whose instructions are not the same.
    pub fn changed(&self) -> impl Iterator<Item = &str> {
        let changed = |finding: &&Finding| finding.quantity == INSTRUCTIONS && finding.verdict != Verdict::Same;
        self.findings.iter().filter(changed).map(|finding| &*finding.benchmark)
    }
}

/// The comparison as a table in Markdown; of the counters only those that changed.
impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Base {}, new {}.\n", self.records[0], self.records[1])?;
        writeln!(f, "| benchmark | quantity | base | new | new / base | verdict |\n|---|---|---|---|---|---|")?;
        let is_told = |finding: &&Finding| finding.quantity == INSTRUCTIONS || finding.verdict != Verdict::Same;
        for Finding { benchmark, quantity, counts: [base, new], verdict } in self.findings.iter().filter(is_told) {
            let ratio = if *base > 0 { format!("{:.4}", *new as f64 / *base as f64) } else { "–".to_owned() };
            writeln!(f, "| {benchmark} | {quantity} | {base} | {new} | {ratio} | {verdict} |")?;
        }
        if !self.functions.is_empty() {
            writeln!(f, "\n| benchmark | function that changed most | base | new |\n|---|---|---|---|")?;
        }
        for (benchmark, ChangedFunction { name, counts: [base, new] }) in &self.functions {
            writeln!(f, "| {benchmark} | `{name}` | {base} | {new} |")?;
        }
        writeln!(f, "\n{} quantities compared.", self.findings.len())?;
        self.notes.iter().try_for_each(|note| writeln!(f, "- {note}"))?;
        match self.regressions() {
            names if names.is_empty() => write!(f, "\nNo regression."),
            names => write!(f, "\nRegressed: {}.", names.join("; ")),
        }
    }
}
