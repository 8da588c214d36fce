//! The solver a simulation holds: checked after every problem, with a fallback, and counted.

use super::{ComplementaritySolver, Lcp, Lemke, ProblemRecorder, SolveStats, Solver, Unsolved};
use crate::linear_algebra::SparseRows;

/// Exact work counts of many solves.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SolverCounters {
    /// Problems given.
    pub solves: u64,
    /// Pivots or iterations, those of the fallback included.
    pub pivots: u64,
    /// Factorisations from scratch.
    pub factorisations: u64,
    /// Problems given to the fallback.
    pub fallbacks: u64,
    /// Problems answered by the affine form of an active set instead, and not among those given: micro steps of a scheme.
    pub parametric: u64,
    /// Problems that stayed unsolved.
    pub failures: u64,
    /// Largest accepted natural residual.
    pub worst_residual: f64,
}

impl SolverCounters {
    /// Adds the counts of another run; the worst residual is that of the worse.
    #[inline]
    pub fn add(&mut self, other: &SolverCounters) {
        self.solves += other.solves;
        self.pivots += other.pivots;
        self.factorisations += other.factorisations;
        self.fallbacks += other.fallbacks;
        self.parametric += other.parametric;
        self.failures += other.failures;
        self.worst_residual = self.worst_residual.max(other.worst_residual);
    }

    /// Returns the counts on top of `earlier` ones of the same solver; the worst residual is that of all.
    #[inline]
    pub fn since(&self, earlier: &SolverCounters) -> Self {
        SolverCounters {
            solves: self.solves - earlier.solves,
            pivots: self.pivots - earlier.pivots,
            factorisations: self.factorisations - earlier.factorisations,
            fallbacks: self.fallbacks - earlier.fallbacks,
            parametric: self.parametric - earlier.parametric,
            failures: self.failures - earlier.failures,
            worst_residual: self.worst_residual,
        }
    }
}

/// Of an attempt that failed.
const NO_ANSWER: SolveStats = SolveStats { pivots: 0, factorisations: 0, fallback: false, residual: f64::INFINITY };

/// A solver whose every answer is measured by the natural residual, and replaced by the fallback's if it is not good
/// enough.
///
/// Solving it means: `r(z) ≤ tolerance`, or [`Unsolved::NotFound`] with the smaller residual of the two attempts.
#[derive(Clone)]
pub struct Checked {
    primary: Solver,
    fallback: Option<Lemke>,
    tolerance: f64,
    counters: SolverCounters,
    /// The matrix of the last problem, read once it comes again.
    rows: SparseRows,
    rows_read: bool,
    /// For the solvers of contacts with friction that are made after this one.
    witness: Option<ProblemRecorder>,
}

impl Checked {
    /// Wraps a solver; `fallback` is tried when the residual of `primary` exceeds `tolerance`.
    pub fn new(primary: Solver, fallback: Option<Lemke>, tolerance: f64) -> Self {
        let rows = SparseRows::new(primary.capacity());
        Checked {
            primary,
            fallback,
            tolerance,
            counters: SolverCounters::default(),
            rows,
            rows_read: false,
            witness: None,
        }
    }

    /// Hands on who is told of problems with friction.
    #[inline]
    pub fn recorded_by(self, witness: Option<ProblemRecorder>) -> Self {
        Checked { witness, ..self }
    }

    /// Returns who is told of problems with friction.
    #[inline]
    pub fn witness(&self) -> Option<&ProblemRecorder> {
        self.witness.as_ref()
    }

    /// Returns the natural residual up to which an answer is accepted.
    #[inline]
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Tells whether the solver goes from one active set to the next: then a problem that has the set of the last one needs no solver.
    #[inline]
    pub fn goes_by_active_sets(&self) -> bool {
        matches!(self.primary, Solver::ActiveSet(_))
    }

    /// Returns the counts since construction.
    #[inline]
    pub fn counters(&self) -> SolverCounters {
        self.counters
    }

    /// Counts what was proposed and accepts it, or runs the fallback.
    ///
    /// Whatever the fallback is given is put together here: an address handed to it would keep problem and stats in
    /// memory in the usual case too, for a third of its time.
    #[inline(always)]
    fn accept(&mut self, lcp: Lcp<'_>, z: &mut [f64], proposed: SolveStats) -> Result<SolveStats, Unsolved> {
        let SolveStats { pivots, factorisations, residual, .. } = proposed;
        self.counters.solves += 1;
        self.counters.pivots += u64::from(pivots);
        self.counters.factorisations += u64::from(factorisations);
        if residual <= self.tolerance {
            self.counters.worst_residual = self.counters.worst_residual.max(residual);
            return Ok(SolveStats { pivots, factorisations, fallback: false, residual });
        }
        let proposed = SolveStats { pivots, factorisations, fallback: false, residual };
        self.fall_back(Lcp::new(lcp.h(), lcp.b), z, proposed)
    }

    /// Runs the fallback after `proposed`, the stats of an insufficient proposal in `z`.
    #[cold]
    fn fall_back(&mut self, lcp: Lcp<'_>, z: &mut [f64], proposed: SolveStats) -> Result<SolveStats, Unsolved> {
        let mut least = proposed.residual;
        if let Some(lemke) = &mut self.fallback {
            self.counters.fallbacks += 1;
            if let Ok(stats) = lemke.attempt(lcp, z) {
                self.counters.pivots += u64::from(stats.pivots);
                let residual = lcp.natural_residual(z);
                if residual <= self.tolerance {
                    self.counters.worst_residual = self.counters.worst_residual.max(residual);
                    let pivots = proposed.pivots + stats.pivots;
                    return Ok(SolveStats { pivots, fallback: true, residual, ..proposed });
                }
                least = least.min(residual);
            }
        }
        self.counters.failures += 1;
        Err(Unsolved::NotFound { residual: least })
    }
}

/// The natural residual of a problem whose matrix is the one that `rows` has read: the same sums without their zeros.
#[inline]
fn residual_of_rows(lcp: Lcp<'_>, rows: &SparseRows, z: &[f64]) -> f64 {
    if !rows.holds() {
        return lcp.natural_residual(z);
    }
    lcp.residual_of(z, |i| rows.row(i).map(|(j, h_ij)| h_ij * z[j]).sum::<f64>() + lcp.b[i])
}

impl ComplementaritySolver for Checked {
    // Not inlined: solver, check and counters make one function in this package.
    fn attempt(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Unsolved> {
        self.rows_read = false;
        let stats = match self.primary.attempt(lcp, z) {
            Ok(stats) => SolveStats { residual: lcp.natural_residual(z), ..stats },
            Err(_) => NO_ANSWER,
        };
        self.accept(lcp, z, stats)
    }

    fn attempt_again(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Unsolved> {
        if !self.rows_read {
            self.rows.read(lcp.h(), lcp.size());
            self.rows_read = true;
        }
        let stats = match self.primary.attempt_again(lcp, z) {
            Ok(stats) => SolveStats { residual: residual_of_rows(lcp, &self.rows, z), ..stats },
            Err(_) => NO_ANSWER,
        };
        self.accept(lcp, z, stats)
    }

    /// [`attempt`](Self::attempt), whose answer is checked already.
    #[inline]
    fn solve(&mut self, lcp: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Unsolved> {
        self.attempt(lcp, z)
    }

    fn reset(&mut self) {
        self.primary.reset();
    }

    fn capacity(&self) -> usize {
        self.primary.capacity()
    }

    fn boxed_clone(&self) -> Box<dyn ComplementaritySolver> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Proposes the same number for every impulse, or nothing.
    #[derive(Clone)]
    struct Stubborn(Option<f64>);

    impl ComplementaritySolver for Stubborn {
        fn attempt(&mut self, _: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Unsolved> {
            z.fill(self.0.unwrap_or_default());
            let stats = SolveStats { pivots: 3, factorisations: 2, ..SolveStats::default() };
            self.0.map(|_| stats).ok_or(Unsolved::NotFound { residual: 0.0 })
        }

        fn boxed_clone(&self) -> Box<dyn ComplementaritySolver> {
            Box::new(self.clone())
        }
    }

    const LCP: Lcp<'_> = Lcp::new(&[2.0], &[-4.0]);

    #[test]
    fn a_wrong_answer_is_replaced_and_counted() {
        for (proposal, own_pivots) in [(Some(7.0), 3), (Some(f64::NAN), 3), (None, 0)] {
            let mut solver = Checked::new(Solver::Other(Box::new(Stubborn(proposal))), Some(Lemke::new(1)), 1e-9);
            let mut z = [0.0];
            let stats = solver.solve(LCP, &mut z).unwrap();
            assert_eq!((z, stats.fallback), ([2.0], true));
            let counters = solver.counters();
            assert_eq!((counters.solves, counters.fallbacks, counters.failures), (1, 1, 0));
            assert!(stats.pivots > own_pivots && counters.pivots == u64::from(stats.pivots));
        }
    }

    #[test]
    fn a_right_answer_is_kept() {
        let mut solver = Checked::new(Solver::Other(Box::new(Stubborn(Some(2.0)))), Some(Lemke::new(1)), 1e-9);
        let stats = solver.solve(LCP, &mut [0.0]).unwrap();
        assert_eq!(stats, SolveStats { pivots: 3, factorisations: 2, fallback: false, residual: 0.0 });
        let mut total = solver.counters();
        total.add(&SolverCounters { solves: 2, worst_residual: 0.5, ..SolverCounters::default() });
        assert_eq!((total.solves, total.factorisations, total.fallbacks, total.worst_residual), (3, 2, 0, 0.5));
    }

    /// `M` of a row of bodies, and `q` under a force that changes from turn to turn.
    fn pushed_row(n: usize, heavier: f64) -> (Vec<f64>, impl Fn(usize) -> Vec<f64>) {
        let coupling = |i: usize, j: usize| heavier * [2.0, -1.0, 0.0][i.abs_diff(j).min(2)];
        let m = (0..n * n).map(|k: usize| coupling(k / n, k % n)).collect();
        (m, move |turn| (0..n).map(|i| libm::sin(0.7 * i as f64 + 0.4 * turn as f64) - 0.3).collect())
    }

    #[test]
    fn a_matrix_said_to_be_the_same_gives_the_same_bits_as_one_found_to_be() {
        for n in [1, 4, 8, 9, 40, 70] {
            let build =
                || Checked::new(Solver::ActiveSet(Box::new(crate::complementarity::ActiveSet::new(n))), None, 1e-9);
            let (mut asking, mut told) = (build(), build());
            let (mut z_asking, mut z_told) = (vec![0.0; n], vec![0.0; n]);
            for heavier in [1.0, 0.5] {
                let (m, q) = pushed_row(n, heavier);
                for turn in 0..20 {
                    // Every fifth problem is solved by zero, and its matrix not looked at; so is the first.
                    let q = if turn % 5 == 0 { vec![1.0; n] } else { q(turn) };
                    let lcp = Lcp::new(&m, &q);
                    asking.solve(lcp, &mut z_asking).unwrap();
                    let stats =
                        if turn == 0 { told.solve(lcp, &mut z_told) } else { told.attempt_again(lcp, &mut z_told) };
                    assert!(stats.unwrap().residual <= 1e-12);
                    assert!(
                        z_asking.iter().zip(&z_told).all(|(a, b)| a.to_bits() == b.to_bits()),
                        "n = {n}, turn {turn}"
                    );
                }
            }
            let (asking, told) = (asking.counters(), told.counters());
            assert_eq!((asking.pivots, asking.factorisations), (told.pivots, told.factorisations));
            assert!(told.factorisations >= 2, "a changed matrix is factorised");
        }
    }

    #[test]
    fn without_its_zeros_a_matrix_gives_the_same_residual() {
        let n = 48;
        // Integers below 2^50: every order of summation is exact.
        let mut m: Vec<f64> = (0..n * n).map(|k: usize| [6.0, -2.0, 0.0][(k / n).abs_diff(k % n).min(2)]).collect();
        let q: Vec<f64> = (0..n).map(|i| (i * 7 % 11) as f64 - 5.0).collect();
        let z: Vec<f64> = (0..n).map(|i| (i * 5 % 7) as f64 - 1.0).collect();
        let mut rows = SparseRows::new(n);
        rows.read(&m, n);
        let lcp = Lcp::new(&m, &q);
        assert!(rows.holds() && lcp.natural_residual(&z) > 0.0);
        assert_eq!(residual_of_rows(lcp, &rows, &z), lcp.natural_residual(&z));
        m[n + 40] = f64::NAN;
        rows.read(&m, n);
        let (lcp, z) = (Lcp::new(&m, &q), vec![0.0; n]);
        assert_eq!(residual_of_rows(lcp, &rows, &z), f64::INFINITY);
    }

    #[test]
    fn without_a_solution_the_failure_names_the_best_residual() {
        let mut solver = Checked::new(Solver::Other(Box::new(Stubborn(Some(0.0)))), Some(Lemke::new(1)), 1e-9);
        let impossible = Lcp::new(&[0.0], &[-4.0]);
        assert_eq!(solver.solve(impossible, &mut [0.0]), Err(Unsolved::NotFound { residual: 1.0 }));
        assert_eq!(solver.counters().failures, 1);
    }
}
