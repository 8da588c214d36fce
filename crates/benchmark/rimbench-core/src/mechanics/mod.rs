//! Mechanics with bilateral and unilateral constraints in maximal or reduced coordinates.
//!
//! A case author writes a [`MechanicalModel`]; [`NonSmoothMechanics`] steps it (paper Eqs. 1–3) and offers it to a
//! co-simulation; [`monolithic`] integrates a whole coupled system in one loop, as the reference.

mod contact_stepper;
mod cubic;
mod energy_ledger;
mod mechanical_model;
mod memory;
mod monolithic;
mod non_smooth_mechanics;
mod stiff_forces;

pub use contact_stepper::{ContactLaw, Friction, is_contact_state};
pub use energy_ledger::EnergyLedger;
pub use mechanical_model::{MechanicalModel, ModelNames, ModelSize};
pub use memory::{bytes_needed, solver_memory};
pub use monolithic::{Due, ReferenceSteps, monolithic, monolithic_with_events};
pub use non_smooth_mechanics::NonSmoothMechanics;
pub use stiff_forces::StiffForces;
