//! Runs, traces and exact values for the script, as one compressed object.
//!
//! A page has a largest size; where all does not fit, less is packed, and the page says what is left out.

use super::Report;
use super::store::Study;
use crate::drawing::{Datum, PanelData, SeriesData};
use crate::seven_bits::seven_bits;
use flate2::Compression;
use flate2::write::GzEncoder;
use rimbench_core::cosim::OutcomeKind;
use rimbench_core::error::{Error, Result};
use rimbench_results::results_table::{ResultsTable, read_table};
use rimbench_statistics::{Run, Runs};
use std::collections::HashMap;
use std::io::Write as _;

/// How much is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Detail {
    /// Of each run the main metrics, and those that are checked to the last digit; traces; exact values behind the figures.
    Runs,
    /// Exact values behind the figures.
    Values,
}

/// Metrics that no reference has a part in, to be compared to the last digit.
const CHECKED: [&str; 3] = ["work_sent_j", "force_peak_n", "exchanges"];

/// Metrics that are packed of every run.
const MAIN: [&str; 4] =
    ["force_error_rms_n", "position_error_rms_m", "interface_residual_j", "force_error_rms_of_peak"];

/// Most rows of a trace.
const TRACE_ROWS: usize = 150;
/// Digits of a metric that is not checked.
const DIGITS: usize = 4;
/// Letters that a run takes at the very least.
const LETTERS: usize = 35;

impl Detail {
    /// What is left out of a page with so much, in sentences.
    pub(super) fn left_out(self, studies: &[Study]) -> Vec<String> {
        let size = format!("so that the page is no larger than {} MB", super::MOST_BYTES as f64 / 1e6);
        if self == Detail::Values {
            return vec![format!("The table of runs, {size}: a page of one group or one study has it.")];
        }
        let mut left_out = vec!["Of each run the main metrics only: `runs.csv` has all.".to_owned()];
        if studies.iter().any(|study| study.folder.join("traces").is_dir()) {
            left_out.push(format!("Traces are thinned to {TRACE_ROWS} rows and a few columns."));
        }
        left_out
    }
}

/// The object, compressed, as letters, with the figures of the studies if they are packed; none if it is longer than `most`.
pub(super) fn data(report: &Report<'_>, detail: Detail, figures: bool, most: usize) -> Result<Option<String>> {
    let count: usize = report.studies.iter().filter_map(|study| study.runs.as_ref()).map(ResultsTable::len).sum();
    if detail == Detail::Runs && count * LETTERS > most {
        return Ok(None);
    }
    let drawn = report.studies.iter().flat_map(|study| &study.figures);
    let drawn = || drawn.clone().filter_map(|(id, _, made)| Some((id.as_str(), made.as_ref().ok()?)));
    let values = drawn().map(|(id, drawing)| (id, panels(drawing.data())));
    let mut parts = vec![
        ("studies", list(report.studies.iter().map(|study| object(parts_of(study, detail))))),
        ("figures", object(values)),
        ("summaries", object(report.studies.iter().filter_map(summary))),
    ];
    if figures {
        let in_text = report.in_text();
        let others = drawn().filter(|(id, _)| !in_text.contains(id));
        parts.push(("svg", object(others.map(|(id, drawing)| (id, text(&drawing.svg()))))));
    }
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    let packed = packed.write_all(object(parts).as_bytes()).and_then(|()| packed.finish());
    let packed = packed.map_err(|error| Error::Incompatible(format!("the runs cannot be packed: {error}")))?;
    let letters = seven_bits(&packed);
    Ok((letters.len() <= most).then_some(letters))
}

/// Columns of a summary that the page shows.
const OF_SUMMARY: [&str; 7] =
    ["case", "set", "label", "macro_step_s", "runs", OutcomeKind::Completed.name(), "force_error_rms_of_peak_median"];

/// The medians that are kept of a study without rows, by its anchor: rows of cells, the header first.
fn summary(study: &Study) -> Option<(String, String)> {
    let (_, table) = study.kept.as_ref()?;
    let columns: Vec<usize> = OF_SUMMARY.iter().filter_map(|name| table.column(name).ok()).collect();
    let cells = |cell: &dyn Fn(usize) -> String| list(columns.iter().map(|&column| cell(column)));
    let head = cells(&|column| text(&table.names()[column]));
    let rows = (0..table.len()).map(|row| cells(&|column| text(table.text(row, column))));
    Some((study.anchor(), list(std::iter::once(head).chain(rows))))
}

/// Writes a list in JSON.
fn list(items: impl IntoIterator<Item = String>) -> String {
    format!("[{}]", items.into_iter().collect::<Vec<_>>().join(","))
}

/// Writes an object in JSON.
fn object<K: AsRef<str>>(entries: impl IntoIterator<Item = (K, String)>) -> String {
    let entries: Vec<String> =
        entries.into_iter().map(|(key, value)| format!("{}:{value}", text(key.as_ref()))).collect();
    format!("{{{}}}", entries.join(","))
}

fn text(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// A number with so many digits, as JSON: null for NaN, and beyond all numbers for what is infinite.
fn number(value: f64, digits: usize) -> String {
    if value.is_nan() {
        return "null".to_owned();
    }
    if value.is_infinite() {
        return if value > 0.0 { "1e999" } else { "-1e999" }.to_owned();
    }
    let written = format!("{value:.*e}", digits - 1);
    let (mantissa, exponent) = written.split_once('e').unwrap_or((&written, "0"));
    let mantissa = if mantissa.contains('.') { mantissa.trim_end_matches('0').trim_end_matches('.') } else { mantissa };
    if exponent == "0" { mantissa.to_owned() } else { format!("{mantissa}e{exponent}") }
}

fn parts_of(study: &Study, detail: Detail) -> Vec<(&'static str, String)> {
    let mut parts = vec![("name", text(&study.name)), ("anchor", text(&study.anchor()))];
    let runs = study.runs.as_ref().filter(|_| detail == Detail::Runs);
    // A study without these has no runs, and a remark that says so.
    let runs = runs.and_then(|table| Some((table, Runs::of(table).ok()?, table.column("outcome").ok()?)));
    if let Some((table, runs, outcome)) = runs {
        parts.extend([
            ("count", table.len().to_string()),
            ("ids", text(&runs.iter().map(|run| format!("{} ", run.id)).collect::<String>())),
            ("settings", settings(table, outcome)),
            ("metrics", metrics(table, outcome)),
            ("claims", claims(study, &runs)),
            ("traces", traces(study, &runs)),
        ]);
    }
    parts
}

/// Of each setting the values that there are, and which of them each run has.
fn settings(runs: &ResultsTable, outcome: usize) -> String {
    let names = runs.names().iter().enumerate().take(outcome + 1).skip(1).map(|(column, name)| (name.as_str(), column));
    let reasons = runs.column("reason").ok();
    let setting = |(name, column)| {
        let mut known: Vec<&str> = Vec::new();
        let mut index_of: HashMap<&str, usize> = HashMap::new();
        let index = |row: usize| {
            let cell = runs.text(row, column);
            *index_of.entry(cell).or_insert_with(|| {
                known.push(cell);
                known.len() - 1
            })
        };
        let indices = list((0..runs.len()).map(index).map(|index| index.to_string()));
        let values = list(known.iter().map(|cell| text(cell)));
        (name, list(if known.len() > 1 { vec![values, indices] } else { vec![values] }))
    };
    object(names.chain(reasons.map(|column| ("reason", column))).map(setting))
}

fn metrics(runs: &ResultsTable, outcome: usize) -> String {
    let names = runs.names().iter().map(String::as_str).enumerate().skip(outcome);
    let wanted = |(column, name): &(usize, &str)| {
        // Of several columns of one name the last is the counter.
        let is_number = || (0..runs.len()).any(|row| !runs.number(row, *column).is_nan());
        (CHECKED.contains(name) || MAIN.contains(name)) && is_number() && runs.last_column(name).ok() == Some(*column)
    };
    object(names.filter(wanted).map(|(column, name)| {
        let exact = CHECKED.contains(&name);
        let cell = |row: usize| match runs.number(row, column) {
            value if exact && value.is_finite() => format!("{value:?}"),
            value => number(value, DIGITS),
        };
        (name, list((0..runs.len()).map(cell)))
    }))
}

/// Each claim with its runs: first and last of each stretch.
fn claims(study: &Study, runs: &Runs<'_>) -> String {
    let rows: HashMap<&str, usize> = runs.iter().enumerate().map(|(row, run)| (run.id, row)).collect();
    list(study.claims.iter().map(|claim| {
        let mut rows: Vec<usize> = claim.run_ids.iter().filter_map(|id| rows.get(id.as_str()).copied()).collect();
        rows.sort_unstable();
        let stretches = rows.chunk_by(|a, b| *b == a + 1).map(|rows| format!("{},{}", rows[0], rows[rows.len() - 1]));
        list([text(&claim.text), list(stretches)])
    }))
}

/// Columns of a trace that are packed where it has them; of another, the first few.
const SHOWN: [&str; 4] = ["actuator_force_n", "effective_mass_kg", "actuator_length_m", "actuator_velocity_m_s"];

fn traces(study: &Study, runs: &Runs<'_>) -> String {
    let of_row = |(row, run): (usize, &Run<'_>)| {
        let name = Some(run.trace).filter(|name| !name.is_empty())?;
        let trace = read_table(&study.folder.join("traces").join(name)).ok()?;
        let time = trace.column("time_s").ok()?;
        let mut columns: Vec<usize> = SHOWN.iter().filter_map(|name| trace.column(name).ok()).collect();
        if columns.is_empty() {
            columns = (0..trace.names().len()).filter(|column| *column != time).take(SHOWN.len()).collect();
        }
        columns.insert(0, time);
        let every = trace.len().div_ceil(TRACE_ROWS).max(1);
        let values = |column| list((0..trace.len()).step_by(every).map(|row| number(trace.number(row, column), 5)));
        let entries = columns.iter().map(|&column| (trace.names()[column].as_str(), values(column)));
        Some((row.to_string(), object(entries)))
    };
    object(runs.iter().enumerate().filter_map(of_row))
}

/// Most points of a series; a trace has more.
const POINTS: usize = 160;

fn panels(panels: &[PanelData]) -> String {
    let series = |series: &SeriesData| {
        let every = series.points.len().div_ceil(POINTS).max(1);
        list([text(&series.name), every.to_string(), list(series.points.iter().step_by(every).map(point))])
    };
    let panel = |panel: &PanelData| {
        list([text(&panel.title), text(&panel.x), text(&panel.y), list(panel.series.iter().map(series))])
    };
    list(panels.iter().map(panel))
}

/// `[x, y, least, most, across, down, note]`, as short as its end allows.
fn point(point: &Datum) -> String {
    let mut parts = vec![number(point.x, 5), number(point.y, 5)];
    if point.range.is_some() || point.at.is_some() || !point.note.is_empty() {
        parts.extend(point.range.unwrap_or([f64::NAN; 2]).map(|end| number(end, 4)));
    }
    match point.at {
        Some((across, down)) => parts.extend([across, down].map(|at| format!("{at:.0}"))),
        None if !point.note.is_empty() => parts.extend(["null"; 2].map(str::to_owned)),
        None => {}
    }
    parts.extend((!point.note.is_empty()).then(|| text(&point.note)));
    list(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_short_as_their_digits_allow() {
        assert_eq!(number(1234.5678, 3), "1.23e3");
        assert_eq!(number(5.0, 6), "5");
        assert_eq!(number(-0.000_25, 4), "-2.5e-4");
        assert_eq!(number(f64::NAN, 4), "null");
        assert_eq!(number(f64::NEG_INFINITY, 4), "-1e999");
        assert_eq!(number(0.0, 4), "0");
    }

    #[test]
    fn a_point_is_as_long_as_what_is_known_of_it() {
        let plain = Datum { x: 1.0, y: 2.0, range: None, note: String::new(), at: None };
        assert_eq!(point(&plain), "[1,2]");
        assert_eq!(point(&Datum { at: Some((3.2, 4.0)), ..plain.clone() }), "[1,2,null,null,3,4]");
        let noted = Datum { note: "a".to_owned(), y: f64::NAN, ..plain };
        assert_eq!(point(&noted), "[1,null,null,null,null,null,\"a\"]");
    }
}
