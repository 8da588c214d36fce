//! Result files that are there without their records, as in a fresh clone: rows that are sealed need not be computed again.

use super::experiment::Experiment;
use super::provenance;
use super::results::{cost_findings, findings_header, trace_name};
use super::store::{Record, TraceMark, row};
use rimbench_core::error::Result;
use rimbench_results::checksums;
use rimbench_results::results_table::{ResultsTable, read_table};
use std::path::Path;

/// The records of the result files of a folder, a column that came later being empty; none if it has none, if they are not as they were
/// written, or if they were held against another reference.
///
/// # Errors
/// [`Error::File`](rimbench_core::error::Error::File) for a file that cannot be read although its checksum is right.
pub(super) fn exported_records(folder: &Path, experiment: &Experiment) -> Result<Vec<Record>> {
    let Ok(Some(sums)) = checksums::read(folder) else { return Ok(Vec::new()) };
    let Ok(copy) = Experiment::read_from_results(folder) else { return Ok(Vec::new()) };
    if checksums::verify(folder).is_err() || copy.reference_identity() != experiment.reference_identity() {
        return Ok(Vec::new());
    }
    let read = |name: &str| read_table(&folder.join(name));
    let (runs, cost, provenance) = (read("runs.csv")?, read("cost.csv")?, read("provenance.csv")?);
    if cost.len() != runs.len() || provenance.len() != runs.len() {
        return Ok(Vec::new());
    }
    let id_of = |table: &ResultsTable| table.column("run_id");
    let (id, cost_id, provenance_id) = (id_of(&runs)?, id_of(&cost)?, id_of(&provenance)?);
    let (limit, trace) = (runs.column("wall_limit_s")?, runs.column("trace")?);
    let found = places(&runs, &findings_header());
    let (spent, from) = (places(&cost, &cost_findings()), places(&provenance, &provenance::HEADER));
    let record = |at: usize| {
        let run_id = runs.text(at, id).to_owned();
        let mark = |every_s: f64| {
            let sha256 = sums.get(&format!("traces/{}", trace_name(&run_id)))?.clone();
            Some(TraceMark { every_s, sha256 })
        };
        let of_one_run = cost.text(at, cost_id) == run_id && provenance.text(at, provenance_id) == run_id;
        of_one_run.then(|| Record {
            findings: cells(&runs, at, &found),
            costs: cells(&cost, at, &spent),
            provenance: cells(&provenance, at, &from),
            trace: copy.trace_every_s.filter(|_| !runs.text(at, trace).is_empty()).and_then(mark),
            wall_limit_s: runs.text(at, limit).parse().ok(),
            run_id: run_id.clone(),
        })
    };
    Ok((0..runs.len()).filter_map(record).collect())
}

/// Where columns stand in a table; none of one that it was written without.
fn places(table: &ResultsTable, names: &[&str]) -> Vec<Option<usize>> {
    names.iter().map(|name| table.column(name).ok()).collect()
}

/// The cells of a row in these columns, empty where there is none.
fn cells(table: &ResultsTable, at: usize, places: &[Option<usize>]) -> String {
    row(&places.iter().map(|place| place.map_or("", |column| table.text(at, column))).collect::<Vec<_>>())
}
