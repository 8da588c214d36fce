//! What figures take from the table of runs: a part of it, and a metric over the phases.

use crate::chart::Loss;
use crate::line_style::LineStyle;
use crate::rows::Row;
use crate::style::Styles;
use rimbench_cases::runs::Finding;
use rimbench_core::error::{Error, Result};
use rimbench_results::selection::{ALL, Runs};
use serde::Deserialize;
use std::collections::BTreeSet;

/// One case of an experiment with several, for a figure or a panel of it.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Only {
    /// One case; "all" pools several.
    #[serde(default)]
    case: Option<String>,
    /// Its parameters as in the column `set` of runs.csv; "" where none is set; "all" pools several.
    #[serde(default)]
    set: Option<String>,
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
    /// What is lost of the runs, and in none of the others.
    pub lost: Loss,
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

impl Only {
    /// The rows of one case with one set of parameters, or of all where that is said.
    ///
    /// # Errors
    /// [`Error::File`] naming what there is, if there is no such row, or if several would be pooled without a word.
    pub fn one_of<'t>(&self, runs: &Runs<'t>) -> Result<Runs<'t>> {
        let chosen = self.of(runs)?;
        let problems = chosen.problems();
        let cases: BTreeSet<&str> = problems.iter().map(|[case, _]| *case).collect();
        let sets: BTreeSet<&str> = problems.iter().map(|[_, set]| *set).collect();
        let (key, values) = match (&self.case, &self.set) {
            (None, _) if cases.len() > 1 => ("case", cases),
            (_, None) if problems.len() > cases.len() => ("set", sets),
            _ => return Ok(chosen),
        };
        let values: Vec<String> = values.into_iter().map(|value| format!("\"{value}\"")).collect();
        let message = format!(
            "has several that would be drawn as one: say only = {{ {key} = … }} with one of {}, or with \"{ALL}\"",
            values.join(", ")
        );
        Err(Error::file(runs.table().path(), message))
    }

    /// The rows of one case, of one set of parameters, or of all.
    ///
    /// # Errors
    /// [`Error::File`] naming what there is, if there is no such row.
    pub fn of<'t>(&self, runs: &Runs<'t>) -> Result<Runs<'t>> {
        let of_case = runs.of_problem(self.case.as_deref(), None);
        let chosen = of_case.of_problem(None, self.set.as_deref());
        for (name, wanted, all, found) in [("case", &self.case, runs, &of_case), ("set", &self.set, &of_case, &chosen)]
        {
            if let Some(wanted) = wanted.as_ref().filter(|_| found.rows().is_empty()) {
                let there = all.problems().into_iter().map(|[case, set]| if name == "case" { case } else { set });
                return Err(Error::file(runs.table().path(), Error::unknown(name, wanted, BTreeSet::from_iter(there))));
            }
        }
        Ok(chosen)
    }
}

/// Refuses rows of one label with several values of what a figure takes for one.
///
/// # Errors
/// [`Error::File`] naming the label and what it has several of.
pub fn refuse_several(runs: &Runs<'_>, what: &str, value: impl Fn(usize) -> String) -> Result<()> {
    let values: BTreeSet<String> = runs.rows().iter().map(|&row| value(row)).collect();
    if values.len() <= 1 {
        return Ok(());
    }
    let label = runs.rows().first().map_or("", |&row| runs.label(row));
    let values = values.into_iter().collect::<Vec<_>>().join(", ");
    let message = format!("has runs of `{label}` with several values of {what} that would be drawn as one: {values}");
    Err(Error::file(runs.table().path(), message))
}

/// Up to where values of a metric of one problem say nothing, because the reference itself is no better known.
pub fn floor(runs: &Runs<'_>, metric: Finding) -> Option<f64> {
    let of_one = runs.problems().len() == 1;
    runs.iter()
        .filter(|_| of_one)
        .filter_map(|run| run.found.floor(metric))
        .find(|value| value.is_finite() && *value > 0.0)
}

/// How a label is drawn: in the colour of its scheme, whatever it begins with.
pub fn style(runs: &Runs<'_>, label: &str, styles: &Styles) -> LineStyle {
    scheme(runs, label).map_or_else(|| styles.of_label(label), |scheme| styles.of_row(label, scheme))
}

/// The scheme of a label, where the results tell it.
fn scheme<'t>(runs: &Runs<'t>, label: &str) -> Option<&'t str> {
    runs.iter().find(|run| *run.label == *label).map(|run| &*run.scheme).filter(|scheme| !scheme.is_empty())
}

/// What a figure calls a label: its scheme and its variants in words. What a label begins with stands for its scheme
/// where no label that begins otherwise has the same one, as in `gap/profile`; else it is a variant too.
pub fn name(runs: &Runs<'_>, label: &str, styles: &Styles) -> String {
    let scheme = |label: &str| scheme(runs, label);
    let begins = |label: &str| label.split('/').next().unwrap_or_default().to_owned();
    let labels = runs.labels(&[]);
    let first = begins(label);
    let stands_for_it = labels.iter().any(|other| begins(other) == first && *other != first);
    match scheme(label) {
        Some(own) if first != own && stands_for_it => {
            let same = |other: &&str| begins(other) != first && scheme(other) == Some(own);
            let variant = if labels.iter().any(same) { label } else { label[first.len()..].trim_start_matches('/') };
            styles.shown_name(&if variant.is_empty() { own.to_owned() } else { format!("{own}/{variant}") })
        }
        _ => styles.shown_name(label),
    }
}

/// The row of a label in a ranked picture.
pub fn row(runs: &Runs<'_>, label: &str, styles: &Styles) -> Row {
    let color = style(runs, label, styles).color;
    Row { label: name(runs, label, styles), name: label.to_owned(), color }
}

/// The unit in which macro steps of some runs are shown, and what milliseconds are multiplied by: steps of microseconds
/// say so.
pub fn unit_of(runs: &Runs<'_>) -> (&'static str, f64) {
    let longest = runs.rows().iter().map(|&row| runs.macro_step_ms(row)).fold(0.0, f64::max);
    if longest < 0.1 { ("µs", 1e3) } else { ("ms", 1.0) }
}

/// A macro step as it was written, without the round-off of another unit.
pub fn rounded(step: f64) -> f64 {
    (step * 1e6).round() / 1e6
}

/// The share of the runs with one abscissa, by ascending abscissa, that are usable: they completed with a metric of at
/// most `within` in magnitude. Those without an answer are left out.
pub fn share_usable(
    runs: &Runs<'_>,
    x: impl Fn(usize) -> f64,
    metric: Finding,
    within: f64,
) -> Result<Vec<OverPhases>> {
    runs.table().check(metric)?;
    let point = |(x, runs): (f64, Runs<'_>)| {
        let is_usable = |row: &&usize| runs.value(**row, metric).abs() <= within;
        let usable = runs.completed().rows().iter().filter(is_usable).count() as f64;
        let tally = runs.tally();
        let tried = tally.completed + tally.failed;
        let share = usable / tried as f64;
        (tried > 0).then_some(OverPhases { x, median: share, least: share, most: share, lost: Loss::default() })
    };
    Ok(runs.by(x).into_iter().filter_map(point).collect())
}

/// A metric as it is shown, or the share that completed, over the runs with one abscissa, by ascending abscissa, with
/// least and most as `bars` says. Runs that did not complete are left out of a metric and counted as lost; where none
/// is left, the point is NaN and breaks the line.
pub fn over_phases(
    runs: &Runs<'_>,
    x: impl Fn(usize) -> f64,
    metric: Finding,
    shown: fn(f64) -> f64,
    bars: Bars,
) -> Result<Vec<OverPhases>> {
    if metric == Finding::Completed {
        let point = |(x, runs): (f64, Runs<'_>)| {
            let share = runs.share_completed()?;
            Some(OverPhases { x, median: share, least: share, most: share, lost: Loss::default() })
        };
        return Ok(runs.by(x).into_iter().filter_map(point).collect());
    }
    runs.table().check(metric)?;
    let value = |row: usize| {
        let value = shown(runs.value(row, metric));
        if value.is_finite() { value } else { f64::NAN }
    };
    let points = runs.over(x, value).into_iter().map(|point| {
        let median = point.pool.median().unwrap_or(f64::NAN);
        let [least, most] = match bars {
            Bars::Range => point.pool.range(),
            // Of one witness nothing can be said: no bar.
            Bars::Bootstrap => point.pool.interval(),
        }
        .unwrap_or([median; 2]);
        let lost = Loss { failed: point.tally.failed_share(), silent: point.tally.silent_share() };
        OverPhases { x: point.x, median, least, most, lost }
    });
    Ok(points.collect())
}
