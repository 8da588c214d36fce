//! Which scheme is stable at which macro step: signs per macro step, or how many cases have which limit, the largest
//! accurate step on top; or, with a row for each case and a panel for each scheme, the share of the runs that fail.

use super::statistics::{Bars, CountedRuns, Only, name, over_phases, rounded, row, unit_of};
use super::valid;
use super::{FigureOptions, Source};
use crate::chart::{Absent, Axis, Cell, Figure, Mode, Name, Plot, Series};
use crate::drawing::{Color, Drawing};
use crate::line_style::{Dash, LineStyle, Marker};
use crate::rows::WRONG;
use crate::style::Styles;
use rimbench_core::error::Result;
use rimbench_results::checksums;
use rimbench_results::run_table::RunTable;
use rimbench_results::selection::Runs;
use rimbench_runs::Finding;
use rimbench_runs::metrics::USABLE;
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
    /// Panels per row; all panels in one row where it is not given.
    #[serde(default, deserialize_with = "valid::columns")]
    columns: Option<usize>,
    /// Rows are the cases, a panel of shares for each scheme row.
    #[serde(default)]
    by_case: bool,
    /// Panels, from the left; cases have one for all scheme rows.
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
type Ranked = (Axis, Vec<(Vec<Cell>, f64)>);

impl FigureOptions for StabilityFigure {
    type Panel = StabilityPanel;

    /// Draws the matrix from `runs.csv`.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for a column that is not there.
    fn draw(&self, source: &Source, styles: &Styles) -> Result<Drawing> {
        if self.by_case {
            return self.cases(&self.panels[0].only.of(&Runs::of(source.runs()?))?, styles)?.draw();
        }
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
            let (across, rows) = match spec.across {
                Across::MacroStep => self.by_step(&spec.only.one_of(runs)?, &labels)?,
                Across::Limit => self.by_limit(&spec.only.of(runs)?, &labels)?,
            };
            rows.iter().zip(&mut reach).for_each(|((_, own), reach)| *reach += own);
            let rows: Vec<Series> = rows
                .into_iter()
                .zip(&labels)
                .map(|((cells, _), label)| filled(row(&all[0], label, styles, Mode::Cells), &across, cells))
                .collect();
            panels.push((plot(&spec.title, across), rows));
        }
        let mut order: Vec<usize> = (0..labels.len()).collect();
        order.sort_by(|&a, &b| reach[b].total_cmp(&reach[a]));
        let ranked =
            |(plot, rows): (Plot, Vec<Series>)| order.iter().map(|&row| rows[row].clone()).fold(plot, Plot::layer);
        let figure = Figure::new(self.width, 0.0, self.columns);
        panels.into_iter().map(ranked).fold(figure, Figure::panel).draw()
    }

    fn finish(&mut self) -> Result<(), String> {
        let wrong = self.by_case && (self.panels.len() > 1 || self.panels[0].of.is_some());
        if wrong {
            Err("panels: `by_case` has one for all scheme rows, of the experiment itself".into())
        } else {
            Ok(())
        }
    }
}

/// A panel of cells.
fn plot(title: &str, across: Axis) -> Plot {
    Plot::new(title, across, Axis::linear("share of the runs that complete"))
}

/// A row with its cells, the value of each and what else is said of it.
fn filled(row: Series, across: &Axis, cells: Vec<Cell>) -> Series {
    let said = |(column, cell): (&Name, &Cell)| match *cell {
        Cell::Absent(absent) => (f64::NAN, absent.in_words().to_owned()),
        Cell::Right => (1.0, String::new()),
        Cell::Wrong => (1.0, WRONG.to_owned()),
        Cell::Lost(share) | Cell::Failed(share) => (1.0 - share, format!("{:.0} % of the runs failed", 100.0 * share)),
        Cell::Silent => (f64::NAN, "no answer".to_owned()),
        Cell::Count(count) => (count as f64, format!("{count} with the limit: {}", column.short)),
    };
    let (values, notes): (Vec<f64>, Vec<String>) = across.names.iter().zip(&cells).map(said).unzip();
    let points = across.names.iter().zip(values).map(|(column, value)| (column.value, value)).collect();
    Series { points, notes, cells, ..row }
}

/// A column.
fn column(value: f64, short: String) -> Name {
    Name { value, short, label: String::new() }
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

    /// The share of the runs that fail; the case with most failures is on top.
    fn cases<'t>(&self, all: &Runs<'t>, styles: &Styles) -> Result<Figure> {
        let labels = all.labels(&self.labels);
        let mut counted = CountedRuns::default();
        for label in &labels {
            let tried = all.of_label(label).select(|row| !all.is_skipped(row));
            tried.by(|row| all.macro_step_ms(row)).iter().try_for_each(|(step, runs)| counted.take(*step, runs))?;
        }
        let (steps, (unit, factor)) = (steps_of(all), unit_of(all));
        let n = counted.in_words().unwrap_or_default();
        let columns = steps.iter().map(|&step| column(step, rounded(step * factor).to_string())).collect();
        let across = Axis::named(format!("macro step H ({unit}), {n} each"), columns);
        let cell = |runs: &Runs<'_>, step: f64| {
            let tally = runs.select(|row| runs.macro_step_ms(row) == step).tally();
            match tally.run() {
                0 => Cell::Absent(Absent::of(tally.skipped)),
                _ if tally.no_answer == tally.run() => Cell::Silent,
                _ => Cell::Failed(tally.failed_share()),
            }
        };
        let of_case = |case: &str, label: &str| -> Vec<Cell> {
            let runs = all.of_problem(Some(case), None).of_label(label);
            steps.iter().map(|&step| cell(&runs, step)).collect()
        };
        let mut cases: Vec<&str> = all.problems().iter().map(|[case, _]| *case).collect();
        cases.sort_unstable();
        cases.dedup();
        let failed = |cell: Cell| if let Cell::Failed(share) = cell { share } else { 0.0 };
        let total = |case: &str| labels.iter().flat_map(|label| of_case(case, label)).map(failed).sum::<f64>();
        let mut ranked: Vec<(f64, &str)> = cases.into_iter().map(|case| (total(case), case)).collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        let style = LineStyle { color: Color::WHITE, ..LineStyle::new([0; 3], Dash::Solid, Marker::Circle) };
        let panel = |label: &&str| {
            let row = |(_, case): &(f64, &str)| {
                let row = Series::new(case.replace('-', " "), Vec::new(), style).mode(Mode::Cells);
                filled(Series { name: (*case).to_owned(), ..row }, &across, of_case(case, label))
            };
            ranked.iter().map(row).fold(plot(&name(all, label, styles), across.clone()), Plot::layer)
        };
        let figure = Figure::new(self.width, 0.0, self.columns);
        Ok(labels.iter().map(panel).fold(figure, Figure::panel))
    }

    fn by_step(&self, runs: &Runs<'_>, labels: &[&str]) -> Result<Ranked> {
        let steps = steps_of(runs);
        let (unit, factor) = unit_of(runs);
        let row = |label: &&str| -> Result<(Vec<Cell>, f64)> {
            let own = runs.of_label(label);
            let cells = steps.iter().map(|&step| self.cell(&own, step)).collect::<Result<Vec<_>>>()?;
            let accurate = cells.iter().take_while(|cell| **cell == Cell::Right).count() as f64;
            // Ties go to the scheme that is stable up to a larger step, then to the one that loses fewer runs.
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
        let columns = steps.iter().map(|&step| column(step, rounded(step * factor).to_string()));
        Ok((Axis::named(format!("macro step H ({unit})"), columns.collect()), rows))
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
        let columns = values.iter().enumerate().map(|(index, value)| column(index as f64, label(value))).collect();
        Ok((Axis::named("largest accurate macro step (ms)", columns), limits.iter().map(row).collect()))
    }
}

/// The macro steps of some runs, ms, ascending.
fn steps_of(runs: &Runs<'_>) -> Vec<f64> {
    runs.by(|row| runs.macro_step_ms(row)).into_iter().map(|(step, _)| step).collect()
}
