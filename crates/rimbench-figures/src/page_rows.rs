//! Rows of a CSV file for a page: which ones, which of their columns, and what several of them come to.
//!
//! ```text
//! where="solver=active-set; n_from>64"                             rows that meet all conditions: =, !=, <, >
//! columns="solver; sum pivots as work; max error in % as worst"    rows that share what is not folded become one line
//! ```

use crate::claims_table::significant;
use rimbench_core::error::{Error, Result};
use rimbench_results::results_table::ResultsTable;

/// What is between the parts of a list.
pub(crate) const BETWEEN: char = ';';

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

/// Whether two numbers are the same up to how they were written.
pub(crate) fn same(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME * other.abs()
}

/// What becomes of several rows.
const FOLDS: [&str; 4] = ["sum", "max", "min", "count"];

/// What is between two sides of a condition; the longer one first.
const CONDITIONS: [&str; 4] = ["!=", "=", "<", ">"];

/// A number as it is shown: in a unit, rounded to significant digits.
pub(crate) fn written(value: f64, unit: &str, digits: usize) -> Result<String> {
    let scale = match UNITS.iter().find(|(name, _)| *name == unit) {
        Some((_, scale)) => *scale,
        None if unit.is_empty() => 1.0,
        None => return Err(Error::unknown("unit", unit, UNITS.iter().map(|(name, _)| *name))),
    };
    Ok(significant(scale * value, digits))
}

/// A column that is asked for.
struct Column<'a> {
    fold: &'a str,
    place: usize,
    unit: &'a str,
    heading: &'a str,
}

impl<'a> Column<'a> {
    /// Reads `[fold] name [in unit] [as heading]`, or `count [as heading]`.
    fn parse(text: &'a str, table: &ResultsTable) -> Result<Self> {
        let (text, heading) =
            text.trim().split_once(" as ").map_or((text.trim(), None), |(text, as_)| (text, Some(as_)));
        let (text, unit) = text.split_once(" in ").unwrap_or((text, ""));
        let (fold, name) = if text == "count" { ("count", "") } else { text.split_once(' ').unwrap_or(("", text)) };
        if !fold.is_empty() && !FOLDS.contains(&fold) {
            return Err(Error::unknown("fold", fold, FOLDS));
        }
        let place = if fold == "count" { 0 } else { table.column(name.trim())? };
        Ok(Column { fold, place, unit: unit.trim(), heading: heading.unwrap_or(text).trim() })
    }

    /// What is shown of rows that are one line: a number, or a text.
    fn value(&self, table: &ResultsTable, rows: &[usize]) -> std::result::Result<f64, String> {
        let numbers = rows.iter().map(|&row| table.number(row, self.place)).filter(|value| !value.is_nan());
        match self.fold {
            "sum" => Ok(numbers.sum()),
            "max" => Ok(numbers.fold(f64::NAN, f64::max)),
            "min" => Ok(numbers.fold(f64::NAN, f64::min)),
            "count" => Ok(rows.len() as f64),
            _ => {
                let text = table.text(rows[0], self.place);
                text.parse().map_err(|_| text.replace('|', "\\|"))
            }
        }
    }

    fn shown(&self, table: &ResultsTable, rows: &[usize], digits: usize) -> Result<String> {
        match self.value(table, rows) {
            // Counts are not rounded.
            Ok(value) if self.unit.is_empty() && value.fract() == 0.0 => Ok(format!("{value}")),
            Ok(value) => written(value, self.unit, digits),
            Err(text) => Ok(text),
        }
    }
}

/// Rows that meet all conditions of a list.
pub(crate) fn rows_where(table: &ResultsTable, conditions: &str) -> Result<Vec<usize>> {
    let mut rows: Vec<usize> = (0..table.len()).collect();
    for condition in conditions.split(BETWEEN).map(str::trim).filter(|condition| !condition.is_empty()) {
        let sign = CONDITIONS.into_iter().find(|sign| condition.contains(sign));
        let sign = sign.ok_or_else(|| Error::invalid("where", condition, "conditions like `column=value`"))?;
        let (name, wanted) = condition.split_once(sign).unwrap_or_default();
        let (column, wanted) = (table.column(name.trim())?, wanted.trim());
        let bound: f64 = wanted.parse().unwrap_or(f64::NAN);
        let meets = |row: usize| table.text(row, column) == wanted || same(table.number(row, column), bound);
        if matches!(sign, "=" | "!=") && !(0..table.len()).any(meets) {
            let mut known: Vec<&str> = (0..table.len()).map(|row| table.text(row, column)).collect();
            known.sort_unstable();
            known.dedup();
            return Err(Error::file(table.path(), Error::unknown("value of a condition", wanted, known)));
        }
        rows.retain(|&row| match sign {
            "=" => meets(row),
            "!=" => !meets(row),
            "<" => table.number(row, column) < bound,
            _ => table.number(row, column) > bound,
        });
    }
    if rows.is_empty() {
        return Err(Error::file(table.path(), format!("no row meets `{conditions}`")));
    }
    Ok(rows)
}

/// One number of a file, or a text; with `over`, the ratio to the same of other rows.
pub(crate) fn value(
    table: &ResultsTable,
    column: &str,
    conditions: &str,
    over: Option<&str>,
    (unit, digits): (&str, usize),
) -> Result<String> {
    let mut column = Column::parse(column, table)?;
    column.unit = unit;
    let rows = |conditions: &str| -> Result<Vec<usize>> {
        let rows = rows_where(table, conditions)?;
        if column.fold.is_empty() && rows.len() > 1 {
            let message = format!("{} rows meet `{conditions}`: say more, or `{}`", rows.len(), FOLDS.join("`, `"));
            return Err(Error::file(table.path(), message));
        }
        Ok(rows)
    };
    let own = rows(conditions)?;
    let Some(over) = over else { return column.shown(table, &own, digits) };
    match (column.value(table, &own), column.value(table, &rows(over)?)) {
        (Ok(own), Ok(other)) => written(own / other, unit, digits),
        _ => Err(Error::invalid("over", over, "rows with a number in that column")),
    }
}

/// A table of some columns. The columns without a fold tell the lines apart where there is one with a fold.
pub(crate) fn table(
    table: &ResultsTable,
    columns: &str,
    conditions: &str,
    named: impl Fn(&str) -> String,
    digits: usize,
) -> Result<String> {
    let columns: Result<Vec<Column<'_>>> = columns.split(BETWEEN).map(|column| Column::parse(column, table)).collect();
    let columns = columns?;
    let keys = |row: usize| {
        let own = columns.iter().filter(|column| column.fold.is_empty());
        own.map(|column| table.text(row, column.place)).collect::<Vec<_>>()
    };
    let folded = columns.iter().any(|column| !column.fold.is_empty());
    let mut lines: Vec<Vec<usize>> = Vec::new();
    for row in rows_where(table, conditions)? {
        match lines.iter_mut().find(|line| folded && keys(line[0]) == keys(row)) {
            Some(line) => line.push(row),
            None => lines.push(vec![row]),
        }
    }
    let headings: Vec<String> = columns.iter().map(|column| named(column.heading)).collect();
    let mut made = format!("| {} |\n|{}\n", headings.join(" | "), "---|".repeat(columns.len()));
    for rows in &lines {
        let cells: Result<Vec<String>> =
            columns.iter().map(|column| Ok(named(&column.shown(table, rows, digits)?))).collect();
        made += &format!("| {} |\n", cells?.join(" | "));
    }
    Ok(made)
}
