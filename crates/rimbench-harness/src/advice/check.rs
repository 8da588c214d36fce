//! How right an advice is: held against phases that it never saw, and against an exhaustive search.

use super::probe::Prober;
use super::{Advice, Choice, Question, advise};
use crate::grid::phase_ensemble;
use crate::references::obtain_reference;
use rayon::prelude::*;
use rimbench_cases::runs::RunRequest;
use rimbench_core::error::Result;

/// What came of a check.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckedAdvice {
    /// The advice.
    pub advice: Advice,
    /// What was advised and the runner-up, at phases that no search saw.
    pub further: Vec<Further>,
    /// The advice of the exhaustive search, at the same phases.
    pub exhaustive: Advice,
    /// The one against the other.
    pub verdict: AdviceVerdict,
}

/// A choice at phases that no search saw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Further {
    /// How many phases.
    pub phases: usize,
    /// At how many of them the error is exceeded by a run that completes.
    pub exceeded: usize,
    /// At how many of them a run does not complete.
    pub unstable: usize,
    /// The largest error of those that complete.
    pub worst_error: f64,
}

/// What an exhaustive search says to an advice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AdviceVerdict {
    /// Nothing is cheaper, or there is none.
    Cheapest,
    /// Something is, by no more than one step of the grid.
    WithinOneStep,
    /// Something is, by more.
    Cheaper,
    /// The advice is none, and there is something.
    Missed,
}

impl AdviceVerdict {
    /// All of them, with their names.
    pub const NAMES: [(&'static str, Self); 4] = [
        ("cheapest", AdviceVerdict::Cheapest),
        ("within one step", AdviceVerdict::WithinOneStep),
        ("cheaper exists", AdviceVerdict::Cheaper),
        ("missed", AdviceVerdict::Missed),
    ];

    fn of(quick: Option<&Choice>, exhaustive: Option<&Choice>) -> Self {
        match (quick, exhaustive) {
            (_, None) => AdviceVerdict::Cheapest,
            (None, Some(_)) => AdviceVerdict::Missed,
            (Some(quick), Some(other)) if other.cost >= quick.cost => AdviceVerdict::Cheapest,
            // Where the grid ends, there is no step on, and nothing is within it.
            (Some(quick), Some(other)) if quick.cost_one_step_on.is_some_and(|on| other.cost >= on) => {
                AdviceVerdict::WithinOneStep
            }
            _ => AdviceVerdict::Cheaper,
        }
    }

    /// Returns its name.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, verdict)| *verdict == self).map_or("", |(name, _)| name)
    }
}

/// Asks a question, and holds the answer against `further` phases that the question does not have and against the answer of an exhaustive
/// search to the same question.
///
/// # Errors
/// Those of [`advise`].
pub fn check_advice(question: Question<'_>, further: usize) -> Result<CheckedAdvice> {
    let advice = advise(Question { exhaustive: false, ..question })?;
    let choices: Vec<&Choice> = advice.best.iter().chain(&advice.runner_up).collect();
    let further = choices.into_iter().map(|choice| look_further(&question, choice, further)).collect::<Result<_>>()?;
    let exhaustive = advise(Question { exhaustive: true, ..question })?;
    let verdict = AdviceVerdict::of(advice.best.as_ref(), exhaustive.best.as_ref());
    Ok(CheckedAdvice { advice, further, exhaustive, verdict })
}

/// Runs a choice at the members of the phase ensemble that follow those of the question.
fn look_further(question: &Question<'_>, choice: &Choice, count: usize) -> Result<Further> {
    let seen = question.phases + question.kept_aside;
    let phases = phase_ensemble(seen + count).split_off(seen);
    let spec_at = |phase: f64| RunRequest { phase: Some(phase), ..choice.request.clone() }.resolve(question.catalogue);
    let spec = spec_at(1.0)?;
    let reference = obtain_reference(&spec, question.cache, question.stop)?;
    let prober = Prober::new(&spec, &reference, question.cache, question.stop)?;
    let runs = phases.par_iter().map(|phase| prober.probe(&spec_at(*phase)?)).collect::<Result<Vec<_>>>()?;
    let errors = runs.iter().filter(|run| run.completed()).map(|run| run.error.unwrap_or(f64::INFINITY));
    Ok(Further {
        phases: runs.len(),
        exceeded: errors.clone().filter(|error| *error > question.error).count(),
        unstable: runs.iter().filter(|run| !run.completed()).count(),
        worst_error: errors.fold(0.0, f64::max),
    })
}

#[cfg(test)]
mod tests {
    use super::super::{LimitFound, Work};
    use super::*;

    #[test]
    fn a_verdict_says_by_how_much_something_is_cheaper() {
        let choice = |cost: f64, on: Option<f64>| Choice {
            request: RunRequest::default(),
            form: String::new(),
            macro_step: 1e-3,
            runs: Vec::new(),
            kept_aside: Vec::new(),
            work: Work::default(),
            cost,
            cost_one_step_on: on,
            spectral_radius: None,
            limit: LimitFound { last_stable: 1e-3, first_unstable: None, failure: None, run_id: None },
        };
        let advised = choice(10.0, Some(8.0));
        let verdict = |other: Option<f64>| {
            let other = other.map(|cost| choice(cost, None));
            AdviceVerdict::of(Some(&advised), other.as_ref()).name()
        };
        assert_eq!(verdict(Some(10.0)), "cheapest");
        assert_eq!(verdict(None), "cheapest");
        assert_eq!(verdict(Some(8.0)), "within one step");
        assert_eq!(verdict(Some(7.9)), "cheaper exists");
        let last = choice(10.0, None);
        assert_eq!(AdviceVerdict::of(Some(&last), Some(&choice(9.9, None))), AdviceVerdict::Cheaper);
        assert_eq!(AdviceVerdict::of(None, Some(&last)), AdviceVerdict::Missed);
        assert_eq!(AdviceVerdict::of(None, None), AdviceVerdict::Cheapest);
    }
}
