//! Figures of an experiment that no list names: where it is stable, and how large its errors are.

use super::FigureEntry;
use super::valid::LONGEST_NAME;
use crate::figure::MOST_LINES;
use rimbench_core::error::{Error, Result};
use rimbench_results::run_table::RunTable;
use rimbench_results::selection::Runs;
use rimbench_runs::Finding;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::Path;

/// Most panels of one figure.
const MOST_PANELS: usize = 6;
/// Most rows of one figure: beyond, the first of the file are shown.
const MOST_ROWS: usize = 40;
/// Signs of a dot plot.
const MOST_SIGNS: usize = 9;
/// What errors are shown of, the first of which some run has a value.
const METRICS: [(&str, &str); 3] = [
    ("force_error_rms_of_peak", "rms force error / peak"),
    ("force_error_rms_n", "rms force error (N)"),
    ("position_error_rms_m", "rms position error (m)"),
];

/// The figures of an experiment's folder, named `group/name`, as they would stand in a list: a stability map, and the
/// error against the macro step, as lines where these can be told apart and in rows where not.
///
/// # Errors
/// [`Error::File`](rimbench_core::error::Error::File) for results without the columns of runs.
pub fn default_figures(name: &str, folder: &Path) -> Result<Vec<FigureEntry>> {
    let table = RunTable::read_from(folder)?;
    let runs = Runs::of(&table);
    let problems: Vec<(String, String)> =
        runs.problems().into_iter().map(|[case, set]| (case.to_owned(), set.to_owned())).collect();
    let all = runs.labels(&[]);
    let labels: Vec<&str> = all.iter().take(MOST_ROWS).copied().collect();
    let steps: BTreeSet<u64> =
        runs.rows().iter().map(|&row| runs.macro_step_ms(row)).filter(|step| *step > 0.0).map(f64::to_bits).collect();
    if problems.is_empty() || labels.is_empty() || steps.is_empty() {
        return Ok(Vec::new());
    }
    let more = match all.len() - labels.len() {
        0 => String::new(),
        more => format!(" The first {MOST_ROWS} rows of the experiment; {more} more are in `runs.csv`."),
    };
    let figure = |end: &str, kind: &str, caption: &str, columns: &str, panels: Vec<Value>| {
        json!({
            "id": id(name, end),
            "kind": kind,
            "experiment": name,
            "caption": format!("{caption}{more} No list of figures names this experiment: it is drawn as all such are."),
            "source": format!("runs.csv, columns label, macro_step_s, {columns}"),
            "panels": panels,
        })
    };
    let metric = METRICS.iter().find(|(metric, _)| {
        let metric = Finding::named(metric);
        metric.is_ok_and(|metric| runs.iter().any(|run| run.found.value(metric).is_finite()))
    });
    // Where the runs can be lost, or where there is nothing else to see.
    let (across, title, caption) = match problems.len() {
        1 => ("macro-step", "What became of the runs", "What became of the runs, for each scheme and macro step."),
        _ => (
            "limit",
            "Limits by scheme",
            "The number of cases by their largest accurate macro step, for each scheme; a scheme that no step tried makes fail is counted last.",
        ),
    };
    let mut map = figure("stability", "stability-map", caption, "outcome", vec![json!({ "across": across })]);
    map["title"] = title.into();
    map["labels"] = json!(labels);
    let mut list = vec![map];
    if let Some((metric, words)) = metric {
        let shown = &problems[..problems.len().min(MOST_PANELS)];
        let (left, note) = match problems.len() - shown.len() {
            0 => (String::new(), None),
            left => (
                format!(" The first {MOST_PANELS} cases; {left} more are in `runs.csv`."),
                Some(format!(
                    "{left} more {} not drawn: the values are in runs.csv.",
                    if left == 1 { "case is" } else { "cases are" }
                )),
            ),
        };
        let lines = labels.len() <= MOST_LINES && steps.len() > 2;
        // Parameters may be long: then there are fewer panels in a line, and what is common to all is left out.
        let one_case = shown.iter().all(|(case, _)| *case == shown[0].0);
        let common = if one_case { common_parameters(shown) } else { Vec::new() };
        let left = match common.is_empty() {
            true => left,
            false => format!("{left} In all panels: {}.", common.join(", ")),
        };
        let heading = |(index, (case, set)): (usize, &(String, String))| {
            let own: Vec<&str> = set.split_whitespace().filter(|parameter| !common.contains(parameter)).collect();
            let case = if own.is_empty() || !one_case || shown.len() == 1 { &**case } else { "" };
            let words =
                [case, &own.join(" ")].into_iter().filter(|words| !words.is_empty()).collect::<Vec<_>>().join(", ");
            if shown.len() == 1 { words } else { format!("({}) {words}", char::from(b'a' + index as u8)) }
        };
        let headings: Vec<String> = shown.iter().enumerate().map(heading).collect();
        let longest = headings.iter().map(|heading| heading.chars().count()).max().unwrap_or(0);
        let columns = shown.len().min(if lines && longest <= 26 { 3 } else { 2 });
        let room = match (columns, lines) {
            (1, _) => 70,
            (2, true) => 44,
            (2, false) => 32,
            _ => 26,
        };
        let headings: Vec<String> = headings.iter().map(|heading| shortened(heading, room)).collect();
        let rows = shown.len().div_ceil(columns) as f64;
        let chosen: Vec<f64> = spread(&steps.iter().map(|bits| f64::from_bits(*bits)).collect::<Vec<_>>());
        let caption = format!(
            "Error against the macro step: median over the phases of the runs that completed, bars from best to worst.{left}"
        );
        let panels = shown.iter().zip(&headings).map(|((case, set), heading)| {
            json!({ "title": heading, "metric": metric, "label": words, "only": { "case": case, "set": set } })
        });
        let mut error = figure("error", if lines { "xy" } else { "dots" }, &caption, metric, panels.collect());
        error["columns"] = columns.into();
        if let Some(note) = note {
            error["note"] = note.into();
        }
        if lines {
            let legend = 20.0 + 16.0 * (labels.len() as f64 / 3.0).ceil();
            error["height"] = (rows * if columns == 1 { 300.0 } else { 215.0 } + legend).min(4000.0).into();
        } else {
            error["labels"] = json!(labels);
            // Cases with grids of their own need all of them, if there are signs enough.
            if steps.len() > MOST_SIGNS {
                error["macro_steps_ms"] = chosen.into();
            }
        }
        list.push(error);
    }
    let entries = list.into_iter().map(|entry| {
        let entry = serde_json::from_value(entry).map_err(|error| Error::file(folder, error.to_string()))?;
        FigureEntry::checked(entry).map_err(|wrong| Error::file(folder, wrong))
    });
    entries.collect()
}

/// Up to four of the values, from the first to the last.
fn spread(values: &[f64]) -> Vec<f64> {
    const MOST: usize = 4;
    let last = values.len() - 1;
    let mut chosen: Vec<f64> = (0..MOST).map(|k| values[(k * last + (MOST - 1) / 2) / (MOST - 1)]).collect();
    chosen.dedup();
    chosen
}

/// A name that is safe as that of a file, and no other experiment's.
fn id(name: &str, end: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '-' | '_') { c } else { '-' };
    let name: String = name.chars().map(safe).collect();
    let kept: String =
        name.chars().rev().take(LONGEST_NAME - end.len() - 1).collect::<Vec<_>>().into_iter().rev().collect();
    format!("{kept}-{end}").trim_start_matches('.').to_owned()
}

/// Parameters that all of several problems have in common.
fn common_parameters(problems: &[(String, String)]) -> Vec<&str> {
    let [(_, first), others @ ..] = problems else { return Vec::new() };
    let in_all = |parameter: &&str| others.iter().all(|(_, set)| set.split_whitespace().any(|own| own == *parameter));
    if others.is_empty() { Vec::new() } else { first.split_whitespace().filter(in_all).collect() }
}

/// A text that is no longer than there is room for: its middle goes, since beginnings are often alike.
fn shortened(text: &str, most: usize) -> String {
    let letters: Vec<char> = text.chars().collect();
    if letters.len() <= most {
        return text.to_owned();
    }
    let kept = most.saturating_sub(1);
    let (head, tail) = (kept.div_ceil(2), kept / 2);
    let end = letters.len() - tail;
    letters[..head].iter().chain(&['…']).chain(&letters[end..]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_of_any_letters_becomes_one_of_a_file() {
        assert_eq!(id("study/mine", "error"), "study-mine-error");
        let long = id(&format!("gruppe/ä {}", "x".repeat(300)), "stability");
        assert!(long.len() <= LONGEST_NAME && long.ends_with("-stability") && long.is_ascii(), "{long}");
    }

    #[test]
    fn a_few_of_many_steps_are_shown_with_both_ends() {
        assert_eq!(spread(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]), [1.0, 3.0, 5.0, 7.0]);
        assert_eq!(spread(&[1.0]), [1.0]);
        assert_eq!(spread(&[1.0, 2.0]), [1.0, 2.0]);
    }

    #[test]
    fn what_all_panels_have_in_common_is_left_out_and_a_long_heading_loses_its_middle() {
        let set = |driver: &str| ("crane".to_owned(), format!("manoeuvre=m1 {driver}"));
        let problems = [set("stale=true"), set("stale=false")];
        assert_eq!(common_parameters(&problems), ["manoeuvre=m1"]);
        assert!(common_parameters(&problems[..1]).is_empty());
        assert_eq!(shortened("coupling=force stale=true", 11), "coupl…=true");
    }
}
