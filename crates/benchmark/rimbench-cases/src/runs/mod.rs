//! A run: what is asked for, what that resolves to, what comes of it, and what that is worth.
//!
//! A file or the command line makes a [`RunRequest`], which a [`Catalogue`](crate::catalogue::Catalogue) resolves to a [`RunSpec`];
//! [`simulate`] makes a [`RunResult`] of it, and [`evaluate`] holds that against a [`Reference`]. What determines a run is one
//! list, [`RunSpec::facts`], from which run id, tables, JSON and plans are made.
//!
//! To add an option: a line in the list of [`RunRequest`], and what it resolves to in [`RunSpec`] with its fact. Neither
//! [`RunRequest::resolve`] nor [`RunSpec::facts`] compiles without it.

mod evaluation;
mod facts;
mod findings;
mod predicted_growth;
mod reference;
mod request;
mod samples;
mod simulation;
mod spec;

pub use evaluation::{EvaluatedRun, evaluate};
pub use facts::{Fact, FactValue, only_of};
pub use findings::{Cell, Columns, Costs, Findings, Latency, counter_names, facts_of, is_taken, names_of};
pub use predicted_growth::{LinearCoupling, NEUTRAL, Recurrence, interface_oscillation, predicted_growth};
pub use reference::{DIVERGENCE_FACTOR, Peak, Reference};
pub use request::{Given, RunOption, RunRequest};
pub use simulation::{Clock, PreparedRun, RunResult, simulate, simulate_inside};
pub use spec::{RunSettings, RunSpec};
