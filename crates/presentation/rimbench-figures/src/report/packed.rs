//! Runs, traces and exact values for the script, as one compressed object.
//!
//! A page has a largest size; where all does not fit, less is packed, and the page says what is left out.

use super::Report;
use super::store::Study;
use crate::drawing::{Datum, PanelData, SeriesData};
use crate::live_part::gzipped;
use crate::seven_bits::seven_bits;
use crate::style::labels_in_words;
use rimbench_core::cosim::OutcomeKind;
use rimbench_results::results_table::read_table;
use rimbench_results::run_table::{Run, RunTable};
use rimbench_runs::Finding;
use serde_json::{Map, Value, json};
use std::collections::HashMap;

/// How much is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Detail {
    /// Of each run the main metrics, and those that are checked to the last digit; traces; exact values behind the
    /// figures.
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
const TRACE_ROWS: usize = 36;
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

/// The object, compressed, as letters, with the figures of the studies if they are packed; none if it is longer than
/// `most`.
pub(super) fn data(report: &Report<'_>, detail: Detail, figures: bool, most: usize) -> Option<String> {
    let count: usize = report.studies.iter().filter_map(|study| study.runs.as_ref()).map(|table| table.len()).sum();
    if detail == Detail::Runs && count * LETTERS > most {
        return None;
    }
    let drawn = report.studies.iter().flat_map(|study| &study.figures);
    let drawn = || drawn.clone().filter_map(|(id, _, made)| Some((id.as_str(), made.as_ref().ok()?)));
    let values: Map<String, Value> = drawn().map(|(id, drawing)| (id.to_owned(), panels(drawing.data()))).collect();
    let mut parts = json!({
        "studies": report.studies.iter().map(|study| parts_of(study, detail)).collect::<Vec<_>>(),
        "figures": values,
        "summaries": report.studies.iter().filter_map(summary).collect::<Map<_, _>>(),
    });
    if figures {
        let in_text = report.in_text();
        let others = drawn().filter(|(id, _)| !in_text.contains(id));
        parts["svg"] = others.map(|(id, drawing)| (id.to_owned(), Value::from(drawing.svg()))).collect();
    }
    let letters = seven_bits(&gzipped(parts.to_string().as_bytes()));
    (letters.len() <= most).then_some(letters)
}

/// Columns of a summary that the page shows.
const OF_SUMMARY: [&str; 7] =
    ["case", "set", "label", "macro_step_s", "runs", OutcomeKind::Completed.name(), "force_error_rms_of_peak_median"];

/// The medians that are kept of a study without rows, by its anchor: rows of cells, the header first.
fn summary(study: &Study) -> Option<(String, Value)> {
    let (_, table) = study.kept.as_ref()?;
    let columns: Vec<usize> = OF_SUMMARY.iter().filter_map(|name| table.column(name).ok()).collect();
    let head: Value = columns.iter().map(|&column| table.names()[column].as_str()).collect();
    let cells = |row| columns.iter().map(|&column| table.text(row, column)).collect::<Value>();
    Some((study.anchor(), std::iter::once(head).chain((0..table.len()).map(cells)).collect()))
}

/// A number with so many digits: null for NaN, and the largest number for what is infinite, which JSON does not know.
fn number(value: f64, digits: usize) -> Value {
    if value.is_infinite() {
        return f64::MAX.copysign(value).into();
    }
    let rounded: f64 = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    let whole = rounded as i64;
    // A whole number is written without its fraction.
    if whole as f64 == rounded && whole.abs() < 1 << 53 { whole.into() } else { rounded.into() }
}

fn parts_of(study: &Study, detail: Detail) -> Value {
    let mut parts = json!({ "name": study.name, "anchor": study.anchor() });
    let runs = study.runs.as_ref().filter(|_| detail == Detail::Runs);
    if let Some(table) = runs {
        let runs = table.runs();
        parts["count"] = runs.len().into();
        parts["ids"] = runs.iter().map(|run| format!("{} ", run.id)).collect::<String>().into();
        parts["settings"] = settings(table);
        parts["metrics"] = metrics(table);
        parts["claims"] = claims(study, runs);
        parts["traces"] = traces(study, runs);
    }
    parts
}

/// In the order of the table, of each setting the values that there are, and which of them each run has.
fn settings(table: &RunTable) -> Value {
    let of = |name: &str, text: &dyn for<'r> Fn(&'r Run) -> &'r str| {
        let mut known: Vec<&str> = Vec::new();
        let mut index_of: HashMap<&str, usize> = HashMap::new();
        let index = |run| {
            let cell = text(run);
            *index_of.entry(cell).or_insert_with(|| {
                known.push(cell);
                known.len() - 1
            })
        };
        let indices: Vec<usize> = table.runs().iter().map(index).collect();
        json!([name, if known.len() > 1 { json!([known, indices]) } else { json!([known]) }])
    };
    let planned = table.settings().enumerate().map(|(place, name)| of(name, &move |run| &run.settings[place]));
    let ends = [of("outcome", &|run| run.found.outcome.name()), of("reason", &|run| &run.found.reason)];
    [of("label", &|run| &run.label)].into_iter().chain(planned).chain(ends).collect()
}

fn metrics(table: &RunTable) -> Value {
    let value = |run: &Run, finding| run.found.value(finding);
    let is_number = |finding| table.has(finding) && table.runs().iter().any(|run| !value(run, finding).is_nan());
    let wanted = |own: &Finding| (CHECKED.contains(&own.name()) || MAIN.contains(&own.name())) && is_number(*own);
    let values = |finding: Finding| {
        let exact = CHECKED.contains(&finding.name());
        let cell = |run| match value(run, finding) {
            value if exact && value.is_finite() => value.into(),
            value => number(value, DIGITS),
        };
        json!([finding.name(), table.runs().iter().map(cell).collect::<Vec<_>>()])
    };
    Finding::all().filter(wanted).map(values).collect()
}

/// Each claim with its runs: first and last of each stretch.
fn claims(study: &Study, runs: &[Run]) -> Value {
    let rows: HashMap<&str, usize> = runs.iter().enumerate().map(|(row, run)| (&*run.id, row)).collect();
    let of_claims = study.claims.iter().map(|claim| {
        let mut rows: Vec<usize> = claim.run_ids.iter().filter_map(|id| rows.get(id.as_str()).copied()).collect();
        rows.sort_unstable();
        let stretches = rows.chunk_by(|a, b| *b == a + 1).flat_map(|rows| [rows[0], rows[rows.len() - 1]]);
        json!([labels_in_words(&claim.text), stretches.collect::<Vec<_>>()])
    });
    of_claims.collect()
}

/// Columns of a trace that are packed where it has them; of another, the first few.
const SHOWN: [&str; 4] = ["actuator_force_n", "effective_mass_kg", "actuator_length_m", "actuator_velocity_m_s"];

fn traces(study: &Study, runs: &[Run]) -> Value {
    let of_row = |(row, run): (usize, &Run)| {
        let name = Some(&*run.trace).filter(|name| !name.is_empty())?;
        let trace = read_table(&study.folder.join("traces").join(name)).ok()?;
        let time = trace.column("time_s").ok()?;
        let mut columns: Vec<usize> = SHOWN.iter().filter_map(|name| trace.column(name).ok()).collect();
        if columns.is_empty() {
            columns = (0..trace.names().len()).filter(|column| *column != time).take(SHOWN.len()).collect();
        }
        columns.insert(0, time);
        let every = trace.len().div_ceil(TRACE_ROWS).max(1);
        let value = |row, column| number(trace.number(row, column), 4);
        let entries = columns.iter().map(|&column| {
            json!([
                trace.names()[column],
                (0..trace.len()).step_by(every).map(|row| value(row, column)).collect::<Vec<_>>()
            ])
        });
        Some((row.to_string(), entries.collect()))
    };
    runs.iter().enumerate().filter_map(of_row).collect::<Map<_, Value>>().into()
}

/// Most points of a series; a trace has more.
const POINTS: usize = 40;

fn panels(panels: &[PanelData]) -> Value {
    let series = |series: &SeriesData| {
        let every = series.points.len().div_ceil(POINTS).max(1);
        json!([series.name, every, series.points.iter().step_by(every).map(point).collect::<Vec<_>>()])
    };
    let panel =
        |panel: &PanelData| json!([panel.title, panel.x, panel.y, panel.series.iter().map(series).collect::<Vec<_>>()]);
    panels.iter().map(panel).collect()
}

/// `[x, y, least, most, across, down, note]`, as short as its end allows.
fn point(point: &Datum) -> Value {
    let mut parts = vec![number(point.x, 5), number(point.y, 4)];
    if point.range.is_some() || point.at.is_some() || !point.note.is_empty() {
        parts.extend(point.range.unwrap_or([f64::NAN; 2]).map(|end| number(end, 4)));
    }
    match point.at {
        Some((across, down)) => parts.extend([across, down].map(|at| Value::from(at.round() as i64))),
        None if !point.note.is_empty() => parts.extend([Value::Null, Value::Null]),
        None => {}
    }
    parts.extend((!point.note.is_empty()).then(|| point.note.as_str().into()));
    parts.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_short_as_their_digits_allow() {
        let written = |value, digits| number(value, digits).to_string();
        assert_eq!(written(1234.5678, 3), "1230");
        assert_eq!(written(5.0, 6), "5");
        assert_eq!(written(-0.000_251_23, 3), "-0.000251");
        assert_eq!(written(f64::NAN, 4), "null");
        assert_eq!(number(f64::NEG_INFINITY, 4).as_f64(), Some(-f64::MAX));
        assert_eq!(written(0.0, 4), "0");
    }

    #[test]
    fn a_point_is_as_long_as_what_is_known_of_it() {
        let plain = Datum { x: 1.0, y: 2.0, range: None, note: String::new(), at: None };
        assert_eq!(point(&plain), json!([1, 2]));
        assert_eq!(point(&Datum { at: Some((3.2, 4.0)), ..plain.clone() }), json!([1, 2, null, null, 3, 4]));
        let noted = Datum { note: "a".to_owned(), y: f64::NAN, ..plain };
        assert_eq!(point(&noted), json!([1, null, null, null, null, null, "a"]));
    }
}
