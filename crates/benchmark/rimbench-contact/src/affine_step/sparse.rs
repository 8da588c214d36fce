//! The active set of many contacts, of whose Delassus matrix only the non-zeros are kept.

mod skip_bound;

use super::by_contact::ByContact;
use super::discretised_model::DiscretisedModel;
use super::{ActiveSetFactor, AffineStep, ModelState, StepContactLaw};
use crate::linear_algebra::SparseFactor;
use skip_bound::SkipBound;

/// `H_AA = L D Lᵀ` by its pattern; conditions are checked over all contacts in order, which is several times as fast as
/// by active ones.
#[derive(Clone)]
pub struct SparseSetFactor(pub(super) Box<ManyContacts>);

#[derive(Clone)]
pub(super) struct ManyContacts {
    factor: SparseFactor,
    column: Vec<f64>,
    by_contact: ByContact,
    bound: SkipBound,
}

impl SparseSetFactor {
    /// Reserves `contacts` contacts with the order and pattern of `factor`, and `interface` interface rows.
    pub fn new(factor: &SparseFactor, contacts: usize, interface: usize) -> Self {
        SparseSetFactor(Box::new(ManyContacts {
            factor: factor.clone(),
            column: vec![0.0; contacts],
            by_contact: ByContact::new(contacts, interface),
            bound: SkipBound::new(contacts),
        }))
    }
}

impl ActiveSetFactor for SparseSetFactor {
    /// The factor with which the last problem was solved, and its impulses.
    type Active<'a> = (&'a SparseFactor, &'a [f64]);
    /// Gaps of a heap give a part of 1e-12 of rounding, divided by the micro step, back and forth; a look at `r` for
    /// that takes a solve each time. This is a tenth of the residual accepted of a solver, and is seen once gaps have
    /// added it up.
    const NEGLIGIBLE: f64 = 1e-10;
    const MANY: bool = true;

    fn factorise(
        &mut self,
        model: &DiscretisedModel,
        (solved, impulses): Self::Active<'_>,
        rows: &mut Vec<usize>,
    ) -> bool {
        let ManyContacts { factor, column, by_contact, .. } = &mut *self.0;
        column.fill(0.0);
        by_contact.clear(model.contacts());
        // Without any impulse the solver has not formed an active set.
        if impulses.iter().any(|impulse| *impulse > 0.0) {
            // Active contacts that carry nothing at the moment stay.
            factor.copy_from(solved);
            rows.extend((0..model.contacts()).filter(|&contact| solved.contains(contact)));
            rows.iter().for_each(|&contact| by_contact.activate(contact));
        }
        true
    }

    fn solve(&mut self, active: &[usize], x: &mut [f64]) {
        let ManyContacts { factor, column, .. } = &mut *self.0;
        active.iter().zip(&*x).for_each(|(&contact, x)| column[contact] = *x);
        factor.solve(column);
        active.iter().zip(x).for_each(|(&contact, x)| *x = column[contact]);
    }

    fn record_tangent(&mut self, at: usize, active: &[usize], impulses: &[f64]) {
        self.0.by_contact.record_tangent(at, active, impulses);
    }

    fn is_in_region(
        step: &AffineStep<Self>,
        law: &StepContactLaw,
        w_plus: &[f64],
        gap: &[f64],
        tolerance: f64,
    ) -> bool {
        step.factor.0.by_contact.is_in_region(step, law, w_plus, gap, tolerance)
    }

    fn write_impulses(
        step: &AffineStep<Self>,
        _: &DiscretisedModel,
        lambda: &[f64],
        _next: &[f64],
        impulses: &mut [f64],
        _tolerance: f64,
    ) -> bool {
        step.factor.0.by_contact.write_impulses(step.sigma, lambda, impulses)
    }

    #[inline(always)]
    fn skip(step: &mut AffineStep<Self>, law: &StepContactLaw, lambda: &[f64], state: &mut ModelState) -> bool {
        if step.factor.0.bound.is_open() {
            if let &[force] = lambda
                && step.skip_one(law, force, &state.w, &mut state.w_plus)
            {
                return true;
            }
            step.end_skips(law, &mut state.w, &mut state.gap);
        }
        false
    }

    #[inline(always)]
    fn bound_skips(
        step: &mut AffineStep<Self>,
        law: &StepContactLaw,
        lambda: &[f64],
        remaining: usize,
        state: &ModelState,
    ) {
        // The last micro step looks at all contacts, so that they are up to date at the communication point.
        step.find_bound(law, lambda, remaining.saturating_sub(1), &state.w_plus, &state.gap);
    }

    #[inline]
    fn end_skips(step: &mut AffineStep<Self>, law: &StepContactLaw, w: &mut [f64], gap: &mut [f64]) {
        step.end_skips(law, w, gap);
        step.factor.0.bound.reset();
    }
}
