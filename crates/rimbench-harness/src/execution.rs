//! Runs what is missing of an experiment on all cores, record by record, and exports the result files when all is there.

use super::build_info::BuildInfo;
use super::cache::Cache;
use super::clock::monotonic_clock;
use super::experiment::{Experiment, PlannedRun};
use super::provenance::Provenance;
use super::references::obtain_reference;
use super::results::{self, runs_header};
use super::store::Store;
use rayon::prelude::*;
use rimbench_cases::catalogue::Catalogue;
use rimbench_cases::runs::{EvaluatedRun, Reference, RunSpec, evaluate, simulate};
use rimbench_core::cosim::{Bounds, Outcome, StopFlag};
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::sweep_temporary_files;
use std::any::Any;
use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What to run, and where to.
#[derive(Debug, Clone, Copy)]
pub struct Job<'a> {
    /// The experiment.
    pub experiment: &'a Experiment,
    /// Where its names are found.
    pub catalogue: &'a Catalogue,
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
/// Raising `stop` ends the job, runs and references under way included; what is stored stays.
///
/// # Errors
/// Bad input; a folder that belongs to something else; a disk that is full. A run that fails is a record.
pub fn run_job(job: Job<'_>, progress: Progress<'_>, stop: StopFlag<'_>) -> Result<Summary> {
    let planned = job.experiment.plan(job.catalogue, job.quick)?;
    if job.fresh {
        Store::clear(job.folder)?;
    }
    let name = job.experiment.name();
    let store = Store::open(job.folder, &name, &columns_of(job.experiment, &planned))?;
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
        let spec = &planned[first].spec;
        let reference = match obtain_reference(spec, job.cache, stop) {
            Err(Error::Stopped) => break,
            reference => reference?,
        };
        let bounds = reference.bounds(spec)?;
        group.into_par_iter().try_for_each(|index| -> Result<()> {
            let planned = &planned[index];
            if stop.check().is_err() {
                return Ok(());
            }
            let run = evaluated(&planned.spec, &bounds, &reference, stop)?;
            // No result: the same command goes on from there.
            if matches!(run.outcome, Outcome::Stopped { .. }) {
                return Ok(());
            }
            let trace = job.experiment.trace_of(&planned.label);
            if let Some(every) = trace {
                results::write_trace(job.folder, &format!("{}.csv", planned.id), &run.trajectory, every)?;
            }
            store.append(&results::record(planned, &run, &provenance, trace.is_some()))?;
            computed.fetch_add(1, Ordering::Relaxed);
            if run.outcome != Outcome::Completed {
                not_completed.fetch_add(1, Ordering::Relaxed);
            }
            progress(&run.outcome);
            Ok(())
        })?;
        held = Some((first, reference));
    }
    store.sync()?;
    let missing = export_if_complete(&job, &planned, held, stop)?;
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
    let planned = job.experiment.plan(job.catalogue, job.quick)?;
    let (name, columns) = (job.experiment.name(), columns_of(job.experiment, &planned));
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
    let missing: HashSet<String> = export_if_complete(&job, &planned, None, StopFlag::never())?.into_iter().collect();
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
    stop: StopFlag<'_>,
) -> Result<Vec<String>> {
    // Other processes may have stored their shards meanwhile.
    let store = Store::open(job.folder, &job.experiment.name(), &columns_of(job.experiment, planned))?;
    let missing: Vec<String> = planned.iter().map(|run| &run.id).filter(|id| !store.contains(id)).cloned().collect();
    if missing.is_empty() {
        results::write_tables(job.folder, planned, &store)?;
        let everything: Vec<usize> = (0..planned.len()).collect();
        let references = groups_of_one_reference(planned, &everything).into_iter().map(|group| {
            let run = &planned[group[0]];
            let shared = |held: &mut (usize, Reference)| planned[held.0].spec.shares_reference_with(&run.spec);
            if let Some((_, reference)) = held.take_if(shared) {
                return Ok((run, reference));
            }
            obtain_reference(&run.spec, job.cache, stop).map(|found| (run, found))
        });
        results::write_references(job.folder, references, job.experiment.trace_every_s)?;
    }
    Ok(missing)
}

/// Runs that share case, parameters and duration, and so the reference; in the order of the plan.
fn groups_of_one_reference(planned: &[PlannedRun], indices: &[usize]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for &index in indices {
        // Cases and parameters are the outer loops of a plan: a group is a run of neighbours.
        let spec = &planned[index].spec;
        match groups.last_mut().filter(|group| planned[group[0]].spec.shares_reference_with(spec)) {
            Some(group) => group.push(index),
            None => groups.push(vec![index]),
        }
    }
    groups
}

/// Simulates a run and holds it against its reference. A defect of ours is a record like others: no reason to lose the other runs.
fn evaluated(spec: &RunSpec, bounds: &Bounds, reference: &Reference, stop: StopFlag<'_>) -> Result<EvaluatedRun> {
    let attempt = catch_unwind(AssertUnwindSafe(|| {
        evaluate(spec, simulate(spec, bounds.clone(), Some(monotonic_clock), stop)?, reference)
    }));
    attempt.unwrap_or_else(|panic| Ok(EvaluatedRun::not_evaluated(panicked(&*panic))))
}

fn panicked(panic: &(dyn Any + Send)) -> Outcome {
    let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
    // A record is one line.
    Outcome::Panicked { message: text.unwrap_or("no message").replace(char::is_control, " ") }
}

/// What records must have been written with to belong together.
fn columns_of(experiment: &Experiment, planned: &[PlannedRun]) -> String {
    format!("{}{}", runs_header(planned).join(","), experiment.reference_identity())
}
