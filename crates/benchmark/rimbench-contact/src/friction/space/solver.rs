//! The solver of contacts with friction in space that a simulation holds.

use super::{SemismoothNewton, SpaceAdmm, SpaceProblem};
use crate::complementarity::{Checked, ProposeImpulses, SolveStats, Unsolved};
use crate::friction::ContactSweeps;
use crate::problem::{Coulomb, DenseDelassus};

/// Turns of the fallbacks; each gives its method twice the iterations of the one before.
const MOST_TURNS: u32 = 8;
/// The turn that starts from zero, after which turns go on from where they are: what was best so far may be a bad
/// start.
const ANEW: u32 = 4;
/// Sweeps and iterations of the first turn.
const FIRST_SWEEPS: u32 = 10;
const FIRST_ITERATIONS: u32 = 100;

/// Sweeps and ADMM by turns, each followed by Newton.
#[derive(Debug, Clone)]
pub struct SpaceFallbacks {
    sweeps: ContactSweeps<2>,
    admm: SpaceAdmm,
    /// The best answer so far.
    start: Vec<f64>,
    best: f64,
}

impl ProposeImpulses for SemismoothNewton {
    type Delassus<'a> = DenseDelassus<'a>;
    type Cone<'a> = Coulomb<'a, 2>;
    type Fallback = SpaceFallbacks;

    fn propose(
        &mut self,
        problem: SpaceProblem<'_>,
        same_matrix: bool,
        tolerance: f64,
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        let size = problem.b.len();
        if !same_matrix {
            self.has_factor = None;
        }
        if size != self.len {
            self.grow(size);
            self.len = size;
            self.last[..size].fill(0.0);
        }
        if problem.is_solved_by_zero()? {
            impulses.fill(0.0);
            self.last[..size].fill(0.0);
            return Ok(SolveStats::default());
        }
        impulses.copy_from_slice(&self.last[..size]);
        let stats = self.iterate_on(problem, tolerance, impulses);
        self.last[..size].copy_from_slice(impulses);
        Ok(stats)
    }

    fn fall_back(
        &mut self,
        fallback: &mut SpaceFallbacks,
        turn: u32,
        problem: SpaceProblem<'_>,
        tolerance: f64,
        impulses: &mut [f64],
    ) -> Option<Result<SolveStats, Unsolved>> {
        if turn == MOST_TURNS {
            return None;
        }
        if fallback.start.len() < impulses.len() {
            fallback.start.resize(impulses.len(), 0.0);
        }
        let start = &mut fallback.start[..impulses.len()];
        if turn == 0 {
            fallback.best = problem.natural_residual(impulses);
        } else if turn <= ANEW + 1 && problem.natural_residual(impulses) > fallback.best {
            impulses.copy_from_slice(start);
        }
        start.copy_from_slice(impulses);
        if turn == ANEW {
            impulses.fill(0.0);
        }
        let (work, factors) = if turn.is_multiple_of(2) {
            (fallback.sweeps.sweep(problem, tolerance, FIRST_SWEEPS << turn, impulses).0, 0)
        } else {
            let (work, factors, _) = fallback.admm.iterate(problem, tolerance, FIRST_ITERATIONS << turn, impulses);
            (work, factors)
        };
        let stats = self.iterate_on(problem, tolerance, impulses);
        fallback.best = fallback.best.min(stats.residual);
        if stats.residual > tolerance {
            return Some(Err(Unsolved::NotFound { residual: stats.residual }));
        }
        self.start_from(impulses);
        let (pivots, factorisations) = (stats.pivots + work, stats.factorisations + factors);
        Some(Ok(SolveStats { pivots, factorisations, ..stats }))
    }

    fn reset(&mut self) {
        self.last.fill(0.0);
    }
}

/// Solves one problem in space after the other, each from the impulses of the last; every answer is measured by the
/// natural residual.
///
/// `P = 0` where that is a solution. Else [`SemismoothNewton`]; where its answer is not good enough, [`ContactSweeps`]
/// and [`SpaceAdmm`] by turns, eight in all, each followed by Newton. Free of allocation up to the number of contacts
/// it was made for.
pub type SpaceSolver = Checked<SemismoothNewton>;

impl SpaceSolver {
    /// Makes room for this many contacts; accepts natural residuals up to `tolerance`.
    pub fn new(contacts: usize, tolerance: f64) -> Self {
        let (sweeps, admm) = (ContactSweeps::new(contacts), SpaceAdmm::new(contacts));
        let fallback = SpaceFallbacks { sweeps, admm, start: vec![0.0; 3 * contacts], best: f64::INFINITY };
        Checked::wrap(SemismoothNewton::new(contacts), fallback, tolerance)
    }
}
