//! Contacts turned into bilateral constraints inside the model: the effective mass, and the smooth variant of the RIM.

use super::reduced_interface_model::ReducedInterfaceModel;
use nalgebra::{SMatrix, SymmetricEigen};
use std::fmt;

/// Below this fraction of the largest diagonal entry a pivot or eigenvalue of `H_cc` counts as zero.
const RANK_TOLERANCE: f64 = 1e-10;

/// Below this fraction of `H_ii` the condensed `Ĥ_ii` is round-off: the interface is locked.
const LOCKED_TOLERANCE: f64 = 1e-12;

/// Number of closed contacts up to which the pseudo-inverse is available.
const PSEUDO_INVERSE_LIMIT: usize = 16;

/// Number of interface rows up to which the heaviest direction is found.
const EIGENVALUE_LIMIT: usize = 8;

/// What to do when the contacts that become bilateral are dependent (`H_cc` singular).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Redundancy {
    /// Keep a largest independent subset, found by pivoted Cholesky; the dependent rows drop out.
    Drop,
    /// Moore–Penrose inverse of `H_cc`: spreads an inconsistent contact velocity over the redundant rows.
    PseudoInverse,
    /// `(H_cc + ε tr(H_cc)/n_c)⁻¹`: compliant contacts; ε is dimensionless.
    Regularised {
        /// Relative compliance ε > 0.
        epsilon: f64,
    },
}

impl fmt::Display for Redundancy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Redundancy::Drop => "drop",
            Redundancy::PseudoInverse => "pseudo-inverse",
            Redundancy::Regularised { .. } => "regularised",
        })
    }
}

/// The model with a set `c` of its contacts closed for good.
///
/// ```text
/// Ĥ_ii = H_ii − H_ic H_cc⁺ H_ci      â_i = a_i − H_ic H_cc⁺ a_c      ŵ_i = w_i − H_ic H_cc⁺ w_c
/// m_eff = 1 / λ_min(Ĥ_ii)            for one interface row simply 1 / Ĥ_ii
/// ```
/// # Shapes and units
/// `h` n_i×n_i (1/kg), `a` n_i (m/s²), `w` n_i (m/s), `effective_mass` kg.
#[derive(Debug, Clone, PartialEq)]
pub struct Condensation {
    /// `Ĥ_ii`, row-major. Set to exactly zero where it is round-off of `H_ii`.
    pub h: Vec<f64>,
    /// `â_i`.
    pub a: Vec<f64>,
    /// `ŵ_i`.
    pub w: Vec<f64>,
    /// Rank of `H_cc`.
    pub rank: usize,
    /// Effective mass of the heaviest interface direction; `+inf` when it is locked.
    pub effective_mass: f64,
    work: Work,
}

#[derive(Debug, Clone, Default, PartialEq)]
struct Work {
    /// Factor of `H_cc` (lower triangle, row-major over the kept rows), or its pseudo-inverse.
    factor: Vec<f64>,
    order: Vec<usize>,
    /// `[H_ci a_c w_c]`, one right-hand side after the other, over the kept rows.
    right: Vec<f64>,
    solved: Vec<f64>,
}

impl Condensation {
    /// Makes the workspace for models with up to `contacts` contacts and `interface` interface rows.
    pub fn new(contacts: usize, interface: usize) -> Self {
        Condensation {
            h: vec![0.0; interface * interface],
            a: vec![0.0; interface],
            w: vec![0.0; interface],
            rank: 0,
            effective_mass: f64::NAN,
            work: Work {
                factor: vec![0.0; contacts * contacts],
                order: Vec::with_capacity(contacts),
                right: vec![0.0; contacts * (interface + 2)],
                solved: vec![0.0; contacts * (interface + 2)],
            },
        }
    }
}

/// Closes the contacts `closed` of `model` for good and writes what the interface then looks like to `out`.
///
/// Dependent contacts are handled as `redundancy` says; for [`Redundancy::PseudoInverse`] with more than
/// 16 closed contacts dependent rows are dropped.
pub fn condense(model: &ReducedInterfaceModel, closed: &[usize], redundancy: Redundancy, out: &mut Condensation) {
    let (n_u, n_i) = (model.contacts(), model.interface());
    for i in 0..n_i {
        for j in 0..n_i {
            out.h[i * n_i + j] = model.entry(n_u + i, n_u + j);
        }
        out.a[i] = model.a[n_u + i];
        out.w[i] = model.w[n_u + i];
    }
    out.rank = 0;
    if !closed.is_empty() {
        let kept = invert(model, closed, redundancy, out);
        let columns = n_i + 2;
        for i in 0..n_i {
            for k in 0..kept {
                let contact = closed[out.work.order[k]];
                let h_ic = model.entry(n_u + i, contact);
                for j in 0..n_i {
                    out.h[i * n_i + j] -= h_ic * out.work.solved[k * columns + j];
                }
                out.a[i] -= h_ic * out.work.solved[k * columns + n_i];
                out.w[i] -= h_ic * out.work.solved[k * columns + n_i + 1];
            }
        }
        for i in 0..n_i {
            if out.h[i * n_i + i] <= LOCKED_TOLERANCE * model.entry(n_u + i, n_u + i) {
                for j in 0..n_i {
                    out.h[i * n_i + j] = 0.0;
                    out.h[j * n_i + i] = 0.0;
                }
            }
        }
    }
    out.effective_mass = effective_mass(&out.h, n_i);
}

/// Solves `H_cc X = [H_ci a_c w_c]` into `work.solved`; returns how many of `closed` (in `work.order`) were kept.
fn invert(model: &ReducedInterfaceModel, closed: &[usize], redundancy: Redundancy, out: &mut Condensation) -> usize {
    let n = closed.len();
    let columns = model.interface() + 2;
    out.work.order.clear();
    out.work.order.extend(0..n);
    let load = |work: &mut Work| {
        for k in 0..work.order.len() {
            let contact = closed[work.order[k]];
            for j in 0..model.interface() {
                work.right[k * columns + j] = model.entry(contact, model.contacts() + j);
            }
            work.right[k * columns + columns - 2] = model.a[contact];
            work.right[k * columns + columns - 1] = model.w[contact];
        }
    };
    if redundancy == Redundancy::PseudoInverse && n <= PSEUDO_INVERSE_LIMIT {
        load(&mut out.work);
        out.rank = pseudo_inverse(model, closed, &mut out.work.factor);
        for k in 0..n {
            for c in 0..columns {
                out.work.solved[k * columns + c] =
                    (0..n).map(|l| out.work.factor[k * n + l] * out.work.right[l * columns + c]).sum();
            }
        }
        return n;
    }
    out.rank = pivoted_cholesky(model, closed, 0.0, &mut out.work);
    let mut kept = out.rank;
    if let Redundancy::Regularised { epsilon } = redundancy {
        let trace: f64 = closed.iter().map(|&contact| model.entry(contact, contact)).sum();
        kept = pivoted_cholesky(model, closed, epsilon * trace / n as f64, &mut out.work);
    }
    load(&mut out.work);
    triangular_solves(&mut out.work, n, kept, columns);
    kept
}

/// Factors `H_cc + shift·1` with diagonal pivoting in `work.order`; returns the numerical rank.
fn pivoted_cholesky(model: &ReducedInterfaceModel, closed: &[usize], shift: f64, work: &mut Work) -> usize {
    let n = closed.len();
    work.order.clear();
    work.order.extend(0..n);
    let diagonal = |slot: usize| model.entry(closed[slot], closed[slot]) + shift;
    let largest = (0..n).map(diagonal).fold(0.0, f64::max);
    for k in 0..n {
        let remaining = |work: &Work, position: usize| {
            let row = &work.factor[position * n..position * n + k];
            diagonal(work.order[position]) - row.iter().map(|x| x * x).sum::<f64>()
        };
        let Some((best, pivot)) =
            (k..n).map(|position| (position, remaining(work, position))).reduce(|a, b| if b.1 > a.1 { b } else { a })
        else {
            return k;
        };
        if pivot.is_nan() || pivot <= RANK_TOLERANCE * largest {
            return k;
        }
        if best != k {
            work.order.swap(k, best);
            for column in 0..k {
                work.factor.swap(k * n + column, best * n + column);
            }
        }
        let root = pivot.sqrt();
        work.factor[k * n + k] = root;
        for position in k + 1..n {
            let mut value = model.entry(closed[work.order[position]], closed[work.order[k]]);
            for column in 0..k {
                value -= work.factor[position * n + column] * work.factor[k * n + column];
            }
            work.factor[position * n + k] = value / root;
        }
    }
    n
}

fn triangular_solves(work: &mut Work, n: usize, kept: usize, columns: usize) {
    work.solved[..kept * columns].copy_from_slice(&work.right[..kept * columns]);
    for c in 0..columns {
        for k in 0..kept {
            let mut value = work.solved[k * columns + c];
            for l in 0..k {
                value -= work.factor[k * n + l] * work.solved[l * columns + c];
            }
            work.solved[k * columns + c] = value / work.factor[k * n + k];
        }
        for k in (0..kept).rev() {
            let mut value = work.solved[k * columns + c];
            for l in k + 1..kept {
                value -= work.factor[l * n + k] * work.solved[l * columns + c];
            }
            work.solved[k * columns + c] = value / work.factor[k * n + k];
        }
    }
}

/// Moore–Penrose inverse of `H_cc`, padded with zeros to a fixed size so that nothing is allocated; returns the rank.
fn pseudo_inverse(model: &ReducedInterfaceModel, closed: &[usize], out: &mut [f64]) -> usize {
    let n = closed.len();
    const N: usize = PSEUDO_INVERSE_LIMIT;
    let padded = SMatrix::<f64, N, N>::from_fn(|row, column| {
        if row < n && column < n { model.entry(closed[row], closed[column]) } else { 0.0 }
    });
    if !padded.iter().all(|entry| entry.is_finite()) {
        out[..n * n].fill(f64::NAN);
        return 0;
    }
    let eigen = SymmetricEigen::new(padded);
    let largest = eigen.eigenvalues.amax();
    let mut rank = 0;
    out[..n * n].fill(0.0);
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *value > RANK_TOLERANCE * largest {
            rank += 1;
            for row in 0..n {
                for column in 0..n {
                    out[row * n + column] += vector[row] * vector[column] / value;
                }
            }
        }
    }
    rank
}

/// `1/λ_min(Ĥ)`; `+inf` where an interface direction is locked.
fn effective_mass(h: &[f64], n: usize) -> f64 {
    let smallest = match n {
        0 => return f64::NAN,
        1 => h[0],
        2..=EIGENVALUE_LIMIT => smallest_eigenvalue(h, n),
        // Beyond that many interface rows the heaviest coordinate direction is reported instead.
        _ => (0..n).map(|i| h[i * n + i]).fold(f64::INFINITY, f64::min),
    };
    let largest = (0..n).map(|i| h[i * n + i]).fold(0.0, f64::max);
    if smallest.is_nan() {
        f64::NAN
    } else if smallest <= LOCKED_TOLERANCE * largest {
        f64::INFINITY
    } else {
        1.0 / smallest
    }
}

fn smallest_eigenvalue(h: &[f64], n: usize) -> f64 {
    const N: usize = EIGENVALUE_LIMIT;
    // Padding with a diagonal above every eigenvalue keeps the smallest one.
    let bound = 1.0 + h.iter().map(|x| x.abs()).sum::<f64>();
    if !bound.is_finite() {
        return f64::NAN;
    }
    SMatrix::<f64, N, N>::from_fn(|row, column| match (row < n && column < n, row == column) {
        (true, _) => h[row * n + column],
        (false, true) => bound,
        (false, false) => 0.0,
    })
    .symmetric_eigenvalues()
    .min()
}
