//! Runs what is missing of an experiment on all cores, row by row, and exports the result files when all is there.

use super::clock::monotonic_clock;
use super::experiment::PlannedRun;
use super::folder::Folder;
use super::grid::MOST_RUNS;
use super::job::{Job, Progress, Shard, Step, StopFlags, Summary};
use super::provenance::Provenance;
use super::references::{has_none, obtain_reference};
use rayon::prelude::*;
use rimbench_core::cosim::{Outcome, StopFlag};
use rimbench_core::error::{Error, Result};
use rimbench_runs::{EvaluatedRun, Reference, RunSpec};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// Runs a job. When all runs of the experiment are stored, by this process or others, the result files are written.
///
/// Raising `stop` ends the job, runs and references under way included; what is stored stays.
///
/// # Errors
/// Bad input; a folder that belongs to something else; a disk that is full. A run that fails is a row.
pub fn run_job(job: Job<'_>, progress: Progress<'_>, stop: StopFlag<'_>) -> Result<Summary> {
    run_job_until(job, progress, StopFlags { soon: stop, now: stop })
}

/// Runs a job as [`run_job`] does, one that can be ended soon or at once.
///
/// # Errors
/// Those of [`run_job`]; [`Error::Stopped`] if it was ended when all runs were done and the result files were not.
pub fn run_job_until(job: Job<'_>, progress: Progress<'_>, stop: StopFlags<'_>) -> Result<Summary> {
    let size = job.experiment.size(job.quick)?;
    let places = match job.shard {
        None => None,
        Some(Shard::Every { .. }) => Some(0..size),
        Some(Shard::Places { first, last }) if first <= last && last < size => Some(first..last + 1),
        Some(Shard::Places { first, last }) => {
            let expected = format!("places of the plan in order, within 0-{}", size - 1);
            return Err(Error::invalid("places", format!("{first}-{last}"), expected));
        }
    };
    let in_shard = |place: usize| job.shard.is_none_or(|shard| shard.has(place));
    let mut all = Summary { in_parts: size > MOST_RUNS, ..Summary::default() };
    let (mut folder, mut whole, mut to_do) = (None, None, 0);
    for part in job.plans(size, places) {
        let (first, plan) = part?;
        let folder = match &mut folder {
            Some(folder) => folder,
            none => none.insert(Folder::open(&job, &plan)?),
        };
        let missing = folder.missing(&plan);
        let stored = plan.len() - missing.len();
        let own = (0..plan.len()).filter(|index| in_shard(first + index)).count();
        let todo: Vec<usize> = missing.into_iter().filter(|index| in_shard(first + index)).collect();
        to_do += todo.len();
        progress(Step::ToDo(to_do));
        let (done, held) = compute(&job, folder, &plan, &todo, progress, stop)?;
        all.planned += own;
        all.reused += own - todo.len();
        all.renewed += done.renewed;
        all.computed += done.computed;
        all.not_completed += done.not_completed;
        all.missing += todo.len() - done.computed;
        all.damaged = done.damaged;
        whole = (!all.in_parts).then_some((plan, stored, held));
        if stop.soon.check().is_err() {
            break;
        }
    }
    // One task of many asks only for its own, and of a plan in parts the rows stay tables of the store.
    let whole = whole.filter(|_| !matches!(job.shard, Some(Shard::Places { .. })));
    let Some((folder, (plan, stored, held))) = folder.zip(whole) else { return Ok(all) };
    (all.planned, all.reused) = (plan.len(), stored);
    let (missing, _) = folder.finish(&job, &plan, held, stop.soon)?;
    let gone = missing.iter().filter(|&&index| in_shard(index)).count();
    if gone > 0 && stop.soon.check().is_ok() {
        let message = format!(
            "lacks {gone} runs that had been stored: the folder was removed, or another process started again with --fresh; \
             run the experiment again"
        );
        return Err(Error::file(job.folder, message));
    }
    all.missing = missing.len();
    Ok(all)
}

/// Computes some runs of a plan and stores them; returns what was done, and the reference that was used last with the
/// place of a run it belongs to.
fn compute(
    job: &Job<'_>,
    folder: &Folder<'_>,
    plan: &[PlannedRun],
    todo: &[usize],
    progress: Progress<'_>,
    stop: StopFlags<'_>,
) -> Result<(Summary, Option<(usize, Reference)>)> {
    let store = &folder.store;
    let renewed = todo.iter().filter(|&&index| store.get(&plan[index].id).is_some()).count();
    let (computed, not_completed) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let origin = Provenance::collect(job.build).origin();
    let keep = |index: usize, run: &EvaluatedRun| -> Result<()> {
        folder.keep(&plan[index], run, origin.clone())?;
        computed.fetch_add(1, Ordering::Relaxed);
        if run.outcome != Outcome::Completed {
            not_completed.fetch_add(1, Ordering::Relaxed);
        }
        progress(Step::Done(run.outcome.class()));
        Ok(())
    };
    let mut held = None;
    for mut group in groups_of_one_reference(plan, todo) {
        let first = most_patient(plan, &group);
        // Runs on one grid follow each other: the reference is brought to their times once.
        let grid = |index: &usize| {
            let spec = &plan[*index].spec;
            [spec.macro_step, spec.phase, spec.micro_step].map(f64::to_bits)
        };
        group.sort_by_key(grid);
        let spec = &plan[first].spec;
        let found = obtain_reference(spec, job.cache, stop.soon);
        let reference = match found {
            Err(Error::Stopped) => break,
            // Without a reference there is no run, and it took longer than any of them may take.
            Err(Error::Overdue { .. }) => {
                let overdue = EvaluatedRun::not_evaluated(Outcome::Timeout { at_s: 0.0 });
                group.iter().try_for_each(|&index| keep(index, &overdue))?;
                continue;
            }
            Err(error) if has_none(&error) => {
                group.iter().try_for_each(|&index| keep(index, &skipped(&error)))?;
                continue;
            }
            found => found?,
        };
        group.into_par_iter().try_for_each(|index| -> Result<()> {
            if stop.soon.check().is_err() {
                return Ok(());
            }
            let is_wanted = job.experiment.trace_of(&plan[index].label).is_some();
            let run = match evaluated(&plan[index].spec, &reference, true, is_wanted, stop.now) {
                Err(error) if has_none(&error) => skipped(&error),
                run => run?,
            };
            // No result: the same command goes on from there.
            if matches!(run.outcome, Outcome::Stopped { .. }) { Ok(()) } else { keep(index, &run) }
        })?;
        held = Some((first, reference));
    }
    store.sync()?;
    let summary = Summary {
        renewed,
        computed: computed.into_inner(),
        not_completed: not_completed.into_inner(),
        damaged: store.damaged.clone(),
        ..Summary::default()
    };
    Ok((summary, held))
}

/// Makes the results folder of a job ready for processes that run parts of it at once.
///
/// # Errors
/// Bad input; a folder that belongs to something else; a disk that is full.
pub fn prepare_folder(job: Job<'_>) -> Result<()> {
    let size = job.experiment.size(job.quick)?;
    let first = job.plans(size, Some(0..size)).next().transpose()?;
    Folder::open(&job, &first.map(|(_, plan)| plan).unwrap_or_default()).map(drop)
}

/// The run of a group that may take longest: the reference of all of them may take as long.
fn most_patient(planned: &[PlannedRun], group: &[usize]) -> usize {
    let patience = |index: &usize| planned[*index].spec.wall_limit.unwrap_or(Duration::MAX);
    group.iter().copied().rev().max_by_key(patience).unwrap_or(group[0])
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

/// Simulates a run and holds it against its reference, micro steps `inside` macro steps as well; all its rows are kept
/// if a trace `is_wanted`. A defect of ours is a record like others: no reason to lose the other runs.
pub(super) fn evaluated(
    spec: &RunSpec,
    reference: &Reference,
    inside: bool,
    is_wanted: bool,
    stop: StopFlag<'_>,
) -> Result<EvaluatedRun> {
    let attempt = catch_unwind(AssertUnwindSafe(|| {
        spec.prepare()?.evaluate(reference, inside, is_wanted, Some(monotonic_clock), stop)
    }));
    attempt.unwrap_or_else(|panic| Ok(EvaluatedRun::not_evaluated(panicked(&*panic))))
}

fn skipped(why: &Error) -> EvaluatedRun {
    EvaluatedRun::not_evaluated(Outcome::Skipped { reason: why.to_string() })
}

fn panicked(panic: &(dyn Any + Send)) -> Outcome {
    let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
    // A record is one line.
    Outcome::Panicked { message: text.unwrap_or("no message").replace(char::is_control, " ") }
}
