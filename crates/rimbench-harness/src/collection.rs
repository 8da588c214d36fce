//! From records to result files: what of a plan is stored, by whichever process, and the tables where that is all of it.

use super::experiment::{PlannedRun, plan_sha256};
use super::foreign::refuse_foreign;
use super::job::{Job, Summary};
use super::references::{has_none, obtain_reference};
use super::results;
use super::stored_runs::StoredRuns;
use rimbench_cases::runs::{Reference, RunSpec};
use rimbench_core::cosim::StopFlag;
use rimbench_core::error::{Error, Result};
use rimbench_results::kept::{PooledSets, keep};
use std::path::Path;
use std::time::Duration;

/// Missing runs that are told one by one.
const TOLD: usize = 20;

/// What of a plan is stored.
#[derive(Debug, Default)]
pub(super) struct Inventory {
    /// Places of the runs that are still to be computed.
    pub(super) missing: Vec<usize>,
    /// Stored runs that are not of the plan.
    unplanned: usize,
}

/// Of each reference of a plan the run that may take longest: the reference may take as long.
#[derive(Debug, Default)]
struct References(Vec<RunSpec>);

impl References {
    /// Names of the cases, numbered where a case has several; none where there is one reference.
    fn names(&self) -> Vec<String> {
        let name = |index: usize, spec: &RunSpec| {
            let before = self.0[..index].iter().filter(|other| other.case.name == spec.case.name).count();
            if before == 0 { spec.case.name.to_string() } else { format!("{}-{}", spec.case.name, before + 1) }
        };
        if self.0.len() == 1 {
            Vec::new()
        } else {
            self.0.iter().enumerate().map(|(index, spec)| name(index, spec)).collect()
        }
    }

    /// Cases and parameters are the outer loops of a plan: runs of one reference are mostly neighbours, unless a case is named again
    /// behind others.
    fn note(&mut self, spec: &RunSpec) {
        let patience = |spec: &RunSpec| spec.wall_limit.unwrap_or(Duration::MAX);
        match self.0.iter_mut().rev().find(|known| known.shares_reference_with(spec)) {
            Some(known) if patience(spec) > patience(known) => *known = spec.clone(),
            Some(_) => {}
            None => self.0.push(spec.clone()),
        }
    }
}

/// Copies the records of other folders into that of a job, writes the result files if all runs are there, and returns what was done
/// with the first of the runs that are missing, twenty at most.
///
/// # Errors
/// Folders that belong to something else; a disk that is full.
pub fn collect_shards(job: Job<'_>, folders: &[&Path]) -> Result<(Summary, Vec<PlannedRun>)> {
    let planned = job.experiment.plan(job.catalogue, job.quick)?;
    refuse_foreign(&job)?;
    job.experiment.copy_to(job.folder)?;
    let own = StoredRuns::open(job.folder, job.experiment)?;
    let mut summary = Summary { planned: planned.len(), damaged: own.store.damaged, ..Summary::default() };
    let mut wanted = own.missing(&planned);
    for folder in folders {
        let other = StoredRuns::open(folder, job.experiment)?;
        summary.damaged += other.store.damaged;
        let mut still_wanted = Vec::new();
        for index in wanted {
            let run = &planned[index];
            match other.store.get(&run.id).filter(|_| other.has(run)) {
                Some(record) => {
                    results::copy_trace(folder, job.folder, &run.id)?;
                    own.store.append(record)?;
                    summary.computed += 1;
                }
                None => still_wanted.push(index),
            }
        }
        wanted = still_wanted;
    }
    own.store.sync()?;
    drop(own);
    let found = export_if_complete(&job, &planned, None, StopFlag::never())?;
    summary.missing = found.missing.len();
    summary.unplanned = found.unplanned;
    summary.reused = planned.len() - found.missing.len() - summary.computed;
    Ok((summary, found.missing.iter().take(TOLD).map(|&index| planned[index].clone()).collect()))
}

/// Writes the result files of an experiment if all its runs are stored; says what is.
///
/// `held` is a reference that is at hand, with the place of a run that it belongs to.
pub(super) fn export_if_complete(
    job: &Job<'_>,
    planned: &[PlannedRun],
    mut held: Option<(usize, Reference)>,
    stop: StopFlag<'_>,
) -> Result<Inventory> {
    let stored_runs = StoredRuns::open(job.folder, job.experiment)?;
    let stored = planned.iter().filter(|run| stored_runs.store.get(&run.id).is_some()).count();
    let found = Inventory { missing: stored_runs.missing(planned), unplanned: stored_runs.store.len() - stored };
    if !found.missing.is_empty() {
        return Ok(found);
    }
    results::write_tables(job.folder, job.experiment, planned, &stored_runs.store)?;
    let mut needed = References::default();
    planned.iter().for_each(|run| needed.note(&run.spec));
    let names = needed.names();
    let references = needed.0.iter().map(|spec| {
        if let Some((_, reference)) = held.take_if(|held| planned[held.0].spec.shares_reference_with(spec)) {
            return Ok((spec, Some(reference)));
        }
        match obtain_reference(spec, job.cache, stop) {
            Err(Error::Overdue { .. }) => Ok((spec, None)),
            Err(error) if has_none(&error) => Ok((spec, None)),
            found => Ok((spec, Some(found?))),
        }
    });
    let problem = |run: &PlannedRun| (run.spec.case.name.to_string(), run.spec.parameters.given());
    let rejected = planned.iter().filter_map(|run| Some((problem(run), run.rejected_draws?))).collect();
    let every = job.experiment.trace_every_s;
    let of_references = results::write_references(job.folder, references, &names, &rejected, every)?;
    let traced = planned.iter().filter(|run| job.experiment.trace_of(&run.label).is_some());
    results::write_checksums(job.folder, traced.map(|run| results::trace_name(&run.id)).chain(of_references))?;
    let pooled = planned.iter().filter_map(|run| Some((problem(run), run.pooled_set.as_ref()?.to_string())));
    keep(job.folder, &PooledSets::from_iter(pooled), &plan_sha256(job.experiment, planned))?;
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Experiment;
    use rimbench_cases::catalogue::Catalogue;

    #[test]
    fn a_case_that_is_named_again_behind_another_has_one_reference() {
        let text = "question = \"?\"\nmacro_steps_s = [1e-3]\n[[cases]]\nname = \"linear-oscillator\"\n[[cases]]\n\
                    name = \"bouncing-ball\"\n[[schemes]]\nscheme = \"zero-order-hold\"\n";
        let experiment = Experiment::parse("a.toml".as_ref(), text.to_owned()).unwrap();
        let plan = experiment.plan(&Catalogue::standard(), false).unwrap();
        let mut found = References::default();
        let limited = RunSpec { wall_limit: Some(Duration::from_secs(1)), ..plan[0].spec.clone() };
        for spec in [&limited, &plan[1].spec, &plan[0].spec, &plan[1].spec, &limited] {
            found.note(spec);
        }
        let names: Vec<_> = found.0.iter().map(|spec| &*spec.case.name).collect();
        assert_eq!(names, ["linear-oscillator", "bouncing-ball"]);
        // The one that may take longest stands for them.
        assert_eq!(found.0[0].wall_limit, None);
    }
}
