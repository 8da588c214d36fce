//! Result files that are there without their records, as in a fresh clone: rows that are sealed need not be computed again.

use super::experiment::{Experiment, PlannedRun};
use super::provenance;
use super::results::{COST_PLAN, cost_header, plan_header, row, runs_header, trace_name};
use super::store::{Record, TraceMark};
use rimbench_core::error::{Error, Result};
use rimbench_results::checksums;
use std::path::Path;

/// The records of the result files of a folder; none if it has none, if they are not as they were written, or if they were
/// written with other columns or held against another reference.
///
/// # Errors
/// [`Error::File`] for a file that cannot be read although its checksum is right.
pub(super) fn exported_records(folder: &Path, experiment: &Experiment, planned: &[PlannedRun]) -> Result<Vec<Record>> {
    let Ok(Some(sums)) = checksums::read(folder) else { return Ok(Vec::new()) };
    let Ok(copy) = Experiment::read_from_results(folder) else { return Ok(Vec::new()) };
    if checksums::verify(folder).is_err() || copy.reference_identity() != experiment.reference_identity() {
        return Ok(Vec::new());
    }
    let names = ["runs.csv", "cost.csv", "provenance.csv"];
    let [Some(runs), Some(cost), Some(provenance)] = [
        rows(&folder.join(names[0]), &runs_header(planned))?,
        rows(&folder.join(names[1]), &cost_header())?,
        rows(&folder.join(names[2]), &provenance::HEADER)?,
    ] else {
        return Ok(Vec::new());
    };
    let said_by_plan = plan_header(planned).len();
    let record = |((run, cost), provenance): ((&Vec<String>, &Vec<String>), &Vec<String>)| {
        let id = &run[0];
        let findings = said_by_plan..run.len() - 2;
        let mark = |every_s: f64| {
            let sha256 = sums.get(&format!("traces/{}", trace_name(id)))?.clone();
            Some(TraceMark { every_s, sha256 })
        };
        (cost[0] == *id && provenance[0] == *id).then(|| Record {
            run_id: id.clone(),
            findings: row(&run[findings]),
            costs: row(&cost[COST_PLAN.len()..]),
            provenance: row(provenance),
            trace: copy.trace_every_s.filter(|_| !run[run.len() - 1].is_empty()).and_then(mark),
            wall_limit_s: run[run.len() - 2].parse().ok(),
        })
    };
    Ok(runs.iter().zip(&cost).zip(&provenance).filter_map(record).collect())
}

/// The rows of a table, if it has just these columns.
fn rows(path: &Path, header: &[&str]) -> Result<Option<Vec<Vec<String>>>> {
    let wrong = |error: csv::Error| Error::file(path, error);
    let mut reader = csv::Reader::from_path(path).map_err(wrong)?;
    if !reader.headers().map_err(wrong)?.iter().eq(header.iter().copied()) {
        return Ok(None);
    }
    let rows: csv::Result<Vec<Vec<String>>> =
        reader.records().map(|record| Ok(record?.iter().map(str::to_owned).collect())).collect();
    rows.map(Some).map_err(wrong)
}
