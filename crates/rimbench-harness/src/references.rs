//! References, computed once on all cores and kept by content.

use super::cache::Cache;
use rayon::prelude::*;
use rimbench_cases::runs::{Reference, RunSpec};
use rimbench_core::cosim::{StopFlag, Trajectory};
use rimbench_core::error::{Error, Result};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How often the wall limit of a reference is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Computes the reference of a run within the run's wall limit, or takes it from the cache, where no case from outside is kept.
///
/// # Errors
/// Bad parameters, or parameters for which the monolithic solution itself fails; [`Error::Stopped`]; [`Error::Overdue`].
pub fn obtain_reference(spec: &RunSpec, cache: &Cache, stop: StopFlag<'_>) -> Result<Reference> {
    if let Some(reference) = Reference::exact(spec)? {
        return Ok(reference);
    }
    let spec = &spec.of_the_reference();
    let key = content_key(spec);
    let kept = if spec.case.from_outside { None } else { cache.read(&key) };
    if let Some(data) = kept
        && let Some(reference) = Reference::unpack(&spec.case, data)
    {
        return Ok(reference);
    }
    let Ok([fine, middle, coarse]) = <[Trajectory; 3]>::try_from(within_limit(spec, stop)?) else {
        unreachable!("three refinements give three solutions")
    };
    let reference = Reference::compared(spec, [coarse, middle, fine])?;
    if !spec.case.from_outside {
        cache.write(&key, &reference.pack());
    }
    Ok(reference)
}

/// The solutions, the finest first because it takes longest.
fn solutions(spec: &RunSpec, stop: StopFlag<'_>) -> Result<Vec<Trajectory>> {
    Reference::REFINEMENTS.par_iter().rev().map(|&refinement| Reference::solution(spec, refinement, stop)).collect()
}

/// The same, ended by a watchman when the wall limit has passed.
fn within_limit(spec: &RunSpec, stop: StopFlag<'_>) -> Result<Vec<Trajectory>> {
    let Some(limit) = spec.wall_limit else { return solutions(spec, stop) };
    let (raised, done, began) = (AtomicBool::new(false), AtomicBool::new(false), Instant::now());
    std::thread::scope(|scope| {
        let watchman = scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                if stop.check().is_err() || began.elapsed() > limit {
                    raised.store(true, Ordering::Relaxed);
                }
                std::thread::park_timeout(LOOK_EVERY);
            }
        });
        let found = solutions(spec, StopFlag::new(&raised));
        done.store(true, Ordering::Relaxed);
        watchman.thread().unpark();
        match found {
            Err(Error::Stopped) if stop.check().is_ok() => Err(Error::Overdue { limit_s: limit.as_secs_f64() }),
            found => found,
        }
    })
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
