//! Who competes: every scheme of the catalogue in every form that it has, and what a scheme must be told.

use rimbench_cases::runs::RunRequest;
use rimbench_core::cosim::{ForceReturn, MechanicsSteps, Sequence, Side};
use rimbench_core::iterative::IterativeDriver;
use rimbench_core::schemes::{Requirement, SchemeEntry};

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

impl Default for Information {
    /// Everything.
    fn default() -> Self {
        Information { model: true, feedback: true, repetition: true }
    }
}

impl Information {
    /// Says why a scheme is out of the question, if it is; its entry in the catalogue tells.
    ///
    /// Without a model fall those that need an interface model. Without feedback fall those that need directional derivatives of
    /// the actuator's outputs, that act through the force they hand to the mechanics, or that take a step again with what came of
    /// it. Without repetition fall those that the loop itself does not run.
    pub fn refuses(self, scheme: &SchemeEntry) -> Option<&'static str> {
        let needs = |needs: &[Requirement]| needs.iter().any(|need| scheme.needs.contains(need));
        match () {
            () if scheme.driver == IterativeDriver::Monolithic => {
                Some("it is no co-simulation: both sides step together")
            }
            () if !self.model && scheme.has_model() => Some("needs an interface model of the mechanics (--no-model)"),
            () if !self.repetition && !scheme.real_time() => Some("takes steps again (--real-time)"),
            () if !self.feedback && needs(&[Requirement::OutputRates, Requirement::OutputRatesIfFeedthrough]) => {
                Some("needs derivatives of the actuator's force (--no-feedback)")
            }
            () if !self.feedback && needs(&[Requirement::HeldReturn]) => {
                Some("acts through the force it hands to the mechanics (--no-feedback)")
            }
            () if !self.feedback && !scheme.real_time() => {
                Some("takes a step again with the force that came of it (--no-feedback)")
            }
            () => None,
        }
    }

    /// Whether a form with this force return may compete: without feedback the force of a macro step does not go back to the mechanics
    /// within it.
    pub(super) fn allows(self, force_return: Option<ForceReturn>) -> bool {
        self.feedback || force_return.is_none_or(|kind| kind == ForceReturn::Held)
    }
}

/// Sequence, force return and mechanics steps; none leaves it to scheme and case.
type Form = (Option<Sequence>, Option<ForceReturn>, Option<MechanicsSteps>);

/// Mechanics steps per macro step of the form between one and all.
const SOME_STEPS: u32 = 10;

/// The forms in which a scheme that the loop runs may compete; see `docs/schemes/options.md`.
fn forms() -> [Form; 6] {
    let actuator_first = Some(Sequence::GaussSeidel { first: Side::Actuator });
    let mechanics_first = Some(Sequence::GaussSeidel { first: Side::Mechanics });
    let returned = |kind, steps| (actuator_first, Some(kind), steps);
    [
        (Some(Sequence::Jacobi), Some(ForceReturn::Held), None),
        returned(ForceReturn::Mean, None),
        returned(ForceReturn::End, None),
        returned(ForceReturn::Profile, MechanicsSteps::count(SOME_STEPS)),
        returned(ForceReturn::Profile, Some(MechanicsSteps::AsActuator)),
        (mechanics_first, Some(ForceReturn::Held), None),
    ]
}

/// The requests by which a scheme competes, `fixed` being what is asked of every run. What does not go together is found when a
/// request is resolved.
pub(super) fn requests(scheme: &SchemeEntry, fixed: &RunRequest, information: Information) -> Vec<RunRequest> {
    let named = RunRequest { scheme: Some(scheme.name.clone().into_owned()), ..fixed.clone() };
    let own = information.allows(scheme.sequence_and_return(None, None).ok().map(|(_, kind)| kind));
    let of_form = |form: Form| {
        let (sequence, force_return, mechanics_steps) = form;
        RunRequest {
            sequence: fixed.sequence.or(sequence),
            force_return: fixed.force_return.or(force_return),
            mechanics_steps: fixed.mechanics_steps.or(mechanics_steps),
            ..named.clone()
        }
    };
    let forms: &[Form] = if scheme.real_time() { &forms() } else { &[] };
    let mut requests: Vec<RunRequest> = own.then(|| named.clone()).into_iter().collect();
    requests.extend(
        forms.iter().filter(|(_, force_return, _)| information.allows(*force_return)).map(|form| of_form(*form)),
    );
    requests
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimbench_core::schemes::standard_schemes;

    fn left(information: Information) -> Vec<String> {
        let schemes = standard_schemes().into_iter().filter(|scheme| information.refuses(scheme).is_none());
        schemes.map(|scheme| scheme.name.into_owned()).collect()
    }

    #[test]
    fn what_falls_without_information_follows_from_what_schemes_need() {
        let everything = left(Information::default());
        let without_model = left(Information { model: false, ..Information::default() });
        let without_feedback = left(Information { feedback: false, ..Information::default() });
        let real_time = left(Information { repetition: false, ..Information::default() });
        let has = |list: &[String], name: &str| list.iter().any(|known| known == name);
        assert!(!has(&everything, "monolithic") && has(&everything, "iterated-aitken"));
        assert!(has(&without_model, "integral-correction-first-order") && !has(&without_model, "interface-mass"));
        assert!(has(&without_feedback, "rim-nonsmooth") && has(&without_feedback, "zero-order-hold"));
        for name in ["integral-correction-first-order", "energy-leak-damper", "interface-jacobian", "iterated-aitken"] {
            assert!(!has(&without_feedback, name), "{name}");
        }
        assert!(!has(&real_time, "iterated-aitken") && has(&real_time, "rim-nonsmooth-gap"));
    }

    #[test]
    fn without_feedback_no_form_returns_the_force_of_its_own_macro_step() {
        let schemes = standard_schemes();
        let of = |name: &str, feedback| {
            let scheme = schemes.iter().find(|scheme| scheme.name == name).unwrap();
            requests(scheme, &RunRequest::default(), Information { feedback, ..Information::default() })
        };
        // The model's own form returns the mean.
        assert_eq!((of("rim-nonsmooth", true).len(), of("rim-nonsmooth", false).len()), (7, 2));
        for request in of("zero-order-hold", false) {
            assert!(request.force_return.is_none_or(|kind| kind == ForceReturn::Held), "{request:?}");
        }
        assert_eq!(of("monolithic", true).len(), 1);
    }

    #[test]
    fn what_is_asked_of_every_run_is_changed_by_no_form() {
        let fixed = RunRequest { mechanics_steps: MechanicsSteps::count(3), ..RunRequest::default() };
        let scheme = &standard_schemes()[0];
        for request in requests(scheme, &fixed, Information::default()) {
            assert_eq!(request.mechanics_steps, fixed.mechanics_steps);
        }
    }
}
