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
    if let Some(Shard::Places { first, last }) = job.shard
        && !(first <= last && last < size)
    {
        let expected = format!("places of the plan in order, within 0-{}", size - 1);
        return Err(Error::invalid("places", format!("{first}-{last}"), expected));
    }
    if let Some(shard) = job.shard.filter(|_| size > MOST_RUNS) {
        return run_parts(job, size, shard, progress, stop);
    }
    let plan = job.experiment.plan(job.catalogue, job.quick)?;
    let folder = Folder::open(&job, &plan)?;
    let in_shard = |index: &usize| job.shard.is_none_or(|shard| shard.has(*index));
    let missing = folder.missing(&plan);
    let reused = plan.len() - missing.len();
    let todo: Vec<usize> = missing.into_iter().filter(in_shard).collect();
    progress(Step::ToDo(todo.len()));
    let (mut summary, held) = compute(&job, &folder, &plan, &todo, progress, stop)?;
    // One task of many asks only for its own.
    if let Some(Shard::Places { first, last }) = job.shard {
        summary.planned = last - first + 1;
        summary.reused = summary.planned - todo.len();
        summary.missing = todo.len() - summary.computed;
        return Ok(summary);
    }
    summary.reused = reused;
    let (missing, _) = folder.finish(&job, &plan, held, stop.soon)?;
    let gone = missing.iter().filter(|&index| in_shard(index)).count();
    if gone > 0 && stop.soon.check().is_ok() {
        let message = format!(
            "lacks {gone} runs that had been stored: the folder was removed, or another process started again with --fresh; \
             run the experiment again"
        );
        return Err(Error::file(job.folder, message));
    }
    summary.missing = missing.len();
    Ok(summary)
}

/// Runs a shard of a plan that is too large to be laid out at once, part by part. There are no result files of so many
/// runs: their rows stay tables of the store.
fn run_parts(job: Job<'_>, size: usize, shard: Shard, progress: Progress<'_>, stop: StopFlags<'_>) -> Result<Summary> {
    let places = match shard {
        Shard::Places { first, last } => first..last + 1,
        Shard::Every { .. } => 0..size,
    };
    let mut all = Summary { in_parts: true, ..Summary::default() };
    let (mut folder, mut to_do) = (None, 0);
    for part in job.experiment.parts(job.catalogue, job.quick, places) {
        let (first, plan) = part?;
        let folder = match &mut folder {
            Some(folder) => folder,
            none => none.insert(Folder::open(&job, &plan)?),
        };
        let own = (0..plan.len()).filter(|index| shard.has(first + index)).count();
        let todo: Vec<usize> = folder.missing(&plan).into_iter().filter(|index| shard.has(first + index)).collect();
        to_do += todo.len();
        progress(Step::ToDo(to_do));
        let (summary, _) = compute(&job, folder, &plan, &todo, progress, stop)?;
        all.planned += own;
        all.reused += own - todo.len();
        all.renewed += summary.renewed;
        all.computed += summary.computed;
        all.not_completed += summary.not_completed;
        all.missing += todo.len() - summary.computed;
        all.damaged = summary.damaged;
        if stop.soon.check().is_err() {
            break;
        }
    }
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
        planned: plan.len(),
        reused: 0,
        renewed,
        computed: computed.into_inner(),
        not_completed: not_completed.into_inner(),
        damaged: store.damaged.clone(),
        missing: 0,
        unplanned: 0,
        in_parts: false,
    };
    Ok((summary, held))
}

/// Makes the results folder of a job ready for processes that run parts of it at once.
///
/// # Errors
/// Bad input; a folder that belongs to something else; a disk that is full.
pub fn prepare_folder(job: Job<'_>) -> Result<()> {
    let plan = match job.experiment.size(job.quick)? {
        size if size > MOST_RUNS => {
            let mut parts = job.experiment.parts(job.catalogue, job.quick, 0..size);
            parts.next().transpose()?.map(|(_, plan)| plan).unwrap_or_default()
        }
        _ => job.experiment.plan(job.catalogue, job.quick)?,
    };
    Folder::open(&job, &plan).map(drop)
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
