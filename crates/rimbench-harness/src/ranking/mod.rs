//! The ranking: which scheme row has least error over the cases, of those that know as much of the other side.
//!
//! ```text
//! ranking file ─► result files of its experiments ─► rows by class and tuning ─► problems ─► cases ─► score, rank
//! ```
//! A problem is a case with its parameters, at a macro step and a phase, with the micro step, the duration and the integrators. On each
//! of them a row has an error, which is the rms force error over the reference's peak, at most 1: a force that is wrong by its peak is
//! worth no more than none, and what failed or could not be run at all is charged the same. So no row gets better by leaving something out,
//! and the score of a row does not depend on who else is there. A run that was begun and gave no answer is no problem that its row has, and
//! a row that lacks one is not ranked.
//!
//! ```text
//! score = exp(mean over cases of the mean over its problems of ln(e + s)) − s          s = 0.1 % of the peak
//! ```
//! Ranks are those of [`ranks`]: cases are drawn, or phases where there is one case.

mod entrants;
mod ranked;

pub use ranked::{CheckedRankClaim, Ranked, RankedRow, Unranked};

use super::checked_results::checked_runs;
use super::experiment::{Experiment, Verdict};
use entrants::{Entrant, enter, of_catalogue};
use ranked::{mean, rank};
use rimbench_cases::catalogue::Catalogue;
use rimbench_core::error::{Error, Result};
use rimbench_results::input::read_text;
use rimbench_results::text_place::said_at;
use rimbench_statistics::bootstrap_interval;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A ranking file as it is written.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ranking {
    /// What the ranking answers, in words.
    pub question: String,
    /// Experiment files, relative to this one.
    experiments: Vec<PathBuf>,
    #[serde(default)]
    claims: Vec<RankClaim>,
    #[serde(skip)]
    path: PathBuf,
}

/// That one row is surely better than another of its group.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct RankClaim {
    id: String,
    text: String,
    /// Label of the row.
    row: String,
    /// Label of the other.
    ahead_of: String,
    finding: Verdict,
}

impl Ranking {
    /// Reads a ranking file.
    ///
    /// # Errors
    /// [`Error::File`] with path, line and what is wrong; unknown keys are errors.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(path, &read_text(path)?)
    }

    /// Reads the text of a ranking file; `path` is what its experiments are relative to, and what errors name.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let wrong = |error: toml::de::Error| {
            Error::file(path, format!("is no ranking: {}", said_at(text, error.span(), error.message())))
        };
        let mut ranking: Ranking = toml::from_str(text).map_err(wrong)?;
        path.clone_into(&mut ranking.path);
        if ranking.experiments.is_empty() {
            return Err(Error::file(path, "experiments = [] is not valid; valid: at least one experiment file"));
        }
        let twice = |index: usize| ranking.claims[..index].iter().any(|earlier| earlier.id == ranking.claims[index].id);
        match (0..ranking.claims.len()).find(|&index| twice(index)) {
            Some(index) => Err(Error::file(path, format!("two claims have the id `{}`", ranking.claims[index].id))),
            None => Ok(ranking),
        }
    }

    /// Returns the experiment files.
    pub fn experiments(&self) -> Vec<PathBuf> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        self.experiments.iter().map(|file| folder.join(file)).collect()
    }

    /// Ranks the rows of its experiments, which `read` reads and whose results lie below `results`.
    ///
    /// # Errors
    /// Those of `read`; [`Error::File`] for results that are not there, not whole, not as they were written, or held against references of their own; for
    /// claims about rows that are not ranked, or not in one group.
    pub fn rank(
        &self,
        catalogue: &Catalogue,
        results: &Path,
        read: impl Fn(&Path) -> Result<Experiment>,
    ) -> Result<Ranked> {
        let mut entrants: BTreeMap<String, Entrant> = BTreeMap::new();
        for file in self.experiments() {
            let experiment = read(&file)?;
            let (runs, _) = checked_runs(&experiment, catalogue, &experiment.results_folder(results))?;
            if !experiment.reference_identity().is_empty() {
                let message = "has a reference_step_s of its own: only what is held against the cases' own references can be ranked";
                return Err(Error::file(file, message));
            }
            enter(&mut entrants, &runs, |row| of_catalogue(catalogue, &runs, row))?;
        }
        self.with_claims(rank(entrants))
    }

    fn with_claims(&self, (mut ranked, values): (Ranked, BTreeMap<String, Vec<f64>>)) -> Result<Ranked> {
        for claim in &self.claims {
            let named = |label: &str| {
                ranked.rows.iter().find(|row| row.label == label).ok_or_else(|| {
                    let rows = ranked.rows.iter().map(|row| row.label.as_str());
                    let error = Error::unknown("row of a claim", label, rows);
                    Error::file(&self.path, format!("claim `{}`: {error}", claim.id))
                })
            };
            let [one, other] = [named(&claim.row)?, named(&claim.ahead_of)?];
            if (&one.class, one.tuned_on.is_empty()) != (&other.class, other.tuned_on.is_empty()) {
                let message = format!(
                    "claim `{}`: `{}` and `{}` are not ranked together, being of different classes, or one of them tuned",
                    claim.id, claim.row, claim.ahead_of
                );
                return Err(Error::file(&self.path, message));
            }
            let differences = values[&one.label].iter().zip(&values[&other.label]);
            let differences: Vec<Vec<f64>> = differences.map(|(a, b)| vec![a - b]).collect();
            let ratio = |values: Vec<f64>| mean(&values).map(libm::exp);
            let measured = ratio(differences.concat());
            let interval = bootstrap_interval(&differences, ratio);
            let verdict = match interval {
                None => Verdict::NotMeasured,
                Some([_, high]) if high < 1.0 => Verdict::Reproduced,
                Some(_) => Verdict::NotReproduced,
            };
            ranked.claims.push(CheckedRankClaim {
                id: claim.id.clone(),
                text: claim.text.clone(),
                row: claim.row.clone(),
                ahead_of: claim.ahead_of.clone(),
                measured,
                low: interval.map(|[low, _]| low),
                high: interval.map(|[_, high]| high),
                verdict,
                finding: claim.finding,
            });
        }
        Ok(ranked)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimbench_core::schemes::InformationClass;
    use rimbench_results::results_table::read_table;
    use std::collections::BTreeSet;

    const HEADER: &str = "label,case,set,scheme,mechanics_integrator,actuator_integrator,gain,macro_step_s,step_control,phase,\
                          micro_step_s,duration_s,outcome,force_error_rms_of_peak,exchanges,mechanics_micro_steps";

    /// Rows of label, case, phase, outcome, error.
    fn entered(rows: &[(&str, &str, &str, &str, &str)]) -> BTreeMap<String, Entrant> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.csv");
        let lines: Vec<String> = rows
            .iter()
            .map(|(label, case, phase, outcome, error)| {
                format!("{label},{case},,nepce,a,b,,0.001,none,{phase},1e-4,1.0,{outcome},{error},2000,1000\n")
            })
            .collect();
        std::fs::write(&path, format!("{HEADER}\n{}", lines.concat())).unwrap();
        let runs = read_table(&path).unwrap();
        let mut entrants = BTreeMap::new();
        enter(&mut entrants, &runs, |_| Ok((InformationClass::Samples, BTreeSet::new()))).unwrap();
        entrants
    }

    #[test]
    fn a_failure_counts_as_the_whole_peak_and_an_error_beyond_it_no_more() {
        let (ranked, _) = rank(entered(&[
            ("good", "a", "1.0", "completed", "0.01"),
            ("good", "b", "1.0", "completed", "0.01"),
            ("fails", "a", "1.0", "diverged", "0.0"),
            ("fails", "b", "1.0", "completed", "0.01"),
            ("wild", "a", "1.0", "completed", "1e9"),
            ("wild", "b", "1.0", "completed", "0.01"),
            ("absent", "a", "1.0", "skipped", ""),
            ("absent", "b", "1.0", "solver-failed", ""),
            // Of this one nobody knows: it is not ranked.
            ("silent", "a", "1.0", "completed", "0.01"),
            ("silent", "b", "1.0", "timeout", ""),
        ]));
        assert_eq!(ranked.rows.len(), 4);
        let scores: Vec<(&str, f64, usize, usize)> =
            ranked.rows.iter().map(|row| (row.label.as_str(), row.score, row.failed, row.skipped)).collect();
        assert_eq!(scores[0].0, "good");
        approx::assert_relative_eq!(scores[0].1, 0.01, max_relative = 1e-12);
        // √(0.011 · 1.001) − 0.001, whether it fails or is wrong beyond the peak.
        let half = (0.011_f64 * 1.001).sqrt() - 1e-3;
        assert_eq!([scores[1].0, scores[2].0], ["fails", "wild"]);
        approx::assert_relative_eq!(scores[1].1, half, max_relative = 1e-12);
        assert_eq!(scores[1].1, scores[2].1);
        assert_eq!([scores[1].2, scores[2].2], [1, 0]);
        assert_eq!((scores[3].0, scores[3].2, scores[3].3), ("absent", 1, 1));
        approx::assert_relative_eq!(scores[3].1, 1.0, max_relative = 1e-12);
        assert_eq!((ranked.problems, ranked.cases), (2, 2));
        assert_eq!(ranked.rows[0].exchanges_per_macro_step, Some(2.0));
    }

    #[test]
    fn who_lacks_a_problem_is_not_ranked_and_cases_weigh_the_same_whatever_their_number_of_problems() {
        let (ranked, values) = rank(entered(&[
            ("whole", "a", "1.0", "completed", "0.1"),
            ("whole", "a", "0.5", "completed", "0.1"),
            ("whole", "a", "0.2", "completed", "0.1"),
            ("whole", "b", "1.0", "completed", "0.001"),
            ("part", "a", "1.0", "completed", "0.001"),
        ]));
        assert_eq!(ranked.unranked, [Unranked { label: "part".into(), why: "lacks 3 problems".into() }]);
        approx::assert_relative_eq!(ranked.rows[0].score, (0.101_f64 * 0.002).sqrt() - 1e-3, max_relative = 1e-12);
        assert_eq!(values.len(), 1);
    }

    #[test]
    fn a_row_that_is_another_scheme_on_another_case_is_refused_unless_it_was_tuned_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.csv");
        let row = |case: &str, control: &str| {
            format!("mine,{case},,nepce,a,b,,0.001,{control},1.0,1e-4,1.0,completed,0.1,2000,1000\n")
        };
        std::fs::write(&path, format!("{HEADER}\n{}{}", row("a", "none"), row("b", "energy-residual"))).unwrap();
        let runs = read_table(&path).unwrap();
        let entered = |tuned_on: &[&str]| {
            let tuned_on: BTreeSet<String> = tuned_on.iter().map(|case| (*case).to_owned()).collect();
            enter(&mut BTreeMap::new(), &runs, |_| Ok((InformationClass::Samples, tuned_on.clone())))
        };
        let said = entered(&[]).unwrap_err().to_string();
        assert!(said.contains("row `mine` has step_control = `none` on `a` and `energy-residual` on `b`"), "{said}");
        entered(&["b"]).unwrap();
    }

    #[test]
    fn what_is_no_ranking_is_refused_with_its_place() {
        let good = "question = \"?\"\nexperiments = [\"a.toml\"]\n[[claims]]\nid = \"x\"\ntext = \"t\"\nrow = \"a\"\nahead_of = \"b\"\n\
                    finding = \"reproduced\"\n";
        Ranking::parse(Path::new("r.toml"), good).unwrap();
        let twice = format!("{good}{}", &good[good.find("[[claims]]").unwrap()..]);
        for (text, wanted) in [
            (good.replace("experiments", "experimens"), "line 2"),
            (good.replace("\"a.toml\"", ""), "at least one experiment file"),
            (good.replace("\"reproduced\"", "\"yes\""), "unknown variant `yes`"),
            (twice, "two claims have the id `x`"),
        ] {
            let said = Ranking::parse(Path::new("r.toml"), &text).unwrap_err().to_string();
            assert!(said.starts_with("r.toml: ") && said.contains(wanted), "{said}");
        }
    }
}
