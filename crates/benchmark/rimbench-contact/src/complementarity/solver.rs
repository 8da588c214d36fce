//! The solver that an entry of the list builds: the default solver under its own type, all others behind a trait
//! object.

use super::active_set::residual_of_rows;
use super::{ActiveSet, ComplementaritySolver, Lcp, Lemke, ProposeImpulses, SolveStats, Unsolved};
use crate::linear_algebra::SparseRows;
use crate::problem::{DenseDelassus, Signorini};

/// A solver by value.
///
/// The default solver answers in some ten nanoseconds (`benches/solvers.rs`), of which a call through a table of
/// functions would be a part worth having; so it is named. Problems for the others are put together where they are
/// handed on: an address of the caller's problem would keep it in memory for the default, for 30 % of its time.
#[derive(Clone)]
pub enum Solver {
    /// The default.
    ActiveSet(Box<ActiveSet>),
    /// Any other.
    Other {
        /// The solver.
        solver: Box<dyn ComplementaritySolver>,
        /// The matrix without its zeros, for the check, read once it comes again.
        rows: SparseRows,
        /// Whether that is the present matrix.
        rows_read: bool,
    },
}

impl Solver {
    /// Tells whether it goes from one active set to the next: then a problem that has the set of the last one needs no
    /// solver.
    #[inline]
    pub fn goes_by_active_sets(&self) -> bool {
        matches!(self, Solver::ActiveSet(_))
    }

    /// Wraps any solver that has no variant of its own.
    pub fn other(solver: impl ComplementaritySolver + 'static) -> Self {
        let rows = SparseRows::new(solver.capacity());
        Solver::Other { solver: Box::new(solver), rows, rows_read: false }
    }
}

impl ComplementaritySolver for Solver {
    #[inline(always)]
    fn attempt(&mut self, lcp: Lcp<'_>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved> {
        match self {
            Solver::ActiveSet(solver) => solver.attempt(lcp, impulses),
            Solver::Other { solver, .. } => solver.attempt(Lcp::new(lcp.h(), lcp.b), impulses),
        }
    }

    fn reset(&mut self) {
        match self {
            Solver::ActiveSet(solver) => solver.reset(),
            Solver::Other { solver, .. } => solver.reset(),
        }
    }

    fn capacity(&self) -> usize {
        match self {
            Solver::ActiveSet(solver) => solver.capacity(),
            Solver::Other { solver, .. } => solver.capacity(),
        }
    }
}

impl ProposeImpulses for Solver {
    type Delassus<'a> = DenseDelassus<'a>;
    type Cone<'a> = Signorini;
    type Fallback = Option<Lemke>;

    #[inline(always)]
    fn propose(
        &mut self,
        lcp: Lcp<'_>,
        same_matrix: bool,
        _tolerance: f64,
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        let attempted = match self {
            Solver::ActiveSet(solver) => solver.solve_from_last_set(lcp, same_matrix, impulses),
            Solver::Other { solver, .. } => solver.attempt(Lcp::new(lcp.h(), lcp.b), impulses),
        };
        let Ok(stats) = attempted else { return Err(Unsolved::NotFound { residual: f64::INFINITY }) };
        let residual = match self {
            Solver::ActiveSet(solver) if same_matrix => solver.residual_again(lcp, impulses),
            Solver::Other { rows, rows_read, .. } if same_matrix => {
                if !std::mem::replace(rows_read, true) {
                    rows.read(lcp.h(), lcp.size());
                }
                residual_of_rows(lcp, rows, impulses)
            }
            Solver::Other { rows_read, .. } => {
                *rows_read = false;
                lcp.natural_residual(impulses)
            }
            Solver::ActiveSet(_) => lcp.natural_residual(impulses),
        };
        Ok(SolveStats { residual, ..stats })
    }

    fn fall_back(
        &mut self,
        lemke: &mut Option<Lemke>,
        turn: u32,
        lcp: Lcp<'_>,
        _tolerance: f64,
        impulses: &mut [f64],
    ) -> Option<Result<SolveStats, Unsolved>> {
        let lemke = lemke.as_mut().filter(|_| turn == 0)?;
        Some(match lemke.attempt(lcp, impulses) {
            // Its factorisation of the last basis is part of the pivots.
            Ok(stats) => Ok(SolveStats { factorisations: 0, residual: lcp.natural_residual(impulses), ..stats }),
            Err(_) => Err(Unsolved::NotFound { residual: f64::INFINITY }),
        })
    }

    fn reset(&mut self) {
        ComplementaritySolver::reset(self);
    }
}
