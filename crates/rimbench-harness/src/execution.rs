//! Runs what is missing of an experiment on all cores, record by record, and exports the result files when all is there.

use super::build_info::BuildInfo;
use super::cache::Cache;
use super::evaluation::{EvaluatedRun, evaluate};
use super::experiment::{Experiment, PlannedRun};
use super::provenance::Provenance;
use super::reference::Reference;
use super::results::{self, RUNS_HEADER};
use super::run::{RunSpec, simulate};
use super::store::Store;
use rayon::prelude::*;
use rimbench_core::cosim::Outcome;
use rimbench_core::error::Result;
use rimbench_results::atomic_file::sweep_temporary_files;
use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// What to run, and where to.
#[derive(Debug, Clone, Copy)]
pub struct Job<'a> {
    /// The experiment.
    pub experiment: &'a Experiment,
    /// Its results folder.
    pub folder: &'a Path,
    /// The quick plan instead of the full one.
    pub quick: bool,
    /// Forget what is stored.
    pub fresh: bool,
    /// Only part i of n, from 1.
    pub shard: Option<(usize, usize)>,
    /// Where references are kept.
    pub cache: &'a Cache,
    /// What the program was built from, for the rows of provenance.
    pub build: &'a BuildInfo,
}

/// What a job did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Summary {
    /// Runs of the whole experiment.
    pub planned: usize,
    /// Runs that were stored before.
    pub reused: usize,
    /// Runs computed now.
    pub computed: usize,
    /// Runs computed now that did not complete; they are rows like others.
    pub not_completed: usize,
    /// Records found damaged, and computed again if they belong to this job.
    pub damaged: usize,
    /// Runs of the whole experiment that are not stored yet.
    pub missing: usize,
}

/// Told the outcome of each run that is done; called from several threads.
pub type Progress<'a> = &'a (dyn Fn(&Outcome) + Sync);

/// Runs a job. When all runs of the experiment are stored, by this process or others, the result files are written.
///
/// Setting `stop` ends the job after the runs under way; what is stored stays.
///
/// # Errors
/// Bad input; a folder that belongs to something else; a disk that is full. A run that fails is a record.
pub fn run_job(job: Job<'_>, progress: Progress<'_>, stop: &AtomicBool) -> Result<Summary> {
    let planned = job.experiment.plan(job.quick)?;
    if job.fresh {
        Store::clear(job.folder)?;
    }
    let name = job.experiment.name();
    let store = Store::open(job.folder, &name, &columns_of(job.experiment))?;
    job.experiment.copy_to(job.folder)?;
    sweep_temporary_files(job.folder);
    sweep_temporary_files(&job.folder.join("traces"));
    let in_shard = |index: usize| job.shard.is_none_or(|(part, parts)| index % parts == part - 1);
    let todo: Vec<usize> =
        (0..planned.len()).filter(|&index| in_shard(index) && !store.contains(&planned[index].id)).collect();
    let (computed, not_completed) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let provenance = Provenance::collect(job.build);
    let mut held = None;
    for group in groups_of_one_reference(&planned, &todo) {
        let first = group[0];
        let spec = &planned[group[0]].spec;
        let case = job.experiment.with_own_reference(spec.case);
        let reference = Reference::obtain(&case, &spec.parameters, spec.solver, spec.duration, job.cache)?;
        let bounds = reference.bounds(spec.case, &spec.parameters, spec.solver)?;
        group.into_par_iter().try_for_each(|index| -> Result<()> {
            if stop.load(Ordering::Relaxed) {
                return Ok(());
            }
            let planned = &planned[index];
            let attempt = catch_unwind(AssertUnwindSafe(|| {
                Ok(evaluate(&planned.spec, simulate(&planned.spec, bounds.clone())?, &reference))
            }));
            let evaluated = attempt.unwrap_or_else(|panic| Ok(EvaluatedRun::panicked(&planned.spec, &*panic)))?;
            let trace = job.experiment.trace_of(&planned.label);
            if let Some(every) = trace {
                results::write_trace(job.folder, &format!("{}.csv", planned.id), &evaluated.trajectory, every)?;
            }
            store.append(&results::record(planned, &evaluated, &provenance, trace.is_some()))?;
            computed.fetch_add(1, Ordering::Relaxed);
            if evaluated.outcome != Outcome::Completed {
                not_completed.fetch_add(1, Ordering::Relaxed);
            }
            progress(&evaluated.outcome);
            Ok(())
        })?;
        held = Some((first, reference));
    }
    store.sync()?;
    let missing = export_if_complete(&job, &planned, held)?;
    Ok(Summary {
        planned: planned.len(),
        reused: planned.iter().filter(|run| store.contains(&run.id)).count(),
        computed: computed.into_inner(),
        not_completed: not_completed.into_inner(),
        damaged: store.damaged,
        missing: missing.len(),
    })
}

/// Copies the records of other folders into that of a job, writes the result files if all runs are there, and returns the
/// runs that are missing.
///
/// # Errors
/// Folders that belong to something else; a disk that is full.
pub fn collect_shards(job: Job<'_>, folders: &[&Path]) -> Result<(Summary, Vec<PlannedRun>)> {
    let planned = job.experiment.plan(job.quick)?;
    let (name, columns) = (job.experiment.name(), columns_of(job.experiment));
    job.experiment.copy_to(job.folder)?;
    let own = Store::open(job.folder, &name, &columns)?;
    let mut summary = Summary { planned: planned.len(), damaged: own.damaged, ..Summary::default() };
    summary.reused = planned.iter().filter(|run| own.contains(&run.id)).count();
    let mut taken: HashSet<&str> = HashSet::new();
    for folder in folders {
        let other = Store::open(folder, &name, &columns)?;
        summary.damaged += other.damaged;
        for id in planned.iter().map(|run| run.id.as_str()).filter(|id| !own.contains(id)) {
            if let Some(record) = other.read(id)?
                && taken.insert(id)
            {
                results::copy_trace(folder, job.folder, id)?;
                own.append(&record)?;
                summary.computed += 1;
            }
        }
    }
    own.sync()?;
    let missing: HashSet<String> = export_if_complete(&job, &planned, None)?.into_iter().collect();
    summary.missing = missing.len();
    Ok((summary, planned.into_iter().filter(|run| missing.contains(&run.id)).collect()))
}

/// Writes the result files of an experiment if all its runs are stored; else names those that are missing.
///
/// `held` is a reference that is at hand, with the index of a run that it belongs to.
fn export_if_complete(
    job: &Job<'_>,
    planned: &[PlannedRun],
    mut held: Option<(usize, Reference)>,
) -> Result<Vec<String>> {
    // Other processes may have stored their shards meanwhile.
    let store = Store::open(job.folder, &job.experiment.name(), &columns_of(job.experiment))?;
    let missing: Vec<String> = planned.iter().map(|run| &run.id).filter(|id| !store.contains(id)).cloned().collect();
    if missing.is_empty() {
        results::write_tables(job.folder, planned, &store)?;
        let everything: Vec<usize> = (0..planned.len()).collect();
        let references = groups_of_one_reference(planned, &everything).into_iter().map(|group| {
            let run = &planned[group[0]];
            let spec = &run.spec;
            if let Some((_, reference)) = held.take_if(|(index, _)| share_reference(&planned[*index].spec, spec)) {
                return Ok((run, reference));
            }
            let case = job.experiment.with_own_reference(spec.case);
            Reference::obtain(&case, &spec.parameters, spec.solver, spec.duration, job.cache).map(|found| (run, found))
        });
        results::write_references(job.folder, references, job.experiment.trace_every_s)?;
    }
    Ok(missing)
}

/// Whether two runs are held against the same reference.
fn share_reference(a: &RunSpec, b: &RunSpec) -> bool {
    a.case.name == b.case.name && a.duration == b.duration && a.parameters == b.parameters
}

/// Runs that share case, parameters and duration, and so the reference; in the order of the plan.
fn groups_of_one_reference(planned: &[PlannedRun], indices: &[usize]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for &index in indices {
        // Cases and parameters are the outer loops of a plan: a group is a run of neighbours.
        match groups.last_mut().filter(|group| share_reference(&planned[group[0]].spec, &planned[index].spec)) {
            Some(group) => group.push(index),
            None => groups.push(vec![index]),
        }
    }
    groups
}

/// What records must have been written with to belong together.
fn columns_of(experiment: &Experiment) -> String {
    format!("{}{}", RUNS_HEADER.join(","), experiment.reference_identity())
}
