//! Runs a plan on all cores, against references computed once.

use super::cache::{Cache, hex};
use super::evaluation::{EvaluatedRun, evaluate};
use super::experiment::{Experiment, PlannedRun};
use super::reference::Reference;
use super::run::{RunSpec, simulate};
use crate::error::Result;
use crate::numerics_version::NUMERICS_VERSION;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::sync::Arc;

/// A run with its row's identity and its result.
#[derive(Debug, Clone)]
pub struct ExecutedRun {
    /// Hash of everything that determines the run.
    pub id: String,
    /// What was planned.
    pub planned: PlannedRun,
    /// What came of it.
    pub evaluated: EvaluatedRun,
    /// The reference it is held against.
    pub reference: Arc<Reference>,
}

/// An experiment with all its runs, in the order of the plan.
#[derive(Debug, Clone)]
pub struct Executed {
    /// The experiment.
    pub experiment: Experiment,
    /// Whether this was the quick plan.
    pub quick: bool,
    /// The runs.
    pub runs: Vec<ExecutedRun>,
}

/// Told about each run that is done; called from several threads.
pub type Progress<'a> = &'a (dyn Fn(&ExecutedRun) + Sync);

/// Plans and runs an experiment.
///
/// # Errors
/// Bad input. A run that fails is a result.
pub fn execute(experiment: &Experiment, quick: bool, cache: &Cache, progress: Progress<'_>) -> Result<Executed> {
    let planned = experiment.plan(quick)?;
    let references = references(&planned, cache)?;
    let runs: Result<Vec<ExecutedRun>> = planned
        .into_par_iter()
        .zip(references)
        .map(|(planned, reference)| {
            let spec = &planned.spec;
            let bounds = reference.bounds(spec.case, &spec.parameters, spec.solver)?;
            let evaluated = evaluate(spec, simulate(spec, bounds)?, &reference);
            let run = ExecutedRun { id: run_id(spec), planned, evaluated, reference };
            progress(&run);
            Ok(run)
        })
        .collect();
    Ok(Executed { experiment: experiment.clone(), quick, runs: runs? })
}

/// One reference per run, shared where case, parameters and duration are the same.
fn references(planned: &[PlannedRun], cache: &Cache) -> Result<Vec<Arc<Reference>>> {
    let mut known: Vec<(&RunSpec, Arc<Reference>)> = Vec::new();
    let mut references = Vec::with_capacity(planned.len());
    for run in planned {
        let spec = &run.spec;
        let same = known.iter().find(|(other, _)| {
            other.case.name == spec.case.name && other.parameters == spec.parameters && other.duration == spec.duration
        });
        let reference = match same {
            Some((_, reference)) => Arc::clone(reference),
            None => {
                let reference =
                    Arc::new(Reference::obtain(spec.case, &spec.parameters, spec.solver, spec.duration, cache)?);
                known.push((spec, Arc::clone(&reference)));
                reference
            }
        };
        references.push(reference);
    }
    Ok(references)
}

/// Hash of everything that determines a run, 16 hexadecimal digits.
pub fn run_id(spec: &RunSpec) -> String {
    let mut key = format!("numerics {NUMERICS_VERSION}\ncase {}\n", spec.case.name);
    for (parameter, value) in spec.parameters.iter() {
        key += &format!("{} = {value}\n", parameter.name);
    }
    key += &format!(
        "scheme {} {:?} {} {}\nH = {:?} φ = {:?} h = {:?} n_m = {} T = {:?}\nsequence {} return {} solver {}\n",
        spec.scheme.name,
        spec.options.redundancy,
        spec.options.motion,
        spec.options.solver.name,
        spec.macro_step,
        spec.phase,
        spec.micro_step,
        spec.mechanics_steps,
        spec.duration,
        spec.sequence,
        spec.force_return,
        spec.solver.name,
    );
    hex(&Sha256::digest(key))[..16].to_owned()
}
