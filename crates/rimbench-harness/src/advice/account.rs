//! What a search has to say of each form when it is done.

use super::search::{Leaders, Search, dearest, milliseconds};
use super::{Choice, Fallen};
use rimbench_cases::runs::RunRequest;
use rimbench_core::error::{Error, Result};

impl Search<'_> {
    /// All that is to be said of a leader.
    pub(super) fn choice(&self, index: usize) -> Result<Choice> {
        let candidate = &self.candidates[index];
        let step = candidate.leading_step();
        let macro_step = self.question.macro_steps[step];
        let mut runs = self.probes(&[(candidate, macro_step)], self.phases)?.remove(0).map_err(Error::Incompatible)?;
        let kept_aside = runs.split_off(self.question.phases);
        let work = dearest(&runs).max(&dearest(&kept_aside));
        let next = self.question.macro_steps.get(step + 1);
        Ok(Choice {
            request: RunRequest { macro_step_s: Some(macro_step), ..candidate.request.clone() },
            form: candidate.form(),
            macro_step,
            cost: self.question.prices.of(&work),
            cost_one_step_on: next.map(|next| self.question.prices.of(&candidate.expected(*next))),
            work,
            spectral_radius: self.growth(candidate, macro_step).0,
            limit: self.limit(candidate, step)?,
            runs,
            kept_aside,
        })
    }

    /// Why each other form is not advised.
    pub(super) fn fallen(&self, leaders: Leaders) -> Vec<Fallen> {
        let others = (0..self.candidates.len()).filter(|index| !leaders.contains(&Some(*index)));
        others.map(|index| self.fall(index)).collect()
    }

    fn fall(&self, index: usize) -> Fallen {
        let candidate = &self.candidates[index];
        let steps = self.question.macro_steps;
        let cost = candidate.met.map(|met| self.cost_at(index, met));
        let (reason, run) = match (candidate.met.zip(cost), candidate.fall.clone()) {
            (_, Some((_, Some(run)))) if candidate.out => (run.reason.clone(), None),
            (Some((met, cost)), fall) => {
                let (beyond, run) = fall.unwrap_or_default();
                let beyond = if beyond.is_empty() { beyond } else { format!("; {beyond}") };
                let met = milliseconds(steps[met]);
                (format!("meets it at the first phase up to {met}, for a cost of {cost:.0}{beyond}"), run)
            }
            (None, Some((reason, run))) => (reason, run),
            (None, None) => {
                let least = self.cost_at(index, steps.len() - 1);
                (format!("not run: costs {least:.0} or more at every macro step"), None)
            }
        };
        Fallen {
            scheme: candidate.scheme().to_owned(),
            request: Some(candidate.request.clone()),
            form: candidate.form(),
            reason,
            run: run.map(|run| *run),
            cost,
        }
    }
}
