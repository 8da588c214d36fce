//! Performance profiles over several experiments: in which share of the problems a scheme is within a factor of the
//! best.

use super::cost::Cost;
use super::valid;
use super::{FigureOptions, Source};
use crate::chart::{Axis, Loss};
use crate::drawing::Drawing;
use crate::rows::{Content, Dot, Dots, Row, RowsPanel, RowsPlot, Sign};
use crate::style::Styles;
use rimbench_cases::runs::Finding;
use rimbench_core::cosim::OutcomeClass;
use rimbench_core::error::{Error, Result};
use rimbench_results::checksums;
use rimbench_results::run_table::{Run, RunTable};
use rimbench_results::selection::Runs;
use rimbench_statistics::{performance_profile, performance_ratios};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Options of a performance profile.
///
/// A problem is a case with its parameters, the duration and the phase; its cost for a scheme is found among the runs
/// at all macro steps.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProfileFigure {
    /// Width, px; 680 px are 180 mm on paper, two columns.
    #[serde(default = "valid::width", deserialize_with = "valid::pixels")]
    width: f64,
    /// Further experiments whose problems count as well.
    #[serde(default, deserialize_with = "valid::experiments")]
    also: Vec<String>,
    /// Scheme rows shown.
    #[serde(default)]
    labels: Vec<String>,
    /// Ratios at which the share is shown: a row per scheme, ranked.
    #[serde(deserialize_with = "valid::some_numbers")]
    at: Vec<f64>,
    /// Panels, from the left.
    #[serde(deserialize_with = "valid::panels")]
    panels: Vec<ProfilePanel>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProfilePanel {
    /// Heading.
    #[serde(default)]
    title: String,
    /// Heading of the horizontal axis.
    #[serde(default = "ratio")]
    label: String,
    /// Leave out cases in which the model of some run is the mechanics itself (`model_exact`).
    #[serde(default)]
    without_exact: bool,
    /// Cost of the cheapest run that is good enough: as above.
    #[serde(default)]
    cost: Option<Cost>,
    /// What must be small enough, a column of runs.csv.
    #[serde(default, deserialize_with = "valid::finding")]
    metric: Option<Finding>,
    /// How small.
    #[serde(default, deserialize_with = "valid::positive")]
    tolerance: Option<f64>,
}

fn ratio() -> String {
    "ratio to the best".to_owned()
}

/// What makes a problem: case, parameters, duration, phase.
type Problem = [String; 4];

/// Least cost by label and problem; +∞ where there is none.
#[derive(Default)]
struct Costs {
    problems: Vec<Problem>,
    /// Those of which nobody knows whether one of the labels solves them.
    unknown: BTreeSet<Problem>,
    of_label: BTreeMap<String, BTreeMap<Problem, f64>>,
}

impl FigureOptions for ProfileFigure {
    type Panel = ProfilePanel;

    /// Draws the profiles from `runs.csv` and `cost.csv` of all experiments.
    ///
    /// # Errors
    /// [`Error::File`] for results or a column that are not there.
    fn draw(&self, source: &Source, styles: &Styles) -> Result<Drawing> {
        let folder = &*source.folder;
        let results = folder.parent().and_then(Path::parent).unwrap_or(folder);
        let mut folders = vec![folder.to_owned()];
        folders.extend(self.also.iter().map(|name| results.join(name)));
        folders[1..].iter().try_for_each(|folder| checksums::verify(folder))?;
        let others = folders[1..].iter().map(|folder| RunTable::read_from(folder)).collect::<Result<Vec<_>>>()?;
        let tables = std::iter::once(source.runs()?).chain(&others);
        let sources: Vec<Runs<'_>> = tables.map(Runs::of).collect();
        let in_all = |label: &&str| sources.iter().all(|runs| !runs.of_label(label).rows().is_empty());
        let labels: Vec<&str> = sources[0].labels(&self.labels).into_iter().filter(in_all).collect();
        if labels.is_empty() {
            return Err(Error::file(folder.join("runs.csv"), "has no label that all experiments of the profile share"));
        }
        let mut ranked = Vec::new();
        for spec in &self.panels {
            let mut costs = Costs::default();
            for (folder, runs) in folders.iter().zip(&sources) {
                spec.collect(folder, runs, &labels, &mut costs)?;
            }
            let rows: Vec<Vec<f64>> = labels.iter().map(|label| costs.row(label)).collect();
            let profiles = performance_ratios(&rows);
            let profiles = profiles.iter().map(|ratios| shares(&performance_profile(ratios), &self.at));
            ranked.push((spec, profiles.collect::<Vec<_>>()));
        }
        self.rows(&labels, ranked, styles).draw_if_it_fits()
    }
}

impl ProfileFigure {
    /// The shares in rows, the largest mean share on top.
    fn rows(&self, labels: &[&str], panels: Vec<(&ProfilePanel, Vec<Vec<f64>>)>, styles: &Styles) -> RowsPlot {
        let total = |row: usize| panels.iter().map(|(_, shares)| shares[row].iter().sum::<f64>()).sum::<f64>();
        let mut order: Vec<usize> = (0..labels.len()).collect();
        order.sort_by(|&a, &b| total(b).total_cmp(&total(a)));
        let dot = |value: &f64| Dot { value: *value, range: None, lost: Ok(Loss::default()) };
        let panel = |(spec, shares): &(&ProfilePanel, Vec<Vec<f64>>)| RowsPanel {
            title: spec.title.clone(),
            content: Content::Dots(Dots {
                axis: Axis::linear("share of problems").range(-0.03, 1.03),
                dots: order.iter().map(|&row| shares[row].iter().map(dot).collect()).collect(),
                marks: Vec::new(),
                floor: None,
            }),
        };
        let first = self.panels.first().map_or("", |spec| spec.label.as_str());
        let within = |value: &f64| match *value {
            1.0 => "is the best (τ = 1)".to_owned(),
            value => format!("within τ = {value}"),
        };
        RowsPlot {
            width: self.width,
            columns: self.panels.len(),
            quantity: first.to_owned(),
            signs: self
                .at
                .iter()
                .map(|value| Sign { value: *value, short: format!("{value}"), label: within(value) })
                .collect(),
            rows: order
                .iter()
                .map(|&row| Row {
                    label: styles.shown_name(labels[row]),
                    name: labels[row].to_owned(),
                    color: styles.of_label(labels[row]).color,
                })
                .collect(),
            panels: panels.iter().map(panel).collect(),
        }
    }
}

/// The heights of a profile at some ratios.
fn shares(corners: &[(f64, f64)], at: &[f64]) -> Vec<f64> {
    let share =
        |at: f64| corners.iter().take_while(|(x, _)| *x <= at * (1.0 + 1e-9)).last().map_or(0.0, |(_, share)| *share);
    at.iter().map(|at| share(*at)).collect()
}

impl ProfilePanel {
    /// Adds the problems of one experiment.
    fn collect(&self, folder: &Path, all: &Runs<'_>, labels: &[&str], into: &mut Costs) -> Result<()> {
        let runs = if self.without_exact { all.without_exact() } else { all.clone() };
        let table = all.table();
        let problem = |row: usize| {
            let run @ Run { duration_s, phase, .. } = all.run(row);
            let [case, set] = run.problem();
            [case, set, &*duration_s.to_string(), phase].map(str::to_owned)
        };
        let cost = self.cost.as_ref().map(|cost| cost.of_runs(folder, table)).transpose()?;
        self.metric.map_or(Ok(()), |metric| table.check(metric))?;
        let tolerance = self.tolerance.unwrap_or(f64::INFINITY);
        let good = |row: usize| {
            runs.is_completed(row) && self.metric.is_none_or(|metric| runs.value(row, metric) <= tolerance)
        };
        for label in labels {
            let mut of_problem: BTreeMap<Problem, Vec<usize>> = BTreeMap::new();
            runs.of_label(label).rows().iter().for_each(|&row| of_problem.entry(problem(row)).or_default().push(row));
            for (problem, mut rows) in of_problem {
                rows.sort_by(|a, b| runs.macro_step_ms(*a).total_cmp(&runs.macro_step_ms(*b)));
                let best = match &cost {
                    Some(cost) => {
                        let costs = rows.iter().filter(|&&row| good(row)).map(|&row| cost[row]);
                        costs.fold(f64::INFINITY, f64::min)
                    }
                    // The inverse, so that less is better.
                    None => rows
                        .iter()
                        .take_while(|&&row| good(row))
                        .last()
                        .map_or(f64::INFINITY, |&row| 1.0 / runs.macro_step_ms(row)),
                };
                let silent = |&row: &usize| runs.class(row) == OutcomeClass::NoAnswer && !runs.is_skipped(row);
                if best.is_infinite() && rows.iter().any(silent) {
                    into.unknown.insert(problem.clone());
                }
                if !into.problems.contains(&problem) {
                    into.problems.push(problem.clone());
                }
                into.of_label.entry((*label).to_owned()).or_default().insert(problem, best);
            }
        }
        Ok(())
    }
}

impl Costs {
    /// The costs of one label over all problems.
    fn row(&self, label: &str) -> Vec<f64> {
        let costs = self.of_label.get(label);
        let of = |problem: &Problem| costs.and_then(|costs| costs.get(problem)).copied().unwrap_or(f64::INFINITY);
        self.problems.iter().filter(|problem| !self.unknown.contains(*problem)).map(of).collect()
    }
}
