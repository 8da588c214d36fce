//! A run: what is asked for, what that resolves to, what comes of it, and what that is worth. Like the core: no file, no
//! thread, no clock.
//!
//! A file or the command line makes a [`RunRequest`], which a [`Catalogue`](catalogue::Catalogue) resolves to a
//! [`RunSpec`]; [`simulate`] makes a [`RunResult`] of it, and [`evaluate`] holds that against a [`Reference`]. What
//! determines a run is one list, [`RunSpec::facts`], from which run id, tables, JSON and plans are made.
//!
//! To add an option: a line in the list of [`RunRequest`], and a field where its value goes, in
//! [`Exchange`](rimbench_core::cosim::Exchange) or [`ModelOptions`](rimbench_core::schemes::ModelOptions).

mod belief;
pub mod catalogue;
mod centre;
mod checks;
mod evaluation;
mod fact;
mod facts;
mod finding;
mod findings;
mod given;
pub mod metrics;
mod options;
mod perturbation;
mod predicted_growth;
mod reference;
mod resolve;
mod run_result;
mod samples;
mod simulation;
mod spec;

pub use belief::{TrueState, believed, what_happens};
pub use evaluation::{EvaluatedRun, evaluate};
pub use fact::{Fact, FactValue};
pub use facts::only_of;
pub use finding::Finding;
pub use findings::{Cell, Columns, Costs, Findings, Latency, facts_of, is_taken, names_of};
pub use given::Given;
pub use options::{OptionOf, RunOption, RunRequest};
pub use perturbation::Perturbation;
pub use predicted_growth::{LinearCoupling, NEUTRAL, Recurrence, interface_oscillation, predicted_growth};
pub use reference::{DIVERGENCE_FACTOR, Peak, Reference, Solution, with_impulses};
pub use run_result::RunResult;
pub use simulation::{Clock, PreparedRun, RefusedSteps, simulate, simulate_inside};
pub use spec::{RunSettings, RunSpec};

/// Hash of the sources that make a reference, made when this crate was built; beside [`rimbench_cases::SOURCES`].
pub const SOURCES: &str = env!("RIMBENCH_RUNS_SOURCES");
