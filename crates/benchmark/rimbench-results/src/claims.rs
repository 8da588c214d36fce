//! A claim with what was measured, and the table of them.

use crate::atomic_file::write_atomically;
use crate::input::check_regular;
use rimbench_core::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;

/// Who makes a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Claimant {
    /// The source paper.
    Paper,
    /// The source paper, in words; the number that the claim is judged by is of this project.
    PaperOurBound,
    /// This project.
    Ours,
}

impl fmt::Display for Claimant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Claimant::Paper => "paper",
            Claimant::PaperOurBound => "paper, our bound",
            Claimant::Ours => "ours",
        })
    }
}

/// What came of a claim, failures first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The expectation does not hold.
    NotReproduced,
    /// The runs it is about are not part of this plan (a quick one), or the metric does not apply to them.
    NotMeasured,
    /// The expectation holds.
    Reproduced,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Verdict::Reproduced => "reproduced",
            Verdict::NotReproduced => "not reproduced",
            Verdict::NotMeasured => "not measured",
        })
    }
}

/// A claim with what was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CheckedClaim {
    /// Experiment the claim stands in.
    pub experiment: String,
    /// Short name.
    pub id: String,
    /// Who claims it.
    pub by: Claimant,
    /// The claim in words.
    pub text: String,
    /// Metric and statistic.
    pub quantity: String,
    /// What was measured.
    pub measured: Option<f64>,
    /// 95 % interval of a median, by the bootstrap over cases, or over phases where there is one case; of a share of
    /// settings, Wilson's.
    pub low: Option<f64>,
    /// Its upper end.
    pub high: Option<f64>,
    /// The same without the cases in which the model of some run is the mechanics itself, if there are such.
    pub without_exact: Option<f64>,
    /// What was expected.
    pub expected: String,
    /// Whether it holds.
    pub verdict: Verdict,
    /// What was found when the experiment was last looked at.
    pub finding: Verdict,
    /// Why it has been replaced by another; empty if it has not.
    #[serde(default)]
    pub superseded: String,
    /// The claim of which this one is a variant; empty where it says something of its own.
    #[serde(default)]
    pub variant_of: String,
    /// Whether numbers of such runs were known when its bound was set, from a trial or from earlier runs.
    #[serde(default)]
    pub numbers_known: bool,
    /// Number of runs it rests on.
    pub runs: usize,
    /// Number of runs that failed among those it speaks of, whether it rests on them or not.
    #[serde(default)]
    pub failed: usize,
    /// Their ids; known where the rows are, and not written.
    #[serde(skip)]
    pub run_ids: Vec<String>,
}

impl CheckedClaim {
    /// Returns from where to where the measured value can be trusted, if both ends are known.
    pub fn interval(&self) -> Option<[f64; 2]> {
        let [low, high] = [self.low?, self.high?];
        (low.is_finite() && high.is_finite()).then_some([low, high])
    }

    /// Returns whether at least the bound is expected, and the bound.
    pub fn bound(&self) -> Option<(bool, f64)> {
        bound_of(&self.expected)
    }

    /// Returns the significant digits with which a value of it is to be shown beside its bound, at least `least`: as
    /// many as tell the two apart.
    pub fn digits(&self, value: f64, least: usize) -> usize {
        self.bound().map_or(least, |(_, bound)| digits_apart(value, bound, least))
    }

    /// Tells whether it counts as a statement: no other claim has replaced it, and it is no variant of one.
    pub fn counts(&self) -> bool {
        self.superseded.is_empty() && self.variant_of.is_empty()
    }

    /// Tells whether the verdict is another than the recorded finding; one that was never recorded cannot differ.
    pub fn differs(&self) -> bool {
        self.finding != Verdict::NotMeasured && self.verdict != self.finding
    }
}

/// Counts how many of the claims that count reproduce, and how many there are: of all, or of one kind.
pub fn tally<'a>(claims: impl Iterator<Item = &'a CheckedClaim>, by: Option<Claimant>) -> [usize; 2] {
    let counted = claims.filter(|claim| claim.counts() && by.is_none_or(|by| claim.by == by));
    counted.fold([0, 0], |[good, all], claim| [good + usize::from(claim.verdict == Verdict::Reproduced), all + 1])
}

/// Says how many of the claims that count reproduce, those of the paper first: `12 of 15 sentences of the paper and 24 of all 33
/// claims reproduce`; nothing where none counts.
pub fn claims_score<'a>(claims: impl Iterator<Item = &'a CheckedClaim> + Clone) -> String {
    match (tally(claims.clone(), Some(Claimant::Paper)), tally(claims, None)) {
        (_, [_, 0]) => String::new(),
        ([_, own], [good, count]) if own == 0 || own == count => format!("{good} of {count} claims reproduce"),
        ([good, own], [reproduced, count]) => {
            let ending = if own == 1 { "" } else { "s" };
            format!("{good} of {own} sentence{ending} of the paper and {reproduced} of all {count} claims reproduce")
        }
    }
}

/// Returns whether at least the bound is expected, and the bound, of an expectation as it is written.
pub fn bound_of(expected: &str) -> Option<(bool, f64)> {
    let (sign, bound) = expected.split_once(' ')?;
    Some((sign == "≥", bound.parse().ok()?))
}

/// Returns the significant digits, at least `least`, from which on a rounded value lies on the same side of a bound,
/// which has all of its own, as the value itself: 0.895 is not 0.9.
pub fn digits_apart(value: f64, bound: f64, least: usize) -> usize {
    let rounded = |digits: usize| format!("{value:.*e}", digits - 1).parse::<f64>().unwrap_or(value);
    (least..MOST_DIGITS)
        .find(|digits| rounded(*digits).partial_cmp(&bound) == value.partial_cmp(&bound))
        .unwrap_or(MOST_DIGITS)
}

/// Returns the significant digits of a number as short as it can be written.
pub fn digits_of(number: f64) -> usize {
    format!("{number:e}").split('e').next().unwrap_or_default().chars().filter(char::is_ascii_digit).count()
}

/// Digits that tell any two numbers apart.
const MOST_DIGITS: usize = 17;

/// Writes checked claims to `claims.csv`.
///
/// # Errors
/// [`Error::File`].
pub fn write_claims(path: &Path, claims: &[CheckedClaim]) -> Result<()> {
    write_atomically(path, |file| {
        let mut writer = csv::Writer::from_writer(file);
        for claim in claims {
            writer.serialize(claim)?;
        }
        writer.flush()
    })
}

/// Reads the claims that were written to a `claims.csv`.
///
/// # Errors
/// [`Error::File`] if it is missing, or no table of claims.
pub fn read_claims(path: &Path) -> Result<Vec<CheckedClaim>> {
    check_regular(path)?;
    let wrong = |error: csv::Error| Error::file(path, error);
    csv::Reader::from_path(path).map_err(wrong)?.deserialize().collect::<csv::Result<_>>().map_err(wrong)
}
