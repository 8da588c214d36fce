//! From an experiment file to runs to CSV. Files, threads and progress live here only.

mod reference;
mod run;

pub use reference::Reference;
pub use run::{RunResult, RunSpec, simulate};
