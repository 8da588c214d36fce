//! The contact problem of one step, Eq. 4 with the contact law: its right-hand side, and its solution.
//!
//! ```text
//! b = w + h a + H_·i h λ_i + t        w⁺ + t = H P + b        0 ≤ w_n⁺ + t_n ⟂ P_n ≥ 0, with friction Coulomb's law for P_t
//! ```
//! t is the gap term, or the impact term of a contact that rebounds. In the paper `b_u = w_u + h a_u`, λ_i is unknown,
//! and `t = 0`.

mod coulomb;

pub(in crate::mechanics) use coulomb::friction_observables;
pub use coulomb::{Friction, is_contact_state};

use super::{ContactLaw, Rebounding};
use crate::error::Failure;
use crate::interface_model::ReducedInterfaceModel;
use coulomb::CoulombStep;
use rimbench_contact::complementarity::{Checked, Lcp, SolverCounters, SparseLcp, SparseSolver, Unsolved};
use rimbench_contact::contact_law::{Solved, gap_velocity};
use rimbench_contact::known_size;
use rimbench_contact::linear_algebra::{SymmetricPattern, body_dot, largest_entry};

/// Contact law and Eq. 4 of a step, which determine the right-hand side of its contact problem.
#[derive(Clone, Copy)]
pub(super) struct ContactTerms<'a> {
    pub(super) law: &'a ContactLaw,
    pub(super) eq4: &'a ReducedInterfaceModel,
    pub(super) rebounding: &'a Rebounding,
    /// Length of the step, s.
    pub(super) h: f64,
    pub(super) solved: Solved,
}

impl ContactTerms<'_> {
    /// Returns `t_n` of a contact: the gap term, or the impact term of one that rebounds, m/s.
    #[inline]
    pub(super) fn normal(&self, contact: usize) -> f64 {
        let ContactTerms { law, eq4, rebounding, h, solved } = *self;
        let gap_term = gap_velocity(eq4.gap[contact], h, h, law.stabilisation);
        rebounding.normal_term(law, contact, gap_term, (eq4.w[contact], h), solved)
    }

    /// Returns `t_t` of a stacked tangential row, its impact term, m/s.
    pub(super) fn tangential(&self, row: usize) -> f64 {
        self.rebounding.tangential_term(self.law, row - self.eq4.contacts(), (self.eq4.w[row], self.h))
    }
}

/// A contact problem with a dense Delassus matrix: `H`, `b`, and `w = H P + b`.
#[derive(Debug, Clone)]
pub(super) struct DenseProblem {
    pub(super) h: Vec<f64>,
    pub(super) b: Vec<f64>,
    pub(super) w: Vec<f64>,
}

impl DenseProblem {
    pub(super) fn new(rows: usize) -> Self {
        DenseProblem { h: vec![0.0; rows * rows], b: vec![0.0; rows], w: vec![0.0; rows] }
    }

    /// Writes `H` and `b`; tangential rows come after the normal ones.
    pub(super) fn pose(&mut self, terms: ContactTerms<'_>, p_i: &[f64]) {
        let Ok(force) = <[f64; 1]>::try_from(p_i) else { return self.pose_rows(self.b.len(), terms, p_i) };
        known_size!(self.b.len(), N if N <= 9 || N == 18 => self.pose_few::<N>(terms, force), rows => self.pose_rows(rows, terms, p_i));
    }

    #[inline(never)]
    fn pose_few<const N: usize>(&mut self, terms: ContactTerms<'_>, force: [f64; 1]) {
        self.pose_rows(N, terms, &force);
    }

    #[inline(always)]
    fn pose_rows(&mut self, rows: usize, terms: ContactTerms<'_>, p_i: &[f64]) {
        let ContactTerms { eq4, h: step, .. } = terms;
        let (stacked, n) = (rows + p_i.len(), eq4.contacts());
        let (h, b) = (&mut self.h[..rows * rows], &mut self.b[..rows]);
        let (stacked_h, w, a) = (&eq4.h[..rows * stacked], &eq4.w[..rows], &eq4.a[..rows]);
        for row in 0..rows {
            let (h_cc, h_ci) = stacked_h[row * stacked..(row + 1) * stacked].split_at(rows);
            let term = if row < n { terms.normal(row) } else { terms.tangential(row) };
            b[row] = w[row] + step * a[row] + body_dot(h_ci, p_i) + term;
            let out = &mut h[row * rows..(row + 1) * rows];
            if rows == 18 {
                // In halves, or the compiler would call a function.
                let (first, second) = out.split_at_mut(9);
                first.copy_from_slice(&h_cc[..9]);
                second.copy_from_slice(&h_cc[9..]);
            } else {
                out.copy_from_slice(h_cc);
            }
        }
    }

    /// Copies `H`, for trials with other right-hand sides.
    fn copy_matrix(&mut self, eq4: &ReducedInterfaceModel) {
        let (rows, stacked) = (self.b.len(), eq4.a.len());
        for (row, out) in self.h.chunks_exact_mut(rows).enumerate() {
            out.copy_from_slice(&eq4.h[row * stacked..row * stacked + rows]);
        }
    }

    /// Replaces the gap term by that of spring and damper, and adds their compliance to the diagonal of `H`, see
    /// [`ContactSpring`](rimbench_contact::contact_law::ContactSpring).
    #[inline]
    fn add_compliance(&mut self, terms: ContactTerms<'_>) {
        let Some(spring) = terms.law.spring else { return };
        let (n, rates) = (self.b.len(), spring.gap_rates(terms.h));
        for contact in 0..terms.eq4.contacts() {
            self.b[contact] += rates.velocity(terms.eq4.gap[contact]) - terms.normal(contact);
            self.h[contact * n + contact] += spring.diagonal(terms.h, terms.h);
        }
    }
}

/// The contact problem of a step with its solver.
#[derive(Clone)]
pub(super) enum StepContacts {
    /// Without friction, every entry of `H` kept.
    Signorini {
        problem: DenseProblem,
        solver: Box<Checked>,
    },
    /// Without friction, `H` by its pattern: its entries stay in Eq. 4.
    Sparse {
        b: Vec<f64>,
        solver: Box<SparseSolver>,
        /// That of `H` with every entry.
        dense: Box<Checked>,
    },
    Coulomb(Box<CoulombStep>),
}

impl StepContacts {
    /// Reserves `contacts` contacts without friction, with `pattern` or every entry.
    pub(super) fn new(contacts: usize, pattern: Option<&SymmetricPattern>, solver: Checked) -> Self {
        match pattern {
            Some(pattern) => StepContacts::Sparse {
                b: vec![0.0; contacts],
                solver: Box::new(SparseSolver::new(pattern, solver.tolerance())),
                dense: Box::new(solver),
            },
            None => StepContacts::Signorini { problem: DenseProblem::new(contacts), solver: Box::new(solver) },
        }
    }

    /// Solves for the contact impulses of one step, the first of `impulses`; the others are `h λ_i`, given.
    ///
    /// # Errors
    /// As the contact solver reports.
    #[inline]
    pub(super) fn solve(&mut self, terms: ContactTerms<'_>, impulses: &mut [f64]) -> Result<(), Failure> {
        let (impulses, p_i) = impulses.split_at_mut(terms.eq4.interface_start());
        match self {
            StepContacts::Signorini { problem, solver } => {
                problem.pose(terms, p_i);
                problem.add_compliance(terms);
                solver.solve(Lcp::new(&problem.h, &problem.b), impulses)?;
            }
            StepContacts::Sparse { b, solver, .. } => {
                for (contact, b) in b.iter_mut().enumerate() {
                    *b = terms.eq4.w[contact] + terms.h * terms.eq4.a[contact] + terms.normal(contact);
                }
                for (i, &impulse) in p_i.iter().enumerate() {
                    let column = terms.eq4.interface_column(i).expect("Eq. 4 is sparse");
                    b.iter_mut().zip(column).for_each(|(b, h)| *b += h * impulse);
                }
                let rows = terms.eq4.contact_rows().expect("Eq. 4 is sparse");
                solver.solve(SparseLcp::by_pattern(rows, b), impulses)?;
            }
            StepContacts::Coulomb(contacts) => contacts.solve(terms, impulses, p_i)?,
        }
        Ok(())
    }

    /// Prepares for trials with the matrix of Eq. 4.
    pub(super) fn begin_trials(&mut self, eq4: &ReducedInterfaceModel) {
        match self {
            StepContacts::Signorini { problem, .. } => problem.copy_matrix(eq4),
            StepContacts::Sparse { solver, .. } => solver.solver.forget_matrix(),
            StepContacts::Coulomb(contacts) => contacts.problem.copy_matrix(eq4),
        }
    }

    /// Solves a trial with the right-hand side `b`, and writes its impulses and velocities `H P + b`.
    ///
    /// # Errors
    /// As the contact solver reports.
    pub(super) fn try_solve(
        &mut self,
        eq4: &ReducedInterfaceModel,
        b: &[f64],
        impulses: &mut [f64],
        velocities: &mut [f64],
    ) -> Result<(), Unsolved> {
        match self {
            StepContacts::Signorini { problem: DenseProblem { h, .. }, solver } => {
                solver.solve(Lcp::new(h, b), impulses)?;
                for ((velocity, b), row) in velocities.iter_mut().zip(b).zip(h.chunks_exact(b.len())) {
                    *velocity = b + body_dot(row, impulses);
                }
            }
            StepContacts::Sparse { solver, .. } => {
                let rows = eq4.contact_rows().expect("Eq. 4 is sparse");
                solver.solve_again(SparseLcp::by_pattern(rows, b), impulses)?;
                velocities.copy_from_slice(solver.solver.velocities());
            }
            StepContacts::Coulomb(contacts) => contacts.try_solve(b, impulses, velocities)?,
        }
        Ok(())
    }

    /// Returns `w⁺ + t = H P + b` of the last step, m/s, normal rows first, and up to where it is rounding: the
    /// tolerance times `‖b‖_∞`.
    pub(super) fn velocities_after(&mut self, impulses: &[f64]) -> (&[f64], f64) {
        match self {
            StepContacts::Signorini { problem: DenseProblem { h, b, w }, solver } => {
                let n = b.len();
                w.copy_from_slice(b);
                // Few contacts carry impulse, and the matrix is symmetric: its rows are its columns.
                for (contact, &impulse) in impulses[..n].iter().enumerate() {
                    if impulse != 0.0 {
                        w.iter_mut().zip(&h[contact * n..(contact + 1) * n]).for_each(|(w, h)| *w += h * impulse);
                    }
                }
                (w, solver.tolerance() * largest_entry(b))
            }
            StepContacts::Sparse { b, solver, .. } => {
                (solver.solver.velocities(), solver.tolerance() * largest_entry(b))
            }
            StepContacts::Coulomb(contacts) => (&contacts.problem.w, contacts.rounding_velocity()),
        }
    }

    /// Returns `total` plus the energy dissipated by the dampers of compliant contacts in the step just solved, J.
    pub(super) fn damper_loss(&self, terms: ContactTerms<'_>, impulses: &[f64], mut total: f64) -> f64 {
        let Some(spring) = terms.law.spring else { return total };
        let DenseProblem { h, b, .. } = match self {
            StepContacts::Signorini { problem, .. } => problem,
            StepContacts::Coulomb(contacts) => &contacts.problem,
            StepContacts::Sparse { .. } => return total,
        };
        let (n, rates) = (b.len(), spring.gap_rates(terms.h));
        for contact in 0..terms.eq4.contacts() {
            let (gap, impulse) = (terms.eq4.gap[contact], impulses[contact]);
            let row = body_dot(&h[contact * n..(contact + 1) * n], &impulses[..n]);
            let w = b[contact] + row - rates.velocity(gap) - spring.diagonal(terms.h, terms.h) * impulse;
            total += spring.loss(impulse, gap, w, terms.h);
        }
        total
    }

    pub(super) fn counters(&self) -> SolverCounters {
        match self {
            StepContacts::Signorini { solver, .. } => solver.counters(),
            StepContacts::Sparse { solver, .. } => solver.counters(),
            StepContacts::Coulomb(contacts) => contacts.counters(),
        }
    }

    /// Returns the solver of contacts without friction whose `H` keeps every entry.
    pub(super) fn signorini(&mut self) -> Option<&mut Checked> {
        if let StepContacts::Signorini { solver, .. } = self { Some(solver) } else { None }
    }

    /// Returns the contacts with friction, if they have it.
    pub(super) fn coulomb(&self) -> Option<&CoulombStep> {
        if let StepContacts::Coulomb(contacts) = self { Some(contacts) } else { None }
    }

    /// Returns the solver of `H` with every entry, where only its non-zeros are kept.
    pub(super) fn dense_solver(&self) -> Option<&Checked> {
        if let StepContacts::Sparse { dense, .. } = self { Some(dense) } else { None }
    }
}
