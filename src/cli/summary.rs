//! What came of an experiment, for reading: medians and what did not complete, by case, scheme row and macro step.

use super::table;
use rimbench::error::Result;
use rimbench::harness::Experiment;
use rimbench::results_table::ResultsTable;
use rimbench::statistics::median;
use std::collections::BTreeMap;
use std::path::Path;

/// Metrics whose medians are shown, with their headings.
const MEDIANS: [(&str, &str); 3] = [
    ("force_error_rms_of_peak", "force error / peak"),
    ("position_error_rms_m", "position error (m)"),
    ("interface_residual_j", "energy residual (J)"),
];

/// Rows shown; all of them are in the file.
const MOST_ROWS: usize = 60;

/// Runs that have all in common but the phase.
#[derive(Debug, Default)]
struct Group {
    runs: usize,
    /// How often each outcome but `completed`.
    failures: BTreeMap<String, usize>,
    /// Values of the completed runs, by metric.
    values: [Vec<f64>; MEDIANS.len()],
}

/// Makes the table from the result files of a folder.
///
/// # Errors
/// [`Error::File`](rimbench::error::Error::File) for a file or column that is not there.
pub(super) fn summary(folder: &Path) -> Result<String> {
    let runs = ResultsTable::read(&folder.join("runs.csv"))?;
    let keys = ["case", "set", "label", "macro_step_s"].map(|name| runs.column(name));
    let [case, set, label, macro_step] = keys;
    let (case, set, label, macro_step) = (case?, set?, label?, macro_step?);
    let outcome = runs.column("outcome")?;
    let metrics = MEDIANS.iter().map(|(name, _)| runs.column(name)).collect::<Result<Vec<usize>>>()?;
    let mut groups: Vec<([String; 4], Group)> = Vec::new();
    for row in 0..runs.len() {
        let key = [case, set, label, macro_step].map(|column| runs.text(row, column).to_owned());
        // Phases are the inner loop of a plan: a group is a run of neighbours.
        if groups.last().is_none_or(|(last, _)| *last != key) {
            groups.push((key, Group::default()));
        }
        let Some((_, group)) = groups.last_mut() else { continue };
        group.runs += 1;
        match runs.text(row, outcome) {
            "completed" => {
                for (values, &metric) in group.values.iter_mut().zip(&metrics) {
                    values.extend(Some(runs.number(row, metric)).filter(|value| !value.is_nan()));
                }
            }
            other => *group.failures.entry(other.to_owned()).or_default() += 1,
        }
    }
    let mut header = vec!["case", "scheme row", "H (ms)", "completed", "did not"];
    header.extend(MEDIANS.map(|(_, heading)| heading));
    let mut table = table(&header);
    for ([case, set, label, macro_step], group) in groups.iter().take(MOST_ROWS) {
        let failed: usize = group.failures.values().sum();
        let failures: Vec<String> = group.failures.iter().map(|(name, count)| format!("{count} {name}")).collect();
        let milliseconds = macro_step.parse::<f64>().map_or_else(|_| macro_step.clone(), |step| plain(step * 1e3));
        let case = if set.is_empty() { case.clone() } else { format!("{case} {set}") };
        let done = format!("{}/{}", group.runs - failed, group.runs);
        let mut row = vec![case, label.clone(), milliseconds, done, failures.join(", ")];
        let medians = group.values.iter().map(|values| median(values.clone()));
        row.extend(medians.map(|value| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.3e}"))));
        table.add_row(row);
    }
    let mut text = format!("Medians over the phases of the runs that completed:\n{table}");
    if groups.len() > MOST_ROWS {
        text += &format!("\n… and {} more in {}", groups.len() - MOST_ROWS, runs.path().display());
    }
    Ok(text)
}

/// Says how many runs did not complete, of all that are stored, and how many were timed while the machine had other things to do.
///
/// # Errors
/// Those of [`summary`].
pub(super) fn remarks(experiment: &Experiment, folder: &Path) -> Result<Vec<String>> {
    let mut remarks = Vec::new();
    let runs = ResultsTable::read(&folder.join("runs.csv"))?;
    let incomplete = runs.len() - runs.rows_where(runs.column("outcome")?, "completed").len();
    if incomplete > 0 {
        remarks.push(format!("Of all {} runs of {}, {incomplete} did not complete.", runs.len(), experiment.name()));
    }
    let provenance = ResultsTable::read(&folder.join("provenance.csv"))?;
    let loaded = provenance.rows_where(provenance.column("machine_load")?, "loaded").len();
    if loaded > 0 {
        remarks.push(format!(
            "{loaded} of {} runs were timed while other programs kept the machine busy: do not trust the times of those \
             (machine_load in provenance.csv)",
            provenance.len()
        ));
    }
    Ok(remarks)
}

/// Six digits at most.
fn plain(value: f64) -> String {
    format!("{value:.5e}").parse::<f64>().map_or_else(|_| value.to_string(), |value| value.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_counted_by_case_scheme_and_macro_step_and_only_completed_ones_have_medians() {
        let folder = tempfile::tempdir().unwrap();
        let runs = "case,set,label,macro_step_s,outcome,force_error_rms_of_peak,position_error_rms_m,interface_residual_j\n\
                    a,,x,0.005,completed,0.1,1,1\na,,x,0.005,diverged,1e9,1,1\na,,x,0.005,completed,0.3,1,1\n\
                    a,,x,0.01,timeout,,,\na,m=2,x,0.01,completed,0.5,1,1\n";
        std::fs::write(folder.path().join("runs.csv"), runs).unwrap();
        let text = summary(folder.path()).unwrap();
        let lines: Vec<&str> = text.lines().filter(|line| line.contains(" x ")).collect();
        assert!(lines[0].contains("2/3") && lines[0].contains("1 diverged") && lines[0].contains("2.000e-1"), "{text}");
        assert!(lines[1].contains("0/1") && lines[1].contains("1 timeout") && lines[1].contains('–'), "{text}");
        assert!(lines[2].contains("a m=2") && lines[2].contains("1/1"), "{text}");
        assert_eq!(lines.len(), 3, "{text}");
    }
}
