//! What figures take from the table of runs: a part of it, and a metric over the phases.

use crate::chart::{Loss, Mode, Series};
use crate::line_style::LineStyle;
use crate::style::Styles;
use rimbench_core::cosim::OutcomeClass;
use rimbench_core::error::{Error, Result};
use rimbench_results::selection::{ALL, Runs};
use rimbench_runs::Finding;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};

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
    /// A parameter: of several sets those in which it is given are left out.
    #[serde(default)]
    without: Option<String>,
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
        let Some(parameter) = &self.without else { return Ok(chosen) };
        let names = |row| chosen.problem(row)[1].split(' ').map(|word| word.split('=').next().unwrap_or(word));
        let is_given = |row: usize| names(row).any(|name| name == parameter);
        let left = chosen.select(|row| !is_given(row));
        if left.rows().is_empty() || left.rows().len() == chosen.rows().len() {
            let there = chosen.rows().iter().flat_map(|&row| names(row)).filter(|name| !name.is_empty());
            let found = Error::unknown("parameter in `without`", parameter, BTreeSet::from_iter(there));
            return Err(Error::file(runs.table().path(), found));
        }
        Ok(left)
    }
}

/// The runs that shares are of: at each abscissa the same ones for every row of a panel.
#[derive(Debug, Default)]
pub struct CountedRuns<'t> {
    /// By the bits of the abscissa: the row that came first, and its runs.
    at: BTreeMap<u64, (&'t str, Vec<CountedRun<'t>>)>,
}

/// What tells a run from the others of its row: case and set, phase, bits of the macro step.
type CountedRun<'t> = ([&'t str; 2], &'t str, u64);

impl<'t> CountedRuns<'t> {
    /// Takes the runs at an abscissa that a share of a row is of.
    ///
    /// # Errors
    /// [`Error::File`] if the share of another row is of other runs there.
    pub fn take(&mut self, x: f64, runs: &Runs<'t>) -> Result<()> {
        let Some(label) = runs.rows().first().map(|&row| runs.label(row)) else { return Ok(()) };
        let mut own: Vec<CountedRun<'t>> =
            runs.iter().map(|run| (run.problem(), &*run.phase, run.macro_step_s.to_bits())).collect();
        own.sort_unstable();
        let (first, known) = self.at.entry(x.to_bits()).or_insert_with(|| (label, own.clone()));
        if *known == own {
            return Ok(());
        }
        let lone = known.iter().find(|run| own.binary_search(run).is_err());
        let lone = lone.or_else(|| own.iter().find(|run| known.binary_search(run).is_err()));
        let such =
            lone.map_or(String::new(), |([case, set], ..)| format!(", as of `{}`", [*case, *set].join(" ").trim_end()));
        let message = format!(
            "has shares of `{first}` over {} runs and of `{label}` over {} that are not the same{such}: such shares are not \
             compared; valid: rows with the same runs, by labels, or by only = {{ case, set, without }}",
            known.len(),
            own.len()
        );
        Err(Error::file(runs.table().path(), message))
    }

    /// Says how many runs a share is of; nothing where nothing was counted.
    pub fn in_words(&self) -> Option<String> {
        let counts = || self.at.values().map(|(_, runs)| runs.len());
        let (least, most) = (counts().min()?, counts().max()?);
        Some(if least == most { format!("n = {most}") } else { format!("n = {least} to {most}") })
    }

    /// Writes it behind a heading.
    pub fn behind(&self, title: &str) -> String {
        match self.in_words() {
            Some(n) if title.is_empty() => n,
            Some(n) => format!("{title}, {n}"),
            None => title.to_owned(),
        }
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

/// The row of a label in a ranked picture, still empty.
pub fn row(runs: &Runs<'_>, label: &str, styles: &Styles, mode: Mode) -> Series {
    let row = Series::new(name(runs, label, styles), Vec::new(), style(runs, label, styles));
    Series { name: label.to_owned(), ..row.mode(mode) }
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

/// The share of the runs with one abscissa, by ascending abscissa, that completed, and with a metric of at most
/// `within` in magnitude where one is given. Those without an answer are left out.
///
/// # Errors
/// [`Error::File`] for a column that is not there, and where the shares that were counted before are of other runs.
pub fn share_of_runs<'t>(
    runs: &Runs<'t>,
    x: impl Fn(usize) -> f64,
    within: Option<(Finding, f64)>,
    counted: &mut CountedRuns<'t>,
) -> Result<Vec<OverPhases>> {
    within.map_or(Ok(()), |(metric, _)| runs.table().check(metric))?;
    let mut points = Vec::new();
    for (x, runs) in runs.by(x) {
        let tried = runs.select(|row| runs.class(row) != OutcomeClass::NoAnswer);
        let is_good = |row: usize| within.is_none_or(|(metric, most)| runs.value(row, metric).abs() <= most);
        let good = tried.completed().select(is_good).rows().len();
        counted.take(x, &tried)?;
        let share = good as f64 / tried.rows().len() as f64;
        let point = OverPhases { x, median: share, least: share, most: share, lost: Loss::default() };
        points.extend((!tried.rows().is_empty()).then_some(point));
    }
    Ok(points)
}

/// A metric as it is shown over the runs with one abscissa, by ascending abscissa, with least and most as `bars` says. Runs that did not complete are left out of a metric and counted as lost; where none
/// is left, the point is NaN and breaks the line.
pub fn over_phases(
    runs: &Runs<'_>,
    x: impl Fn(usize) -> f64,
    metric: Finding,
    shown: fn(f64) -> f64,
    bars: Bars,
) -> Result<Vec<OverPhases>> {
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
