//! One form of a scheme under search: what is known of it, and what is expected.

use super::form::requests;
use super::price::Work;
use super::probe::Probe;
use super::{Fallen, Question};
use rimbench_cases::runs::{RunRequest, RunSpec};
use rimbench_core::cosim::MechanicsSteps;
use rimbench_core::error::{Error, Result};
use rimbench_core::iterative::IterativeDriver;
use std::collections::HashSet;

/// Where and why a form missed the error, and the run that says so.
pub(super) type Fall = (String, Option<Box<Probe>>);

/// A form of a scheme, and the macro steps between which its largest lies that meets the error.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    /// What to ask, macro step and phase aside.
    pub(super) request: RunRequest,
    /// Its run at the smallest macro step.
    pub(super) first: RunSpec,
    /// Index of the largest macro step known to meet the error at all phases of the search.
    pub(super) met: Option<usize>,
    /// Index of the smallest macro step known to miss it; the length of the grid if none is known.
    pub(super) missed: usize,
    /// Macro steps at which a linear case grows without end, whatever the error of a run; not known of all.
    pub(super) grows: Vec<bool>,
    /// Whether `met` has stood the phases kept aside.
    pub(super) checked: bool,
    /// How often it was tried.
    pub(super) tries: usize,
    /// Work at `met`, the dearest phase.
    pub(super) work: Option<Work>,
    /// Where and why it last missed, and with which run.
    pub(super) fall: Option<Fall>,
    /// Work of a run that was made, with its macro step.
    pub(super) seen: Option<(f64, Work)>,
    /// It cannot be run at all.
    pub(super) out: bool,
}

/// Everything that competes, and everything that cannot.
///
/// # Errors
/// Bad input that no scheme could mend: an unknown case, bad parameters, a scheme that is asked for and does not exist.
pub(super) fn all(question: &Question<'_>) -> Result<(Vec<Candidate>, Vec<Fallen>)> {
    let Question { catalogue, fixed, macro_steps, .. } = question;
    let case = catalogue.case(fixed.case.as_deref().unwrap_or_default())?;
    let mut parameters = case.default_parameters();
    fixed.set.iter().try_for_each(|(key, value)| parameters.set(key, value))?;
    let schemes = match &fixed.scheme {
        Some(name) => vec![catalogue.scheme(name)?.clone()],
        None => catalogue.schemes().to_vec(),
    };
    let (mut candidates, mut fallen, mut seen) = (Vec::new(), Vec::new(), HashSet::new());
    let mut first_error = None;
    for scheme in schemes {
        let out = |reason: String| Fallen {
            scheme: scheme.name.clone().into_owned(),
            request: None,
            form: String::new(),
            reason,
            run: None,
            cost: None,
        };
        if let Some(reason) = question.information.refuses(&scheme) {
            fallen.push(out(reason.to_owned()));
            continue;
        }
        let before = candidates.len();
        let mut refused = None;
        for request in requests(&scheme, fixed, question.information) {
            let request = RunRequest { macro_step_s: macro_steps.first().copied(), ..request };
            match request.resolve_for(catalogue, case, &parameters) {
                Ok(first) if seen.insert(first.id()) => candidates.push(Candidate::new(request, first, macro_steps)),
                Ok(_) => {}
                // The scheme's own form comes first: what is wrong with that is what is asked for.
                Err(error) => _ = refused.get_or_insert(error),
            }
        }
        if candidates.len() == before {
            let reason = refused
                .as_ref()
                .map_or_else(|| "no form of it is allowed (--no-feedback)".to_owned(), Error::to_string);
            fallen.push(out(reason));
        }
        first_error = first_error.or(refused);
    }
    match (candidates.is_empty(), first_error) {
        // What no scheme can do is bad input, unless it was forbidden.
        (true, Some(error)) => Err(error),
        _ => Ok((candidates, fallen)),
    }
}

impl Candidate {
    /// The longest macro step at which a leader, or its rival, meets the question: both have one.
    pub(super) fn leading_step(&self) -> usize {
        self.met.expect("leaders and their rivals are of those that meet the question")
    }

    fn new(request: RunRequest, first: RunSpec, macro_steps: &[f64]) -> Self {
        Candidate {
            request,
            first,
            met: None,
            missed: macro_steps.len(),
            grows: vec![false; macro_steps.len()],
            checked: false,
            tries: 0,
            work: None,
            fall: None,
            seen: None,
            out: false,
        }
    }

    /// The scheme's name.
    pub(super) fn scheme(&self) -> &str {
        &self.first.scheme.name
    }

    /// The form in words.
    pub(super) fn form(&self) -> String {
        let RunSpec { sequence, force_return, mechanics_steps, .. } = &self.first;
        let steps = match mechanics_steps {
            MechanicsSteps::AsActuator => "as many mechanics steps as micro steps".to_owned(),
            MechanicsSteps::Count(count) if count.get() == 1 => "1 mechanics step".to_owned(),
            MechanicsSteps::Count(count) => format!("{count} mechanics steps"),
        };
        format!("{sequence}, {force_return}, {steps}")
    }

    /// The run at a macro step and phase.
    ///
    /// # Errors
    /// Those of resolving it: some schemes need more samples than a long macro step leaves.
    pub(super) fn spec(&self, question: &Question<'_>, macro_step: f64, phase: f64) -> Result<RunSpec> {
        let request = RunRequest { macro_step_s: Some(macro_step), phase: Some(phase), ..self.request.clone() };
        request.resolve_for(question.catalogue, &self.first.case, &self.first.parameters)
    }

    /// Work that a run at this macro step is expected to be: from a run that was made, else the least it can be.
    pub(super) fn expected(&self, macro_step: f64) -> Work {
        let first = &self.first;
        let usual = first.case.defaults.micro_step_s.max(first.micro_step);
        let fine = |step: f64| 1.0 / step.min(usual);
        let mechanics_is_fine = first.mechanics_steps == MechanicsSteps::AsActuator;
        if let Some((seen_at, seen)) = &self.seen {
            return seen.scaled(seen_at / macro_step, fine(macro_step) / fine(*seen_at), mechanics_is_fine);
        }
        let steps = (first.duration / macro_step).max(1.0);
        let micro = steps * (macro_step / macro_step.min(usual)).ceil();
        let own = match first.mechanics_steps {
            MechanicsSteps::AsActuator => micro,
            MechanicsSteps::Count(count) => steps * f64::from(count.get()),
        };
        // What is taken again is taken twice at least.
        let times = if matches!(first.scheme.driver, IterativeDriver::Explicit) { 1.0 } else { 2.0 };
        Work { exchanges: steps, mechanics_solves: own * times, micro_steps: micro * times, model_solves: 0.0 }
    }
}
