//! What is missing of an experiment, in chunks that last about equally long.

use crate::experiment::PlannedRun;
use crate::folder::Folder;
use crate::job::Job;
use rimbench_core::error::Result;
use std::collections::BTreeMap;

/// Neighbours in the plan of which some are missing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chunk {
    /// Place of the first run, from 0.
    pub first: usize,
    /// Place of the last run.
    pub last: usize,
    /// Missing runs among them.
    pub runs: usize,
    /// Expected time on one core, s.
    pub seconds: f64,
}

impl Chunk {
    /// Returns its places as `run --places` takes them.
    pub fn places(&self) -> String {
        format!("{}-{}", self.first, self.last)
    }
}

/// How long a chunk is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChunkLimits {
    /// Time of a chunk on one core, s. A run that takes longer is a chunk of its own.
    pub seconds: f64,
    /// Time of a run where the store has measured none to go by, s.
    pub unmeasured_run_s: f64,
}

/// What is missing of an experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct Chunking {
    /// Runs of the experiment.
    pub planned: usize,
    /// Runs that are not stored.
    pub missing: usize,
    /// Missing runs whose time was guessed from stored ones.
    pub measured: usize,
    /// The missing runs.
    pub chunks: Vec<Chunk>,
}

impl Chunking {
    /// Returns the time of all chunks on one core, s.
    pub fn seconds(&self) -> f64 {
        self.chunks.iter().map(|chunk| chunk.seconds).sum()
    }
}

/// Stored runs of a scheme row on a case at one macro step that are looked at: their times differ little.
const LOOKED_AT: usize = 4;

/// Divides what is missing of a job into chunks, by the times that the store has; writes nothing.
///
/// # Errors
/// Bad input; a folder that belongs to something else.
pub fn missing_chunks(job: Job<'_>, limits: ChunkLimits) -> Result<Chunking> {
    let size = job.experiment.size(job.quick)?;
    let mut chunking = Chunking { planned: size, missing: 0, measured: 0, chunks: Vec::new() };
    let (mut folder, mut times) = (None, Times::default());
    let mut divide = |first: usize, planned: Vec<PlannedRun>| -> Result<()> {
        let folder = match &mut folder {
            Some(folder) => folder,
            none => none.insert(Folder::look(&job, &planned)?),
        };
        let missing = folder.missing(&planned);
        chunking.missing += missing.len();
        // Times of finished runs are not needed.
        if !missing.is_empty() {
            for run in &planned {
                if !times.wants(run) {
                    continue;
                }
                let seconds = folder.store.get(&run.id).map(|row| row.costs.wall_s);
                if let Some(seconds) = seconds.filter(|seconds| seconds.is_finite()) {
                    times.learn(run, seconds);
                }
            }
        }
        for index in missing {
            let (place, run) = (first + index, &planned[index]);
            let known = times.of(run);
            chunking.measured += usize::from(known.is_some());
            let most = run.spec.wall_limit.map_or(f64::INFINITY, |limit| limit.as_secs_f64());
            let seconds = known.unwrap_or(limits.unmeasured_run_s).min(most);
            match chunking.chunks.last_mut().filter(|chunk| chunk.seconds + seconds <= limits.seconds) {
                Some(chunk) => {
                    *chunk = Chunk { last: place, runs: chunk.runs + 1, seconds: chunk.seconds + seconds, ..*chunk }
                }
                None => chunking.chunks.push(Chunk { first: place, last: place, runs: 1, seconds }),
            }
        }
        Ok(())
    };
    for part in job.plans(size, Some(0..size)) {
        let (first, planned) = part?;
        divide(first, planned)?;
    }
    Ok(chunking)
}

/// Measured times, by case and scheme row.
#[derive(Debug, Default)]
struct Times(BTreeMap<(String, String), Vec<OfStep>>);

/// The times at one macro step.
#[derive(Debug, Clone, Copy)]
struct OfStep {
    macro_step: f64,
    sum_s: f64,
    count: usize,
}

impl Times {
    fn key(run: &PlannedRun) -> (String, String) {
        (run.spec.case.name.to_string(), run.label.clone())
    }

    /// Whether another time of such a run would tell anything.
    fn wants(&self, run: &PlannedRun) -> bool {
        let known = self.0.get(&Self::key(run)).into_iter().flatten();
        let mut at_step = known.filter(|of| of.macro_step == run.spec.macro_step);
        at_step.next().is_none_or(|of| of.count < LOOKED_AT)
    }

    fn learn(&mut self, run: &PlannedRun, seconds: f64) {
        let known = self.0.entry(Self::key(run)).or_default();
        match known.iter_mut().find(|of| of.macro_step == run.spec.macro_step) {
            Some(of) => *of = OfStep { sum_s: of.sum_s + seconds, count: of.count + 1, ..*of },
            None => known.push(OfStep { macro_step: run.spec.macro_step, sum_s: seconds, count: 1 }),
        }
    }

    /// The mean time at the macro step nearest in ratio, of the same scheme row on the same case; else of any scheme on
    /// that case.
    fn of(&self, run: &PlannedRun) -> Option<f64> {
        let far = |of: &OfStep| (of.macro_step / run.spec.macro_step).ln().abs();
        let nearest = |all: &mut dyn Iterator<Item = &OfStep>| {
            let best = all.min_by(|a, b| far(a).total_cmp(&far(b)))?;
            Some(best.sum_s / best.count as f64)
        };
        let own = self.0.get(&Self::key(run));
        own.and_then(|own| nearest(&mut own.iter())).or_else(|| {
            let of_case = self.0.iter().filter(|((case, _), _)| *case == run.spec.case.name);
            let of_case: Vec<f64> = of_case.filter_map(|(_, own)| nearest(&mut own.iter())).collect();
            (!of_case.is_empty()).then(|| of_case.iter().sum::<f64>() / of_case.len() as f64)
        })
    }
}
