//! The linear equations of one combination of states.

use super::ContactState;
use crate::known_size;

/// A pivot below this part of the first one is zero: its row depends on those before.
const DEPENDENT: f64 = 1e-11;
/// Pivots in the order of the last matrix serve while no row is subtracted more often than this: complete pivoting,
/// which searches all that is left at every step, has 1.
const GROWTH: f64 = 8.0;

/// The equations that hold once it is known what each contact does.
///
/// ```text
/// K = E_σ H F_σ        E_σ: rows n of closed contacts, and t of those that stick
///                      F_σ: columns n, t where a contact sticks; n ∓ μ t where it slides
/// P = F_σ x,  K x = −E_σ b
/// ```
/// `K` is unsymmetric where a contact slides. Rows that depend on others drop out with their unknowns (elimination with
/// complete pivoting): redundant contacts are the rule. Serves the contact problem and what is condensed from it alike.
///
/// Matrices of one combination of states after the other are much alike: they are taken apart in the order of the last
/// one, and searched for pivots only where that order does not serve.
/// # Shapes and units
/// `K` up to 2n×2n, 1/kg; `x` N·s.
#[derive(Debug, Clone)]
pub struct StateSystem {
    /// Stacked row of each unknown: the contact, or n plus the contact where it is tangential, 2n plus it for a second
    /// tangential row.
    rows: Vec<usize>,
    /// Of each unknown what its column is made of: `H_·row`, plus so many times the tangential one.
    columns: Vec<Column>,
    /// In space, the second tangential row of each unknown, and its factor.
    seconds: Vec<(usize, f64)>,
    /// The states of the last matrix.
    states: Vec<ContactState>,
    len: usize,
    rank: usize,
    /// Whether one of them slides.
    slides: bool,
    /// Tangential rows of a contact: 1 in the plane, 2 in space.
    tangents: usize,
    /// `K` in the order of its pivots, then its upper factor, from the diagonal on; row after row, as the lower one,
    /// and one over the pivots.
    matrix: Vec<f64>,
    lower: Vec<f64>,
    inverse: Vec<f64>,
    row_order: Vec<usize>,
    column_order: Vec<usize>,
    /// Rows and columns of the unknowns in that order.
    ordered_rows: Vec<usize>,
    ordered_columns: Vec<Column>,
    /// Room for a permuted right-hand side.
    permuted: Vec<f64>,
}

/// Column of `F_σ` of one unknown.
#[derive(Debug, Clone, Copy, Default)]
struct Column {
    row: usize,
    tangential: usize,
    /// `∓μ` of a contact that slides, in space times the first part of its direction; else 0.
    factor: f64,
}

impl Column {
    #[inline(always)]
    fn of(self, line: &[f64]) -> f64 {
        line[self.row] + self.factor * line[self.tangential]
    }
}

/// `y − factor · x`.
#[inline(always)]
fn subtract<const K: usize>(y: &mut [f64; K], x: &[f64; K], factor: f64) {
    for at in 0..K {
        y[at] -= factor * x[at];
    }
}

impl StateSystem {
    /// Makes room for this many contacts.
    pub fn new(contacts: usize) -> Self {
        Self::with_tangents(contacts, 1)
    }

    /// Makes room for this many contacts with 1 tangential row each, in the plane, or 2, in space.
    pub fn with_tangents(contacts: usize, tangents: usize) -> Self {
        let n = (1 + tangents) * contacts;
        StateSystem {
            tangents,
            rows: vec![0; n],
            columns: vec![Column::default(); n],
            seconds: vec![(0, 0.0); if tangents > 1 { n } else { 0 }],
            states: Vec::with_capacity(contacts),
            len: 0,
            rank: 0,
            slides: false,
            matrix: vec![0.0; n * n],
            lower: vec![0.0; n * n],
            inverse: vec![0.0; n],
            ordered_rows: vec![0; n],
            ordered_columns: vec![Column::default(); n],
            row_order: vec![0; n],
            column_order: vec![0; n],
            permuted: vec![0.0; n],
        }
    }

    /// Makes more room if these many contacts need it.
    pub fn grow(&mut self, contacts: usize) {
        if (1 + self.tangents) * contacts > self.rows.len() {
            *self = StateSystem::with_tangents(contacts, self.tangents);
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

    /// Returns the entry of `line F_σ` for the unknown `k`, 1/kg; `line` are stacked entries, `[n; t]` first.
    #[inline]
    pub fn column_of(&self, k: usize, line: &[f64]) -> f64 {
        self.columns[k].of(line) + self.seconds.get(k).map_or(0.0, |(row, factor)| factor * line[*row])
    }

    /// Tells whether the last matrix was one of these states.
    #[inline]
    pub fn is_of(&self, states: &[ContactState]) -> bool {
        self.states == states
    }

    /// Takes the equations of these states and factorises them; `line` gives a stacked row of `H`, contacts and
    /// tangential rows first.
    #[inline]
    pub fn factorise<'a>(&mut self, friction: &[f64], states: &[ContactState], line: impl Fn(usize) -> &'a [f64]) {
        self.factorise_along(friction, states, &[], line);
    }

    /// Takes them where contacts that slide in space do so along these `directions`, of length 1; none are needed in
    /// the plane.
    #[inline]
    pub fn factorise_along<'a>(
        &mut self,
        friction: &[f64],
        states: &[ContactState],
        directions: &[[f64; 2]],
        line: impl Fn(usize) -> &'a [f64],
    ) {
        let again = self.is_of(states);
        if !again {
            self.take_states(states);
        }
        // Coefficients count where something slides.
        if !again || self.slides {
            self.take_columns(friction, directions);
        }
        if !(again && self.eliminate_in_order(&line)) {
            self.eliminate(&line);
        }
    }

    fn take_columns(&mut self, friction: &[f64], directions: &[[f64; 2]]) {
        let n = self.states.len();
        self.slides = false;
        for (column, &row) in self.columns.iter_mut().zip(&self.rows[..self.len]) {
            *column = Column { row, tangential: row, factor: 0.0 };
            if row < n {
                column.tangential = n + row;
                let direction = self.states[row].friction();
                column.factor = direction * friction[row];
                self.slides |= direction != 0.0;
            }
        }
        for (second, column) in self.seconds.iter_mut().zip(&mut self.columns[..self.len]) {
            let along = if column.row < n { directions[column.row] } else { [1.0, 0.0] };
            *second = (column.tangential + if column.row < n { n } else { 0 }, column.factor * along[1]);
            column.factor *= along[0];
        }
        for (ordered, &column) in self.ordered_columns.iter_mut().zip(&self.column_order[..self.len]) {
            *ordered = self.columns[column];
        }
    }

    fn take_states(&mut self, states: &[ContactState]) {
        let n = states.len();
        self.grow(n);
        self.states.clear();
        self.states.extend_from_slice(states);
        self.len = 0;
        for (contact, state) in states.iter().enumerate() {
            if *state != ContactState::Open {
                self.rows[self.len] = contact;
                self.len += 1;
            }
            if *state == ContactState::Stick {
                for tangent in 1..=self.tangents {
                    self.rows[self.len] = tangent * n + contact;
                    self.len += 1;
                }
            }
        }
    }

    /// Elimination in the order of the last matrix; says whether that serves this one: as many pivots, and none too
    /// small.
    #[inline]
    fn eliminate_in_order<'a>(&mut self, line: &impl Fn(usize) -> &'a [f64]) -> bool {
        // Searched each time: models in space are condensed once per macro step.
        if self.tangents > 1 && self.len > 0 {
            return false;
        }
        known_size!(self.len, K if K <= 8 => self.eliminate_few::<K>(line), k => k == 0)
    }

    /// Solves with a size that the compiler knows; more unknowns are searched for pivots each time.
    ///
    /// Whole lines are subtracted, what is finished included: that is faster than lines of different lengths.
    #[inline(never)]
    fn eliminate_few<'a, const K: usize>(&mut self, line: &impl Fn(usize) -> &'a [f64]) -> bool {
        let StateSystem { matrix, lower, inverse, ordered_rows, ordered_columns, rank, slides, .. } = self;
        let rank = (*rank).min(K);
        let (columns, inverse) = (&ordered_columns[..K], &mut inverse[..K]);
        let lines = &mut matrix.as_chunks_mut::<K>().0[..K];
        let lower = &mut lower.as_chunks_mut::<K>().0[..K];
        if *slides {
            for (target, &row) in lines.iter_mut().zip(&*ordered_rows) {
                let source = line(row);
                for (target, column) in target.iter_mut().zip(columns) {
                    *target = column.of(source);
                }
            }
        } else {
            let mut from = [0; K];
            for (from, column) in from.iter_mut().zip(columns) {
                *from = column.row;
            }
            for (target, &row) in lines.iter_mut().zip(&*ordered_rows) {
                let source = line(row);
                *target = from.map(|column| source[column]);
            }
        }
        let (mut largest, mut growth, mut served) = (0.0, 0.0, true);
        for step in 0..rank {
            let (above, below) = lines.split_at_mut(step + 1);
            let line = &above[step];
            let pivot = line[step];
            largest = if pivot.abs() > largest { pivot.abs() } else { largest };
            served &= pivot.abs() > DEPENDENT * largest;
            inverse[step] = 1.0 / pivot;
            for (target, kept) in below.iter_mut().zip(&mut lower[step + 1..]) {
                let factor = target[step] * inverse[step];
                growth = if factor * factor > growth { factor * factor } else { growth };
                kept[step] = factor;
                subtract(target, line, factor);
            }
        }
        // Rows beyond the rank must still depend on the pivots.
        for line in &lines[rank..] {
            served &= line[rank..].iter().all(|entry| entry.abs() <= DEPENDENT * largest);
        }
        served && growth <= GROWTH * GROWTH
    }

    /// Elimination with complete pivoting, up to the first pivot that is zero.
    #[cold]
    fn eliminate<'a>(&mut self, line: &impl Fn(usize) -> &'a [f64]) {
        let k = self.len;
        let StateSystem { rows, columns, seconds, matrix, row_order, column_order, .. } = self;
        for (target, &row) in matrix[..k * k].chunks_exact_mut(k.max(1)).zip(&*rows) {
            let source = line(row);
            for (target, column) in target.iter_mut().zip(&*columns) {
                *target = column.of(source);
            }
            for (target, (row, factor)) in target.iter_mut().zip(&*seconds) {
                *target += factor * source[*row];
            }
        }
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
                break;
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
        self.keep_factors();
    }

    /// Puts factors and order where they are used.
    fn keep_factors(&mut self) {
        let (k, rank) = (self.len, self.rank);
        self.lower[..k * k].copy_from_slice(&self.matrix[..k * k]);
        for step in 0..rank {
            self.inverse[step] = 1.0 / self.matrix[step * k + step];
        }
        for (to, (&row, &column)) in self.row_order[..k].iter().zip(&self.column_order).enumerate() {
            self.ordered_rows[to] = self.rows[row];
            self.ordered_columns[to] = self.columns[column];
        }
    }

    /// Replaces `x`, one entry per unknown, by `K⁻¹ x`; unknowns of dependent rows are 0.
    pub fn solve(&mut self, x: &mut [f64]) {
        let k = self.len;
        for at in 0..k {
            self.permuted[at] = x[self.row_order[at]];
        }
        self.solve_ordered();
        x[..k].fill(0.0);
        for (y, &column) in self.permuted[..self.rank].iter().zip(&self.column_order) {
            x[column] = *y;
        }
    }

    /// Writes `P = −F_σ K⁻¹ E_σ b`, for as many contacts as the states had.
    #[inline]
    pub fn impulses(&mut self, b: &[f64], impulses: &mut [f64]) {
        for (y, &row) in self.permuted.iter_mut().zip(&self.ordered_rows[..self.len]) {
            *y = -b[row];
        }
        self.solve_ordered();
        impulses[..(1 + self.tangents) * self.states.len()].fill(0.0);
        for (column, &x) in self.ordered_columns.iter().zip(&self.permuted[..self.rank]) {
            impulses[column.row] = x;
            if column.factor != 0.0 {
                impulses[column.tangential] = column.factor * x;
            }
        }
        // Impulses of sliding contacts along their second tangent.
        for ((row, factor), column) in self.seconds.iter().zip(&self.columns[..self.len]) {
            if *factor != 0.0 {
                impulses[*row] = factor * impulses[column.row];
            }
        }
    }

    /// Solves for what stands in `permuted`, rows and unknowns in the order of the pivots.
    #[inline]
    fn solve_ordered(&mut self) {
        known_size!(self.len, K if K <= 8 => self.solve_few::<K>(), k => self.solve_lines(k, self.rank));
    }

    #[inline(never)]
    fn solve_few<const K: usize>(&mut self) {
        if self.rank == K { self.solve_lines(K, K) } else { self.solve_lines(K, self.rank) }
    }

    #[inline(always)]
    fn solve_lines(&mut self, k: usize, rank: usize) {
        let StateSystem { matrix, lower, inverse, permuted, .. } = self;
        let (lower, upper, inverse) = (&lower[..k * k], &matrix[..k * k], &inverse[..k]);
        let (y, rank) = (&mut permuted[..k], rank.min(k));
        for i in 1..rank {
            let known: f64 = lower[i * k..i * k + i].iter().zip(&*y).map(|(l, y)| l * y).sum();
            y[i] -= known;
        }
        for i in (0..rank).rev() {
            let line = &upper[i * k..(i + 1) * k];
            let known: f64 = line[i + 1..rank].iter().zip(&y[i + 1..rank]).map(|(u, y)| u * y).sum();
            y[i] = (y[i] - known) * inverse[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_contact_in_space_slides_with_its_friction_along_both_tangents() {
        let h = [[2.0, 0.5, 0.25], [0.5, 1.0, 0.0], [0.25, 0.0, 1.0]];
        let mut system = StateSystem::with_tangents(1, 2);
        system.factorise_along(&[0.5], &[ContactState::SlipPositive], &[[0.6, 0.8]], |row| &h[row]);
        let mut impulses = [0.0; 3];
        system.impulses(&[-1.75, 3.0, 4.0], &mut impulses);
        // w_n = 2 P_n + 0.5 P_1 + 0.25 P_2 − 1.75 = 0 with P_t = −0.5 P_n [0.6, 0.8].
        for (impulse, wanted) in impulses.into_iter().zip([1.0, -0.3, -0.4]) {
            approx::assert_relative_eq!(impulse, wanted, max_relative = 1e-14);
        }
    }

    #[test]
    fn unknowns_of_dependent_rows_are_zero_whatever_was_solved_before() {
        let (friction, states) = ([0.0; 2], [ContactState::SlipPositive; 2]);
        let mut system = StateSystem::new(2);
        for (coupling, rank, solved) in [(0.0, 2, [3.0, 5.0]), (1.0, 1, [3.0, 0.0]), (-1.0, 1, [3.0, 0.0])] {
            // Normal rows before tangential ones.
            let h = [[1.0, coupling, 0.0, 0.0], [coupling, 1.0, 0.0, 0.0], [0.0; 4], [0.0; 4]];
            system.factorise(&friction, &states, |row| &h[row]);
            let mut x = [3.0, 5.0];
            system.solve(&mut x);
            assert_eq!((system.rank(), x), (rank, solved), "{coupling}");
        }
    }
}
