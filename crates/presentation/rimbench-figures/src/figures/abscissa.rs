//! What is across in an XY figure: the macro step, a parameter of the case, or the cost.

use super::cost::Cost;
use super::valid;
use rimbench_core::error::{Error, Result};
use rimbench_results::results_table::read_table;
use rimbench_results::run_table::Run;
use rimbench_results::selection::Runs;
use serde::Deserialize;
use std::path::Path;

/// What is across in a panel: the macro step, where neither a parameter nor a cost is named.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Across {
    /// A parameter of the case, by name, or a number of an option, as in `delivery_up:delay`; `contact_detection` is
    /// the contact margin, and runs without one are level lines.
    #[serde(default)]
    pub parameter: Option<String>,
    /// A column of cost.csv, or counters of runs.csv joined by `+`: one point per macro step and tolerance.
    #[serde(default)]
    pub cost: Option<Cost>,
    /// Budgets, of communication points and mechanics steps per second: the latter are across, and of the way of each label
    /// (what it says up to its last `/`) the ratio of its least error to that of the best of the panel is shown, in the median
    /// over cases and sets, bars are its quartiles.
    #[serde(default)]
    pub budgets: Option<Vec<[f64; 2]>>,
    /// Heading of the horizontal axis.
    #[serde(default)]
    label: Option<String>,
    /// Horizontal axis, logarithmic.
    #[serde(default, deserialize_with = "valid::positive_interval")]
    pub range: Option<[f64; 2]>,
}

/// The values across, by row of `runs.csv`.
pub(super) enum Abscissa {
    MacroStep,
    Parameter(Vec<f64>),
    Cost(Vec<f64>),
    Budgets(Vec<[f64; 2]>),
}

/// Column of `runs.csv` that says how contacts were detected. With it as the parameter the margin is across: the last
/// part of a label then is no part of the series, and runs without a margin are level lines.
const MARGIN: &str = "contact_detection";

/// The values that there are, ascending.
pub(super) fn abscissae(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

impl Across {
    /// Reads the values across.
    ///
    /// # Errors
    /// [`Error::File`] for a parameter, column or row of cost that is not there.
    pub(super) fn read(&self, folder: &Path, runs: &Runs<'_>) -> Result<Abscissa> {
        if let Some(budgets) = &self.budgets {
            return Ok(Abscissa::Budgets(budgets.clone()));
        }
        match (&self.parameter, &self.cost) {
            (Some(name), _) => parameter_values(name, runs, folder).map(Abscissa::Parameter),
            (None, Some(cost)) => cost.of_runs(folder, runs.table()).map(Abscissa::Cost),
            (None, None) => Ok(Abscissa::MacroStep),
        }
    }

    /// Whether the macro step is across.
    pub(super) fn is_macro_step(&self) -> bool {
        self.parameter.is_none() && self.cost.is_none() && self.budgets.is_none()
    }

    /// The heading of the axis; `unit` is that of the macro step.
    pub(super) fn heading(&self, unit: &str) -> String {
        let named = self.label.clone().or_else(|| self.parameter.clone());
        let named = named.or_else(|| self.cost.as_ref().map(Cost::name));
        named.unwrap_or_else(|| format!("macro step H ({unit})"))
    }

    /// Labels with their rows; with the margin across, what differs in the margin only is one series.
    pub(super) fn series<'t>(&self, runs: &Runs<'t>, values: &[f64], wanted: &[String]) -> Vec<(&'t str, Runs<'t>)> {
        let mut series: Vec<(&str, Runs<'_>)> = Vec::new();
        for label in runs.labels(wanted) {
            let rows = runs.of_label(label);
            let swept =
                self.parameter.as_deref() == Some(MARGIN) && rows.rows().iter().all(|&row| values[row].is_finite());
            let name = label.rsplit_once('/').filter(|_| swept).map_or(label, |(name, _)| name);
            match series.iter_mut().find(|(known, _)| *known == name) {
                Some((_, known)) => *known = known.with_rows([known.rows(), rows.rows()].concat()),
                None => series.push((name, rows)),
            }
        }
        series
    }
}

/// The parameter's value in each run: its row in `parameters.csv`, found by case and set of changed parameters.
fn parameter_values(parameter: &str, runs: &Runs<'_>, folder: &Path) -> Result<Vec<f64>> {
    let option = if parameter == MARGIN { "contact_detection:margin" } else { parameter };
    if let Some((column, part)) = option.split_once(':') {
        let place = runs.table().setting(column)?;
        // The value of a part that a run does not give: no margin, the true mass, no delay.
        let absent = match part {
            "margin" => f64::NAN,
            "mass" | "friction" => 1.0,
            _ => 0.0,
        };
        let number = |text: &str| text.strip_prefix(part)?.strip_prefix(':')?.parse().ok();
        let value = |run: &Run| run.settings[place].split(',').find_map(number).unwrap_or(absent);
        return Ok(runs.iter().map(value).collect());
    }
    let path = folder.join("parameters.csv");
    let parameters = read_table(&path)?;
    let rows = parameters.rows_where(parameters.column("parameter")?, parameter);
    if rows.is_empty() {
        return Err(Error::file(path, format!("has no parameter `{parameter}`")));
    }
    let (case, set) = (parameters.column("case")?, parameters.column("set")?);
    let value = parameters.column("value")?;
    let value_of = |run: &Run| {
        let same = |row: &&usize| [case, set].map(|column| parameters.text(**row, column)) == run.problem();
        rows.iter().find(same).map_or(f64::NAN, |&row| parameters.number(row, value))
    };
    Ok(runs.iter().map(value_of).collect())
}
