//! Closed forms, the plane as a special case, and what is hard: redundant contacts.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rimbench::friction::space::{SpaceAdmm, SpaceProblem, SpaceSolver};
use rimbench::friction::{ContactSweeps, FrictionProblem, FrictionSolver};
use rimbench::linear_algebra::dot;

/// Writes `w = H P + b`.
fn velocities(problem: SpaceProblem<'_>, impulses: &[f64], w: &mut [f64]) {
    for (row, w) in w.iter_mut().enumerate() {
        *w = problem.b[row] + dot(problem.delassus.row(row), impulses);
    }
}

const G: f64 = 9.81;
const MU: f64 = 0.3;

/// Rows over the velocities of one body, with its inverse masses.
struct Body {
    rows: Vec<[f64; 6]>,
    inverse: [f64; 6],
    friction: Vec<f64>,
}

impl Body {
    /// A body `(ẋ, ω)` with contacts at `arms` over a level floor.
    fn on_floor(mass: f64, inertia: [f64; 3], arms: &[[f64; 3]], mu: f64) -> Self {
        let row = |[x, y, z]: [f64; 3], axis: usize| match axis {
            0 => [0.0, 0.0, 1.0, y, -x, 0.0],
            1 => [1.0, 0.0, 0.0, 0.0, z, -y],
            _ => [0.0, 1.0, 0.0, -z, 0.0, x],
        };
        let rows = (0..3).flat_map(|axis| arms.iter().map(move |arm| row(*arm, axis))).collect();
        let [i_x, i_y, i_z] = inertia.map(|i| 1.0 / i);
        let m = 1.0 / mass;
        Body { rows, inverse: [m, m, m, i_x, i_y, i_z], friction: vec![mu; arms.len()] }
    }

    /// A point of 1 kg with these directions n, t1, t2.
    fn point(directions: [[f64; 3]; 3], mu: f64) -> Self {
        let rows = directions.map(|[x, y, z]| [x, y, z, 0.0, 0.0, 0.0]).to_vec();
        Body { rows, inverse: [1.0; 6], friction: vec![mu] }
    }

    fn h(&self) -> Vec<f64> {
        let product = |a: &[f64; 6], b: &[f64; 6]| (0..6).map(|i| a[i] * self.inverse[i] * b[i]).sum::<f64>();
        self.rows.iter().flat_map(|a| self.rows.iter().map(|b| product(a, b))).collect()
    }

    fn velocities(&self, v: &[f64; 6]) -> Vec<f64> {
        self.rows.iter().map(|row| row.iter().zip(v).map(|(a, v)| a * v).sum()).collect()
    }

    /// Steps under gravity along `down` until `done`, at most for `end` seconds; returns time and velocities.
    fn run(
        &self,
        down: [f64; 3],
        mut v: [f64; 6],
        step: f64,
        end: f64,
        done: impl Fn(&[f64; 6]) -> bool,
    ) -> (f64, [f64; 6]) {
        let h = self.h();
        let mut solver = SpaceSolver::new(self.friction.len(), 1e-9);
        let mut impulses = vec![0.0; self.rows.len()];
        let steps = (end / step).round() as u32;
        for k in 1..=steps {
            for (v, g) in v.iter_mut().zip(down) {
                *v += step * G * g;
            }
            let b = self.velocities(&v);
            solver.solve(SpaceProblem::with_friction(&h, &b, &self.friction), &mut impulses).unwrap();
            for (row, impulse) in self.rows.iter().zip(&impulses) {
                for i in 0..6 {
                    v[i] += self.inverse[i] * row[i] * impulse;
                }
            }
            if done(&v) {
                return (f64::from(k) * step, v);
            }
        }
        (end, v)
    }
}

const DOWN: [f64; 3] = [0.0, 0.0, -1.0];

fn speed(v: &[f64; 6]) -> f64 {
    v[..3].iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// A slope along x with the angle α; the tangents are turned by `turn` about its normal.
fn on_slope(alpha: f64, turn: f64, mu: f64) -> Body {
    let (s, c) = (f64::sin(alpha), f64::cos(alpha));
    let (normal, fall, across) = ([-s, 0.0, c], [c, 0.0, s], [0.0, 1.0, 0.0]);
    let (a, b) = (f64::cos(turn), f64::sin(turn));
    let first = std::array::from_fn(|i| a * fall[i] + b * across[i]);
    let second = std::array::from_fn(|i| a * across[i] - b * fall[i]);
    Body::point([normal, first, second], mu)
}

/// With `μ = tan α` the speed v and its part u down the slope have a constant sum, and
/// `u̇ = g sin α (v₀ − 2u)/(v₀ − u)`, so that `g t sin α = u/2 − (v₀/4) ln(1 − 2u/v₀)`; in the end half of the speed is
/// left, down the slope.
#[test]
fn a_block_launched_across_a_slope_turns_down_and_keeps_half_of_its_speed() {
    let (alpha, v_0, end) = (0.3, 1.0, 0.5);
    let (mut low, mut high) = (0.0, 0.5 * v_0);
    for _ in 0..100 {
        let u = 0.5 * (low + high);
        let time = (0.5 * u - 0.25 * v_0 * f64::ln(1.0 - 2.0 * u / v_0)) / (G * f64::sin(alpha));
        if time < end { low = u } else { high = u }
    }
    let exact = v_0 - low;
    assert!((exact - 0.504_089).abs() < 1e-6, "{exact}");
    let error = |step: f64| {
        let body = on_slope(alpha, 0.7, f64::tan(alpha));
        speed(&body.run(DOWN, [0.0, v_0, 0.0, 0.0, 0.0, 0.0], step, end, |_| false).1) - exact
    };
    let (coarse, fine) = (error(1e-3), error(2.5e-4));
    assert!(coarse.abs() < 1e-3, "{coarse}");
    assert!((coarse / fine - 4.0).abs() < 0.2, "of order 1: {coarse}, {fine}");
    let body = on_slope(alpha, 0.0, f64::tan(alpha));
    let left = speed(&body.run(DOWN, [0.0, v_0, 0.0, 0.0, 0.0, 0.0], 2.5e-4, 8.0, |_| false).1);
    assert!((left - 0.5).abs() < 5e-4, "facets would leave 0.707, 0.541 or 0.510: {left}");
}

/// Four facets whose corners lie along the tangents hold `μ / √2` across them: it would slide where
/// `μ / √2 < tan α < μ`.
#[test]
fn a_block_sticks_whichever_way_its_tangents_are_turned() {
    for degrees in [0.0, 11.25, 22.5, 45.0, 80.0] {
        let body = on_slope(0.25, degrees * std::f64::consts::PI / 180.0, MU);
        let (_, v) = body.run(DOWN, [0.0; 6], 1e-3, 1.0, |_| false);
        assert!(speed(&v) < 1e-12, "{degrees}°: {}", speed(&v));
    }
}

/// A ball slips for `2 |u| / (7 μ g)` and leaves with `v − 2u/7`, u being the velocity of the point that touches; it
/// goes on to spin about the vertical.
#[test]
fn a_ball_that_slips_starts_to_roll_when_and_as_it_should() {
    let (mass, radius, mu) = (50.0, 0.2, 0.2);
    let inertia = 0.4 * mass * radius * radius;
    let ball = Body::on_floor(mass, [inertia; 3], &[[0.0, 0.0, -radius]], mu);
    let start = [2.0, 0.0, 0.0, -6.0, -9.0, 4.0];
    let u = [start[0] - radius * start[4], start[1] + radius * start[3]];
    let slips = 2.0 * (u[0] * u[0] + u[1] * u[1]).sqrt() / (7.0 * mu * G);
    let step = 1e-3;
    let rolls = |v: &[f64; 6]| ball.velocities(v)[1..].iter().all(|w| w.abs() < 1e-9);
    let (time, v) = ball.run(DOWN, start, step, 1.0, rolls);
    assert!(time >= slips && time < slips + step, "{time} s, not {slips}");
    for i in 0..2 {
        assert!((v[i] - (start[i] - 2.0 / 7.0 * u[i])).abs() < 1e-9, "{v:?}");
    }
    assert!((v[5] - 4.0).abs() < 1e-12, "{v:?}");
}

/// Three feet that spin about their centre stop after `I ω / (μ m g r)`, and do not lift.
#[test]
fn a_spinning_tripod_stops_when_it_should() {
    let (mass, radius, inertia, spin) = (300.0, 0.5, 50.0, 2.0);
    let arm = |k: usize| {
        let angle = std::f64::consts::PI * (0.5 + 2.0 * k as f64 / 3.0);
        [radius * f64::cos(angle), radius * f64::sin(angle), -0.4]
    };
    let tripod = Body::on_floor(mass, [31.25, 31.25, inertia], &[arm(0), arm(1), arm(2)], MU);
    let stops = inertia * spin / (MU * mass * G * radius);
    let step = 1e-4;
    let (time, v) = tripod.run(DOWN, [0.0, 0.0, 0.0, 0.0, 0.0, spin], step, 0.5, |v| v[5].abs() < 1e-9);
    assert!(time >= stops - 1e-12 && time < stops + step, "{time} s, not {stops}");
    assert!(v[2].abs() < 1e-9, "the associated law would have lifted it: {v:?}");
}

/// A planar problem with a second tangential row that nothing couples, and its tangents turned, has the planar
/// velocities.
#[test]
fn the_plane_is_a_special_case() {
    let mut rng = Pcg64::seed_from_u64(5);
    for _ in 0..300 {
        let n: usize = rng.random_range(1..=5);
        // A body of 1 kg and 1 kg·m² on feet, low enough that the answer is unique: rows (ẋ, ẏ, ω).
        let arms: Vec<[f64; 2]> = (0..n).map(|_| [rng.random_range(-1.0..1.0), rng.random_range(-0.2..0.2)]).collect();
        let normal = arms.iter().map(|[x, _]| [0.0, 1.0, *x]);
        let planar: Vec<[f64; 3]> = normal.chain(arms.iter().map(|[_, y]| [1.0, 0.0, -y])).collect();
        let entry = |i: usize, j: usize| (0..3).map(|k| planar[i][k] * planar[j][k]).sum::<f64>();
        let h: Vec<f64> = (0..4 * n * n).map(|k| entry(k / (2 * n), k % (2 * n))).collect();
        let v: [f64; 3] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        let b: Vec<f64> = planar.iter().map(|row| row.iter().zip(&v).map(|(a, v)| a * v).sum()).collect();
        let friction = vec![MU; n];
        let (mut p, mut w) = (vec![0.0; 2 * n], vec![0.0; 2 * n]);
        let planar_problem = FrictionProblem::<1>::with_friction(&h, &b, &friction);
        FrictionSolver::new(n, 1e-9).solve(planar_problem, &mut p).unwrap();
        planar_problem.velocities(&p, &mut w);
        let turn: f64 = rng.random_range(0.0..6.0);
        let (c, s) = (f64::cos(turn), f64::sin(turn));
        // Rows t1, t2 = planar tangent times (c, s), plus a row of its own times (−s, c).
        let place = |row: usize| {
            if row < n {
                (row, 1.0, 0.0)
            } else if row < 2 * n {
                (row, c, -s)
            } else {
                (row - n, s, c)
            }
        };
        let size = 3 * n;
        let mut h_3 = vec![0.0; size * size];
        for i in 0..size {
            for j in 0..size {
                let ((row, a, own_a), (column, b, own_b)) = (place(i), place(j));
                let own = if row == column { own_a * own_b } else { 0.0 };
                h_3[i * size + j] = a * b * h[row * 2 * n + column] + own;
            }
        }
        let b_3: Vec<f64> = (0..size).map(|i| place(i).1 * b[place(i).0]).collect();
        let mut p_3 = vec![0.0; size];
        let problem = SpaceProblem::with_friction(&h_3, &b_3, &friction);
        SpaceSolver::new(n, 1e-9).solve(problem, &mut p_3).unwrap();
        let mut w_3 = vec![0.0; size];
        velocities(problem, &p_3, &mut w_3);
        for i in 0..size {
            assert!((w_3[i] - place(i).1 * w[place(i).0]).abs() < 1e-7, "{i}: {w_3:?} is not {w:?}");
        }
    }
}

/// Feet of one body that stick on the border of their cones: the answer is w = 0, known, and redundant.
fn sticking_feet(feet: usize, seed: u64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let mut rng = Pcg64::seed_from_u64(seed);
    let arm = |k: usize| {
        let angle = 2.0 * std::f64::consts::PI * (k as f64 + 0.1) / feet as f64;
        [0.5 * f64::cos(angle), 0.5 * f64::sin(angle), -0.4]
    };
    let body = Body::on_floor(300.0, [31.25, 31.25, 50.0], &(0..feet).map(arm).collect::<Vec<_>>(), MU);
    let h = body.h();
    let mut p = vec![0.0; 3 * feet];
    let angle: f64 = rng.random_range(0.0..6.0);
    for foot in 0..feet {
        p[foot] = rng.random_range(0.01..1.0);
        // All the same way, as in a push that is about to move it.
        p[feet + foot] = (1.0 - 1e-7) * MU * p[foot] * f64::cos(angle);
        p[2 * feet + foot] = (1.0 - 1e-7) * MU * p[foot] * f64::sin(angle);
    }
    let b = h.chunks(3 * feet).map(|row| -dot(row, &p)).collect();
    (h, b, body.friction)
}

#[test]
fn redundant_feet_that_stick_on_the_border_are_solved_where_sweeps_need_thousands() {
    let mut slow = 0;
    for feet in [3, 4, 8, 16] {
        for seed in 0..10 {
            let (h, b, friction) = sticking_feet(feet, seed);
            let problem = SpaceProblem::with_friction(&h, &b, &friction);
            let (mut p, mut w) = (vec![0.0; b.len()], vec![0.0; b.len()]);
            SpaceSolver::new(feet, 1e-9).solve(problem, &mut p).unwrap();
            velocities(problem, &p, &mut w);
            let scale = problem.scale();
            assert!(w.iter().all(|w| w.abs() <= 1e-7 * scale), "{feet} feet, {seed}: {w:?}");
            p.fill(0.0);
            let (sweeps, _) = ContactSweeps::<2>::new(feet).sweep(problem, 1e-9, 2000, &mut p);
            slow += usize::from(sweeps == 2000);
        }
    }
    assert!(slow >= 4, "{slow} of 40 are slow for sweeps alone");
}

/// Four feet that slide with spin, all loaded: which of a family of velocities is found depends on where the solver
/// starts. In the plane velocities are unique; in space they are not.
#[test]
fn velocities_of_redundant_feet_that_slide_with_spin_are_not_unique() {
    let arms = [[0.0, 0.5, -0.4], [-0.5, 0.0, -0.4], [0.0, -0.5, -0.4], [0.5, 0.0, -0.4]];
    let body = Body::on_floor(300.0, [31.25, 31.25, 50.0], &arms, MU);
    let (h, b) = (body.h(), body.velocities(&[-0.22, -0.02, -0.065, 0.0, 0.01, 0.03]));
    let problem = SpaceProblem::with_friction(&h, &b, &body.friction);
    let mut found = Vec::new();
    // The load can move from one diagonal to the other.
    for start in [[0.0; 4], [8.0, 2.0, 8.0, 2.0]] {
        let mut newton = SpaceSolver::new(4, 1e-9);
        newton.solver.start_from(&[start, [0.0; 4], [0.0; 4]].concat());
        let (mut p, mut w) = (vec![0.0; 12], vec![0.0; 12]);
        assert!(newton.solve(problem, &mut p).unwrap().residual <= 1e-10);
        velocities(problem, &p, &mut w);
        found.push(w);
    }
    let differ = (0..12).map(|i| (found[0][i] - found[1][i]).abs()).collect::<Vec<_>>();
    assert!(differ[..4].iter().all(|d| *d < 1e-10), "all are closed: {differ:?}");
    assert!(differ[4..].iter().any(|d| *d > 1e-5), "{differ:?}");
}

/// The same feet on springs of 1e7 N/m and dampers of 1e5 N·s/m over 0.1 ms: every method finds one answer.
#[test]
fn velocities_of_redundant_feet_that_give_way_are_unique() {
    let arms = [[0.0, 0.5, -0.4], [-0.5, 0.0, -0.4], [0.0, -0.5, -0.4], [0.5, 0.0, -0.4]];
    let body = Body::on_floor(300.0, [31.25, 31.25, 50.0], &arms, MU);
    let (mut h, b) = (body.h(), body.velocities(&[-0.22, -0.02, -0.065, 0.0, 0.01, 0.03]));
    (0..4).for_each(|contact| h[13 * contact] += 1.0 / (1e-4 * (1e-4 * 1e7 + 1e5)));
    let problem = SpaceProblem::with_friction(&h, &b, &body.friction);
    let mut found = Vec::new();
    for start in [[0.0; 4], [8.0, 2.0, 8.0, 2.0], [2.0, 8.0, 2.0, 8.0]] {
        let start = [start, [0.0; 4], [0.0; 4]].concat();
        let mut newton = SpaceSolver::new(4, 1e-12);
        newton.solver.start_from(&start);
        let mut p = vec![0.0; 12];
        newton.solve(problem, &mut p).unwrap();
        let mut swept = start.clone();
        assert!(ContactSweeps::<2>::new(4).sweep(problem, 1e-12, 10_000, &mut swept).1 <= 1e-12);
        found.extend([p, swept]);
    }
    for other in &found[1..] {
        let differ = other.iter().zip(&found[0]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(differ < 1e-8, "{differ} N·s");
    }
}

/// One contact has a unique answer; what the scalar equation of the sweeps finds is what Newton and ADMM find.
#[test]
fn the_three_methods_agree_where_the_answer_is_unique() {
    let mut rng = Pcg64::seed_from_u64(7);
    for turn in 0..500 {
        let a: [[f64; 3]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        let h: Vec<f64> = (0..9)
            .map(|k| (0..3).map(|i| a[k / 3][i] * a[k % 3][i]).sum::<f64>() + if k / 3 == k % 3 { 0.3 } else { 0.0 })
            .collect();
        let b: [f64; 3] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        let friction = [if turn % 5 == 0 { 0.0 } else { rng.random_range(0.0..0.2) }];
        let problem = SpaceProblem::with_friction(&h, &b, &friction);
        let (mut newton, mut swept, mut split) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        SpaceSolver::new(1, 1e-9).solve(problem, &mut newton).unwrap();
        let (sweeps, residual) = ContactSweeps::<2>::new(1).sweep(problem, 1e-12, 3, &mut swept);
        assert!(sweeps <= 1 && residual <= 1e-12, "{turn}: {sweeps} sweeps, {residual}");
        let (_, _, residual) = SpaceAdmm::new(1).iterate(problem, 1e-10, 5000, &mut split);
        assert!(residual <= 1e-10, "{turn}: {residual}");
        for i in 0..3 {
            assert!((newton[i] - swept[i]).abs() < 1e-7 && (split[i] - swept[i]).abs() < 1e-7, "{turn}");
        }
    }
}

#[test]
fn what_is_not_finite_is_said_and_no_answer_is_a_failure() {
    let h: Vec<f64> = (0..9).map(|k| if k / 3 == k % 3 { 2.0 } else { 0.0 }).collect();
    let mut solver = SpaceSolver::new(1, 1e-9);
    let problem = |b| SpaceProblem::with_friction(&h, b, &[MU]);
    assert_eq!(
        solver.solve(problem(&[-1.0, f64::NAN, 0.0]), &mut [0.0; 3]),
        Err(rimbench::complementarity::Unsolved::NonFinite)
    );
    assert_eq!(solver.solve(problem(&[1.0, 5.0, 0.0]), &mut [0.0; 3]).unwrap().pivots, 0);
    let zeros = SpaceProblem::with_friction(&[0.0; 9], &[-1.0, 0.0, 0.0], &[MU]);
    assert!(solver.solve(zeros, &mut [0.0; 3]).is_err(), "nothing stops it");
    assert_eq!((solver.counters().solves, solver.counters().failures), (3, 2));
}
