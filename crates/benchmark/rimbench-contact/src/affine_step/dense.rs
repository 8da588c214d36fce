//! The active set of contacts without friction, every entry of `H` kept.

use super::discretised_model::DiscretisedModel;
use super::{ActiveSetFactor, AffineStep, DEPENDENT};
use crate::linear_algebra::Factor;

/// `H_AA = L D Lᵀ` of the contacts that push.
#[derive(Clone)]
pub struct DenseFactor(Box<Factor>);

impl DenseFactor {
    /// Reserves `contacts` rows.
    pub fn new(contacts: usize) -> Self {
        DenseFactor(Box::new(Factor::new(contacts)))
    }
}

impl ActiveSetFactor for DenseFactor {
    /// The impulses of the last problem: contacts that push are active.
    type Active<'a> = &'a [f64];

    fn factorise(&mut self, model: &DiscretisedModel, impulses: &[f64], active: &mut Vec<usize>) -> bool {
        let n = model.contacts();
        self.0.clear(n);
        for (contact, &impulse) in impulses.iter().enumerate() {
            if impulse > 0.0 {
                let d = self.0.border(model.h_uu(), active, contact);
                if d.is_nan() || d <= DEPENDENT * model.h_uu()[contact * n + contact] {
                    return false;
                }
                self.0.push(d);
                active.push(contact);
            }
        }
        true
    }

    fn solve(&mut self, _active: &[usize], x: &mut [f64]) {
        self.0.solve(x);
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
        for (contact, impulse) in step.active_impulses(lambda, impulses.len()) {
            if impulse < 0.0 {
                return false;
            }
            impulses[contact] = impulse;
        }
        true
    }
}
