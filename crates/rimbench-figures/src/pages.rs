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
//! <!-- value file=perf/solvers/work.csv column="sum pivots" where="solver=lemke" -->51<!-- /value -->   from another file of results
//! ```
//! The keys are told in `docs/development/regenerate.md`.

use crate::claims_table::significant;
use crate::page_rows::{self, BETWEEN, rows_where, same, written};
use rimbench_core::error::{Error, Result};
use rimbench_results::kept::{SUMMARY_METRICS, SummaryRow, read_summary};
use rimbench_results::results_table::{ResultsTable, read_table};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What a marker asks for.
const KINDS: [&str; 3] = ["value", "table", "claims"];

/// Keys of a marker, of which each kind takes some.
const KEYS: [&str; 22] = [
    "of",
    "row",
    "rows",
    "at",
    "case",
    "cases",
    "set",
    "sets",
    "tolerance",
    "tolerances",
    "by",
    "names",
    "metric",
    "stat",
    "digits",
    "unit",
    "over",
    "claim",
    "file",
    "column",
    "columns",
    "where",
];

/// What lines and columns of a table may be: the key of one, that of a list, and the place among the keys of a summary.
const AXES: [(&str, &str, usize); 4] =
    [("row", "rows", 2), ("case", "cases", 0), ("set", "sets", 1), ("tolerance", "tolerances", 4)];

/// What tells rows of a summary apart, the macro step apart: case, set, scheme row, its place left out, tolerance.
type Which<'a> = [Option<&'a str>; 5];

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

    fn digits(&self) -> Result<usize> {
        let digits = self.get("digits").unwrap_or("2");
        let number = digits.parse().ok().filter(|digits| (1..=8).contains(digits));
        number.ok_or_else(|| Error::invalid("digits", digits, "1 to 8"))
    }

    fn written(&self, value: f64) -> Result<String> {
        written(value, self.get("unit").unwrap_or_default(), self.digits()?)
    }

    fn with_unit(&self, value: f64) -> Result<String> {
        self.written(value).map(|number| self.behind(number))
    }

    fn behind(&self, number: String) -> String {
        self.get("unit").map_or_else(|| number.clone(), |unit| format!("{number} {unit}"))
    }

    /// What a page calls something, by `names="identifier=name; …"`.
    fn named(&self, own: &str) -> String {
        let names = self.list("names").unwrap_or_default();
        let found = names.iter().find_map(|name| name.strip_prefix(own)?.trim_start().strip_prefix('='));
        found.map_or(own, str::trim).to_owned()
    }

    fn which(&self) -> Which<'a> {
        let mut which = Which::default();
        for (key, _, place) in AXES {
            which[place] = self.get(key);
        }
        which
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

    fn file(&self, keys: &Keys<'_>) -> Result<Option<ResultsTable>> {
        keys.get("file").map(|file| read_table(&self.folder.join(file))).transpose()
    }

    fn claims_of(&self, keys: &Keys<'_>) -> Result<(ResultsTable, Vec<usize>)> {
        let name = keys.need("of")?;
        let own = self.folder.join(name).join("claims.csv");
        if own.is_file() || !name.contains('/') {
            let claims = read_table(&own)?;
            let all = (0..claims.len()).collect();
            return Ok((claims, all));
        }
        // Those of a group that is run as a whole stand together.
        let (group, experiment) = name.split_once('/').unwrap_or_default();
        let claims = read_table(&self.folder.join(group).join("claims.csv"))?;
        let rows = claims.rows_where(claims.column("experiment")?, experiment);
        Ok((claims, rows))
    }

    /// A cell of a file, a measured claim, a count of claims, or a median.
    fn value(&mut self, keys: &Keys<'_>) -> Result<String> {
        if let Some(table) = self.file(keys)? {
            let (rows, style) =
                (keys.get("where").unwrap_or_default(), (keys.get("unit").unwrap_or_default(), keys.digits()?));
            let value = page_rows::value(&table, keys.need("column")?, rows, keys.get("over"), style)?;
            return Ok(keys.behind(value));
        }
        if let Some(id) = keys.get("claim") {
            let (claims, rows) = self.claims_of(keys)?;
            let (ids, verdict) = (claims.column("id")?, claims.column("verdict")?);
            if matches!(id, "count" | "reproduced") {
                let reproduced = rows.iter().filter(|&&row| claims.text(row, verdict) == "reproduced").count();
                return Ok(if id == "count" { rows.len() } else { reproduced }.to_string());
            }
            let row = rows.iter().copied().find(|&row| claims.text(row, ids) == id);
            let row = row.ok_or_else(|| Error::unknown("claim", id, rows.iter().map(|&row| claims.text(row, ids))))?;
            return keys.with_unit(claims.number(row, claims.column("measured")?));
        }
        let steps = keys.steps()?;
        let [step] = steps[..] else { return Err(Error::invalid("at", steps.len(), "one macro step")) };
        keys.need("row")?;
        let own = number(self.row(keys, keys.which(), step)?, keys)?;
        let other = keys.get("over").map(|other| {
            let mut which = keys.which();
            which[2] = Some(other);
            number(self.row(keys, which, step)?, keys)
        });
        match (own, other.transpose()?) {
            (Cell::Text(text), _) => Ok(text),
            (Cell::Number(own), None) => keys.with_unit(own),
            (Cell::Number(own), Some(Cell::Number(other))) => keys.with_unit(own / other),
            (_, Some(Cell::Text(_))) => Err(Error::invalid("stat", "a count", "a median, for a ratio")),
        }
    }

    /// The one row of a summary that is asked for.
    fn row<'a>(&'a mut self, keys: &Keys<'_>, which: Which<'a>, step: f64) -> Result<&'a SummaryRow> {
        let rows = self.summary(keys)?;
        for (key, _, place) in AXES {
            let known = rows.iter().map(|row| row.keys[place].as_str());
            if let Some(wanted) = which[place].filter(|wanted| !known.clone().any(|own| own == *wanted)) {
                return Err(Error::unknown(key, wanted, BTreeSet::from_iter(known)));
            }
        }
        let found: Vec<&SummaryRow> = fitting(rows, which).filter(|row| is_step(row, step)).collect();
        match found[..] {
            [row] => Ok(row),
            [] => Err(Error::invalid("at", step, format!("one of {}", joined(&steps_of(fitting(rows, which)))))),
            _ => {
                let several =
                    AXES.iter().filter(|axis| found.iter().any(|row| row.keys[axis.2] != found[0].keys[axis.2]));
                let several: Vec<&str> = several.map(|(key, ..)| *key).collect();
                let message = format!("{} rows of the summary fit; say {}", found.len(), several.join(" and "));
                Err(Error::Incompatible(message))
            }
        }
    }

    /// Lines are scheme rows, or what `by` names; columns are macro steps, or what another list names, at one step.
    fn table(&mut self, keys: &Keys<'_>) -> Result<String> {
        if let Some(table) = self.file(keys)? {
            let (columns, rows) = (keys.need("columns")?, keys.get("where").unwrap_or_default());
            return page_rows::table(&table, columns, rows, |own| keys.named(own), keys.digits()?);
        }
        let axis = |key: &str| AXES.into_iter().find(|axis| axis.0 == key);
        let by = keys.get("by").unwrap_or("row");
        let (by, lines, line) = axis(by).ok_or_else(|| Error::unknown("key", by, AXES.map(|(key, ..)| key)))?;
        let across = AXES.into_iter().find(|(key, list, _)| *key != by && keys.get(list).is_some());
        let fitting: Vec<SummaryRow> = fitting(self.summary(keys)?, keys.which()).cloned().collect();
        let known = || fitting.iter().map(|row| row.keys[line].as_str());
        let lines = keys.list(lines).unwrap_or_else(|| {
            let mut all: Vec<&str> = Vec::new();
            known().for_each(|own| {
                if !all.contains(&own) {
                    all.push(own)
                }
            });
            all
        });
        let mut steps = keys.steps()?;
        if steps.is_empty() {
            steps = steps_of(fitting.iter());
        }
        let columns: Vec<(Which<'_>, f64, String)> = match (across, &steps[..]) {
            (None, steps) => steps.iter().map(|&step| (keys.which(), step, format!("{step} ms"))).collect(),
            (Some((_, list, place)), [step]) => {
                let values = keys.list(list).unwrap_or_default();
                let which = |value| {
                    let mut which = keys.which();
                    which[place] = Some(value);
                    which
                };
                values.into_iter().map(|value| (which(value), *step, keys.named(value))).collect()
            }
            (Some((_, list, _)), steps) => {
                return Err(Error::invalid("at", steps.len(), format!("one macro step, where columns are {list}")));
            }
        };
        let header: String = columns.iter().map(|(.., name)| format!(" {name} |")).collect();
        let head = if by == "row" { "scheme" } else { by };
        let mut table = format!("| {} |{header}\n|---|{}\n", keys.named(head), "---|".repeat(columns.len()));
        for name in &lines {
            table += &format!("| {} |", keys.named(name));
            for (mut which, step, _) in columns.iter().cloned() {
                which[line] = Some(*name);
                let row = self.row(keys, which, step)?;
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
        let wanted = rows_where(&claims, keys.get("where").unwrap_or_default())?;
        let rows = rows.into_iter().filter(|row| wanted.contains(row));
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
    Ok(match keys.get("stat").unwrap_or("median") {
        "median" => Cell::Number(row.quartiles[place][1]),
        "completed" => Cell::Text(row.completed.to_string()),
        "runs" => Cell::Text(row.runs.to_string()),
        "worst" => Cell::Number(row.worst.unwrap_or(f64::NAN)),
        // Of the runs that gave an answer.
        "share" => Cell::Number(row.completed as f64 / (row.completed + row.failed) as f64),
        other => return Err(Error::unknown("stat", other, ["median", "completed", "runs", "worst", "share"])),
    })
}

/// Rows of a summary at all their macro steps.
fn fitting<'a>(rows: &'a [SummaryRow], which: Which<'a>) -> impl Iterator<Item = &'a SummaryRow> + Clone {
    rows.iter().filter(move |row| AXES.iter().all(|axis| which[axis.2].is_none_or(|wanted| row.keys[axis.2] == wanted)))
}

/// Macro steps of rows, in milliseconds, in their order.
fn steps_of<'a>(rows: impl Iterator<Item = &'a SummaryRow>) -> Vec<f64> {
    let mut steps: Vec<f64> = Vec::new();
    for step in rows.filter_map(milliseconds) {
        if !steps.iter().any(|other| same(step, *other)) {
            steps.push(step);
        }
    }
    steps
}

fn joined(steps: &[f64]) -> String {
    steps.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
}

fn milliseconds(row: &SummaryRow) -> Option<f64> {
    // A step in seconds times a thousand is rarely the number that was written.
    row.keys[3].parse().ok().map(|step: f64| (step * 1e9).round() / 1e6)
}

fn is_step(row: &SummaryRow, step: f64) -> bool {
    milliseconds(row).is_some_and(|own| same(own, step))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimbench_results::kept::{PooledSets, keep};

    fn results() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let own = folder.path().join("study/x");
        std::fs::create_dir_all(&own).unwrap();
        let runs = "run_id,label,case,set,macro_step_s,step_tolerance,outcome,force_error_rms_n,position_error_rms_m\n\
                    1,a,box,,0.005,,completed,16.6,0.00123\n2,a,box,,0.01,,completed,30,2e-3\n3,a,box,,0.01,,diverged,,\n\
                    4,b,box,,0.005,,completed,8.3,1e-3\n5,b,box,,0.01,,diverged,1e9,1\n";
        std::fs::write(own.join("runs.csv"), runs).unwrap();
        keep(&own, &PooledSets::new(), &"0".repeat(64)).unwrap();
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
    fn lines_may_be_other_than_schemes_and_names_other_than_identifiers() {
        let folder = results();
        let own = folder.path().join("study/x");
        let runs = "label,case,set,macro_step_s,step_tolerance,outcome,force_error_rms_n\n\
                    a,box,c=1 soft,0.005,,completed,1.5\na,box,hard,0.005,,completed,2.5\n\
                    b,box,c=1 soft,0.005,,completed,3.5\nb,box,hard,0.005,,completed,4.5\n";
        std::fs::write(own.join("runs.csv"), runs).unwrap();
        keep(&own, &PooledSets::new(), &"0".repeat(64)).unwrap();
        let table =
            |marker: &str| fill_page("p".as_ref(), &format!("<!-- table {marker} --><!-- /table -->"), folder.path());
        let made = table("of=study/x by=set row=a names=\"c=1 soft=soft stops; set=stops\"").unwrap();
        assert!(made.contains("\n| stops | 5 ms |\n|---|---|\n| soft stops | 1.5 |\n| hard | 2.5 |\n"), "{made}");
        let made = table("of=study/x by=set rows=\"b; a\" at=5 names=\"b=better\"").unwrap();
        assert!(made.contains("\n| set | better | a |\n|---|---|---|\n| c=1 soft | 3.5 | 1.5 |\n"), "{made}");
        let made = table("of=study/x sets=\"hard; c=1 soft\" at=5").unwrap();
        assert!(made.contains("\n| scheme | hard | c=1 soft |\n|---|---|---|\n| a | 2.5 | 1.5 |\n"), "{made}");
        let error = table("of=study/x at=5").unwrap_err().to_string();
        assert!(error.contains("2 rows of the summary fit; say set"), "{error}");
    }

    #[test]
    fn rows_of_other_files_are_chosen_folded_and_held_against_each_other() {
        let folder = results();
        let work = "solver,from,pivots,worst\none,1,3,1e-9\none,65,7,2e-9\ntwo,1,5,0.5\ntwo,65,,0.25\n";
        std::fs::write(folder.path().join("work.csv"), work).unwrap();
        let filled = |text: &str| fill_page("p".as_ref(), text, folder.path());
        let made = filled(
            "<!-- table file=work.csv columns=\"solver; sum pivots as work; max worst in %\" names=\"one=first\" -->\
             <!-- /table -->",
        );
        let lines = "\n| solver | work | max worst |\n|---|---|---|\n| first | 10 | 2.0e-7 |\n| two | 5 | 50 |\n";
        assert!(made.as_ref().unwrap().contains(lines), "{made:?}");
        let made = filled(
            "<!-- table file=work.csv columns=\"solver; worst\" where=\"from>1; solver!=one\" --><!-- /table -->",
        );
        assert!(made.as_ref().unwrap().contains("|---|---|\n| two | 0.25 |\n\n"), "{made:?}");
        for (keys, said) in [
            ("column=\"sum pivots\" where=solver=one", "10"),
            ("column=\"sum pivots\" where=solver=one over=solver=two unit=times", "2.0 times"),
            ("column=count where=\"worst<0.3\"", "3"),
            ("column=worst where=\"solver=two; from=65.0\" unit=%", "25 %"),
            ("column=solver where=\"worst=0.5\"", "two"),
        ] {
            let made = filled(&format!("<!-- value file=work.csv {keys} -->?<!-- /value -->")).unwrap();
            assert!(made.contains(&format!("-->{said}<!--")), "{keys}: {made}");
        }
        for (keys, said) in [
            ("column=pivots where=solver=one", "2 rows meet `solver=one`"),
            ("column=pivots where=solver=on", "`one`"),
            ("column=pivot", "pivots"),
            ("column=\"mean pivots\"", "sum"),
            ("column=pivots where=\"pivots>9\"", "no row meets"),
        ] {
            let error = filled(&format!("<!-- value file=work.csv {keys} --><!-- /value -->")).unwrap_err().to_string();
            assert!(error.contains(said), "{keys}: {error}");
        }
    }

    #[test]
    fn what_cannot_be_filled_is_named_with_its_line() {
        for (marker, said) in [
            ("<!-- value of=study/x row=c at=5 --><!-- /value -->", "`c`"),
            ("<!-- value of=study/x row=a --><!-- /value -->", "at"),
            ("<!-- value of=study/x row=a at=6 --><!-- /value -->", "one of 5, 10"),
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
