//! Tables and values of pages, from entries in `paper/tables.toml`: what is shown of which file of results.
//!
//! Pages name tables and values, and are [filled](crate::fill_page). The keys are told in
//! `docs/development/regenerate.md`.

use crate::claims_table::significant;
use crate::figures::valid::{self, is_file_name};
use crate::style::{Styles, with_variants};
use rimbench_core::error::{Error, Result};
use rimbench_results::budget::BUDGET;
use rimbench_results::input::read_text;
use rimbench_results::kept::{SUMMARY, SUMMARY_KEYS, read_summary};
use rimbench_results::results_table::{ResultsTable, read_table};
use rimbench_results::selection::has_words;
use rimbench_results::text_place::said_at;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;
use toml::Value;

/// The folder that stands for those of all experiments that are kept.
const ALL: &str = "all";

/// The group whose experiments are kept together, and the groups of which each is kept on its own.
const TOGETHER: &str = "paper";
const GROUPS: [&str; 2] = ["published", "study"];

/// Relative slack when two numbers are held against each other.
const SAME: f64 = 1e-9;

/// Units that a number may be shown in: what a value in SI units is multiplied by.
const UNITS: [(&str, f64); 13] = [
    ("N", 1.0),
    ("J", 1.0),
    ("mJ", 1e3),
    ("m", 1.0),
    ("kg", 1.0),
    ("s", 1.0),
    ("ms", 1e3),
    ("µs", 1e6),
    ("mm", 1e3),
    ("µm", 1e6),
    ("%", 1e2),
    ("times", 1.0),
    ("kN", 1e-3),
];

/// The file that lists the tables and values of pages.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableList {
    #[serde(default, rename = "table")]
    tables: BTreeMap<Place, Table>,
    #[serde(default, rename = "value")]
    values: BTreeMap<Place, Shown>,
}

/// Where something belongs and what it is called: `<folder of results>/<name>`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(try_from = "String")]
struct Place {
    folder: String,
    name: String,
}

/// A table: how it is made of its file.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Table {
    /// A cell for each line and column.
    Grid(Grid),
    /// Columns of the file.
    List(List),
    /// What budgets buy.
    Budgets(Bought),
}

/// A cell for each line and column, in brackets how many runs completed where not all did.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Grid {
    #[serde(default = "summary")]
    file: String,
    #[serde(default)]
    only: Only,
    cell: String,
    /// A column whose sum the sum of the cell's is a share of, over all rows that a cell has.
    of: Option<String>,
    /// What is made of the rows of a cell, where there are several.
    fold: Option<Fold>,
    #[serde(default)]
    lines: Axis,
    across: Axis,
    #[serde(default)]
    unit: Unit,
    #[serde(default = "two", deserialize_with = "valid::digits")]
    digits: usize,
    #[serde(default)]
    names: Names,
}

/// A table of some columns. The columns without a fold tell the lines apart where there is one with a fold.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    #[serde(default = "summary")]
    file: String,
    #[serde(default)]
    only: Only,
    columns: Vec<Column>,
    #[serde(default = "two", deserialize_with = "valid::digits")]
    digits: usize,
    #[serde(default)]
    names: Names,
}

/// What each budget buys, from `budget.csv`: of each case the best form and the best of another way; of drawn settings by
/// how much each way is worse than the best.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Bought {
    #[serde(default)]
    only: Only,
    #[serde(default)]
    names: Names,
}

/// A cell of a file, or what its rows come to.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Shown {
    #[serde(default = "summary")]
    file: String,
    #[serde(default)]
    only: Only,
    column: String,
    fold: Option<Fold>,
    /// A column whose sum that of `column` is a share of.
    of: Option<String>,
}

/// A column of a list.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Column {
    column: String,
    fold: Option<Fold>,
    #[serde(default)]
    unit: Unit,
    heading: Option<String>,
}

/// What lines or columns of a grid are: values of a column, in its unit; all there are, where none is named; labels,
/// where no column is.
#[derive(Debug, Clone, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Axis {
    column: String,
    unit: Unit,
    #[serde(deserialize_with = "valid::texts")]
    values: Vec<String>,
}

impl Default for Axis {
    fn default() -> Self {
        Axis { column: "label".to_owned(), unit: Unit::default(), values: Vec::new() }
    }
}

/// What becomes of several rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Fold {
    Sum,
    Max,
    /// How many have something in the column.
    Count,
}

impl Fold {
    fn of(self, file: &ResultsTable, column: usize, rows: &[usize]) -> f64 {
        let numbers = rows.iter().map(|&row| file.number(row, column)).filter(|value| !value.is_nan());
        match self {
            Fold::Sum => numbers.sum(),
            Fold::Max => numbers.fold(f64::NAN, f64::max),
            Fold::Count => rows.iter().filter(|row| !file.text(**row, column).is_empty()).count() as f64,
        }
    }
}

/// What a page calls identifiers.
type Names = BTreeMap<String, String>;

/// Conditions on columns.
type Only = BTreeMap<String, Condition>;

/// What a row must have in a column: one text is the only one among those that it may be.
#[derive(Debug, Clone)]
struct Condition(Bounds);

/// What a number or text of a row must be, must not be, or be below.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Bounds {
    #[serde(default, deserialize_with = "valid::texts")]
    not: Vec<String>,
    /// The ones it may be; any, where there is none.
    #[serde(default, deserialize_with = "valid::texts")]
    among: Vec<String>,
    below: Option<f64>,
}

/// A unit that numbers are shown in; none is that of the file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Unit {
    name: &'static str,
    scale: f64,
}

fn summary() -> String {
    SUMMARY.to_owned()
}

fn two() -> usize {
    2
}

impl TableList {
    /// Reads the list.
    ///
    /// # Errors
    /// [`Error::File`] with what is wrong first: line, key and what is valid.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(path, &read_text(path)?)
    }

    /// Reads the text of a list; `path` is what errors name.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let wrong = |place, message: &str| Error::file(path, said_at(text, place, message));
        let list = toml::Deserializer::parse(text).map_err(|error| wrong(error.span(), error.message()))?;
        serde_path_to_error::deserialize(list).map_err(|error| wrong(error.inner().span(), &valid::said(&error)))
    }

    /// The tables' names.
    pub fn tables(&self) -> impl Iterator<Item = String> {
        self.tables.keys().map(Place::id)
    }

    /// A table by its name, as a page has it.
    pub(crate) fn table(&self, id: &str, results: &Path) -> Result<String> {
        let found = self.tables.iter().find(|(place, _)| place.id() == id);
        let known: Vec<String> = self.tables().collect();
        let (place, table) = found.ok_or_else(|| Error::unknown("table", id, known.iter().map(String::as_str)))?;
        table.markdown(&place.folder, results).map_err(|error| Error::Incompatible(format!("table `{id}`: {error}")))
    }

    /// The values' names.
    pub fn values(&self) -> impl Iterator<Item = String> {
        self.values.keys().map(Place::id)
    }

    /// A value by its name, as a page has it.
    pub(crate) fn value(&self, id: &str, results: &Path, unit: Unit, digits: usize) -> Result<String> {
        let known: Vec<String> = self.values().collect();
        let found = self.values.iter().find(|(place, _)| place.id() == id);
        let (place, value) = found.ok_or_else(|| Error::unknown("value", id, known.iter().map(String::as_str)))?;
        let file = source(results, &place.folder, &value.file)?;
        let rows = rows_of(&file, &value.only)?;
        if let Some(whole) = &value.of {
            return Ok(unit.written(share(&file, &rows, file.column(&value.column)?, file.column(whole)?), digits));
        }
        if value.fold.is_none() && rows.len() > 1 {
            let message = format!("{} rows are of `{id}`: say more in `only`, or a `fold`", rows.len());
            return Err(Error::file(file.path(), message));
        }
        Ok(shown(&file, file.column(&value.column)?, value.fold, &rows, unit, digits))
    }
}

impl Place {
    fn id(&self) -> String {
        format!("{}/{}", self.folder, self.name)
    }
}

impl TryFrom<String> for Place {
    type Error = String;

    fn try_from(id: String) -> std::result::Result<Self, String> {
        match id.rsplit_once('/').filter(|_| id.split('/').all(is_file_name) && id.split('/').count() <= 3) {
            Some((folder, name)) => Ok(Place { folder: folder.to_owned(), name: name.to_owned() }),
            None => Err(Error::invalid("id", &id, "\"group/experiment/name\", or \"folder/name\"").to_string()),
        }
    }
}

impl Table {
    fn markdown(&self, folder: &str, results: &Path) -> Result<String> {
        match self {
            Table::Grid(grid) => grid.markdown(&source(results, folder, &grid.file)?),
            Table::List(list) => list.markdown(&source(results, folder, &list.file)?),
            Table::Budgets(bought) => bought.markdown(&source(results, folder, BUDGET)?),
        }
    }
}

impl Grid {
    fn markdown(&self, file: &ResultsTable) -> Result<String> {
        let (rows, cell) = (rows_of(file, &self.only)?, file.column(&self.cell)?);
        let (lines, line_values) = self.lines.of(file, &rows)?;
        let (across, across_values) = self.across.of(file, &rows)?;
        let counts = ["completed", "runs"].map(|name| file.column(name).ok());
        let whole = self.of.as_ref().map(|name| file.column(name)).transpose()?;
        let heading = |axis: &Axis, column, value| axis.shown(file, column, &rows, value, &self.names);
        let columns: Vec<String> = across_values.iter().map(|value| heading(&self.across, across, value)).collect();
        let first = if self.lines.column == "label" { "scheme" } else { &self.lines.column };
        let cell_rows = |line: &&str, column: &&str| -> Vec<usize> {
            let fits =
                |row: &&usize| self.lines.has(file, lines, **row, line) && self.across.has(file, across, **row, column);
            rows.iter().filter(fits).copied().collect()
        };
        let (head, rule) = (columns.join(" | "), "---|".repeat(columns.len()));
        let runs = match whole {
            Some(whole) => self.counted(file, whole, [&line_values, &across_values], &cell_rows)?,
            None => String::new(),
        };
        let mut made = format!("| {}{runs} | {head} |\n|---|{rule}\n", named(&self.names, first));
        for line in &line_values {
            made += &format!("| {} |", heading(&self.lines, lines, line));
            for column in &across_values {
                let found = cell_rows(line, column);
                if let Some(whole) = whole {
                    let share = share(file, &found, cell, whole);
                    made += &if share.is_nan() {
                        " – |".to_owned()
                    } else {
                        format!(" {} |", self.unit.written(share, self.digits))
                    };
                    continue;
                }
                if found.is_empty() || (found.len() > 1 && self.fold.is_none()) {
                    let message = format!("{} rows have `{line}` and `{column}`: say one in `only`", found.len());
                    return Err(Error::file(file.path(), message));
                }
                let value = self.fold.map_or_else(|| file.number(found[0], cell), |fold| fold.of(file, cell, &found));
                let value = self.unit.written(value, self.digits);
                let completed = counts.map(|count| count.map(|count| Fold::Sum.of(file, count, &found)));
                made += &match completed {
                    [Some(0.0), _] => " – |".to_owned(),
                    [Some(completed), Some(runs)] if completed < runs => format!(" {value} ({completed}) |"),
                    _ => format!(" {value} |"),
                };
            }
            made.push('\n');
        }
        Ok(made)
    }

    /// Says what the cells are shares of, and refuses those of labels that are shares of something else than others.
    fn counted(
        &self,
        file: &ResultsTable,
        whole: usize,
        [lines, across]: [&[&str]; 2],
        rows: &dyn Fn(&&str, &&str) -> Vec<usize>,
    ) -> Result<String> {
        let is_label = |axis: &Axis| axis.column == "label";
        let keys: Vec<usize> =
            SUMMARY_KEYS.iter().filter(|name| **name != "label").filter_map(|name| file.column(name).ok()).collect();
        let all_of = |line: &&str, column: &&str| {
            let of_row = |&row: &usize| {
                let key: Vec<&str> = keys.iter().map(|&column| file.text(row, column)).collect();
                (key, file.text(row, whole))
            };
            let mut own: Vec<_> = rows(line, column).iter().map(of_row).collect();
            own.sort_unstable();
            own
        };
        let mut counts: Vec<f64> = Vec::new();
        for (line, column) in lines.iter().flat_map(|line| across.iter().map(move |column| (line, column))) {
            // The first of the labels is what the others are held against.
            let first = all_of(
                if is_label(&self.lines) { &lines[0] } else { line },
                if is_label(&self.across) { &across[0] } else { column },
            );
            let own = all_of(line, column);
            if !own.is_empty() && !first.is_empty() && own != first {
                let message = format!(
                    "the shares of `{line}` and `{column}` are of other {} than those beside them: say in `only` which rows, or in \
                     `values` which labels have the same",
                    self.of.as_deref().unwrap_or_default()
                );
                return Err(Error::file(file.path(), message));
            }
            counts.extend(
                (!own.is_empty()).then(|| rows(line, column).iter().map(|&row| file.number(row, whole)).sum::<f64>()),
            );
        }
        let [least, most] =
            [counts.iter().copied().fold(f64::INFINITY, f64::min), counts.iter().copied().fold(0.0, f64::max)];
        let n = if least < most { format!("{least} to {most}") } else { format!("{most}") };
        Ok(format!(", of {n} {}", self.of.as_deref().unwrap_or_default()))
    }
}

impl List {
    fn markdown(&self, file: &ResultsTable) -> Result<String> {
        let places: Vec<usize> = self.columns.iter().map(|own| file.column(&own.column)).collect::<Result<_>>()?;
        let columns = || self.columns.iter().zip(places.iter().copied());
        let texts = |row| {
            let own = columns().filter(|(column, _)| column.fold.is_none());
            own.map(|(_, place)| named(&self.names, file.text(row, place))).collect::<Vec<_>>()
        };
        let is_folded = self.columns.iter().any(|column| column.fold.is_some());
        let mut lines: Vec<Vec<usize>> = Vec::new();
        for row in rows_of(file, &self.only)? {
            match lines.iter_mut().find(|line| is_folded && texts(line[0]) == texts(row)) {
                Some(line) => line.push(row),
                None => lines.push(vec![row]),
            }
        }
        let headings = self.columns.iter().map(|own| named(&self.names, own.heading.as_ref().unwrap_or(&own.column)));
        let headings: Vec<String> = headings.collect();
        let mut made = format!("| {} |\n|{}\n", headings.join(" | "), "---|".repeat(headings.len()));
        for rows in &lines {
            let cell = |(own, place): (&Column, usize)| {
                named(&self.names, &shown(file, place, own.fold, rows, own.unit, self.digits))
            };
            made += &format!("| {} |\n", columns().map(cell).collect::<Vec<_>>().join(" | "));
        }
        Ok(made)
    }
}

impl Bought {
    fn markdown(&self, file: &ResultsTable) -> Result<String> {
        let column = |name: &str| file.column(name);
        let [case, way, label, points, steps] =
            ["case", "way", "label", "exchanges_per_s", "mechanics_steps_per_s"].map(column);
        let [macro_step, error, ratio] = ["macro_step_s", "error_of_peak", "ratio"].map(column);
        let (case, way, label, points, steps, macro_step, error, ratio) =
            (case?, way?, label?, points?, steps?, macro_step?, error?, ratio?);
        let rows = rows_of(file, &self.only)?;
        // Rows over drawn settings have no label: a line is a way of coupling.
        let drawn = rows.iter().all(|&row| file.text(row, label).is_empty());
        let of = |row: usize| file.text(row, if drawn { way } else { case });
        let budget = |row: usize| format!("{}, {}", file.text(row, points), file.text(row, steps));
        let (mut lines, mut across): (Vec<&str>, Vec<String>) = (Vec::new(), Vec::new());
        for &row in &rows {
            lines.extend((!lines.contains(&of(row))).then(|| of(row)));
            across.extend((!across.contains(&budget(row))).then(|| budget(row)));
        }
        // How the force is returned, behind a hyphen, would fill the table.
        let form = |row: usize| {
            let form = file.text(row, label).strip_prefix(file.text(row, way)).unwrap_or_default();
            let form = form.split_once('-').map_or(form, |(form, _)| form);
            format!("{} {}{form}", named(&self.names, file.text(row, way)), 1e3 * file.number(row, macro_step))
        };
        let percent = |row: usize| significant(100.0 * file.number(row, error), 2);
        let mut made =
            format!("| exchanges, steps per s | {} |\n|---|{}\n", across.join(" | "), "---|".repeat(across.len()));
        for line in lines {
            made += &format!("| {} |", named(&self.names, line));
            for column in &across {
                // The best stand first.
                let own: Vec<usize> =
                    rows.iter().copied().filter(|&row| of(row) == line && budget(row) == *column).collect();
                made += &match own[..] {
                    [] => " – |".to_owned(),
                    [row, ..] if drawn => format!(" {} |", significant(file.number(row, ratio), 3)),
                    [best] => format!(" {} {} |", form(best), percent(best)),
                    [best, next, ..] => {
                        let next = format!("{} {}", named(&self.names, file.text(next, way)), percent(next));
                        format!(" {} {}, {next} |", form(best), percent(best))
                    }
                };
            }
            made.push('\n');
        }
        Ok(made)
    }
}

impl Axis {
    /// Its column, and its values.
    fn of<'a>(&'a self, file: &'a ResultsTable, rows: &[usize]) -> Result<(usize, Vec<&'a str>)> {
        let column = file.column(&self.column)?;
        let mut values: Vec<&str> = self.values.iter().map(String::as_str).collect();
        if values.is_empty() {
            for text in rows.iter().map(|&row| file.text(row, column)) {
                if !values.contains(&text) {
                    values.push(text);
                }
            }
        }
        Ok((column, values))
    }

    /// Whether a row has a value, which is in the unit of the axis where it is named, as in the file where it is not.
    fn has(&self, file: &ResultsTable, column: usize, row: usize, value: &str) -> bool {
        let is = |number: f64| same(self.unit.scale * file.number(row, column), number);
        let has_words = || self.column == "set" && !self.values.is_empty() && has_words(file.text(row, column), value);
        file.text(row, column) == value || value.parse().is_ok_and(is) || has_words()
    }

    /// A value as a heading.
    fn shown(&self, file: &ResultsTable, column: usize, rows: &[usize], value: &str, names: &Names) -> String {
        match rows.iter().find(|&&row| self.has(file, column, row, value)) {
            // A step in seconds times a thousand is rarely the number that was written.
            Some(&row) if !self.unit.name.is_empty() => {
                self.unit.behind(format!("{}", (file.number(row, column) * self.unit.scale * 1e6).round() / 1e6))
            }
            _ => named(names, value),
        }
    }
}

impl<'de> Deserialize<'de> for Condition {
    fn deserialize<D: Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error> {
        let read = match Value::deserialize(from)? {
            bounds @ Value::Table(_) => bounds.try_into(),
            value => valid::condition(value).map(|one| Bounds { among: vec![one], ..Bounds::default() }),
        };
        read.map(Condition).map_err(|error: toml::de::Error| D::Error::custom(error.message()))
    }
}

impl Bounds {
    /// Texts that a column must have somewhere.
    fn named(&self) -> &[String] {
        if self.among.is_empty() { &self.not } else { &self.among }
    }

    fn meets(&self, file: &ResultsTable, row: usize, column: usize) -> bool {
        let is_one_of = |texts: &[String]| texts.iter().any(|one| is(file, row, column, one));
        (self.among.is_empty() || is_one_of(&self.among))
            && !is_one_of(&self.not)
            && self.below.is_none_or(|below| file.number(row, column) < below)
    }
}

impl Default for Unit {
    fn default() -> Self {
        Unit { name: "", scale: 1.0 }
    }
}

impl<'de> Deserialize<'de> for Unit {
    fn deserialize<D: Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error> {
        Unit::named(&String::deserialize(from)?).map_err(D::Error::custom)
    }
}

impl Unit {
    /// # Errors
    /// [`Error::UnknownName`] with the units there are.
    pub(crate) fn named(wanted: &str) -> Result<Self> {
        let found = UNITS.iter().find(|(name, _)| *name == wanted).map(|&(name, scale)| Unit { name, scale });
        found.ok_or_else(|| Error::unknown("unit", wanted, UNITS.iter().map(|(name, _)| *name)))
    }

    /// A number as it is shown: in the unit, rounded to significant digits.
    pub(crate) fn written(self, value: f64, digits: usize) -> String {
        significant(self.scale * value, digits)
    }

    /// A number with the unit behind it.
    pub(crate) fn behind(self, number: String) -> String {
        if self.name.is_empty() { number } else { format!("{number} {}", self.name) }
    }
}

/// Reads a file of results; a summary must be the one that its digest tells of. Of [`ALL`] it is that of all experiments
/// that are kept, one behind the other.
fn source(results: &Path, folder: &str, name: &str) -> Result<ResultsTable> {
    let folder = results.join(folder);
    if folder.ends_with(ALL) {
        let mut paths = vec![results.join(TOGETHER).join(name)];
        for group in GROUPS {
            let group = results.join(group);
            let below = std::fs::read_dir(&group).map_err(|error| Error::file(&group, error))?;
            paths.extend(below.filter_map(|entry| Some(entry.ok()?.path().join(name))));
        }
        paths.retain(|path| path.is_file());
        paths.sort();
        let mut tables = paths.iter().map(|path| read_table(path));
        let first = tables.next().ok_or_else(|| Error::file(results, format!("holds no {name} of an experiment")))?;
        return tables.try_fold(first?, |mut all, table| all.append(table?).map(|()| all));
    }
    if name == SUMMARY {
        read_summary(&folder)?;
    }
    read_table(&folder.join(name))
}

/// Reads the claims of an experiment, with their rows; those of a group that is run as a whole stand together.
pub(crate) fn claims_of(results: &Path, experiment: &str) -> Result<(ResultsTable, Vec<usize>)> {
    const CLAIMS: &str = "claims.csv";
    match experiment.split_once('/').filter(|_| !results.join(experiment).join(CLAIMS).is_file()) {
        None => {
            let claims = source(results, experiment, CLAIMS)?;
            let rows = (0..claims.len()).collect();
            Ok((claims, rows))
        }
        Some((group, name)) => {
            let claims = source(results, group, CLAIMS)?;
            let rows = claims.rows_where(claims.column("experiment")?, name);
            Ok((claims, rows))
        }
    }
}

/// What share of a column another one is, both summed over rows.
fn share(file: &ResultsTable, rows: &[usize], column: usize, whole: usize) -> f64 {
    let sum = |column| rows.iter().map(|&row| file.number(row, column)).sum::<f64>();
    sum(column) / sum(whole)
}

/// What a page has of rows that are one line: a number, or a text. Counts are not rounded.
fn shown(file: &ResultsTable, column: usize, fold: Option<Fold>, rows: &[usize], unit: Unit, digits: usize) -> String {
    let text = file.text(rows[0], column);
    let value = fold.map_or_else(|| text.parse().ok(), |fold| Some(fold.of(file, column, rows)));
    match value {
        Some(value) if unit.name.is_empty() && value.fract() == 0.0 => format!("{value}"),
        Some(value) => unit.written(value, digits),
        None => text.replace('|', "\\|"),
    }
}

/// What a page calls something: a scheme as figures call it, where nothing else is said of it, or of what it begins
/// with.
fn named(names: &Names, own: &str) -> String {
    static STYLES: LazyLock<Styles> = LazyLock::new(Styles::standard);
    let mut parts = own.split('/');
    let first = parts.next().unwrap_or_default();
    match (names.get(own), names.get(first)) {
        (Some(name), _) => name.clone(),
        (None, Some(name)) => with_variants(name.clone(), parts),
        (None, None) if STYLES.shown_name(first) != first => STYLES.shown_name(own),
        (None, None) => own.to_owned(),
    }
}

/// Whether two numbers are the same up to how they were written.
fn same(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME * other.abs()
}

/// Whether a cell is a text, or a number that is written otherwise.
fn is(file: &ResultsTable, row: usize, column: usize, wanted: &str) -> bool {
    file.text(row, column) == wanted || wanted.parse().is_ok_and(|wanted| same(file.number(row, column), wanted))
}

/// Rows that meet all conditions.
fn rows_of(file: &ResultsTable, only: &Only) -> Result<Vec<usize>> {
    let mut rows: Vec<usize> = (0..file.len()).collect();
    for (name, Condition(bounds)) in only {
        let column = file.column(name)?;
        for wanted in bounds.named() {
            if !(0..file.len()).any(|row| is(file, row, column, wanted)) {
                let mut known: Vec<&str> = (0..file.len()).map(|row| file.text(row, column)).collect();
                known.sort_unstable();
                known.dedup();
                return Err(Error::file(file.path(), format!("{name}: {}", Error::unknown("value", wanted, known))));
            }
        }
        rows.retain(|&row| bounds.meets(file, row, column));
    }
    if rows.is_empty() {
        let names: Vec<&str> = only.keys().map(String::as_str).collect();
        return Err(Error::file(file.path(), format!("no row meets `only` ({})", names.join(", "))));
    }
    Ok(rows)
}
