//! What of a plan is done: runs stored with the time they may take, and with the traces that are asked for.

use super::experiment::{Experiment, PlanPart, PlannedRun};
use super::provenance;
use super::results::{runs_header, trace_name};
use super::store::{Record, Store, TraceMark};
use rimbench_core::error::Result;
use rimbench_results::checksums::sha256_of_file;
use std::path::Path;

/// The store of an experiment in a folder, with what else belongs to a finished run.
#[derive(Debug)]
pub(super) struct Stock<'a> {
    /// The folder.
    pub(super) folder: &'a Path,
    /// The experiment.
    pub(super) experiment: &'a Experiment,
    /// Its records.
    pub(super) store: Store,
}

impl<'a> Stock<'a> {
    /// Opens the store in a folder.
    ///
    /// # Errors
    /// Those of [`Store::open`].
    pub(super) fn open(folder: &'a Path, experiment: &'a Experiment, planned: &[PlannedRun]) -> Result<Self> {
        let store = Store::open(folder, &experiment.name(), &columns(experiment, planned))?;
        Ok(Stock { folder, experiment, store })
    }

    /// The same, of the runs of a part of a plan only.
    ///
    /// # Errors
    /// Those of [`Store::open`].
    pub(super) fn open_for(folder: &'a Path, experiment: &'a Experiment, part: &PlanPart) -> Result<Self> {
        let ids = part.runs.iter().map(|run| run.id.as_str());
        let store = Store::open_for(folder, &experiment.name(), &columns(experiment, &part.kinds), ids)?;
        Ok(Stock { folder, experiment, store })
    }

    /// Whether a run need not be computed: it is stored, was given as much time as it may take, and has the trace that is asked for.
    ///
    /// # Errors
    /// Those of [`Store::read`].
    pub(super) fn has(&self, run: &PlannedRun) -> Result<bool> {
        if !self.store.holds(&run.id, run.spec.wall_limit) {
            return Ok(false);
        }
        // Without a trace there is nothing in the record to look at.
        Ok(self.experiment.trace_of(&run.label).is_none() || self.has_trace(run, self.store.read(&run.id)?.as_ref()))
    }

    /// The same of a record that is not in the store yet.
    pub(super) fn would_have(&self, run: &PlannedRun, record: &Record) -> bool {
        let wanted_s = run.spec.wall_limit.map_or(f64::INFINITY, |limit| limit.as_secs_f64());
        record.wall_limit_s.unwrap_or(f64::INFINITY) >= wanted_s && self.has_trace(run, Some(record))
    }

    /// Whether the trace that is asked for is there, as it was written with a record.
    fn has_trace(&self, run: &PlannedRun, record: Option<&Record>) -> bool {
        let Some(every_s) = self.experiment.trace_of(&run.label) else { return true };
        let path = self.folder.join("traces").join(trace_name(&run.id));
        let found = || Some(TraceMark { every_s, sha256: sha256_of_file(&path)? });
        record.and_then(|record| record.trace.as_ref()).is_some_and(|kept| found().as_ref() == Some(kept))
    }

    /// Positions of the runs that are still to be computed.
    ///
    /// # Errors
    /// Those of [`Store::read`].
    pub(super) fn missing(&self, planned: &[PlannedRun]) -> Result<Vec<usize>> {
        let lacking = |(index, run)| self.has(run).map(|has| (!has).then_some(index)).transpose();
        planned.iter().enumerate().filter_map(lacking).collect()
    }
}

/// What records must have been written with to belong together.
fn columns(experiment: &Experiment, planned: &[PlannedRun]) -> String {
    let provenance = provenance::HEADER.join(",");
    format!("{}{provenance}{}", runs_header(planned).join(","), experiment.reference_identity())
}
