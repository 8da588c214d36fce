//! Who competes: every scheme of the catalogue in every form that it has, and what a scheme must be told.

use super::Question;
use rimbench_core::cosim::{ActuatorIntegrator, ForceReturn, MechanicsIntegrator, MechanicsSteps, Sequence, Side};
use rimbench_core::error::{Error, Result};
use rimbench_core::iterative::IterativeDriver;
use rimbench_core::schemes::{ContactsAct, Requirement, SchemeEntry};
use rimbench_runs::{RunRequest, RunSpec};
use std::collections::{BTreeSet, HashSet};
use std::sync::Arc;

/// What may be known, and done, where the advice is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Information {
    /// A reduced interface model of the mechanics can be had.
    pub model: bool,
    /// What the actuator's force does within a macro step can be told to the mechanics, or known beforehand.
    pub feedback: bool,
    /// A macro step can be taken again.
    pub repetition: bool,
}

impl Information {
    /// Why a run is out of the question, if it is.
    fn refuses(self, run: &RunSpec) -> Option<&'static str> {
        const FEEDBACK: [Requirement; 3] =
            [Requirement::OutputRates, Requirement::OutputRatesIfFeedthrough, Requirement::HeldReturn];
        let (scheme, is_held) = (&run.scheme, run.force_return == ForceReturn::Held);
        let feedback = FEEDBACK.iter().any(|need| scheme.needs.contains(need)) || !scheme.real_time() || !is_held;
        let reasons = [
            (scheme.driver == IterativeDriver::Monolithic, "is no co-simulation: both sides step together"),
            (!self.model && scheme.has_model(), "needs an interface model of the mechanics (--no-model)"),
            (!self.repetition && !scheme.real_time(), "takes steps again (--real-time)"),
            (!self.feedback && feedback, "acts on the actuator's force within its macro step (--no-feedback)"),
        ];
        reasons.into_iter().find_map(|(holds, reason)| holds.then_some(reason))
    }
}

/// The requests by which a scheme competes, `fixed` being what is asked of every run: its own form, and if the loop
/// runs it those of `docs/schemes/options.md`. What does not go together is found when a request is resolved.
fn requests(scheme: &SchemeEntry, fixed: &RunRequest) -> Vec<RunRequest> {
    let [actuator, mechanics] = [Side::Actuator, Side::Mechanics].map(|first| Some(Sequence::GaussSeidel { first }));
    let forms = [
        (None, None, None),
        (Some(Sequence::Jacobi), Some(ForceReturn::Held), None),
        (actuator, Some(ForceReturn::Mean), None),
        (actuator, Some(ForceReturn::End), None),
        (actuator, Some(ForceReturn::Profile), MechanicsSteps::count(10)),
        (actuator, Some(ForceReturn::Profile), Some(MechanicsSteps::AsActuator)),
        (mechanics, Some(ForceReturn::Held), None),
    ];
    let forms = if scheme.real_time() { &forms[..] } else { &forms[..1] };
    let request = |&(sequence, force_return, mechanics_steps)| RunRequest {
        scheme: Some(scheme.name.to_string()),
        sequence: fixed.sequence.or(sequence),
        force_return: fixed.force_return.or(force_return),
        mechanics_steps: fixed.mechanics_steps.or(mechanics_steps).filter(|_| fixed.mechanics_step_s.is_none()),
        ..fixed.clone()
    };
    forms.iter().map(request).collect()
}

/// Steps of the mechanics in a macro step with which a budget is spent, or a half to an eighth of it by what tries or
/// splits steps, at these macro steps (s).
fn counts_within([_, steps]: [f64; 2], macro_steps: &[f64]) -> BTreeSet<u32> {
    let most = |macro_step: &f64| (steps * macro_step * (1.0 + 1e-9)).max(1.0) as u32;
    macro_steps
        .iter()
        .flat_map(|step| [2, 1].map(|times| times * most(step)))
        .flat_map(|most| [1, 2, 4, 8].map(|part| (most / part).max(1)))
        .collect()
}

/// The requests by which a scheme competes within a budget: with so many steps of the mechanics, in each sequence with
/// each force return; contacts that act over these steps, and steps that are split at impacts, where it has them.
fn requests_within(scheme: &SchemeEntry, fixed: &RunRequest, counts: &BTreeSet<u32>) -> Vec<RunRequest> {
    let fixed = &RunRequest { scheme: Some(scheme.name.to_string()), ..fixed.clone() };
    let whole = |&count: &u32| RunRequest { mechanics_steps: MechanicsSteps::count(count), ..fixed.clone() };
    let all = counts.iter().map(whole).flat_map(|fixed| requests(scheme, &fixed));
    let mut all: Vec<RunRequest> = all.collect();
    if scheme.acts_over_mechanics_step {
        let split = RunRequest {
            mechanics_integrator: Some(fixed.mechanics_integrator.unwrap_or(MechanicsIntegrator::EventSplit)),
            actuator_integrator: Some(fixed.actuator_integrator.unwrap_or(ActuatorIntegrator::Midpoint)),
            ..fixed.clone()
        };
        let own = RunRequest { contacts_act: Some(ContactsAct::MechanicsStep), ..fixed.clone() };
        let returns = [ForceReturn::Mean, ForceReturn::Profile, ForceReturn::Pieces].map(Some);
        let more = [own, split].into_iter().flat_map(|of| {
            returns.map(|force_return| RunRequest { force_return: of.force_return.or(force_return), ..of.clone() })
        });
        all.extend(more.flat_map(|of| {
            counts.iter().map(move |&count| RunRequest { mechanics_steps: MechanicsSteps::count(count), ..of.clone() })
        }));
    }
    all
}

/// Says a coupling as the calls of a master in a macro step, so that it can be followed without this program.
pub fn as_a_master(run: &RunSpec) -> String {
    let step = |length: f64| {
        let (number, unit) = if length < 9e-5 { (length * 1e6, "µs") } else { (length * 1e3, "ms") };
        format!("{} {unit}", format!("{number:.4e}").parse().unwrap_or(number))
    };
    let stepped = |side: &str, count: usize| {
        let times = match count {
            1 => "once".to_owned(),
            2 => "twice".to_owned(),
            count => format!("{count} times"),
        };
        format!("step {side} by {} {times}", step(run.macro_step / count as f64))
    };
    let micro_steps = MechanicsSteps::AsActuator.within(run.macro_step, run.micro_step);
    let mechanics = stepped("mechanics", run.mechanics_steps.within(run.macro_step, run.micro_step));
    let actuator = stepped("actuator", micro_steps);
    let (sent, how) = match &*run.scheme.name {
        "zero-order-hold" => ("", ""),
        "first-order-hold" => (" extrapolated linearly", ""),
        "second-order-hold" => (" extrapolated quadratically", ""),
        _ => (" as the scheme says", &*run.scheme.about),
    };
    let force = match run.force_return {
        ForceReturn::Held => format!("force{sent}"),
        ForceReturn::End => "force as it is then".to_owned(),
        ForceReturn::Mean => "mean force of these steps".to_owned(),
        ForceReturn::Profile | ForceReturn::Pieces => "mean force over each mechanics step".to_owned(),
    };
    let words = match run.sequence {
        Sequence::Jacobi => format!("read motion and force; set motion{sent}, {actuator}; set {force}, {mechanics}"),
        Sequence::GaussSeidel { first: Side::Actuator } => {
            format!("read motion, set it{sent}, {actuator}; set {force}, {mechanics}")
        }
        Sequence::GaussSeidel { first: Side::Mechanics } => {
            format!("read force, set {force}, {mechanics}; read motion, set it{sent}, {actuator}")
        }
    };
    if how.is_empty() { words } else { format!("{words} ({}: {how})", run.scheme.name) }
}

/// The least work that a run like this can be at another macro step, with one solve of an interface model in each micro
/// step.
pub(super) fn least_work(run: &RunSpec, macro_step: f64) -> [f64; 4] {
    let usual = run.case.defaults.micro_step_s.max(run.micro_step);
    let steps = run.duration / macro_step;
    let steps = if run.case.has_fixed_steps() { (steps * (1.0 + 1e-9)).floor() } else { steps }.max(1.0);
    // A ratio that is whole but for round-off is whole.
    let micro_steps = steps * (macro_step / usual - 1e-9).ceil().max(1.0);
    let own = match run.mechanics_steps {
        MechanicsSteps::AsActuator => micro_steps,
        own => steps * own.within(macro_step, usual) as f64,
    };
    // What is taken again is taken twice at least.
    let times = if run.scheme.real_time() { 1.0 } else { 2.0 };
    [steps, own * times, micro_steps * times, micro_steps * times]
}

/// Everything that competes: requests without a macro step, each with its run at the smallest one, or the largest if
/// the mechanics has a longest step of its own.
///
/// # Errors
/// Bad input that no scheme could mend: an unknown case, bad parameters, a scheme that does not exist; why the first
/// falls, if all do.
pub(super) fn all(question: &Question<'_>) -> Result<Vec<(RunRequest, RunSpec)>> {
    let Question { catalogue, fixed, macro_steps, .. } = question;
    let counts = question.budget.map(|budget| counts_within(budget, macro_steps));
    let schemes = match &fixed.scheme {
        Some(name) => vec![catalogue.scheme(name)?],
        None => catalogue.schemes().iter().collect(),
    };
    // A longest step of the mechanics is one step where the macro step is short, and one form as good as another.
    let at = if fixed.mechanics_step_s.is_some() { macro_steps.last() } else { macro_steps.first() };
    let (mut forms, mut seen, mut first_fault) = (Vec::new(), HashSet::new(), None);
    let requests = |scheme: &Arc<SchemeEntry>| match &counts {
        None => requests(scheme, fixed),
        Some(counts) => requests_within(scheme, fixed, counts),
    };
    for request in schemes.into_iter().flat_map(requests) {
        let request = RunRequest { macro_step_s: at.copied(), ..request };
        match request.resolve(catalogue) {
            Ok(run) => match question.information.refuses(&run) {
                Some(reason) => {
                    let message = format!("no scheme competes: {} {reason}", run.scheme.name);
                    first_fault.get_or_insert(Error::Incompatible(message));
                }
                None if seen.insert(run.id()) => forms.push((request, run)),
                None => {}
            },
            Err(error) => _ = first_fault.get_or_insert(error),
        }
    }
    // What no scheme can do is bad input.
    first_fault.filter(|_| forms.is_empty()).map_or(Ok(forms), Err)
}
