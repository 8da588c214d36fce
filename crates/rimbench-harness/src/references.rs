//! References, computed once on all cores and kept by content.

use super::cache::Cache;
use rayon::prelude::*;
use rimbench_cases::runs::{Reference, RunSpec};
use rimbench_core::cosim::{StopFlag, Trajectory};
use rimbench_core::error::Result;

/// Computes the reference of a run, or takes it from the cache.
///
/// # Errors
/// Bad parameters, or parameters for which the monolithic solution itself fails;
/// [`Error::Stopped`](rimbench_core::error::Error::Stopped).
pub fn obtain_reference(spec: &RunSpec, cache: &Cache, stop: StopFlag<'_>) -> Result<Reference> {
    if let Some(reference) = Reference::exact(spec)? {
        return Ok(reference);
    }
    let key = content_key(spec);
    if let Some(data) = cache.read(&key)
        && let Some(reference) = Reference::unpack(&spec.case, data)
    {
        return Ok(reference);
    }
    // The finest takes longest, so it begins first.
    let solutions: Result<Vec<Trajectory>> = Reference::REFINEMENTS
        .par_iter()
        .rev()
        .map(|&refinement| Reference::solution(spec, refinement, stop))
        .collect();
    let Ok([fine, middle, coarse]) = <[Trajectory; 3]>::try_from(solutions?) else {
        unreachable!("three refinements give three solutions")
    };
    let reference = Reference::compared(spec, [coarse, middle, fine]);
    cache.write(&key, &reference.pack());
    Ok(reference)
}

/// Everything that determines a reference, as text; the code itself included.
fn content_key(spec: &RunSpec) -> String {
    let (case, duration) = (&spec.case, spec.duration);
    let mut key = format!(
        "reference of {}\nsources {} {}\nduration_s = {duration:?}\n",
        case.name,
        rimbench_core::SOURCES,
        rimbench_cases::SOURCES
    );
    key += &format!("columns = {:?}\nsteps = {:?}\n", case.recorded_columns(), case.defaults);
    for (parameter, value) in spec.parameters.iter() {
        key += &format!("{} = {value}\n", parameter.name);
    }
    key
}
