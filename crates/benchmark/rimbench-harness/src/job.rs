//! What to run, where to, and what came of it.

use super::build_info::BuildInfo;
use super::cache::Cache;
use super::experiment::{Experiment, PlannedRun};
use super::grid::MOST_RUNS;
use super::store::Damaged;
use rimbench_core::cosim::{OutcomeClass, StopFlag};
use rimbench_core::error::Result;
use rimbench_runs::catalogue::Catalogue;
use std::ops::Range;
use std::path::Path;

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
    /// Forget it unless this very program, of these sources and this compiler, has stored all of it.
    pub of_this_program: bool,
    /// Only a part of the plan; all of it if absent.
    pub shard: Option<Shard>,
    /// Where references are kept.
    pub cache: &'a Cache,
    /// What the program was built from, for the rows of provenance.
    pub build: &'a BuildInfo,
}

impl<'a> Job<'a> {
    /// The whole plan of an experiment, on top of what its folder holds already.
    pub fn new(
        experiment: &'a Experiment,
        catalogue: &'a Catalogue,
        folder: &'a Path,
        cache: &'a Cache,
        build: &'a BuildInfo,
    ) -> Self {
        Job {
            experiment,
            catalogue,
            folder,
            quick: false,
            fresh: false,
            of_this_program: false,
            shard: None,
            cache,
            build,
        }
    }

    /// Lays out the plan of `size` runs, each part of it with the place of its first run: at once, or only these places
    /// of it, part by part, where it is too large for that.
    pub(super) fn plans(
        self,
        size: usize,
        places: Option<Range<usize>>,
    ) -> impl Iterator<Item = Result<(usize, Vec<PlannedRun>)>> + 'a {
        let Job { experiment, catalogue, quick, .. } = self;
        let parts = places.filter(|_| size > MOST_RUNS).map(|places| experiment.parts(catalogue, quick, places));
        let whole = parts.is_none().then(|| Ok((0, experiment.plan(catalogue, quick)?)));
        whole.into_iter().chain(parts.into_iter().flatten())
    }
}

/// A part of a plan, by the places of its runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shard {
    /// Part i of n, from 1: every n-th run. Who is last writes the result files.
    Every {
        /// Which part, from 1.
        part: usize,
        /// Of how many.
        of: usize,
    },
    /// Neighbours, which mostly share a reference: from one place to another, both included, counted from 0. These are
    /// one task of many, so none of them looks after the whole: [`collect_shards`](crate::collect_shards) writes the
    /// result files.
    Places {
        /// Place of the first run.
        first: usize,
        /// Place of the last.
        last: usize,
    },
}

impl Shard {
    /// Whether the run at a place belongs to it.
    pub(super) fn has(self, place: usize) -> bool {
        match self {
            Shard::Every { part, of } => place % of == part - 1,
            Shard::Places { first, last } => (first..=last).contains(&place),
        }
    }
}

/// What a job did.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Summary {
    /// Runs of the whole experiment; those of its places only, for a job of [`Shard::Places`], here and in `missing`.
    pub planned: usize,
    /// Runs that were stored before.
    pub reused: usize,
    /// Runs that were stored, but have to be computed again: they took too long and may take longer now, or the trace
    /// that is asked for is not there, not as it was written, or of another step.
    pub renewed: usize,
    /// Runs computed now.
    pub computed: usize,
    /// Runs computed now that did not complete; they are rows like others.
    pub not_completed: usize,
    /// Rows found damaged, and computed again if they belong to this job.
    pub damaged: Vec<Damaged>,
    /// Runs of the whole experiment that are not stored yet.
    pub missing: usize,
    /// Stored runs that are not of the experiment as it is, where some are missing; only
    /// [`collect_shards`](crate::collect_shards) counts them.
    pub unplanned: usize,
    /// Whether the experiment has more runs than are planned at once: then all counts are of the shard, and there are
    /// no result files.
    pub in_parts: bool,
}

/// How far a job is.
#[derive(Debug, Clone, Copy)]
pub enum Step {
    /// So many runs are to be computed now: not those that are stored, nor those of other shards.
    ToDo(usize),
    /// One of them is done, and counts as this.
    Done(OutcomeClass),
}

/// Told how far a job is; called from several threads.
pub type Progress<'a> = &'a (dyn Fn(Step) + Sync);

/// What may end a job before all its runs are done; what is stored stays.
#[derive(Debug, Clone, Copy)]
pub struct StopFlags<'a> {
    /// No run is begun any more, and a reference under way is given up; runs under way go on to their end.
    pub soon: StopFlag<'a>,
    /// Runs under way end as well, in their next step.
    pub now: StopFlag<'a>,
}
