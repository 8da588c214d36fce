//! What figures make of `runs.csv`: labels, and a metric over the phases.

use crate::style::{SeriesStyle, Styles};
use rimbench_core::error::{Error, Result};
use rimbench_results::results_table::{ResultsTable, uncertainty_of};
use rimbench_statistics::{bootstrap_interval, median};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Name that stands for the share of phases that completed, where a figure asks for a metric.
pub const FRACTION_STABLE: &str = "fraction_stable";

/// Which values of a signed metric are shown, so that a logarithmic axis can hold them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Part {
    /// All, as they are.
    #[default]
    Signed,
    /// Magnitudes.
    Absolute,
    /// Those above zero.
    Positive,
    /// Those below zero, as magnitudes.
    Negative,
}

impl Part {
    fn of(self, value: f64) -> Option<f64> {
        match self {
            Part::Signed => Some(value),
            Part::Absolute => Some(value.abs()),
            Part::Positive => (value > 0.0).then_some(value),
            Part::Negative => (value < 0.0).then_some(-value),
        }
    }
}

/// One case of an experiment with several, for a figure or a panel of it.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Only {
    /// The case, by name; `all` pools over several, which must be said.
    pub case: Option<String>,
    /// Its parameters as they stand in the column `set` of `runs.csv`, empty where none is set; `all` pools over several.
    pub set: Option<String>,
}

/// What is said where several cases, or sets of parameters, are pooled on purpose.
const ALL: &str = "all";

/// The rows of an experiment with the columns that every figure needs.
pub struct Runs {
    /// All of `runs.csv`.
    pub table: ResultsTable,
    label: usize,
    macro_step: usize,
    outcome: usize,
}

/// A quantity over the phases at one abscissa.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OverPhases {
    /// What the runs have in common, a macro step, say.
    pub x: f64,
    /// Median.
    pub median: f64,
    /// Least value.
    pub least: f64,
    /// Largest value.
    pub most: f64,
    /// Share of the runs, skipped ones aside, that did not complete and are in none of the others.
    pub lost: f64,
}

impl Runs {
    /// Reads `runs.csv` of an experiment's folder.
    pub fn read(folder: &Path) -> Result<Self> {
        let table = ResultsTable::read(&folder.join("runs.csv"))?;
        let (label, macro_step) = (table.column("label")?, table.column("macro_step_s")?);
        Ok(Runs { label, macro_step, outcome: table.column("outcome")?, table })
    }

    /// The rows of one case with one set of parameters, or of all where that is said.
    ///
    /// # Errors
    /// [`Error::File`] naming what there is, if there is no such row, or if several would be pooled without a word.
    pub fn only(&self, only: &Only) -> Result<Self> {
        let chosen = self.chosen(only)?;
        chosen.refuse_pool(only)?;
        Ok(chosen)
    }

    /// The rows of one case, of one set of parameters, or of all.
    ///
    /// # Errors
    /// [`Error::File`] naming what there is, if there is no such row.
    pub fn chosen(&self, only: &Only) -> Result<Self> {
        let mut rows: Vec<usize> = (0..self.table.len()).collect();
        for (name, wanted) in [("case", &only.case), ("set", &only.set)] {
            let Some(wanted) = wanted.as_ref().filter(|wanted| *wanted != ALL) else { continue };
            let column = self.table.column(name)?;
            let there: BTreeSet<&str> = rows.iter().map(|&row| self.table.text(row, column)).collect();
            if !there.contains(wanted.as_str()) {
                return Err(Error::file(self.table.path(), Error::unknown(name, wanted, there)));
            }
            rows.retain(|&row| self.table.text(row, column) == wanted);
        }
        Ok(Runs { table: self.table.with_rows(&rows), ..*self })
    }

    /// The rows of all cases, with their parameters, on which no run's model was the mechanics itself.
    ///
    /// # Errors
    /// [`Error::File`] for results that do not say.
    pub fn without_exact(&self) -> Result<Self> {
        let [case, set, exact] = ["case", "set", "model_exact"].map(|name| self.table.column(name));
        let (case, set, exact) = (case?, set?, exact?);
        let problem = |row: usize| (self.table.text(row, case), self.table.text(row, set));
        let all = || 0..self.table.len();
        let known: BTreeSet<_> = all().filter(|&row| self.table.text(row, exact) == "true").map(problem).collect();
        let rows: Vec<usize> = all().filter(|&row| !known.contains(&problem(row))).collect();
        Ok(Runs { table: self.table.with_rows(&rows), ..*self })
    }

    /// Refuses rows of several cases, or of several sets of parameters of one case, unless that is asked for.
    fn refuse_pool(&self, only: &Only) -> Result<()> {
        let problems = self.problems()?;
        let cases: BTreeSet<&str> = problems.iter().map(|(case, _)| *case).collect();
        let sets: BTreeSet<&str> = problems.iter().map(|(_, set)| *set).collect();
        let (key, values) = match (&only.case, &only.set) {
            (None, _) if cases.len() > 1 => ("case", cases),
            (_, None) if problems.len() > cases.len() => ("set", sets),
            _ => return Ok(()),
        };
        let values: Vec<String> = values.into_iter().map(|value| format!("\"{value}\"")).collect();
        let message = format!(
            "has several that would be drawn as one: say only = {{ {key} = … }} with one of {}, or with \"{ALL}\"",
            values.join(", ")
        );
        Err(Error::file(self.table.path(), message))
    }

    /// Cases with their sets of parameters.
    pub fn problems(&self) -> Result<BTreeSet<(&str, &str)>> {
        let (case, set) = (self.table.column("case")?, self.table.column("set")?);
        Ok((0..self.table.len()).map(|row| (self.table.text(row, case), self.table.text(row, set))).collect())
    }

    /// Refuses rows of one label with several values of what a figure takes for one.
    ///
    /// # Errors
    /// [`Error::File`] naming the label and what it has several of.
    pub fn refuse_several(&self, rows: &[usize], what: &str, value: impl Fn(usize) -> String) -> Result<()> {
        let values: BTreeSet<String> = rows.iter().map(|&row| value(row)).collect();
        if values.len() <= 1 {
            return Ok(());
        }
        let label = rows.first().map_or("", |&row| self.table.text(row, self.label));
        let values = values.into_iter().collect::<Vec<_>>().join(", ");
        let message =
            format!("has runs of `{label}` with several values of {what} that would be drawn as one: {values}");
        Err(Error::file(self.table.path(), message))
    }

    /// Up to where values of a metric say nothing, because the reference itself is no better known: of a force or position error of one
    /// problem with a reference that states its uncertainty.
    pub fn floor(&self, metric: &str) -> Option<f64> {
        if self.problems().ok()?.len() != 1 {
            return None;
        }
        let column = |name: &str| self.table.column(name).ok();
        let first = |value: &dyn Fn(usize) -> f64| {
            (0..self.table.len()).map(value).find(|value| value.is_finite() && *value > 0.0)
        };
        match metric {
            // The peak of the reference's force is what one error is of the other.
            "force_error_rms_of_peak" => {
                let force = column(uncertainty_of("force_error_rms_n")?)?;
                let (share, error) = (column(metric)?, column("force_error_rms_n")?);
                first(&|row| {
                    self.table.number(row, force) * self.table.number(row, share) / self.table.number(row, error)
                })
            }
            _ => {
                let own = column(uncertainty_of(metric)?)?;
                first(&|row| self.table.number(row, own))
            }
        }
    }

    /// Labels of the scheme rows, in the order of the experiment; only the wanted ones, if any are named.
    pub fn labels(&self, wanted: &[String]) -> Vec<String> {
        let mut labels: Vec<String> = Vec::new();
        for row in 0..self.table.len() {
            let label = self.table.text(row, self.label);
            let is_wanted = wanted.is_empty() || wanted.iter().any(|name| name == label);
            if is_wanted && !labels.iter().any(|known| known == label) {
                labels.push(label.to_owned());
            }
        }
        labels
    }

    /// How a label is drawn: in the colour of its scheme, whatever it begins with.
    pub fn style(&self, label: &str, styles: &Styles) -> SeriesStyle {
        let row = self.of_label(label).first().copied();
        let scheme = row.zip(self.table.column("scheme").ok()).map(|(row, column)| self.table.text(row, column));
        scheme.map_or_else(|| styles.of_label(label), |scheme| styles.of_row(label, scheme))
    }

    /// Rows of one label.
    pub fn of_label(&self, label: &str) -> Vec<usize> {
        self.table.rows_where(self.label, label)
    }

    /// Macro step of a row, ms, without the round-off of the factor.
    pub fn macro_step_ms(&self, row: usize) -> f64 {
        (self.table.number(row, self.macro_step) * 1e9).round() / 1e6
    }

    /// Whether a row's run reached its end.
    pub fn completed(&self, row: usize) -> bool {
        self.table.text(row, self.outcome) == "completed"
    }

    /// Whether a row's run was left out for a reason.
    pub fn skipped(&self, row: usize) -> bool {
        self.table.text(row, self.outcome) == "skipped"
    }

    /// Share of the rows, skipped ones aside, whose run completed; none if all were skipped.
    pub fn fraction_stable(&self, rows: &[usize]) -> Option<f64> {
        let tried = rows.iter().filter(|&&row| !self.skipped(row)).count();
        let completed = rows.iter().filter(|&&row| self.completed(row)).count();
        (tried > 0).then(|| completed as f64 / tried as f64)
    }

    /// Values of the rows by what may be drawn independently: case with parameters, or each run where there is only one.
    fn witnesses(&self, rows: &[usize], value: impl Fn(usize) -> Option<f64>) -> Vec<Vec<f64>> {
        let columns = [self.table.column("case").ok(), self.table.column("set").ok()];
        let problem = |row: usize| columns.map(|column| column.map_or("", |column| self.table.text(row, column)));
        let mut problems: BTreeMap<_, Vec<f64>> = BTreeMap::new();
        for &row in rows {
            problems.entry(problem(row)).or_default().extend(value(row));
        }
        match problems.len() {
            1 => rows.iter().filter_map(|&row| value(row)).map(|value| vec![value]).collect(),
            _ => problems.into_values().collect(),
        }
    }

    /// A metric, or [`FRACTION_STABLE`], over the rows with one abscissa, by ascending abscissa, with least and most as `bars` says. Runs that did not
    /// complete are left out of a metric and counted as lost; where none is left, the point is NaN and breaks the line.
    pub fn over_phases(
        &self,
        rows: &[usize],
        x: impl Fn(usize) -> f64,
        metric: &str,
        part: Part,
        bars: Bars,
    ) -> Result<Vec<OverPhases>> {
        let groups = groups(rows, x);
        if metric == FRACTION_STABLE {
            let point = |(x, rows): (f64, Vec<usize>)| {
                let share = self.fraction_stable(&rows)?;
                Some(OverPhases { x, median: share, least: share, most: share, lost: 0.0 })
            };
            return Ok(groups.into_iter().filter_map(point).collect());
        }
        let column = self.table.column(metric)?;
        let point = |(x, rows): (f64, Vec<usize>)| {
            let lost = self.fraction_stable(&rows).map_or(0.0, |share| 1.0 - share);
            let value = |row: usize| part.of(self.table.number(row, column)).filter(|value| value.is_finite());
            let completed: Vec<usize> = rows.into_iter().filter(|&row| self.completed(row)).collect();
            let values = completed.iter().filter_map(|&row| value(row)).collect();
            let nothing = OverPhases { x, median: f64::NAN, least: f64::NAN, most: f64::NAN, lost };
            let Some(point) = over(x, values) else { return nothing };
            let (least, most) = match bars {
                Bars::Range => (point.least, point.most),
                // Of one witness nothing can be said: no bar.
                Bars::Bootstrap => bootstrap_interval(&self.witnesses(&completed, value), median)
                    .map_or((point.median, point.median), |[low, high]| (low, high)),
            };
            OverPhases { least, most, lost, ..point }
        };
        Ok(groups.into_iter().map(point).collect())
    }
}

/// What the bars at a median show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Bars {
    /// Least to largest value.
    #[default]
    Range,
    /// How far the median can be trusted: its 95 % interval by the bootstrap.
    Bootstrap,
}

/// Median and range of the finite values, if there are any.
pub fn over(x: f64, mut values: Vec<f64>) -> Option<OverPhases> {
    values.retain(|value| value.is_finite());
    let least = values.iter().copied().reduce(f64::min)?;
    let most = values.iter().copied().reduce(f64::max)?;
    Some(OverPhases { x, median: median(values)?, least, most, lost: 0.0 })
}

/// Rows with equal abscissas, by ascending abscissa; rows without one are left out.
pub fn groups(rows: &[usize], x: impl Fn(usize) -> f64) -> Vec<(f64, Vec<usize>)> {
    let mut keyed: Vec<(f64, usize)> = rows.iter().map(|&row| (x(row), row)).filter(|(x, _)| x.is_finite()).collect();
    keyed.sort_by(|a, b| a.0.total_cmp(&b.0));
    let groups = keyed.chunk_by(|a, b| a.0 == b.0);
    groups.map(|group| (group[0].0, group.iter().map(|(_, row)| *row).collect())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_a_signed_metric_fits_a_logarithmic_axis() {
        let of = |part: Part| [-2.0, 3.0].map(|value| part.of(value));
        assert_eq!(of(Part::Signed), [Some(-2.0), Some(3.0)]);
        assert_eq!(of(Part::Absolute), [Some(2.0), Some(3.0)]);
        assert_eq!(of(Part::Positive), [None, Some(3.0)]);
        assert_eq!(of(Part::Negative), [Some(2.0), None]);
    }

    #[test]
    fn rows_are_grouped_by_their_abscissa_and_infinite_values_left_out() {
        let x = [2.0, 1.0, 2.0, f64::NAN];
        assert_eq!(groups(&[0, 1, 2, 3], |row| x[row]), [(1.0, vec![1]), (2.0, vec![0, 2])]);
        let point = over(2.0, vec![5.0, f64::INFINITY, 1.0, 2.0, 4.0]).unwrap();
        assert_eq!(point, OverPhases { x: 2.0, median: 3.0, least: 1.0, most: 5.0, lost: 0.0 });
        assert_eq!(over(2.0, vec![f64::NAN]), None);
    }
}
