//! The solvers of a model's contact problem: by cone, and by the form of the Delassus matrix.

use super::super::coulomb_contacts::{CoulombContacts, SpaceContacts};
use super::super::recorded_modes::RecordedModes;
use crate::interface_model::{ReducedInterfaceModel, closed_in_space};
use rimbench_contact::affine_step::DiscretisedModel;
use rimbench_contact::affine_step::{ActiveSetFactor, DenseFactor, ModeFactor, SparseSetFactor};
use rimbench_contact::complementarity::{
    Checked, Lcp, ProposeImpulses, Solver, SolverCounters, SparseActiveSet, SparseLcp, SparseSolver, Unsolved,
};
use rimbench_contact::friction::space::{SemismoothNewton, SpaceProblem, SpaceSolver};
use rimbench_contact::friction::{FrictionProblem, FrictionSolver, WarmStates};
use rimbench_contact::linear_algebra::largest_entry;

/// A contact problem `w⁺ = H P + b` of a model.
#[derive(Clone, Copy)]
pub(crate) struct Posed<'a> {
    /// Has H.
    pub(crate) model: &'a DiscretisedModel,
    /// Whether H differs from that of the problem before.
    pub(crate) changed: bool,
    /// m/s.
    pub(crate) b: &'a [f64],
}

/// A solver of `w⁺ = H P + b`, a [`ContactProblem`](rimbench_contact::problem::ContactProblem); it determines the cone
/// K and the form of H.
pub(crate) trait ContactSolver: Clone {
    /// `H_AA` of its active sets, for micro steps that keep the set.
    type Factor: ActiveSetFactor;
    type Method: ProposeImpulses;
    /// Rows of each contact.
    const ROWS: usize = 1;

    /// Solves for `impulses`, from the active set of the last problem.
    ///
    /// # Errors
    /// If no answer was found whose natural residual is within the tolerance.
    fn solve(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Unsolved>;

    /// Solves a trial, which leaves coefficients of friction as they are.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    fn try_solve(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Unsolved> {
        self.solve(posed, impulses)
    }

    /// Solves for the impulses without friction; what is solved next has another cone.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    fn solve_without_friction(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Unsolved> {
        self.solve(posed, impulses)
    }

    /// Returns the active set of the last problem.
    fn active<'a>(&'a self, impulses: &'a [f64]) -> <Self::Factor as ActiveSetFactor>::Active<'a>;

    /// Returns the solver with its check.
    fn checked(&self) -> &Checked<Self::Method>;

    /// Returns the natural residual up to which an answer is accepted.
    fn tolerance(&self) -> f64 {
        self.checked().tolerance()
    }

    fn counters(&self) -> SolverCounters {
        self.checked().counters()
    }

    /// Records what the contacts of `set` have done if they have friction, moving by `w` (m/s), which is rounding up to
    /// `rounding` (m/s).
    fn record_modes(&self, _set: &[usize], _w: &[f64], _rounding: f64, _modes: &mut RecordedModes) {}

    /// Sets the contacts of a model that has arrived.
    fn set_contacts(&mut self, _set: &[usize], _model: &ReducedInterfaceModel) {}

    /// Returns the rows of the model that pose the problem.
    fn rows<'a>(&'a self, set: &'a [usize]) -> &'a [usize] {
        set
    }
}

/// Contacts without friction, every entry of H kept.
#[derive(Clone)]
pub(crate) struct Signorini(pub(crate) Checked);

impl ContactSolver for Signorini {
    type Factor = DenseFactor;
    type Method = Solver;

    #[inline(always)]
    fn solve(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Unsolved> {
        let lcp = Lcp::new(posed.model.h_uu(), posed.b);
        if posed.changed { self.0.solve(lcp, impulses) } else { self.0.solve_again(lcp, impulses) }?;
        Ok(())
    }

    fn active<'a>(&'a self, impulses: &'a [f64]) -> &'a [f64] {
        impulses
    }

    fn checked(&self) -> &Checked {
        &self.0
    }
}

impl ContactSolver for SparseSolver {
    type Factor = SparseSetFactor;
    type Method = SparseActiveSet;

    fn solve(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Unsolved> {
        let rows = posed.model.contact_rows().expect("a sparse solver has a sparse Delassus matrix");
        if posed.changed {
            self.solver.change_pattern(rows.pattern);
            // Macro steps begin alike: with penetrations, and with the force of the point itself.
            self.solver.start_series();
        }
        self.solve_again(SparseLcp::by_pattern(rows, posed.b), impulses)?;
        Ok(())
    }

    fn active<'a>(&'a self, impulses: &'a [f64]) -> <SparseSetFactor as ActiveSetFactor>::Active<'a> {
        (self.solver.factor(), impulses)
    }

    fn checked(&self) -> &Self {
        self
    }
}

impl ContactSolver for CoulombContacts {
    type Factor = ModeFactor;
    type Method = WarmStates;
    const ROWS: usize = 2;

    fn solve(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Unsolved> {
        self.try_solve(posed, impulses)?;
        if let Some(stiction) = self.stiction {
            let (m, h, b) = (self.friction.len(), posed.model.h_uu(), posed.b);
            let w_t = (m..2 * m).map(|row| {
                let pushed: f64 = h[row * 2 * m..].iter().zip(impulses.iter()).map(|(h, p)| h * p).sum();
                b[row] + pushed
            });
            let rounding = self.solver.tolerance() * largest_entry(b);
            stiction.update(&mut self.friction, self.solver.solver.states(), w_t, rounding);
        }
        Ok(())
    }

    fn try_solve(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Unsolved> {
        let problem = FrictionProblem::with_friction(posed.model.h_uu(), posed.b, &self.friction);
        // Coefficients that change make another problem of the same matrix.
        let same = !posed.changed && self.stiction.is_none();
        if same { self.solver.solve_again(problem, impulses) } else { self.solver.solve(problem, impulses) }?;
        Ok(())
    }

    fn solve_without_friction(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Unsolved> {
        let n = posed.b.len();
        let problem = FrictionProblem::with_friction(posed.model.h_uu(), posed.b, &self.none[..self.friction.len()]);
        self.solver.solve(problem, &mut impulses[..n])?;
        Ok(())
    }

    fn active<'a>(&'a self, _: &'a [f64]) -> <ModeFactor as ActiveSetFactor>::Active<'a> {
        (self.solver.solver.states(), &self.friction)
    }

    fn checked(&self) -> &FrictionSolver {
        &self.solver
    }

    /// Of redundant contacts one may be loaded up to its bound and not move.
    fn record_modes(&self, set: &[usize], w: &[f64], rounding: f64, modes: &mut RecordedModes) {
        for ((&contact, state), w_t) in set.iter().zip(self.solver.solver.states()).zip(&w[set.len()..]) {
            modes.record(contact, state.moving(*w_t, rounding));
        }
    }

    /// With coefficients and modes as the model has them.
    fn set_contacts(&mut self, set: &[usize], model: &ReducedInterfaceModel) {
        self.take(set, Self::ROWS, model);
        self.solver.solver.start_from(set.iter().map(|&contact| model.solved_states[contact]));
    }

    fn rows<'a>(&'a self, _: &'a [usize]) -> &'a [usize] {
        &self.rows
    }
}

impl ContactSolver for SpaceContacts {
    /// Never made: where a contact slides in space the solution is not affine, as the direction of its friction turns.
    type Factor = DenseFactor;
    type Method = SemismoothNewton;
    const ROWS: usize = 3;

    fn solve(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Unsolved> {
        if posed.changed {
            for (impulse, force) in impulses.iter_mut().zip(&self.forces) {
                *impulse = posed.model.length() * force;
            }
            self.solver.solver.start_from(impulses);
        }
        self.solver.solve(SpaceProblem::with_friction(posed.model.h_uu(), posed.b, &self.friction), impulses)?;
        Ok(())
    }

    fn solve_without_friction(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Unsolved> {
        let n = posed.b.len();
        let problem = SpaceProblem::with_friction(posed.model.h_uu(), posed.b, &self.none[..self.friction.len()]);
        self.solver.solve(problem, &mut impulses[..n])?;
        Ok(())
    }

    fn active<'a>(&'a self, impulses: &'a [f64]) -> &'a [f64] {
        impulses
    }

    fn checked(&self) -> &SpaceSolver {
        &self.solver
    }

    fn record_modes(&self, set: &[usize], w: &[f64], rounding: f64, modes: &mut RecordedModes) {
        let n = set.len();
        for (slot, &contact) in set.iter().enumerate() {
            modes.record_in_space(contact, closed_in_space([w[n + slot], w[2 * n + slot]], rounding));
        }
    }

    fn set_contacts(&mut self, set: &[usize], model: &ReducedInterfaceModel) {
        self.take(set, Self::ROWS, model);
        self.forces.clear();
        self.forces.extend(self.rows.iter().map(|&row| model.solved_forces[row]));
    }

    fn rows<'a>(&'a self, _: &'a [usize]) -> &'a [usize] {
        &self.rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimbench_contact::friction::Stiction;
    use rimbench_contact::solver_entry::SolverEntry;

    #[test]
    fn each_contact_that_slides_has_the_coefficient_in_motion_from_then_on_and_one_that_stands_that_at_rest() {
        let mut model = ReducedInterfaceModel::zeros_with_friction(&[0.8; 4], 1);
        model.stiction = Some(Stiction { at_rest: 0.8, in_motion: 0.5 });
        (0..9).for_each(|row| model.h[10 * row] = 1.0);
        let mut discretised = DiscretisedModel::new(8, 1);
        discretised.discretise(model.linear(), &(0..8).collect::<Vec<_>>(), 1e-3);
        let mut contacts = CoulombContacts::of(&model, &SolverEntry::active_set()).unwrap();
        contacts.take(&[0, 1, 2, 3], 2, &model);
        // One after the other is pushed along its surface harder than it holds.
        for sliding in 1..=4 {
            let b: [f64; 8] =
                std::array::from_fn(|row| if row < 4 { -1.0 } else { [0.0, 2.0][usize::from(row < 4 + sliding)] });
            contacts.solve(Posed { model: &discretised, changed: sliding == 1, b: &b }, &mut [0.0; 8]).unwrap();
            let wanted: [f64; 4] = std::array::from_fn(|contact| if contact < sliding { 0.5 } else { 0.8 });
            assert_eq!(contacts.friction, wanted);
        }
    }
}
