//! What is simulated, and what is known of it. Like the core: no file, no thread, no clock.
//!
//! | room | what it holds |
//! |---|---|
//! | [`cases`] | what is simulated, with every number a named parameter |
//! | [`models`] | physical models the cases are made from |
//! | [`parameter`] | named numbers, with unit, range and source |

pub mod cases;
pub mod models;
pub mod parameter;

/// Hash of the sources of models and cases, made when this crate was built; beside [`rimbench_core::SOURCES`].
pub const SOURCES: &str = env!("RIMBENCH_CASES_SOURCES");
