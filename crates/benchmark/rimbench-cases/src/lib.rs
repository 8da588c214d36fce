//! What is simulated and what is measured of it. Like the core: no file, no thread, no clock.
//!
//! | room | what it holds |
//! |---|---|
//! | [`runs`] | one run: what is asked for, what determines it, what comes of it |
//! | [`catalogue`] | cases, schemes and solvers by name |
//! | [`cases`] | what is simulated, with every number a named parameter |
//! | [`metrics`] | what is measured, as functions of trajectories |
//! | [`models`] | physical models the cases are made from |

pub mod cases;
pub mod catalogue;
pub mod metrics;
pub mod models;
pub mod runs;

/// Hash of the sources of models and cases, made when this crate was built; beside [`rimbench_core::SOURCES`].
pub const SOURCES: &str = env!("RIMBENCH_CASES_SOURCES");
