//! A run of a plan.

use rimbench_runs::RunSpec;
use std::sync::Arc;

/// One run of the plan, with what its row in data says about it.
#[derive(Debug, Clone)]
pub struct PlannedRun {
    /// What is run.
    pub spec: RunSpec,
    /// Label of the scheme row: given in the file, or made of the scheme's name and what tells rows of one scheme
    /// apart.
    pub label: String,
    /// Its set of parameters, as in the column `set` of `runs.csv`.
    pub set: Arc<str>,
    /// Its set of parameters less those that were drawn, where some were: under this what is kept pools its runs.
    pub pooled_set: Option<Arc<str>>,
    /// How many draws were rejected before that of its setting, where an event is required of settings.
    pub rejected_draws: Option<usize>,
    /// [`RunSpec::id`].
    pub id: String,
}
