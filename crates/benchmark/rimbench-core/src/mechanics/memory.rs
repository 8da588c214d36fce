//! How much memory a mechanical system takes, before its matrices are made.

use super::contact_stepper::ContactLaw;
use super::mechanical_model::MechanicalModel;
use crate::interface_model::{Linearisation, MassMatrix, MatrixForm, Rows};

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
/// Products fewer than n² from which on a sparse `H_uu` is worth its overhead.
const LEAST_SAVED: u64 = 16;

/// Lists the columns of a model's contacts if only those entries are kept of them: the mass is diagonal, there are no
/// joints, springs or solvers that are given whole matrices, and few contacts are coupled, Σ k² ≤ ¾ n² products, and
/// [`LEAST_SAVED`] fewer at least, of n contacts of which k share a velocity.
///
/// Bounds from rows and heaps (`benches/scaling.rs`): with fewer contacts the mechanics' step loses what the reduction
/// saves.
fn kept_columns(model: &impl MechanicalModel, law: ContactLaw, by_active_sets: bool) -> Option<Vec<Vec<usize>>> {
    let size = model.size();
    if size.mass != MatrixForm::Diagonal || size.bilateral > 0 || law.spring.is_some() || !by_active_sets {
        return None;
    }
    model.contact_columns().filter(|contacts| {
        let (products, all) = (products_at_most(contacts, size.velocities), (contacts.len() as u64).pow(2));
        products + LEAST_SAVED <= all && 4 * products <= 3 * all
    })
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
    let (size, kept) = (model.size(), kept_columns(model, law, by_active_sets));
    let mut mass = MassMatrix::zeros(size.velocities, size.mass);
    model.mass_matrix(q, mass.entries_mut());
    Linearisation {
        mass,
        force: vec![0.0; size.velocities],
        bilateral: Rows::zeros(size.bilateral, size.velocities),
        unilateral: match kept {
            Some(columns) => Rows::in_columns(size.velocities, &columns),
            None => Rows::zeros(size.unilateral, size.velocities),
        },
        tangential: Rows::zeros(0, size.velocities),
        interface: Rows::zeros(size.interface, size.velocities),
    }
}

/// Returns the size of the problems that the solver of the contacts needs room for: none where few of many contacts are
/// coupled, which has a solver of its own.
pub fn solver_memory(model: &impl MechanicalModel, law: ContactLaw, by_active_sets: bool) -> usize {
    if kept_columns(model, law, by_active_sets).is_some() { 0 } else { model.size().unilateral }
}

/// Returns how many bytes a model and a scheme that uses its interface model take at most.
///
/// ```text
/// 8 (24 r² + 3 r n) bytes          r = 2 n_u + n_b + n_i rows with friction, n_u + n_b + n_i without; n velocities
/// 16 kiB per contact               where few of many contacts are coupled, or 400 bytes for each k² of a velocity that k share, if that is more
/// ```
/// `by_active_sets` tells whether the solver of the contacts goes from one active set to the next. An estimate from
/// above, for which only the columns are listed.
pub fn bytes_needed(model: &impl MechanicalModel, law: ContactLaw, by_active_sets: bool) -> u64 {
    let size = model.size();
    if let Some(columns) = kept_columns(model, law, by_active_sets) {
        let products = products_at_most(&columns, size.velocities);
        return (size.unilateral as u64 * PER_CONTACT).max(products * PER_PRODUCT);
    }
    let rows = (size.bilateral + size.unilateral + size.tangential + size.interface) as u64;
    8 * rows * (SQUARES * rows + WIDE * size.velocities as u64)
}
