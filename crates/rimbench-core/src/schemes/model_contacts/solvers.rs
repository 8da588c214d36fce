//! The solvers of a model's contact problem: by cone, and by the form of the Delassus matrix.

use super::super::coulomb_contacts::CoulombContacts;
use super::super::space_contacts::SpaceContacts;
use crate::error::Failure;
use crate::interface_model::ReducedInterfaceModel;
use rimbench_contact::affine_step::DiscretisedModel;
use rimbench_contact::affine_step::{ActiveSetFactor, DenseFactor, ModeFactor, SparseSetFactor};
use rimbench_contact::complementarity::{Checked, Lcp, SolverCounters, SparseLcp, SparseSolver};
use rimbench_contact::friction::FrictionProblem;
use rimbench_contact::friction::space::SpaceProblem;

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

/// A solver of `w⁺ = H P + b`, a [`ContactProblem`](rimbench_contact::problem::ContactProblem); it determines the cone K and the form of H.
pub(crate) trait ContactSolver: Clone {
    /// `H_AA` of its active sets, for micro steps that keep the set.
    type Factor: ActiveSetFactor;
    /// Rows of each contact.
    const ROWS: usize = 1;

    /// Solves for `impulses`, from the active set of the last problem.
    ///
    /// # Errors
    /// If no answer was found whose natural residual is within the tolerance.
    fn solve(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Failure>;

    /// Solves a trial, which leaves coefficients of friction as they are.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    fn try_solve(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Failure> {
        self.solve(posed, impulses)
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
    fn solve(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Failure> {
        let lcp = Lcp::new(posed.model.h_uu(), posed.b);
        if posed.changed { self.0.solve(lcp, impulses) } else { self.0.solve_again(lcp, impulses) }?;
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

    fn solve(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Failure> {
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

    fn tolerance(&self) -> f64 {
        self.tolerance()
    }

    fn counters(&self) -> SolverCounters {
        self.counters()
    }
}

impl ContactSolver for CoulombContacts {
    type Factor = ModeFactor;
    const ROWS: usize = 2;

    fn solve(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Failure> {
        self.try_solve(posed, impulses)?;
        if let Some(stiction) = self.stiction {
            let (m, h, b) = (self.friction.len(), posed.model.h_uu(), posed.b);
            let rounding = self.solver.tolerance() * b.iter().fold(0.0, |max: f64, b| max.max(b.abs()));
            for (contact, (coefficient, state)) in self.friction.iter_mut().zip(self.solver.solver.states()).enumerate()
            {
                let row = m + contact;
                let pushed: f64 =
                    h[row * 2 * m..(row + 1) * 2 * m].iter().zip(impulses.iter()).map(|(h, p)| h * p).sum();
                *coefficient = stiction.after(state.moving(b[row] + pushed, rounding));
            }
        }
        Ok(())
    }

    fn try_solve(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Failure> {
        let problem = FrictionProblem::with_friction(posed.model.h_uu(), posed.b, &self.friction);
        // Coefficients that change make another problem of the same matrix.
        let same = !posed.changed && self.stiction.is_none();
        if same { self.solver.solve_again(problem, impulses) } else { self.solver.solve(problem, impulses) }?;
        Ok(())
    }

    fn active<'a>(&'a self, _: &'a [f64]) -> <ModeFactor as ActiveSetFactor>::Active<'a> {
        (self.states(), &self.friction)
    }

    fn tolerance(&self) -> f64 {
        self.solver.tolerance()
    }

    fn counters(&self) -> SolverCounters {
        self.solver.counters()
    }

    /// With coefficients and modes as the model has them.
    fn set_contacts(&mut self, set: &[usize], model: &ReducedInterfaceModel) {
        let n = model.contacts();
        self.rows.clear();
        self.rows.extend(set.iter().copied().chain(set.iter().map(|contact| n + contact)));
        self.friction.clear();
        self.friction.extend(set.iter().map(|&contact| model.friction[contact]));
        self.solver.solver.start_from(set.iter().map(|&contact| model.solved_states[contact]));
    }

    fn rows<'a>(&'a self, _: &'a [usize]) -> &'a [usize] {
        &self.rows
    }
}

impl ContactSolver for SpaceContacts {
    /// Never made: where a contact slides in space the solution is not affine, as the direction of its friction turns.
    type Factor = DenseFactor;
    const ROWS: usize = 3;

    fn solve(&mut self, posed: Posed<'_>, impulses: &mut [f64]) -> Result<(), Failure> {
        if posed.changed {
            for (impulse, force) in impulses.iter_mut().zip(&self.forces) {
                *impulse = posed.model.length() * force;
            }
            self.solver.solver.start_from(impulses);
        }
        self.solver.solve(SpaceProblem::with_friction(posed.model.h_uu(), posed.b, &self.friction), impulses)?;
        Ok(())
    }

    fn active<'a>(&'a self, impulses: &'a [f64]) -> &'a [f64] {
        impulses
    }

    fn tolerance(&self) -> f64 {
        self.solver.tolerance()
    }

    fn counters(&self) -> SolverCounters {
        self.solver.counters()
    }

    fn set_contacts(&mut self, set: &[usize], model: &ReducedInterfaceModel) {
        let n = model.contacts();
        self.rows.clear();
        self.rows.extend((0..3).flat_map(|axis| set.iter().map(move |contact| axis * n + contact)));
        self.friction.clear();
        self.friction.extend(set.iter().map(|&contact| model.friction[contact]));
        self.forces.clear();
        self.forces.extend(self.rows.iter().map(|&row| model.solved_forces[row]));
    }

    fn rows<'a>(&'a self, _: &'a [usize]) -> &'a [usize] {
        &self.rows
    }
}
