//! Who competes: every scheme of the catalogue in every form that it has, and what a scheme must be told.

use super::{AdviceRow, Question};
use rimbench_cases::runs::RunRequest;
use rimbench_core::cosim::{ForceReturn, MechanicsSteps, Sequence, Side};
use rimbench_core::error::{Error, Result};
use rimbench_core::iterative::IterativeDriver;
use rimbench_core::schemes::{Requirement, SchemeEntry};
use std::collections::HashSet;

/// What may be known, and done, where the advice is to be followed.
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
    /// Everything.
    pub const ALL: Self = Information { model: true, feedback: true, repetition: true };

    /// Says why a scheme is out of the question, if it is; its entry in the catalogue tells.
    pub fn refuses(self, scheme: &SchemeEntry) -> Option<&'static str> {
        let needs = |needs: &[Requirement]| needs.iter().any(|need| scheme.needs.contains(need));
        let rates = || needs(&[Requirement::OutputRates, Requirement::OutputRatesIfFeedthrough]);
        let reasons = [
            (scheme.driver == IterativeDriver::Monolithic, "it is no co-simulation: both sides step together"),
            (!self.model && scheme.has_model(), "needs an interface model of the mechanics (--no-model)"),
            (!self.repetition && !scheme.real_time(), "takes steps again (--real-time)"),
            (!self.feedback && rates(), "needs derivatives of the actuator's force (--no-feedback)"),
            (
                !self.feedback && needs(&[Requirement::HeldReturn]),
                "acts through the force it hands to the mechanics (--no-feedback)",
            ),
            (
                !self.feedback && !scheme.real_time(),
                "takes a step again with the force that came of it (--no-feedback)",
            ),
        ];
        reasons.into_iter().find_map(|(holds, reason)| holds.then_some(reason))
    }

    /// Whether a form with this force return may compete: without feedback the force of a macro step does not go back to the mechanics
    /// within it.
    pub(super) fn allows(self, force_return: ForceReturn) -> bool {
        self.feedback || force_return == ForceReturn::Held
    }
}

/// The forms in which a scheme that the loop runs may compete, beside its own: sequence, force return and mechanics steps, of which
/// none leaves it to scheme and case; see `docs/schemes/options.md`.
fn variants() -> [(Sequence, ForceReturn, Option<MechanicsSteps>); 6] {
    let first = |first: Side| Sequence::GaussSeidel { first };
    [
        (Sequence::Jacobi, ForceReturn::Held, None),
        (first(Side::Actuator), ForceReturn::Mean, None),
        (first(Side::Actuator), ForceReturn::End, None),
        (first(Side::Actuator), ForceReturn::Profile, MechanicsSteps::count(10)),
        (first(Side::Actuator), ForceReturn::Profile, Some(MechanicsSteps::AsActuator)),
        (first(Side::Mechanics), ForceReturn::Held, None),
    ]
}

/// The requests by which a scheme competes, `fixed` being what is asked of every run. What does not go together is found when a
/// request is resolved.
fn requests(scheme: &SchemeEntry, fixed: &RunRequest, information: Information) -> Vec<RunRequest> {
    let named = RunRequest { scheme: Some(scheme.name.clone().into_owned()), ..fixed.clone() };
    let own = scheme.sequence_and_return(None, None).is_ok_and(|(_, kind)| information.allows(kind));
    let variants = variants().into_iter().filter(|(_, kind, _)| scheme.real_time() && information.allows(*kind));
    let others = variants.map(|(sequence, force_return, mechanics_steps)| RunRequest {
        sequence: fixed.sequence.or(Some(sequence)),
        force_return: fixed.force_return.or(Some(force_return)),
        mechanics_steps: fixed.mechanics_steps.or(mechanics_steps),
        ..named.clone()
    });
    own.then(|| named.clone()).into_iter().chain(others).collect()
}

/// A scheme that does not compete, and why.
type Refused = (String, String);

/// Everything that competes, and what cannot, with the reason.
///
/// # Errors
/// Bad input that no scheme could mend: an unknown case, bad parameters, a scheme that is asked for and does not exist.
pub(super) fn all(question: &Question<'_>) -> Result<(Vec<AdviceRow>, Vec<Refused>)> {
    let Question { catalogue, fixed, macro_steps, .. } = question;
    let case = catalogue.case(fixed.case.as_deref().unwrap_or_default())?;
    let mut parameters = case.default_parameters();
    fixed.set.iter().try_for_each(|(key, value)| parameters.set(key, value))?;
    let schemes = match &fixed.scheme {
        Some(name) => vec![catalogue.scheme(name)?.clone()],
        None => catalogue.schemes().to_vec(),
    };
    let (mut rows, mut refused, mut seen, mut first_error) = (Vec::new(), Vec::new(), HashSet::new(), None);
    for scheme in schemes {
        let (before, refusal, mut own_error) = (rows.len(), question.information.refuses(&scheme), None);
        for request in requests(&scheme, fixed, question.information).into_iter().filter(|_| refusal.is_none()) {
            let request = RunRequest { macro_step_s: macro_steps.first().copied(), ..request };
            match request.resolve_for(catalogue, case, &parameters) {
                Ok(first) if seen.insert(first.id()) => rows.push(AdviceRow::new(request, first)),
                Ok(_) => {}
                // The scheme's own form comes first: what is wrong with that is what is asked for.
                Err(error) => _ = own_error.get_or_insert(error),
            }
        }
        if rows.len() == before {
            let none = || "no form of it is allowed (--no-feedback)".to_owned();
            let reason = refusal.map_or_else(|| own_error.as_ref().map_or_else(none, Error::to_string), str::to_owned);
            refused.push((scheme.name.to_string(), reason));
        }
        first_error = first_error.or(own_error);
    }
    match (rows.is_empty(), first_error) {
        // What no scheme can do is bad input, unless it was forbidden.
        (true, Some(error)) => Err(error),
        _ => Ok((rows, refused)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimbench_core::schemes::standard_schemes;

    #[test]
    fn what_falls_without_information_follows_from_what_schemes_need() {
        let schemes = standard_schemes();
        let scheme = |name: &str| schemes.iter().find(|scheme| scheme.name == name).unwrap();
        let has = |information: Information, name: &str| information.refuses(scheme(name)).is_none();
        let no_model = Information { model: false, ..Information::ALL };
        let no_feedback = Information { feedback: false, ..Information::ALL };
        let no_repetition = Information { repetition: false, ..Information::ALL };
        assert!(!has(Information::ALL, "monolithic") && has(Information::ALL, "iterated-aitken"));
        assert!(has(no_model, "integral-correction-first-order") && !has(no_model, "interface-mass"));
        assert!(!has(no_repetition, "iterated-aitken") && has(no_repetition, "rim-nonsmooth-gap"));
        assert!(has(no_feedback, "rim-nonsmooth") && has(no_feedback, "zero-order-hold"));
        for name in ["integral-correction-first-order", "energy-leak-damper", "interface-jacobian", "iterated-aitken"] {
            assert!(!has(no_feedback, name), "{name}");
        }
        // The model's own form returns the mean.
        let of = |name: &str, information| requests(scheme(name), &RunRequest::default(), information);
        assert_eq!([Information::ALL, no_feedback].map(|information| of("rim-nonsmooth", information).len()), [7, 2]);
        let held = |request: &RunRequest| request.force_return.is_none_or(|kind| kind == ForceReturn::Held);
        assert!(of("zero-order-hold", no_feedback).iter().all(held));
        assert_eq!(of("iterated-aitken", Information::ALL).len(), 1);
        let fixed = RunRequest { mechanics_steps: MechanicsSteps::count(3), ..RunRequest::default() };
        let all = requests(scheme("nepce"), &fixed, Information::ALL);
        assert!(all.iter().all(|request| request.mechanics_steps == fixed.mechanics_steps));
    }
}
