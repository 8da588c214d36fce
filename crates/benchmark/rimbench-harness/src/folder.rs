//! The results folder of an experiment: whose it is, the rows that are stored in it, what of a plan is missing, and the
//! result files when nothing is.
//!
//! ```text
//! open ─► no files of others ─► rows of the store ─► missing
//! keep, one row per run ─► finish: read again, others may have stored theirs ─► result files
//! ```

use super::build_info::BuildInfo;
use super::experiment::{COPY, Experiment, PlannedRun};
use super::job::{Job, Summary};
use super::provenance::RunOrigin;
use super::references::{References, has_none, obtain_reference};
use super::results;
use super::run_row::{Asked, RunRow, TraceMark};
use super::store::Store;
use rimbench_core::cosim::StopFlag;
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::{check_writable_folder, write_atomically};
use rimbench_results::budget::keep_budget;
use rimbench_results::checksums::sha256_of_file;
use rimbench_results::kept::{PooledSets, keep};
use rimbench_results::run_table::RunTable;
use rimbench_runs::{EvaluatedRun, Reference};
use std::collections::{HashMap, HashSet};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Which program has stored all rows of a folder, where it was one.
const MADE_BY: &str = "records/made_by";

/// Missing runs that are told one by one.
const TOLD: usize = 20;

/// A results folder with the rows that are stored in it.
#[derive(Debug)]
pub(super) struct Folder<'a> {
    path: &'a Path,
    experiment: &'a Experiment,
    build: &'a BuildInfo,
    /// Its rows.
    pub(super) store: Store,
}

impl<'a> Folder<'a> {
    /// Opens the folder of a job to store its runs in, with a copy of the experiment file beside them.
    ///
    /// # Errors
    /// Those of [`look`](Self::look); a disk that is full.
    pub(super) fn open(job: &Job<'a>, plan: &[PlannedRun]) -> Result<Self> {
        let (mark, own) = (job.folder.join(MADE_BY), job.build.program());
        let of_others = std::fs::read_to_string(&mark).ok().as_ref() != Some(&own);
        let fresh = job.fresh || job.of_this_program && of_others;
        let (folder, copy) = Self::trusted(&Job { fresh, ..*job }, plan, true)?;
        check_writable_folder(job.folder)?;
        check_writable_folder(&job.folder.join("records"))?;
        if of_others || fresh {
            // From now on rows of two programs may stand here.
            match folder.store.run_ids().is_empty() {
                true => write_atomically(&mark, |file| file.write_all(own.as_bytes()))?,
                false => drop(std::fs::remove_file(&mark)),
            }
        }
        if let Some(copy) = copy {
            write_atomically(&job.folder.join(COPY), |file| file.write_all(copy.as_bytes()))?;
        }
        Ok(folder)
    }

    /// Opens the folder of a job and writes nothing. What others have put there is not replaced without a word.
    ///
    /// # Errors
    /// [`Error::File`] naming what is there and what to do.
    pub(super) fn look(job: &Job<'a>, plan: &[PlannedRun]) -> Result<Self> {
        Ok(Self::trusted(job, plan, false)?.0)
    }

    /// Opens a folder without files or rows of others, `cleared` of its rows where they are to be forgotten. Returned
    /// with it is the copy of the experiment file where that is not in it.
    fn trusted(job: &Job<'a>, plan: &[PlannedRun], cleared: bool) -> Result<(Self, Option<String>)> {
        let copy = copy_among_own_files(job)?;
        if job.fresh && cleared {
            Store::clear(job.folder)?;
        }
        let folder = Self::of(job.folder, job.experiment, job.build)?;
        if job.fresh || copy.is_none() {
            return Ok((folder, copy));
        }
        // Another experiment file of the same name, one that is there still, and says something else.
        let own = job.experiment.path();
        let rival = |other: &&PathBuf| {
            let is_other = own.canonicalize().is_ok_and(|own| own != **other);
            is_other && other.is_file() && std::fs::read(other).ok() != std::fs::read(own).ok()
        };
        let others = match &folder.store.last_file {
            Some(file) => Some(file).filter(rival).map(|other| format!("{}, an experiment", other.display())),
            None => {
                // A table of another layout was ours when it was written.
                let table = RunTable::read_from(job.folder).ok().filter(|table| !table.is_empty());
                table.filter(|table| !results::shares_runs(plan, table)).map(|_| "another experiment".to_owned())
            }
        };
        let advice = "of the same name: use another folder, or --fresh to replace them";
        let refused = |others| Err(Error::file(job.folder, format!("holds the results of {others} {advice}")));
        others.map_or(Ok((folder, copy)), refused)
    }

    /// Opens a folder whose experiment is known to be this one.
    ///
    /// # Errors
    /// Those of [`Store::open`].
    fn of(path: &'a Path, experiment: &'a Experiment, build: &'a BuildInfo) -> Result<Self> {
        let store = Store::open(path, experiment.path(), &experiment.reference_identity())?;
        Ok(Folder { path, experiment, build, store })
    }

    /// The row of a run that need not be computed: it is no defect of another build, and has the trace that is asked
    /// for, as it was written with it.
    pub(super) fn finished(&self, run: &PlannedRun) -> Option<&RunRow> {
        let row = row_of(&self.store, run).filter(|row| !row.is_defect() || row.origin.is_of(self.build))?;
        let Some(every_s) = self.experiment.trace_of(&run.label) else { return Some(row) };
        let path = self.path.join("traces").join(results::trace_name(&run.id));
        let found = || Some(TraceMark { every_s, sha256: sha256_of_file(&path)? });
        row.trace.as_ref().is_some_and(|kept| found().as_ref() == Some(kept)).then_some(row)
    }

    /// Places of the runs that are still to be computed; of one that has several labels the first that asks for its
    /// trace, or the first.
    pub(super) fn missing(&self, plan: &[PlannedRun]) -> Vec<usize> {
        let mut places: HashMap<&str, usize> = HashMap::new();
        let traced = |place: usize| self.experiment.trace_of(&plan[place].label).is_some();
        for (place, run) in plan.iter().enumerate().filter(|(_, run)| self.finished(run).is_none()) {
            let known = places.entry(&run.id).or_insert(place);
            if traced(place) && !traced(*known) {
                *known = place;
            }
        }
        let mut missing: Vec<usize> = places.into_values().collect();
        missing.sort_unstable();
        missing
    }

    /// Stores a run that has just ended, with its trace where one is asked for.
    ///
    /// # Errors
    /// [`Error::File`] naming the file.
    pub(super) fn keep(&self, planned: &PlannedRun, run: &EvaluatedRun, origin: RunOrigin) -> Result<()> {
        let every = self.experiment.trace_of(&planned.label);
        let write = |every| results::write_trace(self.path, &results::trace_name(&planned.id), &run.trajectory, every);
        let mark = every.map(write).transpose()?;
        self.store.append(RunRow::of(&planned.id, &planned.spec, run, origin, mark))
    }

    /// Reads the folder again, for what others have stored meanwhile, and writes the result files if no run is missing.
    /// Returns the places of those that are, and if any is how many runs are stored that are not of the plan. `held` is
    /// a reference that is at hand, with the place of a run that it belongs to.
    ///
    /// # Errors
    /// [`Error::File`] naming the file; whatever makes a reference fail.
    pub(super) fn finish(
        self,
        job: &Job<'_>,
        plan: &[PlannedRun],
        held: Option<(usize, Reference)>,
        stop: StopFlag<'_>,
    ) -> Result<(Vec<usize>, usize)> {
        let Folder { path, experiment, build, .. } = self;
        let folder = match self.store.is_up_to_date() {
            true => self,
            false => {
                // The rows are held once.
                drop(self);
                Self::of(path, experiment, build)?
            }
        };
        let missing = folder.missing(plan);
        if missing.is_empty() {
            folder.export(job, plan, held, stop)?;
            return Ok((missing, 0));
        }
        let planned: HashSet<&str> = plan.iter().map(|run| run.id.as_str()).collect();
        let unplanned = folder.store.run_ids().difference(&planned).count();
        Ok((missing, unplanned))
    }

    /// Writes the result files, in the order of the plan.
    fn export(
        &self,
        job: &Job<'_>,
        plan: &[PlannedRun],
        mut held: Option<(usize, Reference)>,
        stop: StopFlag<'_>,
    ) -> Result<()> {
        results::write_tables(self.path, self.experiment, plan, |run| row_of(&self.store, run))?;
        let mut needed = References::default();
        plan.iter().for_each(|run| needed.note(&run.spec));
        let names = needed.names();
        let references = needed.0.iter().map(|spec| {
            if let Some((_, reference)) = held.take_if(|held| plan[held.0].spec.shares_reference_with(spec)) {
                return Ok((spec, Some(reference)));
            }
            match obtain_reference(spec, job.cache, stop) {
                Err(Error::Overdue { .. }) => Ok((spec, None)),
                Err(error) if has_none(&error) => Ok((spec, None)),
                found => Ok((spec, Some(found?))),
            }
        });
        let rejected = plan.iter().filter_map(|run| Some((problem(run), run.rejected_draws?))).collect();
        let every = self.experiment.trace_every_s;
        let of_references = results::write_references(self.path, references, &names, &rejected, every)?;
        keep(self.path, &pooled_sets(plan), &self.experiment.sum_of_plan(job.catalogue, plan, job.quick)?)?;
        if let Some(budgets) = self.experiment.budgets() {
            keep_budget(self.path, budgets, &pooled_sets(plan))?;
        }
        let traced = plan.iter().filter(|run| self.experiment.trace_of(&run.label).is_some());
        let beliefs = self.experiment.beliefs(job.catalogue)?;
        let beliefs =
            beliefs.iter().map(|(at_s, runs)| results::write_beliefs(self.path, job.catalogue, *at_s, runs, stop));
        let made = of_references.into_iter().chain(beliefs.collect::<Result<Vec<_>>>()?);
        results::write_checksums(self.path, traced.map(|run| results::trace_name(&run.id)).chain(made))
    }

    /// Holds the `runs.csv` of a folder against the rows that are stored beside it.
    ///
    /// # Errors
    /// [`Error::File`] if one says what the other does not.
    pub(super) fn check(path: &Path, experiment: &Experiment, plan: &[PlannedRun]) -> Result<()> {
        let store = Store::open(path, experiment.path(), &experiment.reference_identity())?;
        results::check_runs(path, experiment, plan, |run| row_of(&store, run))
    }
}

/// The row of a run that [answers](RunRow::answers) what is asked of it.
fn row_of<'s>(store: &'s Store, run: &PlannedRun) -> Option<&'s RunRow> {
    let asked = Asked::of(&run.spec);
    store.rows_of(&run.id).find(|row| row.answers(asked, run.spec.wall_limit))
}

/// Case and set of a run.
fn problem(run: &PlannedRun) -> (String, String) {
    (run.spec.case.name.to_string(), run.set.to_string())
}

/// The sets of parameters of a plan that are pooled.
pub(super) fn pooled_sets(plan: &[PlannedRun]) -> PooledSets {
    plan.iter().filter_map(|run| Some((problem(run), run.pooled_set.as_ref()?.to_string()))).collect()
}

/// Copies the rows of other folders into that of a job, writes the result files if all runs are there, and returns what
/// was done with the first of the runs that are missing, twenty at most.
///
/// # Errors
/// Folders that belong to something else; a disk that is full.
pub fn collect_shards(job: Job<'_>, folders: &[&Path]) -> Result<(Summary, Vec<PlannedRun>)> {
    let plan = job.experiment.plan(job.catalogue, job.quick)?;
    let own = Folder::open(&job, &plan)?;
    let mut summary = Summary { planned: plan.len(), damaged: own.store.damaged.clone(), ..Summary::default() };
    let mut wanted = own.missing(&plan);
    for folder in folders {
        let other = Folder::of(folder, job.experiment, job.build)?;
        summary.damaged.extend(other.store.damaged.iter().cloned());
        let mut still_wanted = Vec::new();
        for index in wanted {
            let Some(row) = other.finished(&plan[index]) else {
                still_wanted.push(index);
                continue;
            };
            results::copy_trace(folder, job.folder, &row.run_id)?;
            own.store.append(row.clone())?;
            summary.computed += 1;
        }
        wanted = still_wanted;
    }
    own.store.sync()?;
    let (missing, unplanned) = own.finish(&job, &plan, None, StopFlag::never())?;
    (summary.missing, summary.unplanned) = (missing.len(), unplanned);
    summary.reused = plan.len() - missing.len() - summary.computed;
    Ok((summary, missing.iter().take(TOLD).map(|&index| plan[index].clone()).collect()))
}

/// Refuses a folder in which files of others have the names of results. Returns the copy of the experiment file where
/// it is not there just as it would be.
fn copy_among_own_files(job: &Job<'_>) -> Result<Option<String>> {
    let (runs, copy) = (job.folder.join("runs.csv"), job.folder.join(COPY));
    let refused = |path: &Path, who: &str| {
        let advice = "would be replaced: move it away or choose another folder with --out";
        Err(Error::file(path, format!("was not written by {who} and {advice}")))
    };
    if runs.exists() && (!copy.is_file() || !begins_as_ours(&runs)) {
        return refused(&runs, "an experiment");
    }
    let text = job.experiment.copy_in(job.folder);
    let text = (!std::fs::read_to_string(&copy).is_ok_and(|there| there == text)).then_some(text);
    let is_ours = text.is_none() || runs.exists() || job.folder.join("records").is_dir();
    if copy.exists() && !is_ours { refused(&copy, "this program") } else { Ok(text) }
}

/// Whether a table has the first column of ours, or nothing that could be lost.
fn begins_as_ours(runs: &Path) -> bool {
    let begins = || -> std::io::Result<bool> {
        let mut line = String::new();
        BufReader::new(std::fs::File::open(runs)?.take(64)).read_line(&mut line)?;
        Ok(line.is_empty() || line.starts_with("run_id,"))
    };
    runs.metadata().is_ok_and(|found| found.is_file()) && begins().unwrap_or(false)
}
