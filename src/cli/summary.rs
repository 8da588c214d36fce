//! What came of an experiment, for reading: medians and what did not complete, by case, scheme row and macro step.

use super::number::{percent, quantity, with_digits};
use super::screen::{Table, paragraph};
use rimbench::error::Result;
use rimbench::harness::Experiment;
use rimbench::kept::{PooledSets, SUMMARY_METRICS, SummaryRow, summarise};
use rimbench::run_table::RunTable;
use rimbench::selection::Runs;
use std::path::Path;

/// Rows shown; all of them are in the file.
const MOST_ROWS: usize = 60;

/// Metrics whose medians are shown, with their headings and units; an error without a unit is a share of the peak.
const MEDIANS: [(&str, &str, &str); 3] = [
    ("force_error_rms_of_peak", "force", "-"),
    ("position_error_rms_m", "position", "m"),
    ("interface_residual_j", "energy", "J"),
];

/// Makes the table from the result files of a folder.
///
/// # Errors
/// [`Error::File`](rimbench::error::Error::File) for a file or column that is not there.
pub(super) fn summary(folder: &Path) -> Result<String> {
    let table = RunTable::read_from(folder)?;
    let rows = summarise(&table, &PooledSets::new());
    let places = MEDIANS.map(|(name, ..)| SUMMARY_METRICS.iter().position(|own| *own == name));
    let mut header = vec!["scheme row", "H", "done"];
    header.extend(MEDIANS.map(|(_, heading, _)| heading));
    let mut text = paragraph("Medians of completed runs: rms errors of force and position, energy residual", 0);
    for of_case in rows[..rows.len().min(MOST_ROWS)].chunk_by(|a, b| a.keys[..2] == b.keys[..2]) {
        let mut shown = Table::new(&header);
        for SummaryRow { keys, runs, completed, failed, no_answer, quartiles, .. } in of_case {
            let [_, _, label, step, _] = keys;
            let ends = [(failed, "failed"), (no_answer, "without an answer")];
            let ends = ends.into_iter().filter(|(count, _)| **count > 0);
            let ends: String = ends.map(|(count, name)| format!(", {count} {name}")).collect();
            let step = with_digits(step.parse().unwrap_or(f64::NAN), "s", 6);
            let mut row = vec![label.clone(), step, format!("{completed}/{runs}{ends}")];
            row.extend(places.iter().zip(MEDIANS).map(|(place, (.., unit))| {
                match place.map_or(f64::NAN, |place| quartiles[place][1]) {
                    median if median.is_nan() => "–".to_owned(),
                    median if unit == "-" => percent(median),
                    median => quantity(median, unit),
                }
            }));
            shown.add_row(row);
        }
        let [case, set, ..] = &of_case[0].keys;
        text += &format!("\n\n{}\n{shown}", format!("{case} {set}").trim_end());
    }
    if rows.len() > MOST_ROWS {
        text += &format!("\n… and {} more in {}", rows.len() - MOST_ROWS, table.path().display());
    }
    Ok(text)
}

/// Counts the runs that did not complete, of all in a results folder.
///
/// # Errors
/// Those of [`summary`].
pub(super) fn count_not_completed(folder: &Path) -> Result<usize> {
    let table = RunTable::read_from(folder)?;
    Ok(table.len() - Runs::of(&table).tally().completed)
}

/// Says how many runs did not complete, of all that are stored; none if all did.
///
/// # Errors
/// Those of [`summary`].
pub(super) fn not_completed(experiment: &Experiment, folder: &Path) -> Result<Option<String>> {
    let table = RunTable::read_from(folder)?;
    let tally = Runs::of(&table).tally();
    let silent = tally.no_answer + tally.skipped;
    let said = if silent > 0 { format!(", {silent} of them without an answer") } else { String::new() };
    let (count, all) = (table.len() - tally.completed, table.len());
    Ok((tally.failed + silent > 0)
        .then(|| format!("Of all {all} runs of {}, {count} did not complete{said}.", experiment.name())))
}
