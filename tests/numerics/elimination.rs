//! Eq. 3 → Eq. 4 against the full saddle-point matrix of Eq. 3, factored densely; and the effective mass.

use crate::support::*;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Eq. 3 at one state, with the contacts that are active and the force at the interface.
struct Problem {
    eq3: Linearisation,
    v: Vec<f64>,
    h: f64,
    stabilisation: f64,
    force: Vec<f64>,
    active: Vec<usize>,
}

/// What the dense solution says, and how well the problem is conditioned.
struct Dense {
    velocity: DVector<f64>,
    bilateral_impulses: DVector<f64>,
    contact_impulses: DVector<f64>,
    h: DMatrix<f64>,
    a: DVector<f64>,
    w: DVector<f64>,
    /// Largest force and free acceleration of a coordinate.
    force_scale: f64,
    acceleration_scale: f64,
    /// Rounding errors that two backward stable ways may differ by, relative to the size of what is compared.
    tolerance: f64,
}

fn matrix(rows: &Rows, columns: usize) -> DMatrix<f64> {
    DMatrix::from_row_slice(rows.len(), columns, &rows.jacobian)
}

fn mass(eq3: &Linearisation) -> DMatrix<f64> {
    let n = eq3.velocities();
    match &eq3.mass {
        MassMatrix::Diagonal(diagonal) => DMatrix::from_diagonal(&DVector::from_column_slice(diagonal)),
        MassMatrix::Dense(dense) => DMatrix::from_row_slice(n, n, dense),
    }
}

fn stack(rows: &[&DMatrix<f64>]) -> DMatrix<f64> {
    let columns = rows[0].ncols();
    let mut out = DMatrix::zeros(rows.iter().map(|block| block.nrows()).sum(), columns);
    let mut at = 0;
    for block in rows {
        out.rows_mut(at, block.nrows()).copy_from(block);
        at += block.nrows();
    }
    out
}

fn condition(matrix: &DMatrix<f64>) -> f64 {
    if matrix.is_empty() {
        return 1.0;
    }
    let values = matrix.clone().singular_values();
    values.max() / values.min()
}

/// `[M −Aᵀ; A 0]`
fn saddle_point(mass: &DMatrix<f64>, rows: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, m) = (mass.nrows(), rows.nrows());
    let mut out = DMatrix::zeros(n + m, n + m);
    out.view_mut((0, 0), (n, n)).copy_from(mass);
    out.view_mut((0, n), (n, m)).copy_from(&-rows.transpose());
    out.view_mut((n, 0), (m, n)).copy_from(rows);
    out
}

fn solve_dense(problem: &Problem) -> Dense {
    let Problem { eq3, h, .. } = problem;
    let n = eq3.velocities();
    let v = DVector::from_column_slice(&problem.v);
    let (m, f) = (mass(eq3), DVector::from_column_slice(&eq3.force));
    let a_b = matrix(&eq3.bilateral, n);
    let (a_u, a_i) = (matrix(&eq3.unilateral, n), matrix(&eq3.interface, n));
    let a_c = a_u.select_rows(&problem.active);
    let convective = |rows: &Rows| DVector::from_column_slice(&rows.convective);
    let joint_start = -problem.stabilisation / h * DVector::from_column_slice(&eq3.bilateral.position);

    // Velocities and all impulses at once: M v⁺ − A_bᵀ P_b − A_cᵀ P_c = M v + h f + h A_iᵀ λ.
    let rows = stack(&[&a_b, &a_c]);
    let full = saddle_point(&m, &rows);
    let (n_b, n_c) = (a_b.nrows(), a_c.nrows());
    let mut right = DVector::zeros(n + n_b + n_c);
    let pushed = &m * &v + *h * (&f + a_i.transpose() * DVector::from_column_slice(&problem.force));
    right.rows_mut(0, n).copy_from(&pushed);
    right.rows_mut(n, n_b).copy_from(&(&joint_start - *h * convective(&eq3.bilateral)));
    for (slot, &contact) in problem.active.iter().enumerate() {
        right[n + n_b + slot] = -h * eq3.unilateral.convective[contact];
    }
    let solution = full.lu().solve(&right).unwrap();

    // H, a, w: unit impulses, free motion and start velocity of the same system with the joints alone.
    let joints = saddle_point(&m, &a_b);
    let lu = joints.lu();
    let solve = |top: &DVector<f64>, bottom: &DVector<f64>| -> DVector<f64> {
        let mut right = DVector::zeros(n + n_b);
        right.rows_mut(0, n).copy_from(top);
        right.rows_mut(n, n_b).copy_from(bottom);
        lu.solve(&right).unwrap().rows(0, n).into_owned()
    };
    let a_x = stack(&[&a_u, &a_i]);
    let none = DVector::zeros(n_b);
    let mut response = DMatrix::zeros(n, a_x.nrows());
    for row in 0..a_x.nrows() {
        response.set_column(row, &solve(&a_x.row(row).transpose(), &none));
    }
    let mut a = &a_x * solve(&f, &-convective(&eq3.bilateral));
    for (a, c) in a.iter_mut().zip(eq3.unilateral.convective.iter().chain(&eq3.interface.convective)) {
        *a += c;
    }
    // Forward error of a backward stable solution: size × ε × condition. Eliminating through S = A M⁻¹ Aᵀ squares what
    // the rows contribute, hence κ(M) κ(S) beside κ of the full matrix. Units do not matter to either way, so the
    // conditions are those of the matrices scaled to diag(M) = 1 and rows of length 1; the spread of diag(M)^½ leads
    // back. 8 is the usual safety on such bounds.
    let minv = m.clone().try_inverse().unwrap();
    let scale = m.diagonal().map(|mass| 1.0 / mass.sqrt());
    let scaled = DMatrix::from_fn(n, n, |i, j| scale[i] * m[(i, j)] * scale[j]);
    let mut unit = DMatrix::from_fn(rows.nrows(), n, |i, j| rows[(i, j)] * scale[j]);
    for mut row in unit.row_iter_mut() {
        row.normalize_mut();
    }
    let schur = &unit * scaled.clone().try_inverse().unwrap() * unit.transpose();
    let applied = &f + a_i.transpose() * DVector::from_column_slice(&problem.force);
    let spread = scale.max() / scale.min();
    let amplification = spread * (condition(&saddle_point(&scaled, &unit)) + condition(&scaled) * condition(&schur));
    Dense {
        velocity: solution.rows(0, n).into_owned(),
        bilateral_impulses: solution.rows(n, n_b).into_owned(),
        contact_impulses: solution.rows(n + n_b, n_c).into_owned(),
        force_scale: applied.amax(),
        acceleration_scale: (minv * applied).amax(),
        h: &a_x * response,
        a,
        w: &a_x * solve(&(&m * &v), &joint_start),
        tolerance: 8.0 * (n + n_b + n_c) as f64 * f64::EPSILON * amplification,
    }
}

/// Largest error relative to its tolerance; 1 is the limit.
fn compare(problem: &Problem) -> (f64, f64) {
    let dense = solve_dense(problem);
    let (mut elimination, model) = reduce(&problem.eq3, &problem.v, problem.h, problem.stabilisation);
    let (n_u, n_c) = (model.contacts(), problem.active.len());
    // Contact impulses of the reduced model: w_c + h a_c + H_cc P_c + H_ci h λ = 0.
    let h_cc = DMatrix::from_fn(n_c, n_c, |i, j| model.entry(problem.active[i], problem.active[j]));
    let b = DVector::from_fn(n_c, |i, _| {
        let row = problem.active[i];
        let interface: f64 =
            problem.force.iter().enumerate().map(|(j, force)| model.entry(row, n_u + j) * problem.h * force).sum();
        model.w[row] + problem.h * model.a[row] + interface
    });
    let p_c = if n_c == 0 { DVector::zeros(0) } else { h_cc.lu().solve(&-b).unwrap() };
    let mut impulses = vec![0.0; n_u + problem.force.len()];
    for (slot, &contact) in problem.active.iter().enumerate() {
        impulses[contact] = p_c[slot];
    }
    for (impulse, force) in impulses[n_u..].iter_mut().zip(&problem.force) {
        *impulse = problem.h * force;
    }
    let mut velocity = vec![0.0; problem.v.len()];
    elimination.velocity_after(problem.h, &impulses, &mut velocity);
    let mut p_b = vec![0.0; problem.eq3.bilateral.len()];
    elimination.bilateral_impulses(problem.h, &impulses, &mut p_b);

    // Each vector against its own size, or that of what cancels in it: a system at rest has velocities h M⁻¹ f taken
    // back by contacts. Impulses of joints and contacts share one scale, for they balance each other.
    let start = problem.v.iter().map(|v| v.abs()).fold(0.0, f64::max);
    let impulse_scale =
        dense.bilateral_impulses.amax().max(dense.contact_impulses.amax()).max(problem.h * dense.force_scale);
    let velocity_scale = dense.velocity.amax().max(start).max(problem.h * dense.acceleration_scale);
    let pairs: [(&[f64], &[f64], f64); 6] = [
        (&velocity, dense.velocity.as_slice(), velocity_scale),
        (p_c.as_slice(), dense.contact_impulses.as_slice(), impulse_scale),
        (&p_b, dense.bilateral_impulses.as_slice(), impulse_scale),
        (&model.h, dense.h.as_slice(), dense.h.amax()),
        (&model.a, dense.a.as_slice(), dense.a.amax().max(dense.acceleration_scale)),
        (&model.w, dense.w.as_slice(), dense.w.amax().max(start)),
    ];
    let worst = pairs
        .iter()
        .filter(|(found, _, _)| !found.is_empty())
        .map(|(found, wanted, scale)| max_difference(found, wanted) / (scale.max(f64::MIN_POSITIVE) * dense.tolerance))
        .fold(0.0, f64::max);
    (worst, dense.tolerance)
}

fn random_rows(rng: &mut Pcg64, count: usize, columns: usize) -> Rows {
    let mut rows = Rows::zeros(count, columns);
    rows.jacobian.fill_with(|| rng.random_range(-1.0..1.0));
    rows.convective.fill_with(|| rng.random_range(-1.0..1.0));
    rows.position.fill_with(|| rng.random_range(-1e-3..1e-3));
    rows
}

fn random_mass(rng: &mut Pcg64, n: usize, dense: bool) -> MassMatrix {
    if !dense {
        return MassMatrix::Diagonal((0..n).map(|_| rng.random_range(0.5..5.0)).collect());
    }
    let root = DMatrix::from_fn(n, n, |_, _| rng.random_range(-1.0..1.0));
    let spd = &root * root.transpose() / n as f64 + DMatrix::identity(n, n);
    MassMatrix::Dense(spd.as_slice().to_vec())
}

fn random_problem(rng: &mut Pcg64, [n_b, n_u, n_i]: [usize; 3], dense: bool) -> Problem {
    // Two freedoms are left when all contacts are active, so that any subset of them is independent.
    let n = n_b + n_u + n_i + 2;
    let active = (0..n_u).filter(|_| rng.random_bool(0.5)).collect();
    Problem {
        eq3: Linearisation {
            mass: random_mass(rng, n, dense),
            force: (0..n).map(|_| rng.random_range(-10.0..10.0)).collect(),
            bilateral: random_rows(rng, n_b, n),
            unilateral: random_rows(rng, n_u, n),
            tangential: Rows::zeros(0, n),
            interface: random_rows(rng, n_i, n),
        },
        v: (0..n).map(|_| rng.random_range(-1.0..1.0)).collect(),
        h: 1e-3,
        stabilisation: 0.2,
        force: (0..n_i).map(|_| rng.random_range(-100.0..100.0)).collect(),
        active,
    }
}

#[test]
fn the_reduced_model_must_not_differ_from_the_full_matrix_on_random_systems() {
    let mut rng = Pcg64::seed_from_u64(1);
    let mut tolerances = Vec::new();
    for n_b in 0..=6 {
        for n_u in 0..=8 {
            for n_i in 1..=3 {
                for dense in [false, true] {
                    let problem = random_problem(&mut rng, [n_b, n_u, n_i], dense);
                    let (error, tolerance) = compare(&problem);
                    let name = format!("n_b={n_b} n_u={n_u} n_i={n_i} dense={dense}");
                    assert!(error <= 1.0, "{name}: {error} of tolerance {tolerance:e}");
                    tolerances.push(tolerance);
                }
            }
        }
    }
    // From 32 rows on the factorisation is another one, for the joints and for a dense mass matrix alike.
    for dense in [false, true] {
        let (error, tolerance) = compare(&random_problem(&mut rng, [33, 6, 2], dense));
        assert!(error <= 1.0 && tolerance < 1e-8, "33 joints, dense={dense}: {error} of tolerance {tolerance:e}");
    }
    // The bound must stay sharp enough to see a wrong term, not only a wrong sign.
    tolerances.sort_by(f64::total_cmp);
    let median = tolerances[tolerances.len() / 2];
    assert!(median < 1e-11, "median tolerance {median:e}");
}

/// A fifth contact, of which the others know nothing, makes the size one that is not written out.
#[test]
fn two_bodies_give_the_bits_that_any_size_gives() {
    let mut rng = Pcg64::seed_from_u64(21);
    for turn in 0..200 {
        let n = 6;
        let problem = Problem {
            eq3: Linearisation {
                mass: random_mass(&mut rng, n, false),
                force: (0..n).map(|_| rng.random_range(-10.0..10.0)).collect(),
                bilateral: random_rows(&mut rng, 2, n),
                unilateral: random_rows(&mut rng, 4, n),
                tangential: Rows::zeros(0, n),
                interface: random_rows(&mut rng, 1, n),
            },
            v: (0..n).map(|_| rng.random_range(-1.0..1.0)).collect(),
            ..random_problem(&mut rng, [0; 3], false)
        };
        let Problem { eq3, v, h, stabilisation, .. } = &problem;
        let mut more = eq3.clone();
        more.unilateral = random_rows(&mut rng, 5, n);
        more.unilateral.jacobian[..4 * n].copy_from_slice(&eq3.unilateral.jacobian);
        more.unilateral.convective[..4].copy_from_slice(&eq3.unilateral.convective);
        let [(mut few, model), (mut any, wider)] = [eq3, &more].map(|eq3| reduce(eq3, v, *h, *stabilisation));
        // Rows of the larger system that are those of the smaller one.
        let rows = [0, 1, 2, 3, 5];
        for (row, &of) in rows.iter().enumerate() {
            let mut pairs = vec![(model.w[row], wider.w[of]), (model.a[row], wider.a[of])];
            pairs
                .extend(rows.iter().enumerate().map(|(column, &at)| (model.h[5 * row + column], wider.h[6 * of + at])));
            assert!(pairs.iter().all(|(a, b)| a.to_bits() == b.to_bits()), "turn {turn}, row {row}: {pairs:?}");
        }
        assert_eq!((&model.gap[..], &model.position), (&eq3.unilateral.position[..], &eq3.interface.position));
        assert_eq!((model.mechanics_step, model.stabilisation), (*h, *stabilisation));
        let p: [f64; 4] = std::array::from_fn(|at| if at == turn % 4 { 0.0 } else { rng.random_range(0.0..1.0) });
        let [mut of_few, mut of_any] = [[0.0; 6], [0.0; 6]];
        let [mut joints_of_few, mut joints_of_any] = [[0.0; 2], [0.0; 2]];
        few.velocity_after(*h, &[&p[..], &[0.7]].concat(), &mut of_few);
        any.velocity_after(*h, &[&p[..], &[0.0, 0.7]].concat(), &mut of_any);
        few.bilateral_impulses(*h, &[&p[..], &[0.7]].concat(), &mut joints_of_few);
        any.bilateral_impulses(*h, &[&p[..], &[0.0, 0.7]].concat(), &mut joints_of_any);
        assert_eq!((of_few, joints_of_few), (of_any, joints_of_any), "turn {turn}");
    }
}

/// A model `H = A M⁻¹ Aᵀ` of rows `A` over unit masses: the contacts first, the last `n_i` rows are the interface.
fn model_of(rows: &DMatrix<f64>, n_i: usize, v: &DVector<f64>, force: &DVector<f64>) -> ReducedInterfaceModel {
    let n_u = rows.nrows() - n_i;
    let mut model = ReducedInterfaceModel::zeros(n_u, n_i);
    // Symmetric, so that row-major and column-major are the same.
    model.h.copy_from_slice((rows * rows.transpose()).as_slice());
    model.a.copy_from_slice((rows * force).as_slice());
    model.w.copy_from_slice((rows * v).as_slice());
    model
}

fn random_model(rng: &mut Pcg64, n_u: usize, n_i: usize, n: usize) -> ReducedInterfaceModel {
    let rows = DMatrix::from_fn(n_u + n_i, n, |_, _| rng.random_range(-1.0..1.0));
    let mut vector = || DVector::from_fn(n, |_, _| rng.random_range(-1.0..1.0));
    let (v, force) = (vector(), vector());
    model_of(&rows, n_i, &v, &force)
}

fn condensed(model: &ReducedInterfaceModel, closed: &[usize]) -> Condensation {
    let mut out = Condensation::new(model.contacts(), model.interface());
    condense(model, closed, &mut out);
    out
}

/// `B Bᵀ` over contacts and interface; contact 2 repeats contact 0 where `dependent`.
fn model_with_copy(rng: &mut Pcg64, contacts: usize, interface: usize, dependent: bool) -> ReducedInterfaceModel {
    let n = contacts + interface;
    let mut b = DMatrix::from_fn(n, n + 2, |_, _| rng.random_range(-1.0..1.0));
    let mut model = ReducedInterfaceModel::zeros(contacts, interface);
    model.a.fill_with(|| rng.random_range(-1.0..1.0));
    model.w.fill_with(|| rng.random_range(-1.0..1.0));
    if dependent {
        let row = b.row(0).into_owned();
        b.set_row(2, &row);
        (model.a[2], model.w[2]) = (model.a[0], model.w[0]);
    }
    model.h.copy_from_slice((&b * b.transpose()).as_slice());
    model
}

#[test]
fn condensation_is_a_pseudo_inverse_away_for_every_number_of_closed_contacts() {
    let mut rng = Pcg64::seed_from_u64(2);
    let closed_sets: [&[usize]; 7] = [&[], &[3], &[0, 1], &[1, 0], &[0, 2], &[2, 0, 3], &[0, 1, 2, 3]];
    for interface in [1, 2] {
        for (closed, dependent) in closed_sets.into_iter().flat_map(|set| [(set, false), (set, true)]) {
            let model = model_with_copy(&mut rng, 4, interface, dependent);
            let n_c = closed.len();
            let h_cc = DMatrix::from_fn(n_c, n_c, |r, c| model.entry(closed[r], closed[c]));
            let h_ci = DMatrix::from_fn(n_c, interface, |r, i| model.entry(closed[r], 4 + i));
            let of_contacts = |values: &[f64]| DVector::from_fn(n_c, |r, _| values[closed[r]]);
            let inverse = if n_c == 0 { h_cc } else { h_cc.pseudo_inverse(1e-9).unwrap() };
            let factor = h_ci.transpose() * inverse;
            let (a, w, h) = (&factor * of_contacts(&model.a), &factor * of_contacts(&model.w), &factor * &h_ci);
            let both_copies = dependent && closed.contains(&0) && closed.contains(&2);
            let out = condensed(&model, closed);
            assert_eq!(out.rank, n_c - usize::from(both_copies), "{closed:?}");
            let close = |found: f64, of_model: f64, taken: f64| {
                assert!((found - of_model + taken).abs() < 1e-8, "{closed:?}");
            };
            for i in 0..interface {
                for j in 0..interface {
                    close(out.h[i * interface + j], model.entry(4 + i, 4 + j), h[(i, j)]);
                }
                close(out.a[i], model.a[4 + i], a[i]);
                close(out.w[i], model.w[4 + i], w[i]);
            }
        }
    }
}

#[test]
fn of_contradicting_contact_velocities_the_first_is_taken() {
    // One mass, one contact row counted twice with velocities 0 and −1: the interface row is the same direction.
    let mut model = ReducedInterfaceModel::zeros(2, 1);
    model.h.fill(1.0);
    model.w.copy_from_slice(&[0.0, -1.0, -0.5]);
    // The first row is kept, and its velocity, 0, taken off.
    let found = condensed(&model, &[0, 1]);
    assert_eq!((found.w[0], found.rank), (-0.5, 1));
}

#[test]
fn a_locked_interface_must_have_an_infinite_mass_and_not_a_large_one() {
    let mut rng = Pcg64::seed_from_u64(5);
    for n in 2..=6 {
        // n independent contacts on n freedoms leave no motion at all.
        let model = random_model(&mut rng, n, 1, n);
        let closed: Vec<usize> = (0..n).collect();
        let locked = condensed(&model, &closed);
        assert_eq!(locked.effective_mass, f64::INFINITY, "n = {n}");
        assert_eq!(locked.h, [0.0], "round-off must not be left as a mobility");
        let free = condensed(&model, &closed[1..]);
        assert!(free.effective_mass.is_finite() && free.effective_mass > 0.0);
    }
    // A plane locked along (1, 1) only: each axis moves, so only the eigenvalue shows it.
    let rows = DMatrix::from_row_slice(3, 2, &[1.0, 1.0, 1.0, 0.0, 0.0, 1.0]);
    let model = model_of(&rows, 2, &DVector::zeros(2), &DVector::zeros(2));
    let locked = condensed(&model, &[0]);
    assert_eq!(locked.effective_mass, f64::INFINITY);
    approx::assert_abs_diff_eq!(locked.h[0], 0.5, epsilon = 4.0 * f64::EPSILON);
}

#[test]
fn the_effective_mass_of_two_and_three_interface_rows_must_be_that_of_the_heaviest_direction() {
    let mut rng = Pcg64::seed_from_u64(6);
    for n_i in [2, 3] {
        for n_u in [0, 1, 3, 5] {
            let model = random_model(&mut rng, n_u, n_i, n_u + n_i + 4);
            let closed: Vec<usize> = (0..n_u).collect();
            let dense = DMatrix::from_row_slice(n_u + n_i, n_u + n_i, &model.h);
            let h_cc = dense.view((0, 0), (n_u, n_u)).into_owned();
            let h_ic = dense.view((n_u, 0), (n_i, n_u)).into_owned();
            let mut schur = dense.view((n_u, n_u), (n_i, n_i)).into_owned();
            if n_u > 0 {
                schur -= &h_ic * h_cc.clone().try_inverse().unwrap() * h_ic.transpose();
            }
            let wanted = 1.0 / schur.symmetric_eigenvalues().min();
            let found = condensed(&model, &closed).effective_mass;
            // Ĥ is known to n² ε κ(H_cc) ‖H‖; relative to its smallest eigenvalue that is its condition once more.
            let tolerance =
                8.0 * ((n_u + n_i) as f64).powi(2) * f64::EPSILON * condition(&h_cc) * dense.amax() * wanted;
            assert!(tolerance < 1e-9, "tolerance {tolerance:e} is no test");
            approx::assert_relative_eq!(found, wanted, max_relative = tolerance);
        }
    }
}
