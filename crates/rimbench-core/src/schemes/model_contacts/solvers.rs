//! The three solvers of a model's contact problem: by cone, and by the form of the Delassus matrix.

use super::super::coulomb_contacts::CoulombContacts;
use crate::error::Failure;
use crate::interface_model::ReducedInterfaceModel;
use rimbench_contact::affine_step::DiscretisedModel;
use rimbench_contact::affine_step::{ActiveSetFactor, DenseFactor, ModeFactor, SparseSetFactor};
use rimbench_contact::complementarity::{Checked, Lcp, SolverCounters, SparseLcp, SparseSolver};

/// A solver of `w⁺ = H P + b`, a [`ContactProblem`](rimbench_contact::problem::ContactProblem); it determines the cone K and the form of H.
pub(crate) trait ContactSolver: Clone {
    /// `H_AA` of its active sets, for micro steps that keep the set.
    type Factor: ActiveSetFactor;

    /// Solves for `impulses`, from the active set of the last problem; `changed` tells that `H` differs from that of the problem before.
    ///
    /// # Errors
    /// If no answer was found whose natural residual is within the tolerance.
    fn solve(
        &mut self,
        model: &DiscretisedModel,
        changed: bool,
        b: &[f64],
        impulses: &mut [f64],
    ) -> Result<(), Failure>;

    /// Solves a trial, which leaves coefficients of friction as they are.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    fn try_solve(
        &mut self,
        model: &DiscretisedModel,
        changed: bool,
        b: &[f64],
        impulses: &mut [f64],
    ) -> Result<(), Failure> {
        self.solve(model, changed, b, impulses)
    }

    /// Returns the active set of the last problem.
    fn active<'a>(&'a self, impulses: &'a [f64]) -> <Self::Factor as ActiveSetFactor>::Active<'a>;

    /// Returns the natural residual up to which an answer is accepted.
    fn tolerance(&self) -> f64;

    fn counters(&self) -> SolverCounters;

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

    #[inline(always)]
    fn solve(
        &mut self,
        model: &DiscretisedModel,
        changed: bool,
        b: &[f64],
        impulses: &mut [f64],
    ) -> Result<(), Failure> {
        let lcp = Lcp::new(model.h_uu(), b);
        if changed { self.0.solve(lcp, impulses) } else { self.0.solve_again(lcp, impulses) }?;
        Ok(())
    }

    fn active<'a>(&'a self, impulses: &'a [f64]) -> &'a [f64] {
        impulses
    }

    fn tolerance(&self) -> f64 {
        self.0.tolerance()
    }

    fn counters(&self) -> SolverCounters {
        self.0.counters()
    }
}

impl ContactSolver for SparseSolver {
    type Factor = SparseSetFactor;

    fn solve(
        &mut self,
        model: &DiscretisedModel,
        changed: bool,
        b: &[f64],
        impulses: &mut [f64],
    ) -> Result<(), Failure> {
        let rows = model.contact_rows().expect("a sparse solver has a sparse Delassus matrix");
        if changed {
            self.solver.change_pattern(rows.pattern);
            // Macro steps begin alike: with penetrations, and with the force of the point itself.
            self.solver.start_series();
        }
        self.solve_again(SparseLcp::by_pattern(rows, b), impulses)?;
        Ok(())
    }

    fn active<'a>(&'a self, impulses: &'a [f64]) -> <SparseSetFactor as ActiveSetFactor>::Active<'a> {
        (self.solver.factor(), impulses)
    }

    fn tolerance(&self) -> f64 {
        self.tolerance()
    }

    fn counters(&self) -> SolverCounters {
        self.counters()
    }
}

impl ContactSolver for CoulombContacts {
    type Factor = ModeFactor;

    fn solve(
        &mut self,
        model: &DiscretisedModel,
        changed: bool,
        b: &[f64],
        impulses: &mut [f64],
    ) -> Result<(), Failure> {
        self.solve(model, changed, b, impulses)?;
        Ok(())
    }

    fn try_solve(
        &mut self,
        model: &DiscretisedModel,
        changed: bool,
        b: &[f64],
        impulses: &mut [f64],
    ) -> Result<(), Failure> {
        self.try_solve(model, changed, b, impulses)?;
        Ok(())
    }

    fn active<'a>(&'a self, _: &'a [f64]) -> <ModeFactor as ActiveSetFactor>::Active<'a> {
        (self.states(), self.friction())
    }

    fn tolerance(&self) -> f64 {
        self.tolerance()
    }

    fn counters(&self) -> SolverCounters {
        self.counters()
    }

    fn set_contacts(&mut self, set: &[usize], model: &ReducedInterfaceModel) {
        CoulombContacts::set_contacts(self, set, model);
    }

    fn rows<'a>(&'a self, _: &'a [usize]) -> &'a [usize] {
        self.stacked_rows()
    }
}
