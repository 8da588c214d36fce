//! Numbers in pages: what stands between two markers is filled from results, so that no page is older than its data.
//!
//! ```text
//! <!-- value claim=study/x:floor unit=N -->43 N<!-- /value -->                               what a claim measured
//! <!-- value file=study/x/summary.csv column=runs where="label=a" -->8<!-- /value -->        a cell of a file
//! <!-- table file=study/x/summary.csv lines=label across="macro_step_s in ms" cell=force_error_rms_n_median -->
//! …
//! <!-- /table -->
//! ```
//! The keys are told in `docs/development/regenerate.md`.

use crate::claims_table::significant;
use rimbench_core::error::{Error, Result};
use rimbench_results::claims::{bound_of, digits_apart};
use rimbench_results::kept::read_summary;
use rimbench_results::results_table::{ResultsTable, read_table};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What a marker asks for.
const KINDS: [&str; 2] = ["value", "table"];

/// Keys of a marker, of which each kind takes some.
const KEYS: [&str; 12] =
    ["claim", "claims", "file", "column", "columns", "lines", "across", "cell", "where", "names", "digits", "unit"];

/// What is between the parts of a list.
const BETWEEN: char = ';';

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

/// What becomes of several rows.
const FOLDS: [&str; 4] = ["sum", "max", "min", "count"];

/// What is between two sides of a condition; the longer one first.
const CONDITIONS: [&str; 4] = ["!=", "=", "<", ">"];

/// Fills all markers of a page from the results in a folder.
///
/// # Errors
/// [`Error::File`] with page, line and what is wrong: a marker that is not closed, a key, a row or a claim that is not there; a
/// summary that is missing or damaged.
pub fn fill_page(page: &Path, text: &str, results: &Path) -> Result<String> {
    let mut sources = Sources { folder: results.to_owned(), tables: BTreeMap::new() };
    let mut filled = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, kind, behind)) = next_marker(rest) {
        let wrong = |error: String| {
            let line = 1 + text[..text.len() - rest.len() + before.len()].matches('\n').count();
            Error::file(page, format!("line {line}: {error}"))
        };
        let (keys, inside) = behind.split_once("-->").ok_or_else(|| wrong("a marker without its end".to_owned()))?;
        let close = format!("<!-- /{kind} -->");
        let (old, after) =
            inside.split_once(&close).ok_or_else(|| wrong(format!("`{kind}` is not closed by `{close}`")))?;
        if next_marker(old).is_some() {
            return Err(wrong(format!("`{kind}` is not closed by `{close}` before the next marker")));
        }
        let keys = Keys::parse(keys).map_err(wrong)?;
        let made = match kind {
            "value" => sources.value(&keys),
            _ => sources.table(&keys).map(|table| format!("\n\n{table}\n")),
        };
        let made = made.map_err(|error| wrong(error.to_string()))?;
        filled += &rest[..rest.len() - inside.len()];
        filled += &made;
        filled += &close;
        rest = after;
    }
    Ok(filled + rest)
}

/// Takes what is between markers out of a page, and the markers: what is left is typed by hand.
pub fn without_filled(text: &str) -> String {
    let (mut left, mut rest) = (String::new(), text);
    while let Some((before, kind, behind)) = next_marker(rest) {
        left += before;
        rest = behind.split_once(&format!("<!-- /{kind} -->")).map_or("", |(_, after)| after);
    }
    left + rest
}

/// What stands before the next marker, its kind, and what stands behind that word. In a block of code a marker is an example.
fn next_marker(text: &str) -> Option<(&str, &'static str, &str)> {
    let (mut at, mut code) = (0, false);
    for line in text.split_inclusive('\n') {
        if line.starts_with("```") {
            code = !code;
        }
        let found = KINDS.iter().filter_map(|kind| Some((line.find(&format!("<!-- {kind} "))?, *kind)));
        if let Some((place, kind)) = found.min().filter(|_| !code) {
            let place = at + place;
            return Some((&text[..place], kind, &text[place + "<!-- ".len() + kind.len()..]));
        }
        at += line.len();
    }
    None
}

/// Keys of a marker.
struct Keys<'a>(BTreeMap<&'a str, &'a str>);

impl<'a> Keys<'a> {
    fn parse(text: &'a str) -> std::result::Result<Self, String> {
        let mut keys = BTreeMap::new();
        let mut rest = text.trim();
        while !rest.is_empty() {
            let (key, behind) = rest.split_once('=').ok_or_else(|| format!("`{rest}` is no key=value"))?;
            let (value, after) = match behind.strip_prefix('"') {
                Some(quoted) => quoted.split_once('"').ok_or_else(|| format!("a quote of `{key}` is not closed"))?,
                None => behind.split_once(char::is_whitespace).unwrap_or((behind, "")),
            };
            if !KEYS.contains(&key) {
                return Err(Error::unknown("key", key, KEYS.iter().copied()).to_string());
            }
            keys.insert(key, value);
            rest = after.trim_start();
        }
        Ok(Keys(keys))
    }

    fn get(&self, key: &str) -> Option<&'a str> {
        self.0.get(key).copied()
    }

    fn need(&self, key: &str) -> Result<&'a str> {
        self.get(key).ok_or_else(|| Error::Incompatible(format!("the marker lacks `{key}`")))
    }

    fn digits(&self) -> Result<usize> {
        let digits = self.get("digits").unwrap_or("2");
        let number = digits.parse().ok().filter(|digits| (1..=8).contains(digits));
        number.ok_or_else(|| Error::invalid("digits", digits, "1 to 8"))
    }

    fn behind(&self, number: String) -> String {
        self.get("unit").map_or_else(|| number.clone(), |unit| format!("{number} {unit}"))
    }

    /// What a page calls something, by `names="identifier=name; …"`.
    fn named(&self, own: &str) -> String {
        let mut names = self.get("names").unwrap_or_default().split(BETWEEN).map(str::trim);
        let found = names.find_map(|name| name.strip_prefix(own)?.trim_start().strip_prefix('='));
        found.map_or(own, str::trim).to_owned()
    }

    /// Rows of a table that meet the conditions.
    fn rows(&self, table: &ResultsTable) -> Result<Vec<usize>> {
        rows_where(table, self.get("where").unwrap_or_default())
    }
}

/// What pages are filled from.
struct Sources {
    folder: PathBuf,
    tables: BTreeMap<String, ResultsTable>,
}

impl Sources {
    /// A file of results; a summary must be the one that its digest tells of.
    fn file(&mut self, name: &str) -> Result<&ResultsTable> {
        if !self.tables.contains_key(name) {
            let path = self.folder.join(name);
            if let Some(folder) = path.parent().filter(|_| path.ends_with("summary.csv")) {
                read_summary(folder)?;
            }
            self.tables.insert(name.to_owned(), read_table(&path)?);
        }
        Ok(&self.tables[name])
    }

    /// The claims of an experiment, with their rows; those of a group that is run as a whole stand together.
    fn claims_of(&mut self, name: &str) -> Result<(&ResultsTable, Vec<usize>)> {
        let own = format!("{name}/claims.csv");
        match name.split_once('/').filter(|_| !self.folder.join(&own).is_file()) {
            None => self.file(&own).map(|claims| (claims, (0..claims.len()).collect())),
            Some((group, experiment)) => {
                let claims = self.file(&format!("{group}/claims.csv"))?;
                Ok((claims, claims.rows_where(claims.column("experiment")?, experiment)))
            }
        }
    }

    /// What a claim measured, or a cell of a file.
    fn value(&mut self, keys: &Keys<'_>) -> Result<String> {
        let (unit, digits) = (keys.get("unit").unwrap_or_default(), keys.digits()?);
        let Some(claim) = keys.get("claim") else {
            let table = self.file(keys.need("file")?)?;
            let column = Column { unit, ..Column::parse(keys.need("column")?, table)? };
            let rows = keys.rows(table)?;
            if column.fold.is_empty() && rows.len() > 1 {
                let conditions = keys.get("where").unwrap_or_default();
                let message = format!("{} rows meet `{conditions}`: say more, or `{}`", rows.len(), FOLDS.join("`, `"));
                return Err(Error::file(table.path(), message));
            }
            return column.shown(table, &rows, digits).map(|number| keys.behind(number));
        };
        let place = claim.rsplit_once(':').ok_or_else(|| Error::invalid("claim", claim, "`group/name:id`"))?;
        let (claims, rows) = self.claims_of(place.0)?;
        let (ids, measured) = (claims.column("id")?, claims.column("measured")?);
        let row = rows.iter().copied().find(|&row| claims.text(row, ids) == place.1);
        let known = rows.iter().map(|&row| claims.text(row, ids));
        let row = row.ok_or_else(|| Error::unknown("claim", place.1, known))?;
        written(claims.number(row, measured), unit, digits).map(|number| keys.behind(number))
    }

    /// The claims of an experiment, a cell for each line and column, or columns of a file.
    fn table(&mut self, keys: &Keys<'_>) -> Result<String> {
        if let Some(experiment) = keys.get("claims") {
            let (claims, rows) = self.claims_of(experiment)?;
            return claims_table(claims, rows, keys);
        }
        let table = self.file(keys.need("file")?)?;
        match keys.get("cell") {
            Some(cell) => pivot(table, cell, keys),
            None => listed(table, keys),
        }
    }
}

fn claims_table(claims: &ResultsTable, rows: Vec<usize>, keys: &Keys<'_>) -> Result<String> {
    let columns = ["text", "measured", "expected", "verdict"].map(|name| claims.column(name));
    let [text, measured, expected, verdict] = columns;
    let (text, measured, expected, verdict) = (text?, measured?, expected?, verdict?);
    let failed = claims.column("failed").ok();
    let wanted = keys.rows(claims)?;
    let mut table = String::from("| claim | measured | expected | |\n|---|---|---|---|\n");
    for row in rows.into_iter().filter(|row| wanted.contains(row)) {
        let [text, expected] = [text, expected].map(|column| claims.text(row, column).replace('|', "\\|"));
        let (value, bound) = (claims.number(row, measured), bound_of(&expected));
        let mut measured = significant(value, bound.map_or(3, |(_, bound)| digits_apart(value, bound, 3)));
        // What a number does not show.
        let meets = bound.is_some_and(|(at_least, bound)| if at_least { value >= bound } else { value <= bound });
        let failed = failed.map_or(0.0, |column| claims.number(row, column));
        if failed > 0.0 && claims.text(row, verdict) == "not-reproduced" && (meets || value.is_nan()) {
            measured += &format!(", {failed} failed");
        }
        table += &format!("| {text} | {measured} | {expected} | {} |\n", claims.text(row, verdict).replace('-', " "));
    }
    Ok(table)
}

/// What lines or columns of a table are: values of a column, `name [in unit] [: value; …]`; all there are, where none is named.
struct Axis<'a> {
    column: usize,
    heading: &'a str,
    unit: &'a str,
    values: Vec<&'a str>,
}

impl<'a> Axis<'a> {
    fn parse(text: &'a str, table: &'a ResultsTable, rows: &[usize]) -> Result<Self> {
        let (name, values) = text.split_once(':').map_or((text, None), |(name, values)| (name, Some(values)));
        let (name, unit) = name.trim().split_once(" in ").unwrap_or((name.trim(), ""));
        let column = table.column(name)?;
        let mut all: Vec<&str> = Vec::new();
        for text in rows.iter().map(|&row| table.text(row, column)) {
            if !all.contains(&text) {
                all.push(text);
            }
        }
        let values = values.map_or(all, |values| values.split(BETWEEN).map(str::trim).collect());
        let heading = if name == "label" { "scheme" } else { name };
        Ok(Axis { column, heading, unit, values })
    }

    /// Whether a row has a value, which is in the unit of the axis where it is named, as in the file where it is not.
    fn has(&self, table: &ResultsTable, row: usize, value: &str) -> bool {
        let number = |value: &str| value.parse().ok().zip(scale(self.unit).ok());
        table.text(row, self.column) == value
            || number(value)
                .is_some_and(|(value, scale): (f64, f64)| same(scale * table.number(row, self.column), value))
    }

    /// A value as a heading.
    fn shown(&self, table: &ResultsTable, rows: &[usize], value: &str, keys: &Keys<'_>) -> String {
        let is_own = |row: &&usize| self.has(table, **row, value);
        match rows.iter().find(is_own).map(|&row| table.number(row, self.column)).zip(scale(self.unit).ok()) {
            // A step in seconds times a thousand is rarely the number that was written.
            Some((number, scale)) if !self.unit.is_empty() => {
                format!("{} {}", (number * scale * 1e6).round() / 1e6, self.unit)
            }
            _ => keys.named(value),
        }
    }
}

/// A cell for each line and column, in brackets how many runs completed where not all did.
fn pivot(table: &ResultsTable, cell: &str, keys: &Keys<'_>) -> Result<String> {
    let (rows, cell) = (keys.rows(table)?, table.column(cell)?);
    let lines = Axis::parse(keys.need("lines")?, table, &rows)?;
    let across = Axis::parse(keys.need("across")?, table, &rows)?;
    let counts = ["completed", "runs"].map(|name| table.column(name).ok());
    let columns: Vec<String> = across.values.iter().map(|value| across.shown(table, &rows, value, keys)).collect();
    let (head, rule) = (columns.join(" | "), "---|".repeat(columns.len()));
    let mut made = format!("| {} | {head} |\n|---|{rule}\n", keys.named(lines.heading));
    for line in &lines.values {
        made += &format!("| {} |", lines.shown(table, &rows, line, keys));
        for column in &across.values {
            let fits = |row: &&usize| lines.has(table, **row, line) && across.has(table, **row, column);
            let found: Vec<usize> = rows.iter().filter(fits).copied().collect();
            let [row] = found[..] else {
                let message = format!("{} rows have `{line}` and `{column}`: say one in `where`", found.len());
                return Err(Error::file(table.path(), message));
            };
            let value = written(table.number(row, cell), keys.get("unit").unwrap_or_default(), keys.digits()?)?;
            let completed = counts.map(|count| count.map(|count| table.number(row, count)));
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

/// A table of some columns. The columns without a fold tell the lines apart where there is one with a fold.
fn listed(table: &ResultsTable, keys: &Keys<'_>) -> Result<String> {
    let columns = keys.need("columns")?.split(BETWEEN).map(|column| Column::parse(column, table));
    let columns: Vec<Column<'_>> = columns.collect::<Result<_>>()?;
    let texts = |row: usize| {
        let own = columns.iter().filter(|column| column.fold.is_empty());
        own.map(|column| table.text(row, column.place)).collect::<Vec<_>>()
    };
    let folded = columns.iter().any(|column| !column.fold.is_empty());
    let mut lines: Vec<Vec<usize>> = Vec::new();
    for row in keys.rows(table)? {
        match lines.iter_mut().find(|line| folded && texts(line[0]) == texts(row)) {
            Some(line) => line.push(row),
            None => lines.push(vec![row]),
        }
    }
    let headings: Vec<String> = columns.iter().map(|column| keys.named(column.heading)).collect();
    let mut made = format!("| {} |\n|{}\n", headings.join(" | "), "---|".repeat(columns.len()));
    for rows in &lines {
        let cells = columns.iter().map(|column| Ok(keys.named(&column.shown(table, rows, keys.digits()?)?)));
        made += &format!("| {} |\n", cells.collect::<Result<Vec<String>>>()?.join(" | "));
    }
    Ok(made)
}

/// Whether two numbers are the same up to how they were written.
fn same(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME * other.abs()
}

/// What a value in SI units is multiplied by to be in a unit.
fn scale(unit: &str) -> Result<f64> {
    let known = UNITS.iter().find(|(name, _)| *name == unit);
    match known {
        Some((_, scale)) => Ok(*scale),
        None if unit.is_empty() => Ok(1.0),
        None => Err(Error::unknown("unit", unit, UNITS.iter().map(|(name, _)| *name))),
    }
}

/// A number as it is shown: in a unit, rounded to significant digits.
fn written(value: f64, unit: &str, digits: usize) -> Result<String> {
    Ok(significant(scale(unit)? * value, digits))
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
fn rows_where(table: &ResultsTable, conditions: &str) -> Result<Vec<usize>> {
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
