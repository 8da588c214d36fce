//! Non-iterative co-simulation of mechanical systems with contact.
//!
//! Everything a simulation needs and nothing else: no file is read, nothing is drawn or printed, no thread is started,
//! and no clock is looked at. Each room uses only those below it; contact problems and their solvers are a crate below
//! all of them, [`rimbench_contact`].
//!
//! ```
//! use rimbench_core::interface_model::{Condensation, ReducedInterfaceModel, condense};
//!
//! // A rod of 3 kg, pushed up at its free end, 1 m from the end that rests on the floor; both move in one direction (Eq. 4 of the paper).
//! let mut model = ReducedInterfaceModel::zeros(1, 1);
//! model.h.copy_from_slice(&[4.0 / 3.0, -2.0 / 3.0, -2.0 / 3.0, 4.0 / 3.0]);
//! model.a.copy_from_slice(&[-9.81, -9.81]);
//! let mut condensed = Condensation::of(&model);
//!
//! // In the air the interface feels a quarter of the rod, on the floor a third: 1/H_ii with the contact open and closed.
//! condense(&model, &[], &mut condensed);
//! assert!((condensed.effective_mass - 0.75).abs() < 1e-12);
//! condense(&model, &[0], &mut condensed);
//! assert!((condensed.effective_mass - 1.0).abs() < 1e-12);
//! ```
//!
//! | room | what it holds |
//! |---|---|
//! | [`schemes`] | how two sides are coupled; one file per scheme |
//! | [`mechanics`] | the non-smooth stepper and the monolithic reference |
//! | [`cosim`] | subsystems, coupling schemes, and the macro loop |
//! | [`interface_model`] | the reduced interface model (paper Eqs. 3 and 4) |
//! | [`error`] | bad input and runs that fail |
//!
//! Raoofian, Kövecses, Teichmann, "Non-smooth Reduced Interface Models for Co-simulation of Mechanical Systems", is
//! "the paper" throughout; what is marked *ours* is this project's own choice.

pub mod cosim;
pub mod error;
pub mod interface_model;
pub mod iterative;
pub mod mechanics;
pub mod name;
pub mod numerics_version;
pub mod parts;
pub mod schemes;

pub use rimbench_contact::{
    affine_step, complementarity, contact_law, friction, known_problems, linear_algebra, solver_entry,
};

/// Hashes of the sources that a simulation without a scheme depends on, made when the crates were built: a result of
/// other sources is out of date.
pub const SOURCES: [&str; 2] = [env!("RIMBENCH_CORE_SOURCES"), rimbench_contact::SOURCES];
