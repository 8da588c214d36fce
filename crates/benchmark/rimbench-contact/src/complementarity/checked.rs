//! The solver a simulation holds: what it proposes is checked after every problem, with a fallback, and counted.

use super::propose::{ProblemOf, ProposeImpulses};
use super::{SolveStats, Solver, Unsolved};
use crate::problem::ContactProblem;

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
    /// Problems answered by the affine form of an active set instead, and not among those given: micro steps of a
    /// scheme.
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

    /// Returns the counts on top of `earlier` ones of this solver; the worst residual is that of all.
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

/// A solver whose every answer is measured by the natural residual, and replaced by the fallback's if it is not good
/// enough.
///
/// Solving it means: `r(P) ≤ tolerance`, or [`Unsolved::NotFound`] with the least residual of all attempts.
#[derive(Debug, Clone)]
pub struct Checked<S: ProposeImpulses = Solver> {
    /// Proposes first.
    pub solver: S,
    fallback: S::Fallback,
    tolerance: f64,
    counters: SolverCounters,
}

impl<S: ProposeImpulses> Checked<S> {
    /// Wraps a solver; `fallback` is asked when the residual of its answer exceeds `tolerance`.
    pub fn wrap(solver: S, fallback: S::Fallback, tolerance: f64) -> Self {
        Checked { solver, fallback, tolerance, counters: SolverCounters::default() }
    }

    /// Returns the natural residual up to which an answer is accepted.
    #[inline]
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Returns the counts since construction.
    #[inline]
    pub fn counters(&self) -> SolverCounters {
        self.counters
    }

    /// Forgets the active set, so that the next answer depends on its problem alone.
    pub fn reset(&mut self) {
        self.solver.reset();
    }

    /// Writes the solution P to `impulses`, N·s.
    ///
    /// # Errors
    /// [`Unsolved::NotFound`] without an answer that is good enough, [`Unsolved::NonFinite`] if `b` is not finite.
    #[inline(never)]
    pub fn solve(&mut self, problem: ProblemOf<'_, S>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved> {
        self.find(problem, false, impulses)
    }

    /// Solves as [`solve`](Self::solve), `H` and K to the last bit those of the problem before; only `b` may differ.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    #[inline(never)]
    pub fn solve_again(&mut self, problem: ProblemOf<'_, S>, impulses: &mut [f64]) -> Result<SolveStats, Unsolved> {
        self.find(problem, true, impulses)
    }

    /// Counts what was proposed and accepts it, or runs the fallback.
    ///
    /// Whatever the fallback is given is put together here: an address handed to it would keep problem and stats in
    /// memory in the usual case too, for a third of its time.
    #[inline(always)]
    fn find(
        &mut self,
        problem: ProblemOf<'_, S>,
        same_matrix: bool,
        impulses: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        self.counters.solves += 1;
        let unsolved = match self.solver.propose(problem, same_matrix, self.tolerance, impulses) {
            Ok(SolveStats { pivots, factorisations, residual, .. }) => {
                let stats = SolveStats { pivots, factorisations, fallback: false, residual };
                if let Some(accepted) = self.accept(stats) {
                    return Ok(accepted);
                }
                Ok(SolveStats { pivots, factorisations, fallback: false, residual })
            }
            Err(unsolved) => Err(unsolved),
        };
        let ContactProblem { delassus, b, cone } = problem;
        self.fall_back(ContactProblem { delassus, b, cone }, impulses, unsolved)
    }

    /// Counts the work of a proposal; returns its stats if it is good enough.
    #[inline(always)]
    fn accept(&mut self, stats: SolveStats) -> Option<SolveStats> {
        self.counters.pivots += u64::from(stats.pivots);
        self.counters.factorisations += u64::from(stats.factorisations);
        let good = stats.residual <= self.tolerance;
        if good {
            self.counters.worst_residual = self.counters.worst_residual.max(stats.residual);
        }
        good.then_some(stats)
    }

    /// Accepts what is good enough on the scale of each contact; returns its stats.
    #[cold]
    fn accept_on_own_scales(
        &mut self,
        problem: ProblemOf<'_, S>,
        impulses: &[f64],
        stats: SolveStats,
    ) -> Option<SolveStats> {
        let residual = problem.residual_on_own_scales(impulses, self.tolerance);
        let good = residual <= self.tolerance;
        if good {
            self.counters.worst_residual = self.counters.worst_residual.max(residual);
        }
        good.then_some(SolveStats { residual, ..stats })
    }

    /// Runs the fallback after an insufficient proposal.
    #[cold]
    fn fall_back(
        &mut self,
        problem: ProblemOf<'_, S>,
        impulses: &mut [f64],
        proposed: Result<SolveStats, Unsolved>,
    ) -> Result<SolveStats, Unsolved> {
        if let Ok(stats) = proposed
            && let Some(accepted) = self.accept_on_own_scales(problem, impulses, stats)
        {
            return Ok(accepted);
        }
        let (mut work, mut least) = (SolveStats::default(), f64::INFINITY);
        let mut attempted = Some(proposed);
        for turn in 0.. {
            match attempted {
                Some(Ok(stats)) => {
                    work.pivots += stats.pivots;
                    work.factorisations += stats.factorisations;
                    least = least.min(stats.residual);
                }
                Some(Err(Unsolved::NotFound { residual })) => least = least.min(residual),
                Some(Err(reason)) => return self.fail(reason),
                None => break,
            }
            attempted = self.solver.fall_back(&mut self.fallback, turn, problem, self.tolerance, impulses);
            self.counters.fallbacks += u64::from(turn == 0 && attempted.is_some());
            if let Some(Ok(stats)) = attempted
                && let Some(stats) = self.accept(stats).or_else(|| self.accept_on_own_scales(problem, impulses, stats))
            {
                let (pivots, factorisations) = (work.pivots + stats.pivots, work.factorisations + stats.factorisations);
                return Ok(SolveStats { pivots, factorisations, fallback: true, ..stats });
            }
        }
        self.fail(Unsolved::NotFound { residual: least })
    }

    /// Counts a problem that stays unsolved. Whatever was tried last is no good start for the next.
    fn fail(&mut self, reason: Unsolved) -> Result<SolveStats, Unsolved> {
        self.counters.failures += 1;
        self.solver.reset();
        Err(reason)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::complementarity::{ComplementaritySolver, Lcp, Lemke, active_set::residual_of_rows};
    use crate::linear_algebra::SparseRows;
    use crate::problem::{DenseDelassus, Signorini};

    /// Proposes one number for all impulses, or nothing.
    #[derive(Clone)]
    struct Stubborn(Option<f64>);

    impl ComplementaritySolver for Stubborn {
        fn attempt(&mut self, _: Lcp<'_>, z: &mut [f64]) -> Result<SolveStats, Unsolved> {
            z.fill(self.0.unwrap_or_default());
            let stats = SolveStats { pivots: 3, factorisations: 2, ..SolveStats::default() };
            self.0.map(|_| stats).ok_or(Unsolved::NotFound { residual: 0.0 })
        }
    }

    const LCP: Lcp<'_> = Lcp::new(&[2.0], &[-4.0]);

    #[test]
    fn a_wrong_answer_is_replaced_and_counted() {
        for (proposal, own_pivots) in [(Some(7.0), 3), (Some(f64::NAN), 3), (None, 0)] {
            let mut solver = Checked::wrap(Solver::other(Stubborn(proposal)), Some(Lemke::new(1)), 1e-9);
            let mut z = [0.0];
            let stats = solver.solve(LCP, &mut z).unwrap();
            assert_eq!((z, stats.fallback), ([2.0], true));
            let counters = solver.counters();
            assert_eq!((counters.solves, counters.fallbacks, counters.failures), (1, 1, 0));
            assert!(stats.pivots > own_pivots && counters.pivots == u64::from(stats.pivots));
        }
    }

    /// Proposes a wrong answer with work of its own, and the right one with more.
    struct Twice;

    impl ProposeImpulses for Twice {
        type Delassus<'a> = DenseDelassus<'a>;
        type Cone<'a> = Signorini;
        type Fallback = ();

        fn propose(&mut self, _: Lcp<'_>, _: bool, _: f64, _: &mut [f64]) -> Result<SolveStats, Unsolved> {
            Ok(SolveStats { pivots: 3, factorisations: 2, residual: 1.0, ..SolveStats::default() })
        }

        fn fall_back(
            &mut self,
            (): &mut (),
            _: u32,
            _: Lcp<'_>,
            _: f64,
            z: &mut [f64],
        ) -> Option<Result<SolveStats, Unsolved>> {
            z.fill(2.0);
            Some(Ok(SolveStats { pivots: 30, factorisations: 20, ..SolveStats::default() }))
        }

        fn reset(&mut self) {}
    }

    #[test]
    fn the_work_of_a_fallback_is_on_top_of_that_of_the_answer_which_it_replaces() {
        let mut solver = Checked::wrap(Twice, (), 1e-9);
        let stats = solver.solve(LCP, &mut [0.0]).unwrap();
        assert_eq!(stats, SolveStats { pivots: 33, factorisations: 22, fallback: true, residual: 0.0 });
        assert_eq!((solver.counters().pivots, solver.counters().factorisations), (33, 22));
    }

    #[test]
    fn a_right_answer_is_kept() {
        let mut solver = Checked::wrap(Solver::other(Stubborn(Some(2.0))), Some(Lemke::new(1)), 1e-9);
        let stats = solver.solve(LCP, &mut [0.0]).unwrap();
        assert_eq!(stats, SolveStats { pivots: 3, factorisations: 2, fallback: false, residual: 0.0 });
        let mut total = solver.counters();
        total.add(&SolverCounters { solves: 2, worst_residual: 0.5, ..SolverCounters::default() });
        assert_eq!((total.solves, total.factorisations, total.fallbacks, total.worst_residual), (3, 2, 0, 0.5));
    }

    /// `H` of a row of bodies, and `b` under a force that changes from turn to turn.
    fn pushed_row(n: usize, heavier: f64) -> (Vec<f64>, impl Fn(usize) -> Vec<f64>) {
        let coupling = |i: usize, j: usize| heavier * [2.0, -1.0, 0.0][i.abs_diff(j).min(2)];
        let m = (0..n * n).map(|k: usize| coupling(k / n, k % n)).collect();
        (m, move |turn| (0..n).map(|i| libm::sin(0.7 * i as f64 + 0.4 * turn as f64) - 0.3).collect())
    }

    #[test]
    fn a_matrix_said_to_be_the_same_gives_the_same_bits_as_one_found_to_be() {
        for n in [1, 4, 8, 9, 40, 70] {
            let build =
                || Checked::wrap(Solver::ActiveSet(Box::new(crate::complementarity::ActiveSet::new(n))), None, 1e-9);
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
                        if turn == 0 { told.solve(lcp, &mut z_told) } else { told.solve_again(lcp, &mut z_told) };
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
        let mut h: Vec<f64> = (0..n * n).map(|k: usize| [6.0, -2.0, 0.0][(k / n).abs_diff(k % n).min(2)]).collect();
        let b: Vec<f64> = (0..n).map(|i| (i * 7 % 11) as f64 - 5.0).collect();
        let p: Vec<f64> = (0..n).map(|i| (i * 5 % 7) as f64 - 1.0).collect();
        let mut rows = SparseRows::new(n);
        rows.read(&h, n);
        let lcp = Lcp::new(&h, &b);
        assert!(rows.holds() && lcp.natural_residual(&p) > 0.0);
        assert_eq!(residual_of_rows(lcp, &rows, &p), lcp.natural_residual(&p));
        h[n + 40] = f64::NAN;
        rows.read(&h, n);
        assert_eq!(residual_of_rows(Lcp::new(&h, &b), &rows, &vec![0.0; n]), f64::INFINITY);
    }

    /// A blade of 100 kg presses light bodies against a wall, which all take on its impulse, by 1 N·s.
    #[test]
    fn bodies_a_hundred_million_times_as_light_as_their_neighbour_are_solved_to_the_rounding_of_their_rows() {
        const CONTACTS: usize = 11;
        for mass in [1e-3, 1e-4, 1e-5, 1e-6] {
            let inverse = |body: usize| if body == 0 { 0.01 } else { 1.0 / mass };
            let h: Vec<f64> = (0..CONTACTS * CONTACTS)
                .map(|at| match (at / CONTACTS, at % CONTACTS) {
                    (i, j) if i == j => inverse(i) + if i + 1 < CONTACTS { inverse(i + 1) } else { 0.0 },
                    (i, j) if i.abs_diff(j) == 1 => -inverse(i.max(j)),
                    _ => 0.0,
                })
                .collect();
            let mut solver = Checked::wrap(
                Solver::ActiveSet(Box::new(crate::complementarity::ActiveSet::new(CONTACTS))),
                Some(Lemke::new(CONTACTS)),
                1e-9,
            );
            let mut impulses = [0.0; CONTACTS];
            for turn in 1..50 {
                let pressed = 0.1 + libm::sin(0.7 * f64::from(turn)).abs();
                let b: [f64; CONTACTS] = std::array::from_fn(|i| if i == 0 { -0.01 * pressed } else { 0.0 });
                let lcp = Lcp::new(&h, &b);
                let stats = solver.solve(lcp, &mut impulses).unwrap();
                assert!(stats.residual <= 1e-9 && !stats.fallback, "{mass} kg: {stats:?}");
                for impulse in impulses {
                    assert!((impulse / pressed - 1.0).abs() < 1e-5, "{mass} kg: {impulse} for {pressed}");
                }
            }
        }
    }

    #[test]
    fn without_a_solution_the_failure_names_the_best_residual() {
        let mut solver = Checked::wrap(Solver::other(Stubborn(Some(0.0))), Some(Lemke::new(1)), 1e-9);
        let impossible = Lcp::new(&[0.0], &[-4.0]);
        assert_eq!(solver.solve(impossible, &mut [0.0]), Err(Unsolved::NotFound { residual: 1.0 }));
        assert_eq!(solver.counters().failures, 1);
    }
}
