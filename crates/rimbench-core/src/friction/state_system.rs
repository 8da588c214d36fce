//! The linear equations of one combination of states.

use super::ContactState;

/// A pivot below this part of the first one is zero: its row depends on those before.
const DEPENDENT: f64 = 1e-11;

/// The equations that hold once it is known what each contact does.
///
/// ```text
/// K = E_σ H F_σ        E_σ: rows n of closed contacts, and t of those that stick
///                      F_σ: columns n, t where a contact sticks; n ∓ μ t where it slides
/// P = F_σ x,  K x = −E_σ b
/// ```
/// `K` is unsymmetric where a contact slides. Rows that depend on others drop out with their unknowns (elimination with complete pivoting):
/// redundant contacts are the rule. Serves the contact problem and what is condensed from it alike.
/// # Shapes and units
/// `K` up to 2n×2n, 1/kg; `x` N·s.
#[derive(Debug, Clone)]
pub struct StateSystem {
    /// Stacked row of each unknown: the contact, or n plus the contact where it is tangential.
    rows: Vec<usize>,
    len: usize,
    rank: usize,
    /// `K`, then its factors.
    matrix: Vec<f64>,
    row_order: Vec<usize>,
    column_order: Vec<usize>,
    /// Room for a permuted right-hand side.
    permuted: Vec<f64>,
}

impl StateSystem {
    /// Makes room for this many contacts.
    pub fn new(contacts: usize) -> Self {
        let n = 2 * contacts;
        StateSystem {
            rows: vec![0; n],
            len: 0,
            rank: 0,
            matrix: vec![0.0; n * n],
            row_order: vec![0; n],
            column_order: vec![0; n],
            permuted: vec![0.0; n],
        }
    }

    /// Makes more room if these many contacts need it.
    pub fn grow(&mut self, contacts: usize) {
        if 2 * contacts > self.rows.len() {
            *self = StateSystem::new(contacts);
        }
    }

    /// Returns the stacked rows of the unknowns, in their order.
    #[inline]
    pub fn rows(&self) -> &[usize] {
        &self.rows[..self.len]
    }

    /// Returns how many of them are independent.
    #[inline]
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Returns one entry of `row F_σ` for the unknown `k`, from a row of stacked `[n; t]` entries.
    #[inline]
    pub fn column_of(&self, k: usize, friction: &[f64], states: &[ContactState], row: impl Fn(usize) -> f64) -> f64 {
        let (source, n) = (self.rows[k], states.len());
        let own = row(source);
        if source >= n {
            return own;
        }
        match states[source] {
            ContactState::Open | ContactState::Stick => own,
            slips => own + slips.friction() * friction[source] * row(n + source),
        }
    }

    /// Takes the equations of these states and factorises them; `entry` gives `H`.
    pub fn factorise(&mut self, friction: &[f64], states: &[ContactState], entry: impl Fn(usize, usize) -> f64) {
        let n = states.len();
        self.grow(n);
        self.len = 0;
        for (contact, state) in states.iter().enumerate() {
            if *state != ContactState::Open {
                self.rows[self.len] = contact;
                self.len += 1;
            }
            if *state == ContactState::Stick {
                self.rows[self.len] = n + contact;
                self.len += 1;
            }
        }
        let k = self.len;
        let mut matrix = std::mem::take(&mut self.matrix);
        for (slot, target) in matrix[..k * k].chunks_exact_mut(k.max(1)).enumerate() {
            let row = self.rows[slot];
            for (other, target) in target.iter_mut().enumerate() {
                *target = self.column_of(other, friction, states, |column| entry(row, column));
            }
        }
        self.matrix = matrix;
        self.eliminate();
    }

    /// Elimination with complete pivoting, up to the first pivot that is zero.
    fn eliminate(&mut self) {
        let k = self.len;
        let StateSystem { matrix, row_order, column_order, .. } = self;
        let (matrix, row_order, column_order) = (&mut matrix[..k * k], &mut row_order[..k], &mut column_order[..k]);
        row_order.iter_mut().enumerate().for_each(|(i, order)| *order = i);
        column_order.iter_mut().enumerate().for_each(|(i, order)| *order = i);
        let mut largest = 0.0;
        self.rank = k;
        for step in 0..k {
            let (mut pivot, mut row, mut column) = (0.0, step, step);
            for i in step..k {
                for (j, entry) in matrix[i * k + step..(i + 1) * k].iter().enumerate() {
                    if entry.abs() > pivot {
                        (pivot, row, column) = (entry.abs(), i, step + j);
                    }
                }
            }
            largest = if step == 0 { pivot } else { largest };
            if pivot.is_nan() || pivot <= DEPENDENT * largest {
                self.rank = step;
                return;
            }
            if row != step {
                let (above, below) = matrix.split_at_mut(row * k);
                above[step * k..(step + 1) * k].swap_with_slice(&mut below[..k]);
                row_order.swap(step, row);
            }
            if column != step {
                for line in matrix.chunks_exact_mut(k) {
                    line.swap(step, column);
                }
                column_order.swap(step, column);
            }
            let (above, below) = matrix.split_at_mut((step + 1) * k);
            let line = &above[step * k..];
            let inverse = 1.0 / line[step];
            for target in below.chunks_exact_mut(k) {
                let factor = target[step] * inverse;
                target[step] = factor;
                if factor != 0.0 {
                    for (entry, above) in target[step + 1..].iter_mut().zip(&line[step + 1..]) {
                        *entry -= factor * above;
                    }
                }
            }
        }
    }

    /// Replaces `x`, one entry per unknown, by `K⁻¹ x`; unknowns of dependent rows are 0.
    pub fn solve(&mut self, x: &mut [f64]) {
        let (k, rank) = (self.len, self.rank);
        let StateSystem { matrix, row_order, column_order, permuted, .. } = self;
        let y = &mut permuted[..rank];
        for i in 0..rank {
            let known: f64 = matrix[i * k..i * k + i].iter().zip(&*y).map(|(l, y)| l * y).sum();
            y[i] = x[row_order[i]] - known;
        }
        x[..k].fill(0.0);
        for i in (0..rank).rev() {
            let line = &matrix[i * k..i * k + rank];
            let known: f64 = line[i + 1..].iter().zip(&y[i + 1..]).map(|(u, y)| u * y).sum();
            y[i] = (y[i] - known) / line[i];
        }
        for (y, &column) in y.iter().zip(&*column_order) {
            x[column] = *y;
        }
    }

    /// Writes `P = F_σ x`.
    pub fn impulses(&self, friction: &[f64], states: &[ContactState], x: &[f64], impulses: &mut [f64]) {
        let n = states.len();
        impulses[..2 * n].fill(0.0);
        for (&row, &x) in self.rows().iter().zip(x) {
            impulses[row] = x;
            if row < n {
                // One that sticks has its own unknown, which comes next.
                impulses[n + row] = states[row].friction() * friction[row] * x;
            }
        }
    }
}
