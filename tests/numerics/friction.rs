//! Contact problems with Coulomb friction: closed forms, and all methods against each other.
//!
//! Impulses of redundant contacts are not unique; what is compared is what is: velocities and the resultant.

use crate::support::*;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rimbench::complementarity::{Lcp, SolveStats, Unsolved};
use rimbench::friction::{
    ActiveStates, ContactState, ContactSweeps, CopositiveLemke, ENUMERATION_LIMIT, Enumeration, FrictionProblem,
    FrictionSolution, FrictionSolver,
};

use ContactState::{Open, SlipNegative, SlipPositive, Stick};

/// What a solution by elimination leaves: a few roundings per row.
const ROUND_OFF: f64 = 1e-13;

/// Rows of contacts on bodies with unit-free masses, by which everything about a problem is known.
#[derive(Debug, Clone)]
struct Bodies {
    /// `A`, normal rows first.
    rows: Vec<Vec<f64>>,
    h: Vec<f64>,
    b: Vec<f64>,
    friction: Vec<f64>,
}

impl Bodies {
    fn new(rows: Vec<Vec<f64>>, mass: &[f64], v: &[f64], friction: &[f64]) -> Self {
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).zip(mass).map(|((a, b), m)| a * b / m).sum::<f64>();
        let h = rows.iter().flat_map(|a| rows.iter().map(|b| product(a, b))).collect();
        let b = rows.iter().map(|a| a.iter().zip(v).map(|(a, v)| a * v).sum()).collect();
        Bodies { rows, h, b, friction: friction.to_vec() }
    }

    fn problem(&self) -> FrictionProblem<'_> {
        FrictionProblem::with_friction(&self.h, &self.b, &self.friction)
    }

    fn w(&self, impulses: &[f64]) -> Vec<f64> {
        let mut w = vec![0.0; self.b.len()];
        self.problem().velocities(impulses, &mut w);
        w
    }

    fn resultant(&self, impulses: &[f64]) -> Vec<f64> {
        let columns = self.rows[0].len();
        (0..columns).map(|j| self.rows.iter().zip(impulses).map(|(row, p)| row[j] * p).sum()).collect()
    }
}

/// A planar body `(ẋ, ẏ, ω)` of mass 1 with contacts at arms `(x, y)` over a level floor.
fn on_floor(arms: &[[f64; 2]], inertia: f64, v: [f64; 3], mu: f64) -> Bodies {
    let normal = arms.iter().map(|[x, _]| vec![0.0, 1.0, *x]);
    let tangential = arms.iter().map(|[_, y]| vec![1.0, 0.0, -y]);
    Bodies::new(normal.chain(tangential).collect(), &[1.0, 1.0, inertia], &v, &vec![mu; arms.len()])
}

fn solved(problem: FrictionProblem<'_>) -> (Vec<ContactState>, Vec<f64>) {
    let n = problem.contacts();
    let mut solver = FrictionSolver::new(n, 1e-9);
    let mut impulses = vec![f64::NAN; 2 * n];
    let stats = solver.solve(problem, &mut impulses).unwrap();
    assert!(stats.residual <= ROUND_OFF, "{}", stats.residual);
    (solver.solver.states().to_vec(), impulses)
}

/// The rod of Painlevé: uniform, of half length 1 and mass 1, its tip on the floor at tan θ = 2, sliding so that
/// friction digs it in.
fn rod(mu: f64, w_n: f64) -> Bodies {
    let angle = 2.0_f64.atan();
    let (x, y) = (-angle.cos(), -angle.sin());
    let mut rod = on_floor(&[[x, y]], 1.0 / 3.0, [0.0; 3], mu);
    // With H_nt below 0 it is sliding backwards that digs in.
    let digs_in = rod.h[1].signum();
    rod.b = vec![w_n, digs_in];
    rod
}

#[test]
fn the_rod_of_painleve_must_have_one_solution_below_four_thirds_and_three_above() {
    let critical = rod(1.0, 0.0);
    let mu_p = critical.h[0] / critical.h[1].abs();
    // (1 + 3 cos²θ)/(3 sin θ cos θ), and its least value over all angles.
    assert!((mu_p - 4.0 / 3.0).abs() <= 8.0 * f64::EPSILON, "{mu_p}");
    for (mu, count) in [(1.2, 1), (4.0 / 3.0 - 1e-6, 1), (4.0 / 3.0 + 1e-6, 3), (1.5, 3)] {
        // The tip is about to leave, slowly enough that friction that pushes it in does not turn it round first.
        let rod = rod(mu, 1e-3 * (1.0 - 0.75 * mu).abs());
        let solutions = Enumeration::new(1).solutions(rod.problem(), ROUND_OFF).unwrap();
        let states: Vec<_> = solutions.iter().map(|solution| solution.states[0]).collect();
        assert_eq!(states.len(), count, "μ = {mu}: {states:?}");
        assert_eq!(states[0], Open);
        if count == 3 {
            // It jams, or it is pushed in by its own friction.
            assert_eq!(states[1], Stick);
            assert!(matches!(states[2], SlipPositive | SlipNegative));
            assert!(solutions[1..].iter().all(|solution| solution.impulses[0] > 0.0));
        }
        // Nothing that pushes is wanted where nothing needs to.
        assert_eq!(solved(rod.problem()).0, [Open]);
    }
    // Pressed down it has one solution on either side, and beyond the coefficient it cannot slide.
    for (mu, state) in [(1.2, false), (1.5, true)] {
        let (states, _) = solved(rod(mu, -1e-3).problem());
        assert_eq!(states == [Stick], state, "μ = {mu}: {states:?}");
    }
}

#[test]
fn a_problem_in_which_friction_alone_must_push_apart_what_it_presses_together_has_no_answer() {
    // A tip that can move along one line only, down and forwards in one: no impulse within the cone lifts it.
    let jam = Bodies::new(vec![vec![1.0], vec![2.0]], &[1.0], &[-1.0], &[1.0]);
    assert!(jam.h[0] < jam.h[1].abs(), "beyond the coefficient of Painlevé");
    let (_, p) = solved(jam.problem());
    assert!(jam.w(&p).iter().all(|w| w.abs() <= ROUND_OFF), "pushed along its line it stops: {p:?}");
    // The same with a gap term that wants it to open by more than its tangential row allows.
    let impossible = FrictionProblem::with_friction(&jam.h, &[-1.0, 2.0], &[1.0]);
    let mut impulses = [0.0; 2];
    let failed = FrictionSolver::new(1, 1e-9).solve(impossible, &mut impulses);
    assert!(matches!(failed, Err(Unsolved::NotFound { residual }) if residual > 1e-3), "{failed:?}");
    let undefined = FrictionProblem::with_friction(&jam.h, &[f64::NAN, 2.0], &[1.0]);
    assert_eq!(FrictionSolver::new(1, 1e-9).solve(undefined, &mut impulses), Err(Unsolved::NonFinite));
}

/// Contacts at random places of two bodies, against each other and against the ground.
fn random_bodies(rng: &mut Pcg64, contacts: usize) -> Bodies {
    let mut draw = |low: f64, high: f64| rng.random_range(low..high);
    let (mut normal, mut tangential) = (Vec::new(), Vec::new());
    for contact in 0..contacts {
        let angle = draw(-0.6, 0.6);
        let direction = [angle.sin(), angle.cos()];
        let along = [direction[1], -direction[0]];
        let arms = [[draw(-1.0, 1.0), draw(-1.0, 0.0)], [draw(-1.0, 1.0), draw(0.0, 1.0)]];
        let part =
            |[x, y]: [f64; 2], [n_x, n_y]: [f64; 2], sign: f64| [sign * n_x, sign * n_y, sign * (x * n_y - y * n_x)];
        let row = |direction: [f64; 2]| {
            let upper = part(arms[0], direction, 1.0);
            // The first contacts are between the bodies, the others of one of them with the ground.
            match contact % 3 {
                0 => [upper, part(arms[1], direction, -1.0)].concat(),
                1 => [[0.0; 3], upper].concat(),
                _ => [upper, [0.0; 3]].concat(),
            }
        };
        normal.push(row(direction));
        tangential.push(row(along));
    }
    let mass: Vec<f64> = [1.0, 1.0, 0.4, 3.0, 3.0, 0.5].map(|m| m * draw(0.5, 2.0)).to_vec();
    let v: Vec<f64> = (0..6).map(|i| draw(-1.0, 1.0) - if i % 3 == 1 { 1.0 } else { 0.0 }).collect();
    let friction: Vec<f64> = (0..contacts).map(|_| draw(0.0, 0.7)).collect();
    Bodies::new([normal, tangential].concat(), &mass, &v, &friction)
}

fn assert_same(name: &str, bodies: &Bodies, found: &[f64], expected: &[f64], tolerance: f64) {
    let pairs = [(bodies.w(found), bodies.w(expected)), (bodies.resultant(found), bodies.resultant(expected))];
    for (found, expected) in pairs {
        let scale = expected.iter().fold(1.0, |max: f64, x| max.max(x.abs()));
        for (f, e) in found.iter().zip(&expected) {
            assert!((f - e).abs() <= tolerance * scale, "{name}: {found:?}, not {expected:?}");
        }
    }
}

/// Whether solutions differ in what is unique where there is one.
fn several(bodies: &Bodies, solutions: &[FrictionSolution]) -> bool {
    let w = bodies.w(&solutions[0].impulses);
    let same = |p: &[f64]| bodies.w(p).iter().zip(&w).all(|(a, b)| (a - b).abs() <= 1e-8);
    !solutions.iter().all(|solution| same(&solution.impulses))
}

#[test]
fn all_methods_must_find_the_same_velocities_and_resultant_where_there_is_one_solution() {
    let mut rng = Pcg64::seed_from_u64(16);
    let (mut unique, mut warm, mut swept) = (0, 0, 0);
    for problem in 0..400 {
        let n = 1 + problem % ENUMERATION_LIMIT;
        let bodies = random_bodies(&mut rng, n);
        let solutions = Enumeration::new(n).solutions(bodies.problem(), 1e-11).unwrap();
        assert!(!solutions.is_empty(), "a copositive problem without gap terms has a solution");
        let (mut states, mut impulses) = (vec![Open; n], vec![0.0; 2 * n]);
        // Lemke's promise holds however many there are.
        CopositiveLemke::new(n).attempt(bodies.problem(), &mut states, &mut impulses).unwrap();
        assert!(bodies.problem().natural_residual(&impulses) <= 1e-10, "{bodies:?}");
        let wanted = &solutions[0].impulses;
        if several(&bodies, &solutions) {
            continue;
        }
        unique += 1;
        // Solutions by elimination, their rows conditioned up to about 1e4.
        assert_same("lemke", &bodies, &impulses, wanted, 1e-9);
        assert_same("solver", &bodies, &solved_any(&bodies), wanted, 1e-9);
        if ActiveStates::new(n).attempt(bodies.problem(), false, &mut vec![Open; n], &mut impulses).is_ok() {
            assert_same("active states", &bodies, &impulses, wanted, 1e-9);
            warm += 1;
        }
        // These stop at a residual; a direction that hardly moves anything may be off by so many times more.
        impulses.fill(0.0);
        if ContactSweeps::<1>::new(n).sweep(bodies.problem(), 1e-13, 5000, &mut impulses).1 <= 1e-13 {
            assert_same("sweeps", &bodies, &impulses, wanted, 1e-7);
            swept += 1;
        }
    }
    assert!(unique >= 350 && warm >= unique * 8 / 10 && swept >= unique / 2);
}

fn solved_any(bodies: &Bodies) -> Vec<f64> {
    let n = bodies.friction.len();
    let mut impulses = vec![0.0; 2 * n];
    FrictionSolver::new(n, 1e-9).solve(bodies.problem(), &mut impulses).unwrap();
    impulses
}

#[test]
fn without_friction_the_problem_must_be_the_linear_complementarity_problem_of_its_normal_rows() {
    let mut rng = Pcg64::seed_from_u64(17);
    for _ in 0..50 {
        let mut bodies = random_bodies(&mut rng, 4);
        bodies.friction.fill(0.0);
        let normal: Vec<f64> = (0..4).flat_map(|row| bodies.h[8 * row..8 * row + 4].to_vec()).collect();
        let mut z = vec![0.0; 4];
        solver().checked(4).solve(Lcp::new(&normal, &bodies.b[..4]), &mut z).unwrap();
        z.extend([0.0; 4]);
        assert_same("frictionless", &bodies, &solved_any(&bodies), &z, 1e-9);
    }
}

#[test]
fn two_corners_of_a_block_must_share_a_push_that_neither_can_take_alone() {
    // Level block on two corners, pushed with more than one corner's friction and less than both: the tangential rows
    // are dependent.
    let block = on_floor(&[[-0.5, -0.2], [0.5, -0.2]], 0.3, [0.3, -1.0, 0.0], 0.4);
    let (states, p) = solved(block.problem());
    assert!(block.w(&p).iter().all(|w| w.abs() <= ROUND_OFF), "it stands still");
    assert!((p[2] + p[3] + 0.3).abs() <= ROUND_OFF && (p[0] + p[1] - 1.0).abs() <= ROUND_OFF);
    assert!(states.iter().all(|state| *state != Open), "{states:?}");
}

#[test]
fn the_states_of_the_last_problem_must_solve_the_next_in_one_go() {
    let block = |push: f64| on_floor(&[[-0.5, -0.2], [0.5, -0.1]], 0.3, [push, -1.0, 0.1], 0.4);
    let (mut solver, mut impulses) = (FrictionSolver::new(2, 1e-9), [0.0; 4]);
    for push in [0.9, 0.91, 0.92] {
        let stats = solver.solve(block(push).problem(), &mut impulses).unwrap();
        assert_eq!(stats.pivots == 0, push != 0.9, "{push}");
        assert!(stats.residual <= ROUND_OFF && !stats.fallback);
    }
    let counters = solver.counters();
    assert_eq!((counters.solves, counters.fallbacks, counters.failures), (3, 0, 0));
    assert!(counters.worst_residual <= ROUND_OFF);
}

#[test]
fn the_worst_violation_of_a_contact_must_decide_and_not_the_one_that_is_looked_at_first() {
    // Two points apart: the first touches with a pull of round-off and slides backwards, the second is pressed.
    let h = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]].concat();
    let points = FrictionProblem::with_friction(&h, &[1e-13, -1.0, -1.0, 0.0], &[0.5, 0.5]);
    let (mut states, mut impulses) = ([SlipPositive, Stick], [0.0; 4]);
    let stats = ActiveStates::new(2).attempt(points, false, &mut states, &mut impulses).unwrap();
    assert!(stats.pivots > 0 && states[0] != SlipPositive, "it does not slide forwards: {states:?}");
    assert!(points.natural_residual(&impulses) <= 1e-12);
}

#[test]
fn the_states_that_a_method_reports_must_be_those_of_its_impulses() {
    let mut rng = Pcg64::seed_from_u64(17);
    let mut degenerate = 0;
    for problem in 0..600 {
        let n = 1 + problem % ENUMERATION_LIMIT;
        let mut bodies = random_bodies(&mut rng, n);
        if problem % 3 == 0 {
            // Contacts that only just touch, and twice the same one: bases with zeros in them.
            bodies.b[0] = 0.0;
            if n > 1 {
                for (to, from) in [(1, 0), (n + 1, n)] {
                    bodies.rows[to] = bodies.rows[from].clone();
                    bodies.b[to] = bodies.b[from];
                    (0..2 * n).for_each(|k| bodies.h[to * 2 * n + k] = bodies.h[from * 2 * n + k]);
                    (0..2 * n).for_each(|k| bodies.h[k * 2 * n + to] = bodies.h[k * 2 * n + from]);
                }
                bodies.friction[1] = bodies.friction[0];
            }
            degenerate += 1;
        }
        let problem = bodies.problem();
        let (mut states, mut impulses) = (vec![Open; n], vec![0.0; 2 * n]);
        let check = |name: &str, found: Result<SolveStats, Unsolved>, states: &[ContactState], impulses: &[f64]| {
            if found.is_err() || problem.natural_residual(impulses) > 1e-9 {
                return;
            }
            let scale = impulses.iter().fold(1e-300, |max: f64, p| max.max(p.abs()));
            for (c, state) in states.iter().enumerate() {
                let (p_n, p_t, mu) = (impulses[c], impulses[n + c], problem.cone.friction[c]);
                let off = match state {
                    Open => p_n.abs() + p_t.abs(),
                    Stick => (p_t.abs() - mu * p_n).max(0.0),
                    slips => (p_t - slips.friction() * mu * p_n).abs(),
                };
                assert!(off <= 1e-8 * scale, "{name}: {state:?} with {p_n:e}, {p_t:e} at μ = {mu}");
            }
        };
        let found = CopositiveLemke::new(n).attempt(problem, &mut states, &mut impulses);
        check("Lemke", found, &states, &impulses);
        let found = Enumeration::new(n).attempt(problem, 1e-11, &mut states, &mut impulses);
        check("enumeration", found, &states, &impulses);
        states.fill(Open);
        let found = ActiveStates::new(n).attempt(problem, false, &mut states, &mut impulses);
        check("active states", found, &states, &impulses);
    }
    assert_eq!(degenerate, 200);
}

#[test]
fn a_matrix_that_stays_must_be_factorised_once_per_combination_of_states() {
    let block = on_floor(&[[-0.5, -0.2], [0.5, -0.1]], 0.3, [0.1, -1.0, 0.1], 0.4);
    let (mut solver, mut impulses) = (FrictionSolver::new(2, 1e-9), [0.0; 4]);
    let first = solver.solve(block.problem(), &mut impulses).unwrap();
    assert_eq!(first.factorisations, first.pivots + 1);
    for push in [0.11, 0.12, 0.13] {
        let mut pushed = block.clone();
        pushed.b = on_floor(&[[-0.5, -0.2], [0.5, -0.1]], 0.3, [push, -1.0, 0.1], 0.4).b;
        let stats = solver.solve_again(pushed.problem(), &mut impulses).unwrap();
        assert_eq!((stats.pivots, stats.factorisations), (0, 0), "{push}");
        assert!(stats.residual <= ROUND_OFF);
    }
    // Another matrix with the same states is another matrix.
    let heavier = on_floor(&[[-0.5, -0.2], [0.5, -0.1]], 0.9, [0.13, -1.0, 0.1], 0.4);
    let stats = solver.solve(heavier.problem(), &mut impulses).unwrap();
    assert_eq!(stats.factorisations, stats.pivots + 1);
    assert!(stats.residual <= ROUND_OFF && !stats.fallback);
}

#[test]
fn a_coefficient_that_changes_must_be_seen_where_states_and_matrix_stay() {
    let block = |mu: f64| on_floor(&[[-0.5, -0.2], [0.5, -0.2]], 0.3, [3.0, -1.0, 0.0], mu);
    let (mut solver, mut impulses) = (FrictionSolver::new(2, 1e-9), [0.0; 4]);
    for mu in [0.0, 0.3, 0.1] {
        let stats = solver.solve(block(mu).problem(), &mut impulses).unwrap();
        assert!(stats.residual <= ROUND_OFF && !stats.fallback, "μ = {mu}: {stats:?}");
        assert!((impulses[2] + impulses[3] + mu).abs() <= ROUND_OFF, "μ = {mu}: {impulses:?}");
    }
}

/// The relaxed problem as a quadratic program over the cone itself, for an interior-point solver that shares nothing
/// with ours:
///
/// ```text
/// min ½ Pᵀ H P + (b + [s; 0])ᵀ P        μ P_n ± P_t ≥ 0,  P_n ≥ 0
/// ```
/// None where it does not come to its end.
fn by_cone_program(bodies: &Bodies, lifted: &[f64]) -> Option<Vec<f64>> {
    let n = bodies.friction.len();
    let upper = |columns: usize| (0..columns).flat_map(|j| (0..=j).map(move |i| (i, j)));
    let starts = (0..=2 * n).map(|j| j * (j + 1) / 2).collect();
    let rows = upper(2 * n).map(|(i, _)| i).collect();
    let h = CscMatrix::new(2 * n, 2 * n, starts, rows, upper(2 * n).map(|(i, j)| bodies.h[i * 2 * n + j]).collect());
    // Column by column of [−μ −1; −μ 1; −1 0].
    let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for column in 0..2 * n {
        let (c, of_normal) = (column % n, column < n);
        let entries = if of_normal { [-bodies.friction[c], -bodies.friction[c], -1.0] } else { [-1.0, 1.0, 0.0] };
        for (block, entry) in entries.into_iter().enumerate().take(if of_normal { 3 } else { 2 }) {
            rows.push(block * n + c);
            values.push(entry);
        }
        starts.push(rows.len());
    }
    let cone = CscMatrix::new(3 * n, 2 * n, starts, rows, values);
    let shift = lifted.iter().copied().chain(std::iter::repeat_n(0.0, n));
    let q: Vec<f64> = bodies.b.iter().zip(shift).map(|(b, s)| b + s).collect();
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-12,
        tol_gap_rel: 1e-12,
        tol_feas: 1e-10,
        ..DefaultSettings::default()
    };
    let mut solver = DefaultSolver::new(&h, &q, &cone, &vec![0.0; 3 * n], &[NonnegativeConeT(3 * n)], settings).ok()?;
    solver.solve();
    (solver.solution.status == SolverStatus::Solved).then(|| solver.solution.x.clone())
}

/// Coulomb's law as the fixed point of such programs: what slides is lifted by `μ |w_t|`, so that is taken back
/// beforehand.
fn by_cone_programs(bodies: &Bodies) -> Option<Vec<f64>> {
    let n = bodies.friction.len();
    let mut lifted = vec![0.0; n];
    for _ in 0..300 {
        let impulses = by_cone_program(bodies, &lifted)?;
        let w = bodies.w(&impulses);
        let next: Vec<f64> = (0..n).map(|c| bodies.friction[c] * w[n + c].abs()).collect();
        let change = next.iter().zip(&lifted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        lifted = next;
        // The root of a gap of 1e-12 is what an interior point leaves of a velocity where a contact is degenerate.
        if change <= 1e-7 {
            return Some(impulses);
        }
    }
    None
}

#[test]
fn a_fixed_point_of_convex_programs_solved_by_another_library_must_be_what_the_solver_finds() {
    let mut rng = Pcg64::seed_from_u64(24);
    let feet = [[-0.5, -0.2], [0.5, -0.1]];
    let mut problems = vec![
        on_floor(&[[0.0, -0.5]], 0.5, [1.0, -1.0, 0.0], 0.3),
        on_floor(&[[0.0, -0.5]], 0.5, [0.1, -1.0, 0.0], 0.3),
        on_floor(&feet, 0.3, [0.9, -1.0, 0.1], 0.4),
        on_floor(&feet, 0.3, [0.3, -1.0, 0.0], 0.4),
        on_floor(&[[-0.5, -0.2], [0.5, -0.2]], 0.3, [3.0, -1.0, 0.0], 0.1),
    ];
    let by_hand = problems.len();
    problems.extend((0..120).map(|problem| random_bodies(&mut rng, 1 + problem % ENUMERATION_LIMIT)));
    let (mut unique, mut found) = (0, 0);
    for (index, bodies) in problems.iter().enumerate() {
        let n = bodies.friction.len();
        let solutions = Enumeration::new(n).solutions(bodies.problem(), 1e-11).unwrap();
        if several(bodies, &solutions) {
            assert!(index >= by_hand);
            continue;
        }
        unique += 1;
        let program = by_cone_programs(bodies);
        assert!(program.is_some() || index >= by_hand, "{bodies:?}");
        if let Some(impulses) = program {
            // The root of the gap, and what the iteration and a direction that hardly moves anything make of it.
            assert_same("another library", bodies, &solved_any(bodies), &impulses, 1e-4);
            found += 1;
        }
    }
    assert!(unique >= 110 && found >= unique * 8 / 10, "{found} of {unique}");
}
