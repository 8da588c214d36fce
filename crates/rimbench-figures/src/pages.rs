//! Numbers in pages: what stands between two markers is filled from summaries and claims, so that no page is older than its data.
//!
//! ```text
//! <!-- value of=study/x row=rim-nonsmooth at=5 unit=N -->16.6 N<!-- /value -->       a number in a sentence
//! <!-- table of=study/x rows="zero-order-hold; rim-nonsmooth" at="1 2 5" -->         medians, one line per scheme row
//! …
//! <!-- /table -->
//! <!-- claims of=study/x -->                                                         the claims and what came of them
//! …
//! <!-- /claims -->
//! ```
//! The keys are told in `docs/development/regenerate.md`.

use crate::claims_table::significant;
use rimbench_core::error::{Error, Result};
use rimbench_results::kept::{SUMMARY_METRICS, SummaryRow, read_summary};
use rimbench_results::results_table::ResultsTable;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Relative slack when a macro step is looked up.
const SAME_STEP: f64 = 1e-9;

/// What a marker asks for.
const KINDS: [&str; 3] = ["value", "table", "claims"];

/// Keys of a marker, of which each kind takes some.
const KEYS: [&str; 14] = [
    "of",
    "row",
    "rows",
    "at",
    "case",
    "cases",
    "set",
    "tolerance",
    "metric",
    "stat",
    "digits",
    "unit",
    "over",
    "claim",
];

/// What is between the parts of a list in a marker.
const BETWEEN: char = ';';

/// Units that a number may be shown in: what a value in SI units is multiplied by.
const UNITS: [(&str, f64); 9] =
    [("N", 1.0), ("J", 1.0), ("m", 1.0), ("kg", 1.0), ("s", 1.0), ("mm", 1e3), ("µm", 1e6), ("%", 1e2), ("times", 1.0)];

/// Fills all markers of a page from the results in a folder.
///
/// # Errors
/// [`Error::File`] with page, line and what is wrong: a marker that is not closed, a key, a row or a claim that is not there; a
/// summary that is missing or damaged.
pub fn fill_page(page: &Path, text: &str, results: &Path) -> Result<String> {
    let mut sources = Sources { folder: results.to_owned(), summaries: BTreeMap::new() };
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
            "table" => sources.table(&keys).map(|table| format!("\n\n{table}\n")),
            _ => sources.claims(&keys).map(|table| format!("\n\n{table}\n")),
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

    fn list(&self, key: &str) -> Option<Vec<&'a str>> {
        self.get(key).map(|list| list.split(BETWEEN).map(str::trim).collect())
    }

    /// Macro steps in milliseconds.
    fn steps(&self) -> Result<Vec<f64>> {
        let number = |text: &str| text.parse().map_err(|_| Error::invalid("at", text, "macro steps in milliseconds"));
        self.get("at").unwrap_or_default().split_whitespace().map(number).collect()
    }

    fn written(&self, value: f64) -> Result<String> {
        let unit = self.get("unit").unwrap_or_default();
        let scale = match UNITS.iter().find(|(name, _)| *name == unit) {
            Some((_, scale)) => *scale,
            None if unit.is_empty() => 1.0,
            None => return Err(Error::unknown("unit", unit, UNITS.iter().map(|(name, _)| *name))),
        };
        let digits = self.get("digits").unwrap_or("2");
        let digits = digits
            .parse()
            .ok()
            .filter(|digits| (1..=8).contains(digits))
            .ok_or_else(|| Error::invalid("digits", digits, "1 to 8"))?;
        Ok(significant(scale * value, digits))
    }

    fn with_unit(&self, value: f64) -> Result<String> {
        let number = self.written(value)?;
        Ok(self.get("unit").map_or_else(|| number.clone(), |unit| format!("{number} {unit}")))
    }
}

/// What pages are filled from.
struct Sources {
    folder: PathBuf,
    summaries: BTreeMap<String, Vec<SummaryRow>>,
}

impl Sources {
    fn summary(&mut self, keys: &Keys<'_>) -> Result<&[SummaryRow]> {
        let name = keys.need("of")?;
        if !self.summaries.contains_key(name) {
            self.summaries.insert(name.to_owned(), read_summary(&self.folder.join(name))?);
        }
        Ok(&self.summaries[name])
    }

    fn claims_of(&self, keys: &Keys<'_>) -> Result<(ResultsTable, Vec<usize>)> {
        let name = keys.need("of")?;
        let own = self.folder.join(name).join("claims.csv");
        if own.is_file() || !name.contains('/') {
            let claims = ResultsTable::read(&own)?;
            let all = (0..claims.len()).collect();
            return Ok((claims, all));
        }
        // Those of a group that is run as a whole stand together.
        let (group, experiment) = name.split_once('/').unwrap_or_default();
        let claims = ResultsTable::read(&self.folder.join(group).join("claims.csv"))?;
        let rows = claims.rows_where(claims.column("experiment")?, experiment);
        Ok((claims, rows))
    }

    /// A measured claim, a count of claims, or a median.
    fn value(&mut self, keys: &Keys<'_>) -> Result<String> {
        if let Some(id) = keys.get("claim") {
            let (claims, rows) = self.claims_of(keys)?;
            let (ids, verdict) = (claims.column("id")?, claims.column("verdict")?);
            if matches!(id, "count" | "reproduced") {
                let reproduced = rows.iter().filter(|&&row| claims.text(row, verdict) == "reproduced").count();
                return Ok(if id == "count" { rows.len() } else { reproduced }.to_string());
            }
            let row = rows.iter().copied().find(|&row| claims.text(row, ids) == id);
            let row = row.ok_or_else(|| Error::unknown("claim", id, rows.iter().map(|&row| claims.text(row, ids))))?;
            return match keys.get("stat").unwrap_or("measured") {
                "verdict" => Ok(claims.text(row, verdict).replace('-', " ")),
                column @ ("measured" | "low" | "high") => keys.with_unit(claims.number(row, claims.column(column)?)),
                other => Err(Error::unknown("stat", other, ["measured", "low", "high", "verdict"])),
            };
        }
        let steps = keys.steps()?;
        let [step] = steps[..] else { return Err(Error::invalid("at", steps.len(), "one macro step")) };
        let row = keys.need("row")?;
        let own = number(self.row(keys, row, step, keys.get("case"))?, keys)?;
        let other = keys.get("over").map(|other| number(self.row(keys, other, step, keys.get("case"))?, keys));
        match (own, other.transpose()?) {
            (Cell::Text(text), _) => Ok(text),
            (Cell::Number(own), None) => keys.with_unit(own),
            (Cell::Number(own), Some(Cell::Number(other))) => keys.with_unit(own / other),
            (_, Some(Cell::Text(_))) => Err(Error::invalid("stat", "a count", "a quartile, for a ratio")),
        }
    }

    fn row(&mut self, keys: &Keys<'_>, label: &str, step: f64, case: Option<&str>) -> Result<&SummaryRow> {
        let is =
            |row: &SummaryRow, key: usize, wanted: Option<&str>| wanted.is_none_or(|wanted| row.keys[key] == wanted);
        let (set, tolerance) = (keys.get("set"), keys.get("tolerance"));
        let found: Vec<&SummaryRow> = self
            .summary(keys)?
            .iter()
            .filter(|row| is(row, 0, case) && is(row, 1, set) && row.keys[2] == label && is(row, 4, tolerance))
            .filter(|row| is_step(row, step))
            .collect();
        match found[..] {
            [row] => Ok(row),
            _ => Err(Error::Incompatible(format!(
                "{} rows of the summary are `{label}` at {step} ms; say case, set or tolerance where there are several",
                found.len()
            ))),
        }
    }

    fn table(&mut self, keys: &Keys<'_>) -> Result<String> {
        let mut steps = keys.steps()?;
        let rows = self.summary(keys)?;
        let mut labels: Vec<String> = Vec::new();
        let mut known: Vec<f64> = Vec::new();
        for row in rows.iter().filter(|row| keys.get("case").is_none_or(|case| row.keys[0] == case)) {
            if !labels.contains(&row.keys[2]) {
                labels.push(row.keys[2].clone());
            }
            known.extend(milliseconds(row).filter(|step| !known.iter().any(|other| same(*step, *other))));
        }
        if steps.is_empty() {
            steps = known;
        }
        if let Some(wanted) = keys.list("rows") {
            labels = wanted.into_iter().map(str::to_owned).collect();
        }
        // Columns are macro steps, or cases at one of them.
        let columns: Vec<(Option<&str>, f64, String)> = match (keys.list("cases"), &steps[..]) {
            (None, steps) => steps.iter().map(|&step| (keys.get("case"), step, format!("{step} ms"))).collect(),
            (Some(cases), [step]) => cases.into_iter().map(|case| (Some(case), *step, case.to_owned())).collect(),
            (Some(_), steps) => {
                return Err(Error::invalid("at", steps.len(), "one macro step, where columns are cases"));
            }
        };
        let header: String = columns.iter().map(|(.., name)| format!(" {name} |")).collect();
        let mut table = format!("| scheme |{header}\n|---|{}\n", "---|".repeat(columns.len()));
        for label in &labels {
            table += &format!("| {label} |");
            for (case, step, _) in &columns {
                let row = self.row(keys, label, *step, *case)?;
                let cell = match number(row, keys)? {
                    Cell::Text(text) => text,
                    Cell::Number(_) if row.completed == 0 => "–".to_owned(),
                    Cell::Number(value) if row.completed < row.runs => {
                        format!("{} ({})", keys.written(value)?, row.completed)
                    }
                    Cell::Number(value) => keys.written(value)?,
                };
                table += &format!(" {cell} |");
            }
            table.push('\n');
        }
        Ok(table)
    }

    fn claims(&self, keys: &Keys<'_>) -> Result<String> {
        let (claims, rows) = self.claims_of(keys)?;
        let [text, measured, expected, verdict] =
            ["text", "measured", "expected", "verdict"].map(|name| claims.column(name));
        let (text, measured, expected, verdict) = (text?, measured?, expected?, verdict?);
        let mut table = String::from("| claim | measured | expected | |\n|---|---|---|---|\n");
        for row in rows {
            let [text, expected] = [text, expected].map(|column| claims.text(row, column).replace('|', "\\|"));
            let measured = significant(claims.number(row, measured), 3);
            table +=
                &format!("| {text} | {measured} | {expected} | {} |\n", claims.text(row, verdict).replace('-', " "));
        }
        Ok(table)
    }
}

/// What is shown of a row.
enum Cell {
    Number(f64),
    Text(String),
}

fn number(row: &SummaryRow, keys: &Keys<'_>) -> Result<Cell> {
    let metric = keys.get("metric").unwrap_or(SUMMARY_METRICS[0]);
    let place = SUMMARY_METRICS.iter().position(|name| *name == metric);
    let place = place.ok_or_else(|| Error::unknown("metric", metric, SUMMARY_METRICS))?;
    let [low, middle, high] = row.quartiles[place];
    Ok(match keys.get("stat").unwrap_or("median") {
        "median" => Cell::Number(middle),
        "q1" => Cell::Number(low),
        "q3" => Cell::Number(high),
        "completed" => Cell::Text(row.completed.to_string()),
        "runs" => Cell::Text(row.runs.to_string()),
        other => return Err(Error::unknown("stat", other, ["median", "q1", "q3", "completed", "runs"])),
    })
}

fn milliseconds(row: &SummaryRow) -> Option<f64> {
    // A step in seconds times a thousand is rarely the number that was written.
    row.keys[3].parse().ok().map(|step: f64| (step * 1e9).round() / 1e6)
}

fn is_step(row: &SummaryRow, step: f64) -> bool {
    milliseconds(row).is_some_and(|own| same(own, step))
}

fn same(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME_STEP * other.abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimbench_results::kept::keep;

    fn results() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let own = folder.path().join("study/x");
        std::fs::create_dir_all(&own).unwrap();
        let runs = "run_id,label,case,set,macro_step_s,step_tolerance,outcome,force_error_rms_n,position_error_rms_m\n\
                    1,a,box,,0.005,,completed,16.6,0.00123\n2,a,box,,0.01,,completed,30,2e-3\n3,a,box,,0.01,,diverged,,\n\
                    4,b,box,,0.005,,completed,8.3,1e-3\n5,b,box,,0.01,,diverged,1e9,1\n";
        std::fs::write(own.join("runs.csv"), runs).unwrap();
        keep(&own).unwrap();
        let claims = "experiment,id,text,measured,low,high,expected,verdict\nx,floor,t,43.26,40,50,≥ 2,reproduced\n";
        std::fs::write(own.join("claims.csv"), claims).unwrap();
        folder
    }

    fn filled(text: &str) -> Result<String> {
        fill_page("page.md".as_ref(), text, results().path())
    }

    #[test]
    fn markers_are_filled_and_what_is_around_them_stays() {
        let page = "It has <!-- value of=study/x row=a at=5 unit=N digits=3 -->?<!-- /value -->, \
                    <!-- value of=study/x row=a at=5 over=b -->?<!-- /value --> times b, \
                    <!-- value of=study/x row=a at=5 metric=position_error_rms_m unit=mm -->?<!-- /value -->, and \
                    <!-- value of=study/x claim=floor unit=N -->?<!-- /value --> of \
                    <!-- value of=study/x claim=count -->?<!-- /value -->.";
        let once = filled(page).unwrap();
        let text: String =
            once.split("<!--").map(|part| part.split_once("-->").map_or(part, |(_, text)| text)).collect();
        assert_eq!(text, "It has 16.6 N, 2.0 times b, 1.2 mm, and 43 N of 1.");
        assert_eq!(filled(&once).unwrap(), once);
        assert_eq!(without_filled(&once), "It has ,  times b, , and  of .");
        let example = "```text\n<!-- value of=nothing -->\n```\n";
        assert_eq!(filled(example).unwrap(), example);
    }

    #[test]
    fn a_table_says_how_many_completed_where_not_all_did() {
        let table = filled("<!-- table of=study/x at=\"5 10\" digits=3 --><!-- /table -->").unwrap();
        assert!(
            table.contains("\n| scheme | 5 ms | 10 ms |\n|---|---|---|\n| a | 16.6 | 30.0 (1) |\n| b | 8.30 | – |\n"),
            "{table}"
        );
        let claims = filled("<!-- claims of=study/x -->\n<!-- /claims -->").unwrap();
        assert!(claims.contains("| t | 43.3 | ≥ 2 | reproduced |"), "{claims}");
    }

    #[test]
    fn what_cannot_be_filled_is_named_with_its_line() {
        for (marker, said) in [
            ("<!-- value of=study/x row=c at=5 --><!-- /value -->", "0 rows of the summary are `c` at 5 ms"),
            ("<!-- value of=study/x row=a --><!-- /value -->", "at"),
            ("<!-- value of=study/x claim=flor --><!-- /value -->", "`floor`"),
            ("<!-- value of=study/x colour=red --><!-- /value -->", "colour"),
            ("<!-- value of=study/y row=a at=5 --><!-- /value -->", "digest.toml"),
            ("<!-- value of=study/x row=a at=5 -->", "is not closed"),
            ("<!-- value of=study/x row=a at=5 unit=ft --><!-- /value -->", "ft"),
        ] {
            let error = filled(&format!("one\n{marker}")).unwrap_err().to_string();
            assert!(error.contains("page.md: line 2") && error.contains(said), "{marker}: {error}");
        }
    }
}
