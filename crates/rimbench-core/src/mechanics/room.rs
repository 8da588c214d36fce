//! How much memory a mechanical system takes, before any of it is taken.

use super::contact_stepper::{ContactLaw, MANY_CONTACTS};
use super::mechanical_model::{MechanicalModel, ModelSize};
use crate::interface_model::MassMatrix;

/// Square matrices over all rows that mechanics and a scheme with a model keep between them, where every entry is kept: models, their
/// packed and condensed forms, contact problems, and the workspaces of two solvers.
const SQUARES: u64 = 24;
/// Matrices with an entry for each row and velocity.
const WIDE: u64 = 3;
/// Bytes per contact where few meet: some 10 entries of `H_uu` and 30 of a factor, each in several copies with its place.
const PER_CONTACT: u64 = 16 << 10;

/// Tells whether only what is not zero is kept of the contacts: many, of which few meet, without joints, springs or a solver that is
/// given whole matrices.
pub(super) fn keeps_what_meets(size: ModelSize, mass: &MassMatrix, law: ContactLaw, by_active_sets: bool) -> bool {
    size.unilateral >= MANY_CONTACTS
        && size.bilateral == 0
        && matches!(mass, MassMatrix::Diagonal(_))
        && law.spring.is_none()
        && by_active_sets
}

/// Returns the size of the problems that the solver of the contacts needs room for: none where few of many contacts meet, which has a
/// solver of its own.
pub fn solver_room(model: &impl MechanicalModel, law: ContactLaw, by_active_sets: bool) -> usize {
    let size = model.size();
    let few = keeps_what_meets(size, &model.empty_mass_matrix(), law, by_active_sets);
    if few && model.unilateral_columns().is_some() { 0 } else { size.unilateral }
}

/// Returns how many bytes a model and a scheme that uses its interface model take at most.
///
/// ```text
/// 8 (24 r² + 3 r n) bytes          r = 2 n_u + n_b + n_i rows with friction, n_u + n_b + n_i without; n velocities
/// 16 kiB per contact               where few of many contacts meet
/// ```
/// `by_active_sets` tells whether the solver of the contacts goes from one active set to the next. An estimate from above: nothing is
/// measured or allocated.
pub fn bytes_needed(model: &impl MechanicalModel, law: ContactLaw, by_active_sets: bool) -> u64 {
    let size = model.size();
    if solver_room(model, law, by_active_sets) < size.unilateral {
        return size.unilateral as u64 * PER_CONTACT;
    }
    let rows = (size.unilateral + model.tangential_rows() + size.bilateral + size.interface) as u64;
    8 * rows * (SQUARES * rows + WIDE * size.velocities as u64)
}
