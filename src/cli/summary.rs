//! What came of an experiment, for reading: medians and what did not complete, by case, scheme row and macro step.

use super::number::{percent, quantity, with_digits};
use super::screen::{Table, paragraph};
use rimbench::error::Result;
use rimbench::harness::Experiment;
use rimbench::run_table::RunTable;
use rimbench::runs::Finding;
use rimbench::selection::Runs;
use std::collections::BTreeMap;
use std::path::Path;

/// Metrics whose medians are shown, with their headings and units; an error without a unit is a share of the peak.
const MEDIANS: [(&str, &str, &str); 3] = [
    ("force_error_rms_of_peak", "force", "-"),
    ("position_error_rms_m", "position", "m"),
    ("interface_residual_j", "energy", "J"),
];

/// Rows shown; all of them are in the file.
const MOST_ROWS: usize = 60;

/// Makes the table from the result files of a folder.
///
/// # Errors
/// [`Error::File`](rimbench::error::Error::File) for a file or column that is not there.
pub(super) fn summary(folder: &Path) -> Result<String> {
    let table = RunTable::read_from(folder)?;
    let metrics = MEDIANS.iter().map(|(name, ..)| Finding::named(name)).collect::<Result<Vec<Finding>>>()?;
    let groups = Runs::of(&table).by_key(|run| (run.problem(), &*run.label, run.macro_step_s.to_bits()));
    let mut header = vec!["scheme row", "H", "done"];
    header.extend(MEDIANS.map(|(_, heading, _)| heading));
    let mut text = paragraph("Medians of completed runs: rms errors of force and position, energy residual", 0);
    let shown = &groups[..groups.len().min(MOST_ROWS)];
    for of_case in shown.chunk_by(|a, b| a.0.0 == b.0.0) {
        let mut shown = Table::new(&header);
        for ((_, label, macro_step), runs) in of_case {
            let completed = runs.completed();
            let mut failures: BTreeMap<&str, usize> = BTreeMap::new();
            let failed = runs.rows().iter().filter(|&&row| !runs.is_completed(row));
            failed.for_each(|&row| *failures.entry(runs.run(row).found.outcome.name()).or_default() += 1);
            let failures: String = failures.iter().map(|(name, count)| format!(", {count} {name}")).collect();
            let step = with_digits(f64::from_bits(*macro_step), "s", 6);
            let done = format!("{}/{}{failures}", completed.rows().len(), runs.rows().len());
            let mut row = vec![(*label).to_owned(), step, done];
            row.extend(metrics.iter().zip(MEDIANS).map(|(&metric, (.., unit))| {
                match completed.pool(|row| runs.value(row, metric)).median() {
                    None => "–".to_owned(),
                    Some(value) if unit == "-" => percent(value),
                    Some(value) => quantity(value, unit),
                }
            }));
            shown.add_row(row);
        }
        let ([case, set], ..) = of_case[0].0;
        text += &format!("\n\n{}\n{shown}", format!("{case} {set}").trim_end());
    }
    if groups.len() > MOST_ROWS {
        text += &format!("\n… and {} more in {}", groups.len() - MOST_ROWS, table.path().display());
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
