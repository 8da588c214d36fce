//! Eq. 4 discretised over the micro step δ, for the contacts of the set.

use super::implicit_feedthrough::ImplicitFeedthrough;
use crate::error::Failure;
use crate::interface_model::{Condensation, ReducedInterfaceModel};
use crate::linear_algebra::{SymmetricPattern, SymmetricRows};
use std::sync::Arc;

/// Eq. 4 over a micro step of length δ, column by column, contacts of the set first.
///
/// ```text
/// w⁺ = w + δ a + δ H_·i λ + H_·u P            w = [w_u; w_i]
/// ```
/// Within a macro step everything but `w`, `λ` and `P` stays the same, so `δ a` and `δ H_·i` are multiplied out once. For
/// an interface of one row a micro step then is two multiples of a vector, and one more for each contact that carries
/// impulse.
#[derive(Debug, Clone, Default)]
pub(super) struct DiscretisedModel {
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
    meeting: Option<Arc<SymmetricPattern>>,
}

impl DiscretisedModel {
    /// Reserves `contacts` contacts and `interface` interface rows.
    pub(super) fn new(contacts: usize, interface: usize) -> Self {
        let rows = contacts + interface;
        DiscretisedModel {
            contacts: 0,
            length: f64::NAN,
            free_increment: vec![0.0; rows],
            force_columns: vec![0.0; rows * interface],
            impulse_columns: vec![0.0; rows * contacts],
            h_uu: vec![0.0; contacts * contacts],
            meeting: None,
        }
    }

    /// Reserves room for models like this one with all their contacts, by the pattern of their Delassus matrix if they have one.
    pub(super) fn of_all(model: &ReducedInterfaceModel) -> Self {
        let Some(meeting) = model.meeting() else { return Self::new(model.contacts(), model.interface()) };
        let (rows, n_i) = (model.contacts() + model.interface(), model.interface());
        DiscretisedModel {
            free_increment: vec![0.0; rows],
            force_columns: vec![0.0; rows * n_i],
            impulse_columns: vec![0.0; rows * n_i],
            h_uu: vec![0.0; meeting.entries()],
            meeting: Some(meeting.clone()),
            ..Self::new(0, 0)
        }
    }

    /// Returns `H_uu` by its pattern, if it has one.
    #[inline]
    pub(super) fn contact_rows(&self) -> Option<SymmetricRows<'_>> {
        self.meeting.as_deref().map(|pattern| SymmetricRows { pattern, entries: &self.h_uu })
    }

    /// Returns the rows of contacts in the set; none where they are condensed away.
    #[inline]
    pub(super) fn contacts(&self) -> usize {
        self.contacts
    }

    /// Returns δ, s.
    #[inline]
    pub(super) fn length(&self) -> f64 {
        self.length
    }

    /// Returns `H_uu` of the set.
    #[inline]
    pub(super) fn h_uu(&self) -> &[f64] {
        &self.h_uu[..self.contacts * self.contacts]
    }

    /// Returns `δ a` of `rows` rows.
    #[inline]
    pub(super) fn free_increment(&self, rows: usize) -> &[f64] {
        &self.free_increment[..rows]
    }

    /// Returns column `j` of `δ H_·i`, of `rows` rows.
    #[inline]
    pub(super) fn force_column(&self, j: usize, rows: usize) -> &[f64] {
        &self.force_columns[j * rows..(j + 1) * rows]
    }

    /// Discretises `model` over `length` (s) for the rows `set`: contacts, then their tangential rows where they have friction.
    pub(super) fn discretise(&mut self, model: &ReducedInterfaceModel, set: &[usize], length: f64) {
        let (n, n_u, n_i) = (set.len(), model.interface_start(), model.interface());
        let rows = n + n_i;
        (self.contacts, self.length) = (n, length);
        if self.meeting.is_some() {
            return self.discretise_by_pattern(model);
        }
        let sources = || set.iter().copied().chain(n_u..n_u + n_i).enumerate();
        for (row, source) in sources() {
            self.free_increment[row] = length * model.a[source];
            for j in 0..n_i {
                self.force_columns[j * rows + row] = length * model.entry(source, n_u + j);
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
    fn discretise_by_pattern(&mut self, model: &ReducedInterfaceModel) {
        if let (Some(meeting), Some(packed)) = (model.meeting(), &mut self.meeting)
            && !Arc::ptr_eq(meeting, packed)
        {
            packed.clone_from(meeting);
            self.h_uu.resize(meeting.entries(), 0.0);
        }
        let (h_uu, of_interface) = model.h.split_at(self.h_uu.len());
        self.h_uu.copy_from_slice(h_uu);
        self.impulse_columns.copy_from_slice(of_interface);
        for (free_increment, a) in self.free_increment.iter_mut().zip(&model.a) {
            *free_increment = self.length * a;
        }
        for (force, h) in self.force_columns.iter_mut().zip(&self.impulse_columns) {
            *force = self.length * h;
        }
    }

    /// Adds the compliance of contacts to the diagonal of `H_uu` (1/kg).
    pub(super) fn regularise(&mut self, addition: f64) {
        let n = self.contacts;
        for contact in 0..n {
            self.h_uu[contact * n + contact] += addition;
        }
    }

    /// Eliminates a force that depends on the velocity within the micro step.
    ///
    /// ```text
    /// λ = λ₀ + E (w_i⁺ − w_i)        K = E (1 − δ H_ii E)⁻¹
    /// δ a += δ H_·i K δ a_i          δ H_·i += δ H_·i K δ H_ii          H_·u += δ H_·i K H_iu
    /// ```
    /// The discretised model then takes `λ₀` as its force.
    /// # Errors
    /// [`Cause::Singular`](crate::error::Cause::Singular) if force and velocity do not determine each other.
    pub(super) fn eliminate_feedthrough(&mut self, following: &mut ImplicitFeedthrough) -> Result<(), Failure> {
        let (n, n_i) = (self.contacts, following.interface());
        let rows = n + n_i;
        let DiscretisedModel { free_increment, force_columns, impulse_columns, h_uu, .. } = self;
        let force_columns = &mut force_columns[..rows * n_i];
        following.eliminate(|row, column| force_columns[column * rows + n + row])?;
        let respond = |target: &mut [f64], room: &mut [f64], following: &ImplicitFeedthrough| {
            room.copy_from_slice(&target[n..]);
            for (force, column) in force_columns.chunks_exact(rows).enumerate() {
                add_multiple(target, following.response(force, room), column);
            }
        };
        let mut room = std::mem::take(&mut following.room);
        respond(&mut free_increment[..rows], &mut room, following);
        for (slot, column) in impulse_columns.chunks_exact_mut(rows.max(1)).take(n).enumerate() {
            respond(column, &mut room, following);
            for row in 0..n {
                h_uu[row * n + slot] = column[row];
            }
        }
        // Rows of δ H_·i, all columns at once: each column is needed as it was.
        following.mix(rows, force_columns);
        following.room = room;
        Ok(())
    }

    /// Discretises a model whose closed contacts are condensed away.
    pub(super) fn discretise_condensed(&mut self, model: &Condensation, length: f64) {
        (self.contacts, self.length) = (0, length);
        for (free_increment, a) in self.free_increment.iter_mut().zip(&model.a) {
            *free_increment = length * a;
        }
        // Ĥ_ii is symmetric without friction: its rows are its columns.
        for (column, h) in self.force_columns.iter_mut().zip(&model.h) {
            *column = length * h;
        }
        if model.is_unsymmetric() {
            let n = model.a.len();
            for (at, h) in model.h.iter().enumerate() {
                self.force_columns[at % n * n + at / n] = length * h;
            }
        }
    }

    /// Writes `w + δ a + δ H_·i λ` to `free`.
    #[inline]
    pub(super) fn free_velocity(&self, w: &[f64], lambda: &[f64], free: &mut [f64]) {
        let rows = w.len();
        for (free, (w, free_increment)) in free.iter_mut().zip(w.iter().zip(&self.free_increment)) {
            *free = w + free_increment;
        }
        for (j, &force) in lambda.iter().enumerate() {
            add_multiple(free, force, &self.force_columns[j * rows..(j + 1) * rows]);
        }
    }

    /// Writes the velocities after a step without contact impulses to `next`; returns true, as no contact problem is left.
    #[inline(never)]
    pub(super) fn step_without_contacts(&self, w: &[f64], lambda: &[f64], next: &mut [f64]) -> bool {
        if let &[force] = lambda {
            next[0] = w[0] + self.free_increment[0] + force * self.force_columns[0];
        } else {
            let rows = lambda.len();
            self.free_velocity(&w[..rows], lambda, &mut next[..rows]);
        }
        true
    }

    /// Adds `H_·u P` to `w`.
    #[inline]
    pub(super) fn add_impulses(&self, impulses: &[f64], w: &mut [f64]) {
        for (contact, &impulse) in impulses.iter().enumerate() {
            if impulse != 0.0 {
                self.add_impulse(contact, impulse, w);
            }
        }
    }

    /// Adds `H_·α P_α` of one contact of the set to `w`.
    #[inline]
    pub(super) fn add_impulse(&self, contact: usize, impulse: f64, w: &mut [f64]) {
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

/// `target += factor · x`.
#[inline]
pub(super) fn add_multiple(target: &mut [f64], factor: f64, x: &[f64]) {
    for (target, x) in target.iter_mut().zip(x) {
        *target += factor * x;
    }
}
