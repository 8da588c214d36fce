//! Eq. 3 → Eq. 4 and condensation against dense textbook algebra, for every size that takes its own way through the code.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rimbench::interface_model::{
    Condensation, Elimination, Linearisation, MassMatrix, ReducedInterfaceModel, Redundancy, Rows, condense,
};

const STEP: f64 = 1e-2;
const STABILISATION: f64 = 0.2;

/// Rows over few of the velocities, as contacts have them.
fn sparse_rows(rng: &mut Pcg64, count: usize, n: usize) -> Rows {
    let mut rows = Rows::zeros(count, n);
    for row in 0..count {
        let first = rng.random_range(0..n);
        for k in first..n.min(first + 4) {
            rows.jacobian[row * n + k] = rng.random_range(-1.0..1.0);
        }
        rows.convective[row] = rng.random_range(-1.0..1.0);
        rows.position[row] = rng.random_range(-1e-3..1e-3);
    }
    rows
}

fn matrix(rows: &Rows, n: usize) -> DMatrix<f64> {
    DMatrix::from_row_slice(rows.len(), n, &rows.jacobian)
}

fn close(found: f64, expected: f64, scale: f64, what: &str) {
    assert!((found - expected).abs() <= 1e-11 * (1.0 + scale), "{what}: {found} instead of {expected}");
}

#[test]
fn elimination_agrees_with_the_textbook_for_every_block_size() {
    let mut rng = Pcg64::seed_from_u64(1);
    for (n, n_b, dense) in [
        (3, 0, false),
        (3, 1, false),
        (6, 2, false),
        (6, 2, true),
        (9, 4, false),
        (5, 1, true),
        (8, 0, false),
        (12, 0, true),
    ] {
        let m = if dense {
            let b = DMatrix::from_fn(n, n, |_, _| rng.random_range(-1.0..1.0));
            &b * b.transpose() + DMatrix::identity(n, n)
        } else {
            DMatrix::from_diagonal(&DVector::from_fn(n, |_, _| rng.random_range(0.5..2.0)))
        };
        let mut bilateral = sparse_rows(&mut rng, n_b, n);
        for b in 0..n_b {
            bilateral.jacobian[b * n + b] += 2.0;
        }
        let eq3 = Linearisation {
            mass: if dense {
                MassMatrix::Dense(m.as_slice().to_vec())
            } else {
                MassMatrix::Diagonal(m.diagonal().as_slice().to_vec())
            },
            force: (0..n).map(|_| rng.random_range(-1.0..1.0)).collect(),
            bilateral,
            unilateral: sparse_rows(&mut rng, 4, n),
            tangential: Rows::zeros(0, n),
            interface: sparse_rows(&mut rng, 2, n),
        };
        let v = DVector::from_fn(n, |_, _| rng.random_range(-1.0..1.0));
        let mut elimination = Elimination::new(&eq3);
        let mut model = ReducedInterfaceModel::zeros(4, 2);
        elimination.reduce(&eq3, v.as_slice(), STEP, STABILISATION, &mut model).unwrap();

        let m_inv = m.clone().try_inverse().unwrap();
        let a_b = matrix(&eq3.bilateral, n);
        let s_inv = (&a_b * &m_inv * a_b.transpose()).try_inverse().unwrap();
        let to_joints = &m_inv * a_b.transpose() * &s_inv;
        let g = &m_inv - &to_joints * &a_b * &m_inv;
        let f = DVector::from_column_slice(&eq3.force);
        let error = DVector::from_column_slice(&eq3.bilateral.position);
        let start = &v - &to_joints * (&a_b * &v + error * (STABILISATION / STEP));
        let free =
            &m_inv * &f - &to_joints * (&a_b * (&m_inv * &f) + DVector::from_column_slice(&eq3.bilateral.convective));
        let mut a = DMatrix::zeros(6, n);
        a.rows_mut(0, 4).copy_from(&matrix(&eq3.unilateral, n));
        a.rows_mut(4, 2).copy_from(&matrix(&eq3.interface, n));
        let convective = [&eq3.unilateral.convective[..], &eq3.interface.convective].concat();
        let h = &a * &g * a.transpose();
        for row in 0..6 {
            close(model.w[row], (a.row(row) * &start)[0], start.amax(), "w");
            close(model.a[row], (a.row(row) * &free)[0] + convective[row], free.amax(), "a");
            for column in 0..6 {
                close(model.entry(row, column), h[(row, column)], h.amax(), "H");
                assert_eq!(model.entry(row, column), model.entry(column, row));
            }
        }
        // The way back: M (v⁺ − v) = h f + A_bᵀ P_b + A_xᵀ P_x.
        let impulses = [0.3, 0.0, 0.7, 0.0, -0.2, 0.1];
        let (mut after, mut p_b) = (vec![0.0; n], vec![0.0; n_b]);
        elimination.velocity_after(STEP, &impulses, &mut after);
        elimination.bilateral_impulses(STEP, &impulses, &mut p_b);
        let change = &m * (DVector::from_vec(after) - &v);
        let sum = &f * STEP
            + a_b.transpose() * DVector::from_vec(p_b)
            + a.transpose() * DVector::from_column_slice(&impulses);
        for k in 0..n {
            close(change[k], sum[k], sum.amax(), "impulse balance");
        }
    }
}

/// `B Bᵀ` over contacts and interface; contact 2 repeats contact 0 where `dependent`.
fn random_model(rng: &mut Pcg64, contacts: usize, interface: usize, dependent: bool) -> ReducedInterfaceModel {
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
            let model = random_model(&mut rng, 4, interface, dependent);
            let n_c = closed.len();
            let h_cc = DMatrix::from_fn(n_c, n_c, |r, c| model.entry(closed[r], closed[c]));
            let h_ci = DMatrix::from_fn(n_c, interface, |r, i| model.entry(closed[r], 4 + i));
            let of_contacts = |values: &[f64]| DVector::from_fn(n_c, |r, _| values[closed[r]]);
            let factor =
                if n_c == 0 { h_ci.transpose() } else { h_ci.transpose() * h_cc.pseudo_inverse(1e-9).unwrap() };
            let (a, w) = (&factor * of_contacts(&model.a), &factor * of_contacts(&model.w));
            let h = &factor * &h_ci;
            let both_copies = dependent && closed.contains(&0) && closed.contains(&2);
            for redundancy in [Redundancy::Drop, Redundancy::PseudoInverse, Redundancy::Regularised { epsilon: 1e-12 }]
            {
                let mut out = Condensation::new(4, interface);
                condense(&model, closed, redundancy, &mut out);
                assert_eq!(out.rank, n_c - usize::from(both_copies), "{closed:?} {redundancy:?}");
                for i in 0..interface {
                    let tolerance = 1e-8;
                    for j in 0..interface {
                        let expected = model.entry(4 + i, 4 + j) - h[(i, j)];
                        assert!((out.h[i * interface + j] - expected).abs() < tolerance, "{closed:?} {redundancy:?}");
                    }
                    assert!((out.a[i] - model.a[4 + i] + a[i]).abs() < tolerance, "{closed:?} {redundancy:?}");
                    assert!((out.w[i] - model.w[4 + i] + w[i]).abs() < tolerance, "{closed:?} {redundancy:?}");
                }
            }
        }
    }
}
