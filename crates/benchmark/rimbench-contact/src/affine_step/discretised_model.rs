//! Contacts and interface rows over a micro step δ: a linear model, discretised for a set of contacts.

use crate::known_size;
use crate::linear_algebra::{SymmetricPattern, SymmetricRows};
use std::sync::Arc;

/// A linear model of contact rows `u` and interface rows `i`, as it stands: `ẇ = a + H_·u Ṗ + H_·i λ`.
///
/// # Shapes and units
/// Rows stacked `[u; i]`: `a` m/s²; `h` 1/kg, row-major. With a `pattern`, `h` holds the entries of `H_uu` where the
/// pattern says, then `H_ui` column by column, then `H_ii`.
#[derive(Debug, Clone, Copy)]
pub struct LinearModel<'a> {
    /// `H`.
    pub h: &'a [f64],
    /// Free accelerations, m/s².
    pub a: &'a [f64],
    /// Rows of contacts; with friction normal rows, then tangential ones.
    pub contact_rows: usize,
    /// Rows of the interface.
    pub interface: usize,
    /// The non-zeros of `H_uu`, where it is not dense.
    pub pattern: Option<&'a Arc<SymmetricPattern>>,
    /// Whether `H_ui` is not the transpose of `H_iu`.
    pub unsymmetric: bool,
}

impl LinearModel<'_> {
    /// Returns one entry of `H`, 1/kg.
    #[inline(always)]
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        let n = self.contact_rows;
        let Some(pattern) = self.pattern else { return self.h[row * (n + self.interface) + column] };
        let (row, column) = (row.min(column), row.max(column));
        if column < n {
            return pattern.position(row, column).map_or(0.0, |at| self.h[at]);
        }
        self.h[pattern.entries() + (column - n) * (n + self.interface) + row]
    }
}

/// Contacts from which a look whether all are in the set costs less than it spares.
const MANY: usize = 8;

/// The columns of a [`DiscretisedModel`], each as long as rows in use.
#[derive(Debug)]
pub struct DiscretisedColumns<'a> {
    /// `δ a`.
    pub free_increment: &'a mut [f64],
    /// Columns of `δ H_·i`.
    pub force_columns: &'a mut [f64],
    /// Columns of `H_·u`.
    pub impulse_columns: &'a mut [f64],
    /// `H_uu`, row-major.
    pub h_uu: &'a mut [f64],
}

/// A [`LinearModel`] over a micro step of length δ, column by column, contacts of the set first.
///
/// ```text
/// w⁺ = w + δ a + δ H_·i λ + H_·u P            w = [w_u; w_i]
/// ```
/// Within a macro step everything but `w`, `λ` and `P` is constant, so `δ a` and `δ H_·i` are multiplied out once. For
/// an interface of one row a micro step then is two multiples of a vector, and one more for each contact that carries
/// impulse.
#[derive(Debug, Clone, Default)]
pub struct DiscretisedModel {
    contacts: usize,
    /// δ, s.
    length: f64,
    /// `δ a`.
    free_increment: Vec<f64>,
    /// Columns of `δ H_·i`.
    force_columns: Vec<f64>,
    /// Columns of `H_·u`.
    impulse_columns: Vec<f64>,
    /// `H_uu`, row-major; where it has a pattern, its non-zeros.
    h_uu: Vec<f64>,
    pattern: Option<Arc<SymmetricPattern>>,
}

impl DiscretisedModel {
    /// Reserves `contacts` contacts and `interface` interface rows.
    pub fn new(contacts: usize, interface: usize) -> Self {
        let rows = contacts + interface;
        DiscretisedModel {
            contacts: 0,
            length: f64::NAN,
            free_increment: vec![0.0; rows],
            force_columns: vec![0.0; rows * interface],
            impulse_columns: vec![0.0; rows * contacts],
            h_uu: vec![0.0; contacts * contacts],
            pattern: None,
        }
    }

    /// Reserves all contacts of models whose Delassus matrix has this pattern, and `interface` interface rows.
    pub fn by_pattern(pattern: Arc<SymmetricPattern>, interface: usize) -> Self {
        let rows = pattern.size() + interface;
        DiscretisedModel {
            free_increment: vec![0.0; rows],
            force_columns: vec![0.0; rows * interface],
            impulse_columns: vec![0.0; rows * interface],
            h_uu: vec![0.0; pattern.entries()],
            pattern: Some(pattern),
            ..Self::new(0, 0)
        }
    }

    /// Returns `H_uu` by its pattern, if it has one.
    #[inline]
    pub fn contact_rows(&self) -> Option<SymmetricRows<'_>> {
        self.pattern.as_deref().map(|pattern| SymmetricRows { pattern, entries: &self.h_uu })
    }

    /// Returns the rows of contacts in the set; none where they are condensed away.
    #[inline]
    pub fn contacts(&self) -> usize {
        self.contacts
    }

    /// Returns δ, s.
    #[inline]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Returns `H_uu` of the set, n×n, row-major, 1/kg.
    #[inline]
    pub fn h_uu(&self) -> &[f64] {
        &self.h_uu[..self.contacts * self.contacts]
    }

    /// Returns `δ a` of `rows` rows, m/s.
    #[inline]
    pub fn free_increment(&self, rows: usize) -> &[f64] {
        &self.free_increment[..rows]
    }

    /// Returns column `j` of `δ H_·i`, of `rows` rows, s/kg.
    #[inline]
    pub fn force_column(&self, j: usize, rows: usize) -> &[f64] {
        &self.force_columns[j * rows..(j + 1) * rows]
    }

    /// Discretises `model` over `length` (s) for the rows `set`: contacts, then their tangential rows where they have
    /// friction.
    pub fn discretise(&mut self, model: LinearModel<'_>, set: &[usize], length: f64) {
        let (n, n_u, n_i) = (set.len(), model.contact_rows, model.interface);
        let rows = n + n_i;
        (self.contacts, self.length) = (n, length);
        if self.pattern.is_some() {
            return self.discretise_by_pattern(model);
        }
        // Where all of many contacts are in the set, the rows of the symmetric H are the columns, as they stand.
        let whole =
            n >= MANY && n == n_u && model.pattern.is_none() && !model.unsymmetric && set.iter().copied().eq(0..n);
        if whole {
            let h = &model.h[..n * rows];
            self.impulse_columns[..n * rows].copy_from_slice(h);
            known_size!(
                n,
                N if N > MANY => copy_first_columns::<N>(h, rows, &mut self.h_uu),
                _ => h.chunks_exact(rows).zip(self.h_uu.chunks_exact_mut(n)).for_each(|(row, out)| out.copy_from_slice(&row[..n])),
            );
        }
        let sources = set.iter().copied().chain(n_u..n_u + n_i).enumerate();
        for (row, source) in sources {
            self.free_increment[row] = length * model.a[source];
            for j in 0..n_i {
                self.force_columns[j * rows + row] = length * model.entry(source, n_u + j);
            }
            if whole {
                continue;
            }
            for (slot, &contact) in set.iter().enumerate() {
                let entry = model.entry(source, contact);
                self.impulse_columns[slot * rows + row] = entry;
                if row < n {
                    self.h_uu[row * n + slot] = entry;
                }
            }
        }
    }

    /// Discretises all contacts by their pattern; `impulse_columns` then are those of the interface.
    fn discretise_by_pattern(&mut self, model: LinearModel<'_>) {
        if let (Some(pattern), Some(own)) = (model.pattern, &mut self.pattern)
            && !Arc::ptr_eq(pattern, own)
        {
            own.clone_from(pattern);
            self.h_uu.resize(pattern.entries(), 0.0);
        }
        let (h_uu, of_interface) = model.h.split_at(self.h_uu.len());
        self.h_uu.copy_from_slice(h_uu);
        self.impulse_columns.copy_from_slice(of_interface);
        for (free_increment, a) in self.free_increment.iter_mut().zip(model.a) {
            *free_increment = self.length * a;
        }
        for (force, h) in self.force_columns.iter_mut().zip(&self.impulse_columns) {
            *force = self.length * h;
        }
    }

    /// Adds the compliance of contacts to the diagonal of `H_uu` (1/kg), in their normal rows, the first ones.
    pub fn regularise(&mut self, normal_rows: usize, addition: f64) {
        let n = self.contacts;
        for contact in 0..normal_rows {
            self.h_uu[contact * n + contact] += addition;
        }
    }

    /// Lends all columns, to change a model after its discretisation.
    pub fn columns_mut(&mut self) -> DiscretisedColumns<'_> {
        let DiscretisedModel { free_increment, force_columns, impulse_columns, h_uu, .. } = self;
        DiscretisedColumns { free_increment, force_columns, impulse_columns, h_uu }
    }

    /// Discretises a model of interface rows alone, `w⁺ = w + δ a + δ H λ`, over `length` (s); `h` is row-major. Of a
    /// symmetric one rows are taken as columns.
    pub fn discretise_interface(&mut self, a: &[f64], h: &[f64], symmetric: bool, length: f64) {
        (self.contacts, self.length) = (0, length);
        for (free_increment, a) in self.free_increment.iter_mut().zip(a) {
            *free_increment = length * a;
        }
        for (column, h) in self.force_columns.iter_mut().zip(h) {
            *column = length * h;
        }
        if !symmetric {
            let n = a.len();
            for (at, h) in h.iter().enumerate() {
                self.force_columns[at % n * n + at / n] = length * h;
            }
        }
    }

    /// Writes `w + δ a + δ H_·i λ` to `free`.
    #[inline]
    pub fn free_velocity(&self, w: &[f64], lambda: &[f64], free: &mut [f64]) {
        let rows = w.len();
        for (free, (w, free_increment)) in free.iter_mut().zip(w.iter().zip(&self.free_increment)) {
            *free = w + free_increment;
        }
        for (j, &force) in lambda.iter().enumerate() {
            add_multiple(free, force, &self.force_columns[j * rows..(j + 1) * rows]);
        }
    }

    /// Writes the velocities after a step without contact impulses to `w_plus`; returns true, as no contact problem is
    /// left.
    #[inline(never)]
    pub fn step_without_contacts(&self, w: &[f64], lambda: &[f64], w_plus: &mut [f64]) -> bool {
        if let &[force] = lambda {
            w_plus[0] = w[0] + self.free_increment[0] + force * self.force_columns[0];
        } else {
            let rows = lambda.len();
            self.free_velocity(&w[..rows], lambda, &mut w_plus[..rows]);
        }
        true
    }

    /// Adds `H_·u P` to `w`.
    #[inline]
    pub fn add_impulses(&self, impulses: &[f64], w: &mut [f64]) {
        for (contact, &impulse) in impulses.iter().enumerate() {
            if impulse != 0.0 {
                self.add_impulse(contact, impulse, w);
            }
        }
    }

    /// Adds `H_·α P_α` of one contact of the set to `w`.
    #[inline]
    pub fn add_impulse(&self, contact: usize, impulse: f64, w: &mut [f64]) {
        let rows = w.len();
        if let Some(h_uu) = self.contact_rows() {
            h_uu.add_row(contact, impulse, w);
            let columns = self.impulse_columns.chunks_exact(rows);
            w[self.contacts..].iter_mut().zip(columns).for_each(|(w, column)| *w += impulse * column[contact]);
            return;
        }
        add_multiple(w, impulse, &self.impulse_columns[contact * rows..(contact + 1) * rows]);
    }
}

#[inline(never)]
fn copy_first_columns<const N: usize>(h: &[f64], columns: usize, out: &mut [f64]) {
    for (row, out) in h.chunks_exact(columns).zip(out.as_chunks_mut::<N>().0) {
        // In halves: to copy more than 16 numbers at once the compiler calls a function.
        let (first, second) = out.split_at_mut(N / 2);
        first.copy_from_slice(&row[..N / 2]);
        second.copy_from_slice(&row[N / 2..N]);
    }
}

/// Adds `factor · x` to `target`.
#[inline]
pub(super) fn add_multiple(target: &mut [f64], factor: f64, x: &[f64]) {
    for (target, x) in target.iter_mut().zip(x) {
        *target += factor * x;
    }
}
