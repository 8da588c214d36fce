//! Contacts turned into bilateral constraints inside the model: the effective mass, and the smooth variant of the RIM.

use super::contact_modes::ContactModes;
use super::frictional_condensation::StateWork;
use super::reduced_interface_model::ReducedInterfaceModel;
use nalgebra::SMatrix;
use rimbench_contact::linear_algebra::SparseFactor;

/// Below this fraction of the largest diagonal entry a pivot or eigenvalue of `H_cc` counts as zero.
const RANK_TOLERANCE: f64 = 1e-10;

/// Below this fraction of `H_ii` the condensed `Ĥ_ii` is round-off: the interface is locked.
const LOCKED_TOLERANCE: f64 = 1e-12;

/// Number of closed contacts beyond which those of a sparse model are factorised by their pattern.
const FEW_CONTACTS: usize = 2;

/// Number of interface rows up to which the heaviest direction is found.
const EIGENVALUE_LIMIT: usize = 8;

/// The model with a set `c` of its contacts closed for good.
///
/// ```text
/// Ĥ_ii = H_ii − H_ic H_cc⁺ H_ci      â_i = a_i − H_ic H_cc⁺ a_c      ŵ_i = w_i − H_ic H_cc⁺ w_c
/// m_eff = 1 / λ_min(Ĥ_ii)            for one interface row simply 1 / Ĥ_ii
/// ```
/// With friction the closed contacts stick or slide as the model says: `Ĥ_ii = H_ii − H_i· F_σ K⁻¹ E_σ H_·i`, see
/// [`StateSystem`](rimbench_contact::friction::StateSystem); then it is unsymmetric, and an effective mass below 0, an
/// interface that locks by its own friction, counts as infinite.
///
/// # Shapes and units
/// `h` n_i×n_i (1/kg), `a` n_i (m/s²), `w` n_i (m/s), `effective_mass` kg.
#[derive(Debug, Clone)]
pub struct Condensation {
    /// `Ĥ_ii`, row-major. Set to exactly zero where it is round-off of `H_ii`, or below 0.
    pub h: Vec<f64>,
    /// `â_i`.
    pub a: Vec<f64>,
    /// `ŵ_i`.
    pub w: Vec<f64>,
    /// Rank of `H_cc`.
    pub rank: usize,
    /// Effective mass of the heaviest interface direction; `+inf` when it is locked.
    pub effective_mass: f64,
    /// Whether an entry was below 0, and not by round-off: the interface locks by its own friction, which no motion of
    /// the body does.
    pub locks_itself: bool,
    work: Work,
}

#[derive(Debug, Clone, Default)]
struct Work {
    /// `[H a w]` over the closed contacts, then the interface; what is left of it while contacts are eliminated.
    tableau: Vec<f64>,
    pivot_row: Vec<f64>,
    eliminated: Vec<bool>,
    /// In place of the tableau, where few of many contacts are coupled; a column over the contacts, and which of them
    /// are closed.
    factor: Option<SparseFactor>,
    column: Vec<f64>,
    closed: Vec<bool>,
    /// Where there is friction.
    states: Option<Box<StateWork>>,
}

impl Condensation {
    /// Makes the workspace for models with up to `contacts` contacts and `interface` interface rows.
    pub fn new(contacts: usize, interface: usize) -> Self {
        let (rows, columns) = (contacts + interface, contacts + interface + 2);
        Condensation {
            h: vec![0.0; interface * interface],
            a: vec![0.0; interface],
            w: vec![0.0; interface],
            rank: 0,
            effective_mass: f64::NAN,
            locks_itself: false,
            work: Work {
                tableau: vec![0.0; rows * columns],
                pivot_row: vec![0.0; columns],
                eliminated: vec![false; contacts],
                ..Work::default()
            },
        }
    }

    /// Tells whether `Ĥ_ii` may be unsymmetric, as it is where contacts slide.
    pub fn is_unsymmetric(&self) -> bool {
        self.work.states.is_some()
    }

    /// Makes the workspace for models like this one.
    pub fn of(model: &ReducedInterfaceModel) -> Self {
        if model.has_friction() {
            let work = Work { states: Some(Box::new(StateWork::new(model))), ..Work::default() };
            return Condensation { work, ..Self::new(0, model.interface()) };
        }
        let Some(pattern) = model.delassus_pattern() else { return Self::new(model.contacts(), model.interface()) };
        let mut condensation = Self::new(FEW_CONTACTS, model.interface());
        let work = &mut condensation.work;
        work.factor = Some(SparseFactor::new(pattern));
        work.column = vec![0.0; model.contacts()];
        work.closed = vec![false; model.contacts()];
        condensation
    }
}

/// Closes the contacts `closed` of `model` for good and writes what the interface then looks like to `out`.
///
/// Contacts that depend on others are left out.
pub fn condense(model: &ReducedInterfaceModel, closed: &[usize], out: &mut Condensation) {
    condense_in_modes(model, model.modes(), closed, out);
}

/// Closes the contacts `closed` of `model` for good, with friction in these modes instead of those that the model says;
/// see [`condense`].
pub fn condense_in_modes(
    model: &ReducedInterfaceModel,
    modes: ContactModes<'_>,
    closed: &[usize],
    out: &mut Condensation,
) {
    let (n_u, n_i, n_c) = (model.interface_start(), model.interface(), closed.len());
    if model.has_friction() {
        condense_frictional(model, modes, closed, out);
    } else if out.work.factor.is_some() && n_c > FEW_CONTACTS {
        condense_by_pattern(model, closed, out);
    } else if n_i == 1 && n_c <= 2 && !model.unsymmetric {
        project_scalar(model, closed, out);
    } else {
        load(model, closed, &mut out.work);
        out.rank = eliminate(n_c, n_i, &mut out.work);
        read_interface(n_c, out);
    }
    out.locks_itself = false;
    for i in 0..n_i {
        let rounding = LOCKED_TOLERANCE * model.entry(n_u + i, n_u + i);
        if n_c > 0 && out.h[i * n_i + i] <= rounding {
            out.locks_itself |= out.h[i * n_i + i] < -rounding;
            for j in 0..n_i {
                out.h[i * n_i + j] = 0.0;
                out.h[j * n_i + i] = 0.0;
            }
        }
    }
    out.effective_mass = match &mut out.work.states {
        Some(work) if n_i > 1 => effective_mass(work.symmetric_part(&out.h), n_i),
        _ => effective_mass(&out.h, n_i),
    };
}

/// Returns the rank of `H_cc` of the normal rows of contacts, of which fewer than contacts are redundant: by Cholesky's
/// factor with the largest pivot left, in `rows`, which is overwritten.
pub(crate) fn rank_of_normal_rows(model: &ReducedInterfaceModel, closed: &[usize], rows: &mut Vec<f64>) -> usize {
    let n = closed.len();
    rows.clear();
    rows.extend(closed.iter().flat_map(|&row| closed.iter().map(move |&column| model.entry(row, column))));
    let mut largest = 0.0;
    for rank in 0..n {
        let pivot = (0..n).max_by(|&a, &b| rows[a * n + a].total_cmp(&rows[b * n + b])).unwrap_or(0);
        let value = rows[pivot * n + pivot];
        largest = f64::max(largest, value);
        if value.is_nan() || value <= RANK_TOLERANCE * largest {
            return rank;
        }
        for row in (0..n).filter(|&row| row != pivot) {
            let factor = rows[row * n + pivot] / value;
            (0..n).for_each(|column| rows[row * n + column] -= factor * rows[pivot * n + column]);
        }
        (0..n).for_each(|column| rows[pivot * n + column] = 0.0);
    }
    n
}

/// Condenses contacts with friction.
#[cold]
fn condense_frictional(
    model: &ReducedInterfaceModel,
    modes: ContactModes<'_>,
    closed: &[usize],
    out: &mut Condensation,
) {
    let Condensation { h, a, w, rank, work, .. } = out;
    let work = work.states.get_or_insert_with(|| Box::new(StateWork::new(model)));
    *rank = work.condense(model, modes, closed, [h, a, w]);
}

/// Condenses contacts of a model whose `H_uu` has a pattern. Contacts are left out that depend on those before them in
/// the factor's order.
fn condense_by_pattern(model: &ReducedInterfaceModel, closed: &[usize], out: &mut Condensation) {
    let (n_u, n_i) = (model.contacts(), model.interface());
    let Work { factor: Some(factor), column, closed: marks, .. } = &mut out.work else { return };
    let Some(rows) = model.contact_rows() else { return };
    factor.change_pattern(rows.pattern);
    marks.fill(false);
    closed.iter().for_each(|&contact| marks[contact] = true);
    out.rank = factor.factorise(rows, 0.0, RANK_TOLERANCE, |contact| marks[contact]);
    for i in 0..n_i {
        // H_cc⁻¹ H_ci, then its products with what the interface feels.
        let of_interface = |i: usize| model.interface_column(i).map_or(&[][..], |column| &column[..n_u]);
        column.copy_from_slice(of_interface(i));
        factor.solve(column);
        let product = |x: &[f64]| column.iter().zip(x).map(|(y, x)| y * x).sum::<f64>();
        for j in 0..n_i {
            out.h[j * n_i + i] = model.entry(n_u + i, n_u + j) - product(of_interface(j));
        }
        out.a[i] = model.a[n_u + i] - product(&model.a[..n_u]);
        out.w[i] = model.w[n_u + i] - product(&model.w[..n_u]);
    }
}

/// [`eliminate`] for one interface row and at most two closed contacts, on registers: this is what is
/// asked at each communication point of a small case.
fn project_scalar(model: &ReducedInterfaceModel, closed: &[usize], out: &mut Condensation) {
    let n_u = model.contacts();
    // [H_ic, H_cc, a_c, w_c] of a contact.
    let of = |c: usize| [model.entry(n_u, c), model.entry(c, c), model.a[c], model.w[c]];
    let mut left = [model.entry(n_u, n_u), model.a[n_u], model.w[n_u]];
    let mut subtract = |[h_ic, h_cc, a, w]: [f64; 4]| {
        let factor = h_ic / h_cc;
        left = [left[0] - factor * h_ic, left[1] - factor * a, left[2] - factor * w];
    };
    out.rank = 0;
    if let Some(&contact) = closed.first() {
        let (mut first, mut second) = (of(contact), closed.get(1).map(|&c| of(c)));
        if let Some(other) = &mut second
            && other[1] > first[1]
        {
            std::mem::swap(&mut first, other);
        }
        if first[1] > 0.0 {
            subtract(first);
            out.rank = 1;
            if let Some([h_ic, h_cc, a, w]) = second {
                let cross = model.entry(closed[0], closed[1]);
                let factor = cross / first[1];
                let rest = h_cc - factor * cross;
                if rest > RANK_TOLERANCE * first[1] {
                    subtract([h_ic - factor * first[0], rest, a - factor * first[2], w - factor * first[3]]);
                    out.rank = 2;
                }
            }
        }
    }
    (out.h[0], out.a[0], out.w[0]) = (left[0], left[1], left[2]);
}

/// Copies `[H_cc  H_ci  a_c  w_c;  H_ic  H_ii  a_i  w_i]` to the tableau.
fn load(model: &ReducedInterfaceModel, closed: &[usize], work: &mut Work) {
    let (n_u, n_c) = (model.contacts(), closed.len());
    let n = n_u + model.interface();
    let columns = n_c + model.interface() + 2;
    let sources = closed.iter().copied().chain(n_u..n);
    for (source, row) in sources.zip(work.tableau.chunks_mut(columns)) {
        for (entry, &contact) in row.iter_mut().zip(closed) {
            *entry = model.entry(source, contact);
        }
        for (entry, interface) in row[n_c..].iter_mut().zip(n_u..n) {
            *entry = model.entry(source, interface);
        }
        row[columns - 2] = model.a[source];
        row[columns - 1] = model.w[source];
    }
}

/// Eliminates the contacts of the tableau one by one, that with the largest remaining diagonal first, and leaves out
/// those that are dependent on the ones before; returns how many were not.
///
/// ```text
/// row ← row − (H_row,c / H_cc) row_c            a Schur complement at a time
/// ```
fn eliminate(n_c: usize, n_i: usize, work: &mut Work) -> usize {
    let columns = n_c + n_i + 2;
    let Work { tableau, pivot_row, eliminated, .. } = work;
    let pivot_row = &mut pivot_row[..columns];
    eliminated[..n_c].fill(false);
    let mut largest = 0.0;
    for rank in 0..n_c {
        let remaining = (0..n_c).filter(|&contact| !eliminated[contact]).map(|c| (c, tableau[c * columns + c]));
        let Some((contact, pivot)) = remaining.reduce(|best, other| if other.1 > best.1 { other } else { best }) else {
            return rank;
        };
        // The first pivot is the largest diagonal entry of H_cc.
        largest = if rank == 0 { pivot } else { largest };
        if pivot.is_nan() || pivot <= RANK_TOLERANCE * largest {
            return rank;
        }
        eliminated[contact] = true;
        pivot_row.copy_from_slice(&tableau[contact * columns..(contact + 1) * columns]);
        let inverse = 1.0 / pivot;
        for row in (0..n_c + n_i).filter(|&row| row >= n_c || !eliminated[row]) {
            let row = &mut tableau[row * columns..(row + 1) * columns];
            let factor = row[contact] * inverse;
            // Most contacts of a large system are not coupled.
            if factor == 0.0 {
                continue;
            }
            for (entry, pivot) in row.iter_mut().zip(&*pivot_row) {
                *entry -= factor * pivot;
            }
        }
    }
    n_c
}

/// The interface rows are then `[Ĥ_ii â_i ŵ_i]`.
fn read_interface(n_c: usize, out: &mut Condensation) {
    let n_i = out.a.len();
    let columns = n_c + n_i + 2;
    for i in 0..n_i {
        let row = &out.work.tableau[(n_c + i) * columns..(n_c + i + 1) * columns][n_c..];
        out.h[i * n_i..(i + 1) * n_i].copy_from_slice(&row[..n_i]);
        out.a[i] = row[n_i];
        out.w[i] = row[n_i + 1];
    }
}

/// `1/λ_min(Ĥ)`; `+inf` where an interface direction is locked.
fn effective_mass(h: &[f64], n: usize) -> f64 {
    if n == 0 {
        return f64::NAN;
    }
    // Beyond that many interface rows the heaviest coordinate direction is reported instead.
    let smallest = smallest_eigenvalue(h, n);
    let largest = (0..n).map(|i| h[i * n + i]).fold(0.0, f64::max);
    if smallest.is_nan() {
        f64::NAN
    } else if smallest <= LOCKED_TOLERANCE * largest {
        f64::INFINITY
    } else {
        1.0 / smallest
    }
}

/// Returns the smallest eigenvalue of a symmetric row-major matrix; beyond eight rows the least diagonal entry.
pub(crate) fn smallest_eigenvalue(h: &[f64], n: usize) -> f64 {
    const N: usize = EIGENVALUE_LIMIT;
    match n {
        1 => return h[0],
        2..=N => {}
        _ => return (0..n).map(|i| h[i * n + i]).fold(f64::INFINITY, f64::min),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// `Ĥ_ii = H_ii − H_ic H_cc⁻¹ H_ci`, `â_i = a_i − H_ic H_cc⁻¹ a_c`, and `ŵ_i` likewise.
    #[test]
    fn a_closed_contact_takes_the_interface_along_as_it_answers_and_not_as_the_interface_answers_to_it() {
        for (unsymmetric, h_ci) in [(true, 0.5), (false, 1.0)] {
            let mut model = ReducedInterfaceModel::zeros(1, 1);
            model.h.copy_from_slice(&[2.0, h_ci, 1.0, 4.0]);
            (model.a, model.w, model.unsymmetric) = (vec![3.0, 5.0], vec![-1.0, 6.0], unsymmetric);
            let mut out = Condensation::of(&model);
            condense(&model, &[0], &mut out);
            let (h, a, w) = (4.0 - 0.5 * h_ci, 5.0 - 0.5 * 3.0, 6.0 + 0.5);
            assert_eq!((out.h[0], out.a[0], out.w[0], out.rank), (h, a, w, 1));
            assert_eq!(out.effective_mass, 1.0 / h);
        }
    }
}
