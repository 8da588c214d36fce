//! From Eq. 3 to Eq. 4 where few of many contacts are coupled: no joints, a diagonal mass, and rows that involve few
//! velocities each.

use super::delassus_products::DelassusProducts;
use super::linearisation::{Linearisation, MassMatrix, Rows};
use super::reduced_interface_model::ReducedInterfaceModel;
use rimbench_contact::linear_algebra::SymmetricPattern;

/// Eliminates velocities contact by contact and meeting by meeting.
///
/// ```text
/// H_αβ = Σ_k A_αk A_βk / m_k            over the velocities k that both contacts share
/// H_xi = A_x M⁻¹ A_iᵀ      w_x = A_x v      a_x = A_x M⁻¹ f + Ȧ_x v
/// ```
/// All of it costs as much as there are meetings, of which each contact of a heap has a few.
#[derive(Debug, Clone)]
pub(super) struct LocalElimination {
    products: DelassusProducts,
    inverse_mass: Vec<f64>,
    /// `A_u M⁻¹` and `M⁻¹ A_iᵀ`.
    scaled: Vec<f64>,
    interface: Vec<f64>,
    /// Columns of the entries of `A_u`, and where its rows start.
    columns: Vec<u32>,
    starts: Vec<usize>,
}

impl LocalElimination {
    /// Returns the contacts that are coupled: those that share a velocity.
    pub(super) fn delassus_pattern(rows: &Rows, velocities: usize) -> Option<SymmetricPattern> {
        let (starts, columns) = rows.columns_by_row()?;
        Some(DelassusProducts::pattern(starts, columns, velocities))
    }

    /// Lists the products of every meeting; none if the rows keep all their entries.
    pub(super) fn new(eq3: &Linearisation, pattern: &SymmetricPattern) -> Option<Self> {
        let (starts, columns) = eq3.unilateral.columns_by_row()?;
        let (n, n_i) = (eq3.velocities(), eq3.interface.len());
        Some(LocalElimination {
            products: DelassusProducts::new(starts, columns, pattern),
            inverse_mass: vec![0.0; n],
            scaled: vec![0.0; columns.len()],
            interface: vec![0.0; n * n_i],
            columns: columns.to_vec(),
            starts: starts.to_vec(),
        })
    }

    /// Fills everything of `model` that depends on the state, and `free` with `M⁻¹ f`.
    pub(super) fn reduce(
        &mut self,
        eq3: &Linearisation,
        v: &[f64],
        free: &mut [f64],
        model: &mut ReducedInterfaceModel,
    ) {
        let (n, n_u, n_i) = (v.len(), model.contacts(), model.interface());
        if let MassMatrix::Diagonal(mass) = &eq3.mass {
            for ((inverse, mass), (free, force)) in
                self.inverse_mass.iter_mut().zip(mass).zip(free.iter_mut().zip(&eq3.force))
            {
                *inverse = 1.0 / mass;
                *free = force * *inverse;
            }
        }
        let a = &eq3.unilateral.jacobian;
        for ((scaled, a), &column) in self.scaled.iter_mut().zip(a).zip(&self.columns) {
            *scaled = a * self.inverse_mass[column as usize];
        }
        self.products.fill(a, &self.scaled, &mut model.h);
        for contact in 0..n_u {
            let entries = self.starts[contact]..self.starts[contact + 1];
            let known = a[entries.clone()].iter().zip(&self.columns[entries]);
            let along = |x: &[f64]| known.clone().map(|(a, &column)| a * x[column as usize]).sum::<f64>();
            model.w[contact] = along(v);
            model.a[contact] = along(free) + eq3.unilateral.convective[contact];
        }
        let first = model.h.len() - (n_u + n_i) * n_i;
        for i in 0..n_i {
            let a_i = eq3.interface.row(i);
            let dot = |x: &[f64]| a_i.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
            model.w[n_u + i] = dot(v);
            model.a[n_u + i] = dot(free) + eq3.interface.convective[i];
            let scaled = &mut self.interface[i * n..(i + 1) * n];
            for (scaled, (a, inverse)) in scaled.iter_mut().zip(a_i.iter().zip(&self.inverse_mass)) {
                *scaled = a * inverse;
            }
            let column = &mut model.h[first + i * (n_u + n_i)..][..n_u + n_i];
            for (contact, entry) in column[..n_u].iter_mut().enumerate() {
                *entry = eq3.unilateral.velocity(contact, scaled);
            }
            for (j, entry) in column[n_u..].iter_mut().enumerate() {
                *entry = eq3.interface.velocity(j, scaled);
            }
        }
    }

    /// Adds what the stacked impulses `[P_u; h λ_i]` do to `v`.
    pub(super) fn add_impulses(&self, impulses: &[f64], v: &mut [f64]) {
        let (contacts, forces) = impulses.split_at(self.starts.len() - 1);
        for (contact, &impulse) in contacts.iter().enumerate() {
            if impulse != 0.0 {
                let entries = self.starts[contact]..self.starts[contact + 1];
                for (scaled, &column) in self.scaled[entries.clone()].iter().zip(&self.columns[entries]) {
                    v[column as usize] += impulse * scaled;
                }
            }
        }
        for (&force, scaled) in forces.iter().zip(self.interface.chunks_exact(v.len())) {
            v.iter_mut().zip(scaled).for_each(|(v, scaled)| *v += force * scaled);
        }
    }
}
