//! What of a plan is done: runs stored with the time they may take, and with the traces that are asked for.

use super::experiment::{Experiment, PlannedRun};
use super::provenance;
use super::results::{cost_findings, findings_header, trace_name};
use super::store::{Columns, Store, TraceMark};
use rimbench_core::error::Result;
use rimbench_results::checksums::sha256_of_file;
use std::collections::HashSet;
use std::path::Path;

/// The store of an experiment in a folder, with what else belongs to a finished run.
#[derive(Debug)]
pub(super) struct StoredRuns<'a> {
    /// The folder.
    pub(super) folder: &'a Path,
    /// The experiment.
    pub(super) experiment: &'a Experiment,
    /// Its records.
    pub(super) store: Store,
}

impl<'a> StoredRuns<'a> {
    /// Opens the store in a folder.
    ///
    /// # Errors
    /// Those of [`Store::open`].
    pub(super) fn open(folder: &'a Path, experiment: &'a Experiment) -> Result<Self> {
        let store = Store::open(folder, &experiment.name(), &experiment.reference_identity(), columns())?;
        Ok(StoredRuns { folder, experiment, store })
    }

    /// Whether a run need not be computed: it is stored, was given as much time as it may take, and has the trace that is asked for, as
    /// it was written with its record.
    pub(super) fn has(&self, run: &PlannedRun) -> bool {
        if !self.store.holds(&run.id, run.spec.wall_limit) {
            return false;
        }
        let Some(every_s) = self.experiment.trace_of(&run.label) else { return true };
        let path = self.folder.join("traces").join(trace_name(&run.id));
        let found = || Some(TraceMark { every_s, sha256: sha256_of_file(&path)? });
        self.store
            .get(&run.id)
            .and_then(|record| record.trace.as_ref())
            .is_some_and(|kept| found().as_ref() == Some(kept))
    }

    /// Positions of the runs that are still to be computed; of one that has several labels the first.
    pub(super) fn missing(&self, planned: &[PlannedRun]) -> Vec<usize> {
        let mut seen = HashSet::new();
        (0..planned.len())
            .filter(|&index| !self.has(&planned[index]) && seen.insert(planned[index].id.as_str()))
            .collect()
    }
}

/// Columns of the records of an experiment.
pub(super) fn columns() -> Columns {
    Columns::of([findings_header(), cost_findings(), provenance::HEADER.to_vec()])
}
