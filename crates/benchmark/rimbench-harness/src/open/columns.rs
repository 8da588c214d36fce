//! What the columns of result tables mean: a results folder as a data package (<https://datapackage.org>).

use rimbench_cases::parameter::unit_of;
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;
use rimbench_results::checksums::sha256_of_file;
use rimbench_runs::RunRequest;
use rimbench_runs::metrics::METRICS;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader};
use std::path::Path;

/// Name of the file that describes a folder.
pub(crate) const DATA_PACKAGE: &str = "datapackage.json";

/// Columns that are neither metrics nor options.
const MEANINGS: [(&str, &str); 63] = [
    ("run_id", "Hash of all that determines the run"),
    ("label", "Row of the experiment that it is of"),
    ("set", "Parameters of the case that the experiment sets"),
    ("audit", "Whether the energy that the model creates was accounted for"),
    ("outcome", "How it ended"),
    ("outcome_at_s", "When it left the path of a completed run"),
    ("reason", "Why, in words; empty for a completed run"),
    ("ended_at_s", "Time of the last communication point reached"),
    ("model_exact", "Whether the interface model is the mechanics itself"),
    ("reference_force_uncertainty_n", "Rms uncertainty of the reference's force, between its rows too"),
    ("reference_position_uncertainty_m", "Rms uncertainty of the reference's position, between its rows too"),
    ("macro_steps", "Macro steps taken"),
    ("repeated_macro_steps", "Macro steps taken again"),
    ("exchanges", "Exchanges between both sides"),
    ("catch_up_steps", "Steps that a model ran forward from late samples"),
    ("mechanics_micro_steps", "Own steps of the mechanics"),
    ("actuator_micro_steps", "Own steps of the actuator"),
    ("eliminations", "Contact problems that were set up from the mechanics"),
    ("mechanics_lcp_solves", "Contact problems that the mechanics solved"),
    ("mechanics_lcp_pivots", "Pivots of these"),
    ("mechanics_lcp_factorisations", "Factorisations of these"),
    ("mechanics_lcp_fallbacks", "Those that a second method had to solve"),
    ("scheme_lcp_solves", "Contact problems that the scheme solved"),
    ("scheme_lcp_pivots", "Pivots of these"),
    ("scheme_lcp_factorisations", "Factorisations of these"),
    ("scheme_lcp_fallbacks", "Those that a second method had to solve"),
    ("scheme_parametric_steps", "Steps of the scheme without a solve"),
    ("trace", "File with its rows, in the folder traces"),
    ("wall_s", "Wall time of the macro loop"),
    ("real_time_factor", "Simulated time over wall time"),
    ("latency_p50_s", "Median wall time of a macro step"),
    ("latency_p99_s", "Wall time that 99 % of the macro steps keep"),
    ("latency_max_s", "Longest wall time of a macro step"),
    ("missed_deadlines", "Macro steps that took longer than H"),
    ("git_revision", "Revision of the sources"),
    ("git_dirty", "Whether they were changed"),
    ("lock_hash", "Hash of the versions of all libraries"),
    ("version", "Version of the program"),
    ("rustc", "Compiler"),
    ("cpu", "Processor"),
    ("target", "Platform that it was compiled for"),
    ("target_cpu", "Processor that it was compiled for"),
    ("parameter", "Name of a parameter of the case"),
    ("value", "Its value"),
    ("unit", "Its unit"),
    ("source", "Where it is from"),
    ("interface_frequency_rad_s", "Frequency of the linearised interface at the start"),
    ("interface_damping_ratio", "Its damping ratio"),
    ("rejected_draws", "Draws before this one, in which the event did not happen"),
    ("column", "Column of the reference"),
    ("rms_uncertainty", "Its rms uncertainty, in its unit"),
    ("observed_order", "Order of convergence that was observed"),
    ("finest_step_s", "Finest step of the reference"),
    ("runs", "Number of runs"),
    ("completed", "Runs that completed"),
    ("failed", "Runs that did not hold"),
    ("no_answer", "Runs that say nothing"),
    ("usable", "Runs that completed with an rms force error of at most a tenth of the event's peak"),
    ("problem", "Case with its parameters"),
    ("time_s", "Time"),
    ("fmu_digest", "Hash of what a case from files is made of"),
    ("python_digest", "Hash of a class of Python"),
    ("predicted_growth", "Growth per macro step that the linearised coupling predicts"),
];

/// What stands behind the name of a metric in a summary, and what it says.
const OF_RUNS: [(&str, &str); 4] = [
    ("_q1", "lower quartile over completed runs"),
    ("_median", "median over completed runs"),
    ("_q3", "upper quartile over completed runs"),
    ("_worst", "largest over completed runs"),
];

/// Returns the unit of a column and what it means; none of a column that is not known.
pub fn meaning(column: &str) -> Option<(&'static str, String)> {
    let metric = |name: &str| METRICS.iter().find(|metric| metric.name == name);
    if let Some(metric) = metric(column) {
        return Some((metric.unit, metric.about.to_owned()));
    }
    for (end, of) in OF_RUNS {
        if let Some(metric) = column.strip_suffix(end).and_then(metric) {
            return Some((metric.unit, format!("{}: {of}", metric.about)));
        }
    }
    let option = RunRequest::OPTIONS.iter().find(|option| option.key == column).map(|option| option.about);
    let known = MEANINGS.iter().find(|(name, _)| *name == column).map(|(_, about)| *about);
    // A table of references has the scale of a setting under the name of a metric.
    known.or(option).map(|about| (unit_of_column(column), about.to_owned()))
}

/// The unit that a name ends in; `-` of counts, names and shares.
fn unit_of_column(column: &str) -> &'static str {
    let unit = unit_of(column);
    if unit.is_empty() { "-" } else { unit }
}

/// Describes a file of a data package, with its checksum if that is to be said.
pub(super) fn resource(path: &str, sum: Option<String>) -> Value {
    let mut resource = json!({"name": path.to_lowercase().replace(['/', '_'], "-"), "path": path});
    if let Some(sum) = sum {
        resource["hash"] = json!(format!("sha256:{sum}"));
    }
    resource
}

/// Describes the tables of a results folder, with every column, and the other files, with their checksums but for
/// those that differ from machine to machine.
///
/// # Errors
/// [`Error::File`] for a table that cannot be read.
pub(crate) fn describe(folder: &Path, files: &[String], measured: &[&str]) -> Result<()> {
    let mut resources = Vec::new();
    for file in files {
        let path = folder.join(file);
        let mut resource = resource(file, sha256_of_file(&path).filter(|_| !measured.contains(&&**file)));
        if file.ends_with(".csv") && !file.contains('/') {
            let mut header = String::new();
            let read = std::fs::File::open(&path).and_then(|file| BufReader::new(file).read_line(&mut header));
            read.map_err(|error| Error::file(&path, error))?;
            let field = |column: &str| {
                let (unit, about) = meaning(column).unwrap_or(("-", String::new()));
                json!({"name": column, "unit": unit, "description": about})
            };
            let fields: Vec<Value> = header.trim_end().split(',').map(field).collect();
            resource["schema"] = json!({"fields": fields});
        }
        resources.push(resource);
    }
    let name = folder.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let package = json!({"name": name, "profile": "tabular-data-package", "resources": resources});
    let text = serde_json::to_vec_pretty(&package).map_err(|error| Error::file(folder, error))?;
    write_atomically(&folder.join(DATA_PACKAGE), |file| file.write_all(&text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimbench_core::cosim::Outcome;
    use rimbench_runs::{Costs, Findings, names_of};

    #[test]
    fn every_column_of_every_table_has_a_meaning() {
        let mut names = names_of(|each| Findings::nothing(&Outcome::Completed).columns(each));
        names.extend(names_of(|each| Costs::default().columns(each)));
        names.extend(names_of(|each| crate::provenance::RunOrigin::default().columns(each)));
        names.extend(RunRequest::OPTIONS.iter().map(|option| option.key));
        let summary = rimbench_results::kept::summary_text(&[], false).unwrap();
        let pooled = rimbench_results::kept::summary_text(&[], true).unwrap();
        let headers = [summary, pooled].map(|text| String::from_utf8(text).unwrap());
        names.extend(headers.iter().flat_map(|text| text.trim_end().split(',')));
        let unknown: Vec<_> = names.iter().filter(|name| meaning(name).is_none()).collect();
        assert!(unknown.is_empty(), "{unknown:?}");
        assert_eq!(meaning("force_error_rms_n_median").unwrap().0, "N");
        assert_eq!(meaning("macro_steps").unwrap().0, "-");
        assert_eq!(meaning("other"), None);
    }
}
