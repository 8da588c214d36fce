//! The differences between dense, sparse and frictional contact problems on a critical region.

use super::discretised_model::DiscretisedModel;
use super::{AffineStep, ForceRegion, ModelState, NEGLIGIBLE, StepContactLaw};

/// `H_AA` of the active set, factorised, and the conditions of its region that depend on the kind of contact problem.
pub trait ActiveSetFactor: Clone + Sized {
    /// The active set as the solver of the contact problem reports it.
    type Active<'a>;
    /// Rows of each contact: the normal one, with friction the tangential one as well.
    const ROWS: usize = 1;
    /// Below this part of the velocities that a micro step gives, `r` is rounding.
    const NEGLIGIBLE: f64 = NEGLIGIBLE;
    /// Whether contacts are many: then sizes known to the compiler are not worth their code, and rounding in the gaps
    /// of a heap must not keep `r` from decaying.
    const MANY: bool = false;

    /// Factorises `H_AA` of an active set and lists its rows; false if they depend on each other.
    fn factorise(&mut self, model: &DiscretisedModel, active: Self::Active<'_>, rows: &mut Vec<usize>) -> bool;

    /// Replaces `x`, by active rows, by `H_AA⁻¹ x`.
    fn solve(&mut self, active: &[usize], x: &mut [f64]);

    /// Adds to `w` the velocities that the impulse of one active row gives.
    fn add_impulse(&self, model: &DiscretisedModel, row: usize, impulse: f64, w: &mut [f64]) {
        model.add_impulse(row, impulse, w);
    }

    /// Records the active rows' impulses of one tangent.
    #[inline(always)]
    fn record_tangent(&mut self, _column: usize, _active: &[usize], _impulses: &[f64]) {}

    /// Tells whether active rows rest at their gap terms, and no other contact moves further in than its own allows.
    #[inline(always)]
    fn is_in_region(
        step: &AffineStep<Self>,
        law: &StepContactLaw,
        w_plus: &[f64],
        gap: &[f64],
        tolerance: f64,
    ) -> bool {
        let rests = |row: &usize| (w_plus[*row] + law.gap_term(gap, *row)).abs() <= tolerance;
        !law.is_violated(w_plus, gap, step.accepted(tolerance)) && step.active.iter().all(rests)
    }

    /// Writes the impulses as long as all are admissible; tells whether they are.
    fn write_impulses(
        step: &AffineStep<Self>,
        model: &DiscretisedModel,
        lambda: &[f64],
        w_plus: &[f64],
        impulses: &mut [f64],
        tolerance: f64,
    ) -> bool;

    /// Keeps the forces for which impulses, in a step from `w`, are admissible; velocities up to `rounding` (m/s) are
    /// zero.
    fn keep_admissible(step: &AffineStep<Self>, _w: &[f64], _rounding: f64, region: &mut ForceRegion) {
        (0..step.active.len()).for_each(|slot| region.keep(|column| step.impulse(slot, column)));
    }

    /// Takes a micro step without a look at the contacts where bounds allow it; `w` and `gap` are brought up to date
    /// where they no longer do.
    #[inline(always)]
    fn skip(_: &mut AffineStep<Self>, _: &StepContactLaw, _lambda: &[f64], _: &mut ModelState) -> bool {
        false
    }

    /// Bounds how many of the `remaining` micro steps can be skipped, after one that ended with `state.w_plus`.
    #[inline(always)]
    fn bound_skips(_: &mut AffineStep<Self>, _: &StepContactLaw, _l: &[f64], _remaining: usize, _: &ModelState) {}

    /// Brings velocities and gaps of contacts that were skipped up to date.
    #[inline(always)]
    fn end_skips(_: &mut AffineStep<Self>, _: &StepContactLaw, _w: &mut [f64], _gap: &mut [f64]) {}
}
