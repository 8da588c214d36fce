//! Up to where a choice stays stable.

use super::candidate::Candidate;
use super::search::Search;
use rimbench_core::error::Result;

/// How far it is to the end of stability, on the macro steps that were tried.
#[derive(Debug, Clone, PartialEq)]
pub struct LimitFound {
    /// Largest macro step up to which, from the one that is advised, it is stable at every phase, s.
    pub last_stable: f64,
    /// The next macro step, which is not; none if the grid ended before.
    pub first_unstable: Option<f64>,
    /// What happens there, and at which phase.
    pub failure: Option<String>,
    /// The run there.
    pub run_id: Option<String>,
}

impl Search<'_> {
    /// Goes up from the macro step with this index until a run does not complete within bounds, or, on a linear case, the spectral
    /// radius exceeds one.
    pub(super) fn limit(&self, candidate: &Candidate, from: usize) -> Result<LimitFound> {
        let steps = self.question.macro_steps;
        let mut found = LimitFound { last_stable: steps[from], first_unstable: None, failure: None, run_id: None };
        for &step in &steps[from + 1..] {
            if self.room() < self.search_phases().len() {
                break;
            }
            if let Some((failure, run_id)) = self.unstable(candidate, step)? {
                return Ok(LimitFound { first_unstable: Some(step), failure: Some(failure), run_id, ..found });
            }
            found.last_stable = step;
        }
        Ok(found)
    }

    fn unstable(&self, candidate: &Candidate, step: f64) -> Result<Option<(String, Option<String>)>> {
        let runs = self.probes(&[(candidate, step)], self.search_phases())?.remove(0);
        let runs = match runs {
            Ok(runs) => runs,
            Err(reason) => return Ok(Some((reason, None))),
        };
        if let Some(run) = runs.iter().find(|run| !run.completed()) {
            return Ok(Some((format!("{} (phase {:.4})", run.reason, run.phase), Some(run.run_id.clone()))));
        }
        Ok(self.growth(candidate, step).1.map(|reason| (reason, None)))
    }
}
