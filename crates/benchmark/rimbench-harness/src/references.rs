//! References, computed once on all cores and kept by content.

use super::cache::Cache;
use rayon::prelude::*;
use rimbench_core::cosim::StopFlag;
use rimbench_core::error::{Error, Result};
use rimbench_runs::{Reference, RunSpec, Solution};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Thread;
use std::time::{Duration, Instant};

/// How often the wall limit of a reference is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Computes the reference of a run within the run's wall limit, or takes it from the cache, where no case from outside
/// is kept.
///
/// # Errors
/// Bad parameters, or parameters for which the monolithic solution itself fails or is [not known](Reference::check);
/// [`Error::Stopped`]; [`Error::Overdue`].
pub fn obtain_reference(spec: &RunSpec, cache: &Cache, stop: StopFlag<'_>) -> Result<Reference> {
    if let Some(reference) = within_limit(spec, stop, |stop| Reference::exact(spec, stop))? {
        return Ok(reference);
    }
    let spec = &spec.of_the_reference();
    let key = content_key(spec);
    let kept = if spec.case.from_outside { None } else { cache.read(&key) };
    if let Some(data) = kept
        && let Some(reference) = Reference::unpack(&spec.case, data)
    {
        reference.check(spec)?;
        return Ok(reference);
    }
    let Ok([fine, middle, coarse]) = <[Solution; 3]>::try_from(within_limit(spec, stop, |stop| solutions(spec, stop))?)
    else {
        unreachable!("three refinements give three solutions")
    };
    let reference = Reference::compared(spec, [coarse, middle, fine], stop)?;
    if !spec.case.from_outside {
        cache.write(&key, &reference.pack());
    }
    reference.check(spec)?;
    Ok(reference)
}

/// Tells whether an error says that a set of parameters has no reference: it leaves its range, or its machine cannot be
/// built. That is a finding about the machine, and no reason to end an experiment.
pub(super) fn has_none(error: &Error) -> bool {
    matches!(error, Error::Incompatible(_) | Error::InvalidValue { .. })
}

/// The solutions, the finest first because it takes longest.
fn solutions(spec: &RunSpec, stop: StopFlag<'_>) -> Result<Vec<Solution>> {
    Reference::REFINEMENTS.par_iter().rev().map(|&refinement| Reference::solution(spec, refinement, stop)).collect()
}

/// Solves for a reference, ended by a watchdog when the wall limit has passed.
fn within_limit<T>(spec: &RunSpec, stop: StopFlag<'_>, solve: impl FnOnce(StopFlag<'_>) -> Result<T>) -> Result<T> {
    let Some(limit) = spec.wall_limit else { return solve(stop) };
    let (raised, done, began) = (AtomicBool::new(false), AtomicBool::new(false), Instant::now());
    std::thread::scope(|scope| {
        let watchdog = scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                if stop.check().is_err() || began.elapsed() > limit {
                    raised.store(true, Ordering::Relaxed);
                }
                std::thread::park_timeout(LOOK_EVERY);
            }
        });
        // Also when solving panics: the scope waits for the watchdog.
        let _ended = Ended { done: &done, watchdog: watchdog.thread().clone() };
        match solve(StopFlag::new(&raised)) {
            Err(Error::Stopped) if stop.check().is_ok() => Err(Error::Overdue { limit_s: limit.as_secs_f64() }),
            found => found,
        }
    })
}

/// Sends a watchdog home when it goes out of scope.
struct Ended<'a> {
    done: &'a AtomicBool,
    watchdog: Thread,
}

impl Drop for Ended<'_> {
    fn drop(&mut self) {
        self.done.store(true, Ordering::Relaxed);
        self.watchdog.unpark();
    }
}

/// Everything that determines a reference, as text; the code itself included.
pub(super) fn content_key(spec: &RunSpec) -> String {
    let (case, duration) = (&spec.case, spec.duration);
    let mut key = format!(
        "reference of {}\nsources {} {} {}\nduration_s = {duration:?}\n",
        case.name,
        rimbench_core::SOURCES.join(" "),
        rimbench_cases::SOURCES,
        rimbench_runs::SOURCES
    );
    key += &format!("columns = {:?}\nsteps = {:?}\n", case.recorded_columns(), case.defaults);
    // Of cases that are built in, the sources above are the digest.
    key += &spec.case.digest.iter().map(|digest| format!("case_digest = {digest}\n")).collect::<String>();
    for (parameter, value) in spec.parameters.iter() {
        key += &format!("{} = {value}\n", parameter.name);
    }
    key
}

/// Of each reference of a plan the run that may take longest: the reference may take as long.
#[derive(Debug, Default)]
pub(super) struct References(pub(super) Vec<RunSpec>);

impl References {
    /// Names of the cases, numbered where a case has several; none where there is one reference.
    pub(super) fn names(&self) -> Vec<String> {
        let name = |index: usize, spec: &RunSpec| {
            let before = self.0[..index].iter().filter(|other| other.case.name == spec.case.name).count();
            if before == 0 { spec.case.name.to_string() } else { format!("{}-{}", spec.case.name, before + 1) }
        };
        if self.0.len() == 1 {
            Vec::new()
        } else {
            self.0.iter().enumerate().map(|(index, spec)| name(index, spec)).collect()
        }
    }

    /// Cases and parameters are the outer loops of a plan: runs of one reference are mostly neighbours, unless a case
    /// is named again behind others.
    pub(super) fn note(&mut self, spec: &RunSpec) {
        let patience = |spec: &RunSpec| spec.wall_limit.unwrap_or(Duration::MAX);
        match self.0.iter_mut().rev().find(|known| known.shares_reference_with(spec)) {
            Some(known) if patience(spec) > patience(known) => *known = spec.clone(),
            Some(_) => {}
            None => self.0.push(spec.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimbench_runs::RunRequest;
    use rimbench_runs::catalogue::Catalogue;

    #[test]
    fn a_case_that_is_named_again_behind_another_has_one_reference() {
        let spec = |case| RunRequest::of(case, "zero-order-hold").resolve(&Catalogue::standard()).unwrap();
        let [first, other] = ["linear-oscillator", "bouncing-ball"].map(spec);
        let limited = first.with(|own| own.wall_limit = Some(Duration::from_secs(1))).unwrap();
        let mut found = References::default();
        for spec in [&limited, &other, &first, &other, &limited] {
            found.note(spec);
        }
        let names: Vec<_> = found.0.iter().map(|spec| &*spec.case.name).collect();
        assert_eq!(names, ["linear-oscillator", "bouncing-ball"]);
        // The one that may take longest stands for them.
        assert_eq!(found.0[0].wall_limit, None);
    }
}
