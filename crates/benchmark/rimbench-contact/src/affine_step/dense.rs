//! The active set of contacts without friction, every entry of `H` kept.

use super::by_contact::ByContact;
use super::discretised_model::DiscretisedModel;
use super::{ActiveSetFactor, AffineStep, DEPENDENT, StepContactLaw};
use crate::linear_algebra::Factor;

/// `H_AA = L D Lᵀ` of the contacts that push.
#[derive(Clone)]
pub struct DenseFactor(Box<(Factor, ByContact)>);

impl DenseFactor {
    /// Reserves `contacts` rows and `interface` interface rows.
    pub fn new(contacts: usize, interface: usize) -> Self {
        DenseFactor(Box::new((Factor::new(contacts), ByContact::new(contacts, interface))))
    }
}

impl ActiveSetFactor for DenseFactor {
    /// The impulses of the last problem: contacts that push are active.
    type Active<'a> = &'a [f64];

    fn factorise(&mut self, model: &DiscretisedModel, impulses: &[f64], active: &mut Vec<usize>) -> bool {
        let n = model.contacts();
        let (factor, by_contact) = &mut *self.0;
        factor.clear(n);
        by_contact.clear(n);
        for (contact, &impulse) in impulses.iter().enumerate() {
            if impulse > 0.0 {
                let d = factor.border(model.h_uu(), active, contact);
                if d.is_nan() || d <= DEPENDENT * model.h_uu()[contact * n + contact] {
                    return false;
                }
                factor.push(d);
                by_contact.activate(contact);
                active.push(contact);
            }
        }
        true
    }

    fn solve(&mut self, _active: &[usize], x: &mut [f64]) {
        self.0.0.solve(x);
    }

    fn record_tangent(&mut self, at: usize, active: &[usize], impulses: &[f64]) {
        self.0.1.record_tangent(at, active, impulses);
    }

    #[inline(always)]
    fn is_in_region(
        step: &AffineStep<Self>,
        law: &StepContactLaw,
        w_plus: &[f64],
        gap: &[f64],
        tolerance: f64,
    ) -> bool {
        step.factor.0.1.is_in_region(step, law, w_plus, gap, tolerance)
    }

    #[inline(always)]
    fn write_impulses(
        step: &AffineStep<Self>,
        _: &DiscretisedModel,
        lambda: &[f64],
        _next: &[f64],
        impulses: &mut [f64],
        _tolerance: f64,
    ) -> bool {
        step.factor.0.1.write_impulses(step.sigma, lambda, impulses)
    }
}
