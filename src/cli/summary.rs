//! What came of an experiment, for reading: medians and what did not complete, by case, scheme row and macro step.

use super::number::{percent, quantity, with_digits};
use super::screen::{Table, paragraph};
use rimbench::error::Result;
use rimbench::harness::{Comparison, ComparisonRow, Experiment, MEDIANS};
use rimbench::run_table::RunTable;
use rimbench::selection::Runs;
use std::path::Path;

/// Rows shown; all of them are in the file.
const MOST_ROWS: usize = 60;

/// Makes the table from the result files of a folder.
///
/// # Errors
/// [`Error::File`](rimbench::error::Error::File) for a file or column that is not there.
pub(super) fn summary(folder: &Path) -> Result<String> {
    let table = RunTable::read_from(folder)?;
    let Comparison { rows } = Comparison::of(&table)?;
    let mut header = vec!["scheme row", "H", "done"];
    header.extend(MEDIANS.map(|(_, heading, _)| heading));
    let mut text = paragraph("Medians of completed runs: rms errors of force and position, energy residual", 0);
    for of_case in rows[..rows.len().min(MOST_ROWS)].chunk_by(|a, b| a.problem == b.problem) {
        let mut shown = Table::new(&header);
        for ComparisonRow { label, macro_step_s, runs, completed, failures, medians, .. } in of_case {
            let failures: String = failures.iter().map(|(name, count)| format!(", {count} {name}")).collect();
            let step = with_digits(*macro_step_s, "s", 6);
            let mut row = vec![label.clone(), step, format!("{completed}/{runs}{failures}")];
            row.extend(medians.iter().zip(MEDIANS).map(|(median, (.., unit))| match median {
                None => "–".to_owned(),
                Some(value) if unit == "-" => percent(*value),
                Some(value) => quantity(*value, unit),
            }));
            shown.add_row(row);
        }
        let [case, set] = &of_case[0].problem;
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
