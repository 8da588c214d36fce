//! Runs, traces and exact values for the script, as one compressed object.
//!
//! A page has a largest size; where all does not fit, less is packed, and the page says what is left out.

use super::Report;
use super::store::Study;
use crate::drawing::{Datum, PanelData};
use crate::vector;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use rimbench_core::error::{Error, Result};
use rimbench_results::results_table::{ResultsTable, read_table};
use std::collections::HashMap;
use std::fmt::Write as _;
use std::io::Write as _;

/// How much of the runs is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd)]
pub(super) enum Detail {
    /// Every metric and counter.
    Full,
    /// The main metrics, and those that are checked, to the last digit.
    Digits,
    /// The main metrics only.
    Main,
    /// Settings and outcomes, two metrics.
    Least,
    /// No runs.
    NoRuns,
    /// Neither runs nor exact values.
    Nothing,
}

/// Metrics that no reference has a part in, to be compared to the last digit.
const CHECKED: [&str; 3] = ["work_sent_j", "force_peak_n", "exchanges"];

/// Metrics that are packed of every run.
const MAIN: [&str; 4] =
    ["force_error_rms_n", "position_error_rms_m", "interface_residual_j", "force_error_rms_of_peak"];

impl Detail {
    pub(super) const ALL: [Detail; 6] =
        [Detail::Full, Detail::Digits, Detail::Main, Detail::Least, Detail::NoRuns, Detail::Nothing];

    /// Most rows of a trace.
    fn rows(self) -> usize {
        match self {
            Detail::Full => 400,
            Detail::Digits => 150,
            _ => 0,
        }
    }

    /// Digits of a metric.
    fn digits(self) -> usize {
        match self {
            Detail::Full => 6,
            Detail::Digits => 4,
            _ => 3,
        }
    }

    /// Digits of a run id.
    fn id(self) -> usize {
        match self {
            Detail::Full | Detail::Digits => 16,
            Detail::Main => 8,
            _ => 6,
        }
    }

    /// Letters that a run takes at the very least.
    fn letters(self) -> usize {
        match self {
            Detail::Full => 110,
            Detail::Digits => 35,
            Detail::Main => 14,
            Detail::Least => 7,
            Detail::NoRuns | Detail::Nothing => 0,
        }
    }

    /// What is left out of a page with so much, in sentences.
    pub(super) fn left_out(self, studies: &[Study]) -> Vec<String> {
        let traces = studies.iter().any(|study| study.folder.join("traces").is_dir());
        let mut left_out = Vec::new();
        let size = format!("so that the page is no larger than {} MB", super::MOST_BYTES / 1_000_000);
        match self {
            Detail::Full if traces => left_out.push("Traces are thinned to 400 rows and a few columns.".to_owned()),
            Detail::Full => {}
            Detail::Digits => {
                left_out.push(format!("Of each run the main metrics only, {size}: `runs.csv` has all."));
                if traces {
                    left_out.push(format!("Traces are thinned to 150 rows and a few columns, {size}."));
                }
            }
            Detail::Main | Detail::Least => left_out.push(format!(
                "Of each run {} metrics with three digits and the first {} digits of its id, and no traces, {size}: a page of one group or one study has more.",
                if self == Detail::Main { "four" } else { "two" },
                self.id()
            )),
            Detail::NoRuns => left_out.push(format!("The table of runs, {size}: a page of one group or one study has it.")),
            Detail::Nothing => {
                left_out.push(format!("The table of runs and the exact values behind the figures, {size}: a page of fewer studies has them."));
            }
        }
        left_out
    }
}

/// The object, compressed, as letters, with the figures of the studies if they are packed; none if it is longer than `most`.
pub(super) fn data(report: &Report<'_>, detail: Detail, figures: bool, most: usize) -> Result<Option<String>> {
    let count: usize = report.studies.iter().filter_map(|study| study.runs.as_ref()).map(ResultsTable::len).sum();
    if count * detail.letters() > most {
        return Ok(None);
    }
    let mut json = String::from("{\"studies\":[");
    for (index, study) in report.studies.iter().enumerate() {
        comma(&mut json, index);
        pack_study(&mut json, study, detail);
    }
    json.push_str("],\"figures\":{");
    if detail < Detail::Nothing {
        let figures = report.studies.iter().flat_map(|study| &study.figures);
        let drawn = figures.filter_map(|(id, _, made)| Some((id, made.as_ref().ok()?)));
        for (index, (id, drawing)) in drawn.enumerate() {
            comma(&mut json, index);
            let _ = write!(json, "{}:", text(id));
            pack_panels(&mut json, &drawing.data);
        }
    }
    json.push('}');
    if figures {
        json.push_str(",\"svg\":{");
        let in_text = report.in_text();
        let drawn = report.studies.iter().flat_map(|study| &study.figures);
        let drawn = drawn.filter_map(|(id, _, made)| Some((id, made.as_ref().ok()?)));
        for (index, (id, drawing)) in drawn.filter(|(id, _)| !in_text.contains(id.as_str())).enumerate() {
            comma(&mut json, index);
            let _ = write!(json, "{}:{}", text(id), text(&vector::svg(drawing)));
        }
        json.push('}');
    }
    json.push('}');
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    let packed = packed.write_all(json.as_bytes()).and_then(|()| packed.finish());
    let packed = packed.map_err(|error| Error::Incompatible(format!("the runs cannot be packed: {error}")))?;
    let letters = BASE64_STANDARD.encode(packed);
    Ok((letters.len() <= most).then_some(letters))
}

fn comma(json: &mut String, index: usize) {
    if index > 0 {
        json.push(',');
    }
}

fn text(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// A number with so many digits, as JSON: null for NaN, and beyond all numbers for what is infinite.
fn number(json: &mut String, value: f64, digits: usize) {
    if value.is_nan() {
        json.push_str("null");
    } else if value.is_infinite() {
        json.push_str(if value > 0.0 { "1e999" } else { "-1e999" });
    } else {
        let written = format!("{value:.*e}", digits - 1);
        let (mantissa, exponent) = written.split_once('e').unwrap_or((&written, "0"));
        let mantissa =
            if mantissa.contains('.') { mantissa.trim_end_matches('0').trim_end_matches('.') } else { mantissa };
        json.push_str(mantissa);
        if exponent != "0" {
            let _ = write!(json, "e{exponent}");
        }
    }
}

fn pack_study(json: &mut String, study: &Study, detail: Detail) {
    let _ = write!(json, "{{\"name\":{},\"anchor\":{}", text(&study.name), text(&study.anchor()));
    if let Some(runs) = study.runs.as_ref().filter(|_| detail < Detail::NoRuns) {
        pack_runs(json, study, runs, detail);
    }
    json.push('}');
}

fn pack_runs(json: &mut String, study: &Study, runs: &ResultsTable, detail: Detail) {
    let Ok(id) = runs.column("run_id") else { return };
    let names = runs.names();
    let outcome = runs.column("outcome").unwrap_or(names.len());
    let _ = write!(json, ",\"count\":{},\"ids\":\"", runs.len());
    let short = |row: usize| runs.text(row, id).get(..detail.id()).unwrap_or(runs.text(row, id));
    (0..runs.len()).for_each(|row| json.push_str(&format!("{} ", short(row))));
    json.push_str("\",\"settings\":{");
    let reasons = (detail <= Detail::Digits).then(|| runs.column("reason").ok()).flatten();
    let settings = names.iter().enumerate().take(outcome + 1).skip(1).map(|(column, name)| (column, name.as_str()));
    for (index, (column, name)) in settings.chain(reasons.map(|column| (column, "reason"))).enumerate() {
        comma(json, index);
        let mut known: Vec<&str> = Vec::new();
        let mut index_of: HashMap<&str, usize> = HashMap::new();
        let indices: Vec<usize> = (0..runs.len())
            .map(|row| {
                let cell = runs.text(row, column);
                *index_of.entry(cell).or_insert_with(|| {
                    known.push(cell);
                    known.len() - 1
                })
            })
            .collect();
        let values: Vec<String> = known.iter().map(|cell| text(cell)).collect();
        let _ = write!(json, "{}:[[{}]", text(name), values.join(","));
        if known.len() > 1 {
            json.push_str(",[");
            for (at, index) in indices.iter().enumerate() {
                comma(json, at);
                let _ = write!(json, "{index}");
            }
            json.push(']');
        }
        json.push(']');
    }
    json.push_str("},\"metrics\":{");
    let counters = outcome..names.len();
    let is_number = |column: usize| (0..runs.len()).any(|row| !runs.number(row, column).is_nan());
    let mut packed = 0;
    for (column, name) in names.iter().enumerate().filter(|(column, _)| counters.contains(column)) {
        let name = name.as_str();
        let exact = CHECKED.contains(&name) && detail <= Detail::Digits;
        let wanted = match detail {
            Detail::Full => name != "outcome" && name != "wall_limit_s",
            Detail::Digits => exact || MAIN.contains(&name),
            Detail::Main => MAIN.contains(&name),
            _ => MAIN[..2].contains(&name),
        };
        // Of several columns of one name the last is the counter.
        if !wanted || !is_number(column) || runs.last_column(name).ok() != Some(column) {
            continue;
        }
        comma(json, packed);
        packed += 1;
        let _ = write!(json, "{}:[", text(name));
        for row in 0..runs.len() {
            comma(json, row);
            let value = runs.number(row, column);
            match exact && value.is_finite() {
                true => {
                    let _ = write!(json, "{value:?}");
                }
                false => number(json, value, detail.digits()),
            }
        }
        json.push(']');
    }
    json.push_str("},\"claims\":[");
    let rows: HashMap<&str, usize> = (0..runs.len()).map(|row| (runs.text(row, id), row)).collect();
    for (index, claim) in study.claims.iter().enumerate() {
        comma(json, index);
        let mut rows: Vec<usize> = claim.run_ids.iter().filter_map(|id| rows.get(id.as_str()).copied()).collect();
        rows.sort_unstable();
        // First and last of each stretch.
        let stretches = rows.chunk_by(|a, b| *b == a + 1).map(|rows| format!("{},{}", rows[0], rows[rows.len() - 1]));
        let _ = write!(json, "[{},[{}]]", text(&claim.text), stretches.collect::<Vec<_>>().join(","));
    }
    json.push_str("],\"traces\":{");
    pack_traces(json, study, runs, detail.rows());
    json.push('}');
}

/// Columns of a trace that are packed where it has them; of another, the first few.
const SHOWN: [&str; 4] = ["actuator_force_n", "effective_mass_kg", "actuator_length_m", "actuator_velocity_m_s"];

fn pack_traces(json: &mut String, study: &Study, runs: &ResultsTable, most: usize) {
    let Some(column) = runs.column("trace").ok().filter(|_| most > 0) else { return };
    let mut packed = 0;
    for row in (0..runs.len()).filter(|&row| !runs.text(row, column).is_empty()) {
        let Ok(trace) = read_table(&study.folder.join("traces").join(runs.text(row, column))) else { continue };
        let Ok(time) = trace.column("time_s") else { continue };
        let mut columns: Vec<usize> = SHOWN.iter().filter_map(|name| trace.column(name).ok()).collect();
        if columns.is_empty() {
            columns = (0..trace.names().len()).filter(|column| *column != time).take(SHOWN.len()).collect();
        }
        columns.insert(0, time);
        comma(json, packed);
        packed += 1;
        let _ = write!(json, "\"{row}\":{{");
        let every = trace.len().div_ceil(most).max(1);
        for (index, &column) in columns.iter().enumerate() {
            comma(json, index);
            let _ = write!(json, "{}:[", text(&trace.names()[column]));
            for (at, row) in (0..trace.len()).step_by(every).enumerate() {
                comma(json, at);
                number(json, trace.number(row, column), 5);
            }
            json.push(']');
        }
        json.push('}');
    }
}

/// Most points of a series; a trace has more.
const POINTS: usize = 160;

fn pack_panels(json: &mut String, panels: &[PanelData]) {
    json.push('[');
    for (index, panel) in panels.iter().enumerate() {
        comma(json, index);
        let _ = write!(json, "[{},{},{},[", text(&panel.title), text(&panel.x), text(&panel.y));
        for (index, series) in panel.series.iter().enumerate() {
            comma(json, index);
            let every = series.points.len().div_ceil(POINTS).max(1);
            let _ = write!(json, "[{},{every},[", text(&series.name));
            for (index, point) in series.points.iter().step_by(every).enumerate() {
                comma(json, index);
                pack_point(json, point);
            }
            json.push_str("]]");
        }
        json.push_str("]]");
    }
    json.push(']');
}

/// `[x, y, least, most, across, down, note]`, as short as its end allows.
fn pack_point(json: &mut String, point: &Datum) {
    json.push('[');
    number(json, point.x, 5);
    json.push(',');
    number(json, point.y, 5);
    let [low, high] = point.range.unwrap_or([f64::NAN; 2]);
    if point.range.is_some() || point.at.is_some() || !point.note.is_empty() {
        json.push(',');
        number(json, low, 4);
        json.push(',');
        number(json, high, 4);
    }
    if let Some((across, down)) = point.at {
        let _ = write!(json, ",{:.0},{:.0}", across, down);
    } else if !point.note.is_empty() {
        json.push_str(",null,null");
    }
    if !point.note.is_empty() {
        let _ = write!(json, ",{}", text(&point.note));
    }
    json.push(']');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_short_as_their_digits_allow() {
        let of = |value: f64, digits: usize| {
            let mut json = String::new();
            number(&mut json, value, digits);
            json
        };
        assert_eq!(of(1234.5678, 3), "1.23e3");
        assert_eq!(of(5.0, 6), "5");
        assert_eq!(of(-0.000_25, 4), "-2.5e-4");
        assert_eq!(of(f64::NAN, 4), "null");
        assert_eq!(of(f64::NEG_INFINITY, 4), "-1e999");
        assert_eq!(of(0.0, 4), "0");
    }

    #[test]
    fn a_point_is_as_long_as_what_is_known_of_it() {
        let point = Datum { x: 1.0, y: 2.0, range: None, note: String::new(), at: None };
        let of = |point: &Datum| {
            let mut json = String::new();
            pack_point(&mut json, point);
            json
        };
        assert_eq!(of(&point), "[1,2]");
        assert_eq!(of(&Datum { at: Some((3.2, 4.0)), ..point.clone() }), "[1,2,null,null,3,4]");
        assert_eq!(of(&Datum { note: "a".to_owned(), y: f64::NAN, ..point }), "[1,null,null,null,null,null,\"a\"]");
    }
}
