//! Which scheme is stable at which macro step: signs per macro step, or how many cases have which limit; the largest
//! accurate step on top.

use super::statistics::{Bars, Only, over_phases, rounded, row, unit_of};
use super::valid;
use super::{FigureOptions, Source};
use crate::chart::Absent;
use crate::drawing::Drawing;
use crate::rows::{Cell, Column, Content, Grid, RowsPanel, RowsPlot};
use crate::style::Styles;
use rimbench_cases::metrics::USABLE;
use rimbench_cases::runs::Finding;
use rimbench_core::error::Result;
use rimbench_results::checksums;
use rimbench_results::run_table::RunTable;
use rimbench_results::selection::Runs;
use serde::Deserialize;

/// What says whether a stable run is right, and up to where. Results that lack it are not judged.
const JUDGE: &str = "force_error_rms_of_peak";

/// Options of a stability map.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StabilityFigure {
    /// Width, px; 680 px are 180 mm on paper, two columns.
    #[serde(default = "valid::width", deserialize_with = "valid::pixels")]
    width: f64,
    /// Scheme rows shown; all there are where none is given.
    #[serde(default)]
    labels: Vec<String>,
    /// Panels, from the left.
    #[serde(deserialize_with = "valid::panels")]
    panels: Vec<StabilityPanel>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StabilityPanel {
    /// Heading.
    #[serde(default)]
    title: String,
    /// Whose results the panel shows.
    #[serde(default, deserialize_with = "valid::experiment")]
    of: Option<String>,
    /// Columns: macro steps, each with what became of the runs; or limits, each with the number of cases whose largest
    /// accurate macro step it is.
    #[serde(default)]
    across: Across,
    /// The part of the results shown.
    #[serde(default)]
    only: Only,
}

/// What the columns of a panel are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Across {
    #[default]
    MacroStep,
    Limit,
}

/// A panel before its rows are ranked: columns, and of each label its cells and how far it comes, from 0 to 1.
type Ranked = (Vec<Column>, String, Vec<(Vec<Cell>, f64)>);

impl FigureOptions for StabilityFigure {
    type Panel = StabilityPanel;

    /// Draws the matrix from `runs.csv`.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for a column that is not there.
    fn draw(&self, source: &Source, styles: &Styles) -> Result<Drawing> {
        let folder = &*source.folder;
        let results = folder.ancestors().nth(2).unwrap_or(folder);
        let read = |panel: &StabilityPanel| -> Result<Option<RunTable>> {
            let Some(folder) = panel.of.as_ref().map(|name| results.join(name)) else { return Ok(None) };
            checksums::verify(&folder)?;
            RunTable::read_from(&folder).map(Some)
        };
        let tables = self.panels.iter().map(read).collect::<Result<Vec<_>>>()?;
        let own = source.runs()?;
        let all: Vec<Runs<'_>> = tables.iter().map(|table| Runs::of(table.as_ref().unwrap_or(own))).collect();
        let labels = all[0].labels(&self.labels);
        let mut panels = Vec::new();
        let mut reach = vec![0.0; labels.len()];
        for (spec, runs) in self.panels.iter().zip(&all) {
            let (columns, quantity, rows) = match spec.across {
                Across::MacroStep => self.by_step(&spec.only.one_of(runs)?, &labels)?,
                Across::Limit => self.by_limit(&spec.only.of(runs)?, &labels)?,
            };
            rows.iter().zip(&mut reach).for_each(|((_, own), reach)| *reach += own);
            let cells: Vec<Vec<Cell>> = rows.into_iter().map(|(cells, _)| cells).collect();
            panels.push((spec.title.clone(), Grid { quantity, columns, cells }));
        }
        let mut order: Vec<usize> = (0..labels.len()).collect();
        order.sort_by(|&a, &b| reach[b].total_cmp(&reach[a]));
        let ranked = |(title, grid): (String, Grid)| {
            let cells = order.iter().map(|&row| grid.cells[row].clone()).collect();
            RowsPanel { title, content: Content::Grid(Grid { cells, ..grid }) }
        };
        let panels: Vec<RowsPanel> = panels.into_iter().map(ranked).collect();
        let rows = order.iter().map(|&index| row(&all[0], labels[index], styles)).collect();
        let (columns, quantity, signs) = (panels.len(), String::new(), Vec::new());
        RowsPlot { width: self.width, columns, quantity, signs, rows, panels }.draw_if_it_fits()
    }
}

impl StabilityFigure {
    /// What became of the runs of one label at one macro step.
    fn cell(&self, runs: &Runs<'_>, step: f64) -> Result<Cell> {
        let here = runs.select(|row| runs.macro_step_ms(row) == step);
        let judge = Finding::named(JUDGE)?;
        let tally = here.tally();
        Ok(match tally.failed_share() {
            _ if tally.run() == 0 => Cell::Absent(Absent::of(tally.skipped)),
            share if share > 0.0 => Cell::Lost(share),
            // Of some phases nothing is known.
            _ if tally.no_answer > 0 => Cell::Silent,
            _ if !here.table().has(judge) => Cell::Right,
            _ => match over_phases(&here, |_| step, judge, f64::abs, Bars::Range)?.first() {
                Some(error) if error.median > USABLE => Cell::Wrong,
                _ => Cell::Right,
            },
        })
    }

    fn by_step(&self, runs: &Runs<'_>, labels: &[&str]) -> Result<Ranked> {
        let steps = steps_of(runs);
        let (unit, factor) = unit_of(runs);
        let row = |label: &&str| -> Result<(Vec<Cell>, f64)> {
            let own = runs.of_label(label);
            let cells = steps.iter().map(|&step| self.cell(&own, step)).collect::<Result<Vec<_>>>()?;
            let accurate = cells.iter().take_while(|cell| **cell == Cell::Right).count() as f64;
            // Of equals the one that stays stable longer, then the one that loses fewer runs.
            let kept = cells.iter().map(|cell| match cell {
                Cell::Right | Cell::Wrong => 1.0,
                Cell::Lost(share) => 0.5 * (1.0 - share),
                _ => 0.0,
            });
            let count = cells.len().max(1) as f64;
            let kept = kept.sum::<f64>() / count;
            Ok((cells, accurate / count + 0.01 * kept))
        };
        let rows = labels.iter().map(row).collect::<Result<_>>()?;
        let column = |step: &f64| Column { label: rounded(step * factor).to_string(), value: *step };
        Ok((steps.iter().map(column).collect(), format!("macro step H ({unit})"), rows))
    }

    /// Counts the cases by the largest accurate macro step that each allows; the last column are those in which no step
    /// tried fails.
    fn by_limit(&self, runs: &Runs<'_>, labels: &[&str]) -> Result<Ranked> {
        let mut limits: Vec<Vec<(f64, f64)>> = vec![Vec::new(); labels.len()];
        for problem in runs.problems() {
            let part = runs.select(|row| runs.problem(row) == problem);
            let steps = steps_of(&part);
            for (label, limits) in labels.iter().zip(&mut limits) {
                let own = part.of_label(label);
                let cells = steps.iter().map(|&step| self.cell(&own, step)).collect::<Result<Vec<_>>>()?;
                let tried: Vec<(f64, Cell)> =
                    steps.iter().copied().zip(cells).filter(|(_, cell)| !matches!(cell, Cell::Absent(_))).collect();
                let good = tried.iter().take_while(|(_, cell)| *cell == Cell::Right).count();
                let limit = match good {
                    _ if tried.is_empty() => continue,
                    // Where nothing is known of the next step there is no limit to be counted.
                    good if tried.get(good).is_some_and(|(_, cell)| *cell == Cell::Silent) => continue,
                    0 => 0.0,
                    all if all == tried.len() => f64::INFINITY,
                    some => tried[some - 1].0,
                };
                limits.push((limit, good as f64 / tried.len() as f64));
            }
        }
        let mut values: Vec<f64> = limits.iter().flatten().map(|limit| limit.0).chain([0.0, f64::INFINITY]).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        let label = |value: &f64| match *value {
            0.0 => "none".to_owned(),
            value if value.is_infinite() => "all tried".to_owned(),
            value if value < 0.1 => format!("{} µs", rounded(value * 1e3)),
            value => rounded(value).to_string(),
        };
        let row = |limits: &Vec<(f64, f64)>| {
            let count = |value: &f64| Cell::Count(limits.iter().filter(|limit| limit.0 == *value).count());
            let mean = limits.iter().map(|limit| limit.1).sum::<f64>() / limits.len().max(1) as f64;
            (values.iter().map(count).collect(), mean)
        };
        let column = |(index, value)| Column { label: label(value), value: index as f64 };
        let columns = values.iter().enumerate().map(column).collect();
        Ok((columns, "largest accurate macro step (ms)".to_owned(), limits.iter().map(row).collect()))
    }
}

/// The macro steps of some runs, ms, ascending.
fn steps_of(runs: &Runs<'_>) -> Vec<f64> {
    runs.by(|row| runs.macro_step_ms(row)).into_iter().map(|(step, _)| step).collect()
}
