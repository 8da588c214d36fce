//! Non-iterative co-simulation of mechanical systems with contact.
//!
//! Everything a simulation needs and nothing else: no file is read, nothing is drawn or printed, no thread is started, and no
//! clock is looked at. Each room uses only those below it.
//!
//! | room | what it holds |
//! |---|---|
//! | [`schemes`] | how two sides are coupled; one file per scheme |
//! | [`mechanics`] | the non-smooth stepper and the monolithic reference |
//! | [`cosim`] | subsystems, coupling schemes, and the macro loop |
//! | [`interface_model`] | the reduced interface model (paper Eqs. 3 and 4) |
//! | [`friction`] | contact problems with Coulomb friction in the plane and their solvers |
//! | [`complementarity`] | linear complementarity problems and their solvers |
//! | [`linear_algebra`] | factors, products and storage for small dense matrices |
//! | [`error`] | bad input and runs that fail |
//!
//! Raoofian, Kövecses, Teichmann, "Non-smooth Reduced Interface Models for Co-simulation of Mechanical Systems", is "the
//! paper" throughout; what is marked *ours* is this project's own choice.

pub mod ceilings;
pub mod complementarity;
pub mod cosim;
pub mod error;
pub mod friction;
pub mod interface_model;
pub mod linear_algebra;
pub mod mechanics;
pub mod name;
pub mod numerics_version;
pub mod schemes;

/// Hash of the sources of the rooms that a simulation without a scheme needs, made when this crate was built: what was cached with
/// another is not that of this code.
pub const SOURCES: &str = env!("RIMBENCH_CORE_SOURCES");
