//! How much memory a mechanical system takes, before its matrices are made.

use super::contact_stepper::ContactLaw;
use super::mechanical_model::{MechanicalModel, Sparsity};
use crate::interface_model::{Elimination, Linearisation, MassMatrix, MatrixForm, Rows};

/// Square matrices over all rows that mechanics and a scheme with a model keep between them, where every entry is kept:
/// models, their packed and condensed forms, contact problems, and the workspaces of two solvers.
const SQUARES: u64 = 24;
/// Matrices with an entry for each row and velocity.
const WIDE: u64 = 3;
/// Bytes per contact where few are coupled: some 10 entries of `H_uu` and 30 of a factor, each in several copies with
/// its place.
const PER_CONTACT: u64 = 16 << 10;
/// Bytes per entry of `H_uu` at most: more where many contacts share a velocity.
const PER_PRODUCT: u64 = 400;
/// Bytes per joint where only what is not zero is kept of them: some 5 entries of `S` and 10 of its factor, with their
/// places.
const PER_JOINT: u64 = 2 << 10;

/// Joints from which on only what is not zero is kept of them, where each involves few velocities
/// (`benches/scaling.rs`).
pub const MANY_JOINTS: usize = 12;

/// Products fewer than n² from which on a sparse `H_uu` is worth its overhead.
const LEAST_SAVED: u64 = 16;

impl Sparsity {
    /// Tells what is kept of a model's rows: of contacts where few are coupled, without springs and without a solver
    /// that is given whole matrices; of joints, if they are many or the contacts so kept. With joints that keep
    /// everything contacts do so, too.
    fn kept(model: &impl MechanicalModel, law: ContactLaw, by_active_sets: bool) -> Self {
        let size = model.size();
        if size.mass != MatrixForm::Diagonal {
            return Sparsity::default();
        }
        let mut all = model.sparsity();
        all.bilateral = all.bilateral.filter(|_| size.bilateral > 0);
        let apart = size.bilateral == 0 || all.bilateral.is_some();
        all.unilateral = all.unilateral.filter(|_| apart && law.spring.is_none() && by_active_sets);
        if all.few_are_coupled(size.velocities) {
            return all;
        }
        Sparsity { unilateral: None, bilateral: all.bilateral.filter(|_| size.bilateral >= MANY_JOINTS) }
    }

    /// Rows with these columns, or with all.
    fn rows(columns: Option<&Vec<Vec<usize>>>, count: usize, velocities: usize) -> Rows {
        match columns {
            Some(columns) => Rows::in_columns(velocities, columns),
            None => Rows::zeros(count, velocities),
        }
    }

    /// Tells whether few contacts are coupled, so that `H_uu` is sparse: Σ k² ≤ ¾ n² products, and [`LEAST_SAVED`]
    /// fewer at least, of n contacts of which k share a velocity; with joints as [`Elimination::delassus_pattern`]
    /// says.
    ///
    /// Bounds from rows and heaps (`benches/scaling.rs`): with fewer contacts the mechanics' step loses what the
    /// reduction saves.
    fn few_are_coupled(&self, velocities: usize) -> bool {
        let Some(contacts) = &self.unilateral else { return false };
        if self.bilateral.is_none() {
            let (products, all) = (products_at_most(contacts, velocities), (contacts.len() as u64).pow(2));
            return products + LEAST_SAVED <= all && 4 * products <= 3 * all;
        }
        let known = |columns: &Option<Vec<Vec<usize>>>| Self::rows(columns.as_ref(), 0, velocities);
        let eq3 = Linearisation {
            mass: MassMatrix::Diagonal(Vec::new()),
            force: vec![0.0; velocities],
            bilateral: known(&self.bilateral),
            unilateral: known(&self.unilateral),
            tangential: Rows::default(),
            interface: Rows::default(),
        };
        Elimination::delassus_pattern(&eq3).is_some()
    }
}

/// Returns how many products `A M⁻¹ Aᵀ` of contacts with these columns has at most: the sum of k² over velocities that
/// k contacts share.
fn products_at_most(columns: &[Vec<usize>], velocities: usize) -> u64 {
    let mut knowing = vec![0_u64; velocities];
    columns.iter().flatten().for_each(|&column| knowing[column] += 1);
    knowing.iter().map(|k| k * k).sum()
}

/// Makes Eq. 3 of a model, with nothing in it yet but the mass at `q`, and room for what is to be kept of its rows.
pub(super) fn empty_equations(
    model: &impl MechanicalModel,
    q: &[f64],
    law: ContactLaw,
    by_active_sets: bool,
) -> Linearisation {
    let (size, kept) = (model.size(), Sparsity::kept(model, law, by_active_sets));
    let mut mass = MassMatrix::zeros(size.velocities, size.mass);
    model.mass_matrix(q, mass.entries_mut());
    Linearisation {
        mass,
        force: vec![0.0; size.velocities],
        bilateral: Sparsity::rows(kept.bilateral.as_ref(), size.bilateral, size.velocities),
        unilateral: Sparsity::rows(kept.unilateral.as_ref(), size.unilateral, size.velocities),
        tangential: Rows::zeros(0, size.velocities),
        interface: Rows::zeros(size.interface, size.velocities),
    }
}

/// Returns the size of the problems that the solver of the contacts needs room for: none where few of many contacts are
/// coupled, which has a solver of its own.
pub fn solver_memory(model: &impl MechanicalModel, law: ContactLaw, by_active_sets: bool) -> usize {
    let size = model.size();
    if Sparsity::kept(model, law, by_active_sets).unilateral.is_some() { 0 } else { size.unilateral }
}

/// Returns how many bytes a model and a scheme that uses its interface model take at most.
///
/// ```text
/// 8 (24 r² + 3 r n) bytes          r = 2 n_u + n_b + n_i rows with friction, n_u + n_b + n_i without; n velocities
/// 16 kiB per contact               where few of many contacts are coupled, or 400 bytes for each k² of a velocity that k share, if that is more
/// 2 kiB per joint and velocity     in place of its rows above, where joints are many and involve few velocities each
/// ```
/// `by_active_sets` tells whether the solver of the contacts goes from one active set to the next. An estimate from
/// above, for which only the columns are listed.
pub fn bytes_needed(model: &impl MechanicalModel, law: ContactLaw, by_active_sets: bool) -> u64 {
    let (size, kept) = (model.size(), Sparsity::kept(model, law, by_active_sets));
    let contacts = (size.unilateral + size.tangential + size.interface) as u64;
    let (joints, velocities) = (size.bilateral as u64, size.velocities as u64);
    let (of_joints, rows) = match kept.bilateral {
        Some(_) => ((joints + velocities) * PER_JOINT, contacts),
        None => (0, contacts + joints),
    };
    if let Some(columns) = &kept.unilateral {
        let products = products_at_most(columns, size.velocities);
        return of_joints + (size.unilateral as u64 * PER_CONTACT).max(products * PER_PRODUCT);
    }
    of_joints + 8 * rows * (SQUARES * rows + WIDE * velocities)
}
