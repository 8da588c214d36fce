//! What came of an experiment, for reading: medians and what did not complete, by case, scheme row and macro step.

use super::table;
use rimbench::error::Result;
use rimbench::harness::Experiment;
use rimbench::results_table::read_table;
use rimbench::statistics::Runs;
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

/// Makes the table from the result files of a folder.
///
/// # Errors
/// [`Error::File`](rimbench::error::Error::File) for a file or column that is not there.
pub(super) fn summary(folder: &Path) -> Result<String> {
    let file = read_table(&folder.join("runs.csv"))?;
    let metrics = MEDIANS.iter().map(|(name, _)| file.column(name)).collect::<Result<Vec<usize>>>()?;
    let groups = Runs::of(&file)?.by_columns(["case", "set", "label", "macro_step_s"])?;
    let mut header = vec!["case", "scheme row", "H (ms)", "completed", "did not"];
    header.extend(MEDIANS.map(|(_, heading)| heading));
    let mut table = table(&header);
    for ([case, set, label, macro_step], runs) in groups.iter().take(MOST_ROWS) {
        let completed = runs.completed();
        let mut failures: BTreeMap<&str, usize> = BTreeMap::new();
        let failed = runs.rows().iter().filter(|&&row| !runs.is_completed(row));
        failed.for_each(|&row| *failures.entry(runs.outcome(row)).or_default() += 1);
        let failures: Vec<String> = failures.iter().map(|(name, count)| format!("{count} {name}")).collect();
        let milliseconds =
            macro_step.parse::<f64>().map_or_else(|_| (*macro_step).to_owned(), |step| plain(step * 1e3));
        let case = if set.is_empty() { (*case).to_owned() } else { format!("{case} {set}") };
        let done = format!("{}/{}", completed.rows().len(), runs.rows().len());
        let mut row = vec![case, (*label).to_owned(), milliseconds, done, failures.join(", ")];
        let medians = metrics.iter().map(|&metric| completed.pool(|row| file.number(row, metric)).median());
        row.extend(medians.map(|value| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.3e}"))));
        table.add_row(row);
    }
    let mut text = format!("Medians over the phases of the runs that completed:\n{table}");
    if groups.len() > MOST_ROWS {
        text += &format!("\n… and {} more in {}", groups.len() - MOST_ROWS, file.path().display());
    }
    Ok(text)
}

/// Says how many runs did not complete, of all that are stored, and how many were timed while the machine had other things to do.
///
/// # Errors
/// Those of [`summary`].
pub(super) fn remarks(experiment: &Experiment, folder: &Path) -> Result<Vec<String>> {
    let mut remarks = Vec::new();
    let runs = read_table(&folder.join("runs.csv"))?;
    let incomplete = runs.len() - runs.rows_where(runs.column("outcome")?, "completed").len();
    if incomplete > 0 {
        remarks.push(format!("Of all {} runs of {}, {incomplete} did not complete.", runs.len(), experiment.name()));
    }
    let provenance = read_table(&folder.join("provenance.csv"))?;
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
