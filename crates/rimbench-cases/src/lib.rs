//! What is simulated and what is measured of it. Like the core: no file, no thread, no clock.
//!
//! | room | what it holds |
//! |---|---|
//! | [`cases`] | what is simulated, with every number a named parameter |
//! | [`metrics`] | what is measured, as functions of trajectories |
//! | [`models`] | physical models the cases are made from |

pub mod cases;
pub mod metrics;
pub mod models;

/// Hash of the sources of models and cases, made when this crate was built; beside [`rimbench_core::SOURCES`].
pub const SOURCES: &str = env!("RIMBENCH_CASES_SOURCES");
