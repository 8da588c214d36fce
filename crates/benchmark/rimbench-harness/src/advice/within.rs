//! What a budget buys: of the cells within it, the one that errs least at its worst phase.

use super::{Advice, Catalogue, Choice, Result, RunRequest, Search};
use rayon::prelude::*;
use rimbench_core::cosim::MechanicsSteps;
use rimbench_core::error::Error;
use rimbench_core::schemes::{ContactsAct, Requirement};
use rimbench_results::budget::{Form, best_within};
use rimbench_runs::RunSpec;
use std::collections::BTreeSet;

/// The longest macro step that is tried, s, if it is no more than a tenth of the run: beyond it nothing was best.
const LONGEST: f64 = 0.02;

/// Takes the budget out of a request in which the steps of the mechanics are those per second, and says which macro
/// steps (s) are tried within it, ascending: one that spends all exchanges, longer ones by factors of two, so that a
/// larger budget has them too, and one that would spend twice as many.
///
/// # Errors
/// An unknown case; [`Error::InvalidValue`] for what is no number above 0, and for fewer steps than communication
/// points; [`Error::Incompatible`] without steps.
pub fn budget_of(catalogue: &Catalogue, fixed: &mut RunRequest, exchanges: f64) -> Result<([f64; 2], Vec<f64>)> {
    let steps = match (fixed.mechanics_steps.take(), fixed.mechanics_step_s) {
        (Some(MechanicsSteps::Count(count)), None) => f64::from(count.get()),
        (Some(found), None) => {
            let expected = "with --exchanges a number of steps per second, as --mechanics-steps 1000";
            return Err(Error::invalid("mechanics-steps", found, expected));
        }
        _ => {
            let message = "--exchanges needs --mechanics-steps, steps per second as in --mechanics-steps 1000, and no --mechanics-step";
            return Err(Error::Incompatible(message.to_owned()));
        }
    };
    let usual = catalogue.case(fixed.case.as_deref().unwrap_or_default())?.defaults.duration_s;
    let duration_s = fixed.duration_s.unwrap_or(usual);
    if !(exchanges.is_finite() && exchanges * duration_s >= 1.0) {
        let expected = format!("a number per second, at least {} for a run of {duration_s} s", 1.0 / duration_s);
        return Err(Error::invalid("exchanges", exchanges, expected));
    }
    if !(steps.is_finite() && steps >= exchanges) {
        let expected = format!(
            "a number per second, at least the exchanges, {exchanges}: a macro step has a step of the mechanics"
        );
        return Err(Error::invalid("mechanics-steps", steps, expected));
    }
    let longest = LONGEST.min(0.1 * duration_s).max(2.0 / exchanges).min(duration_s) * (1.0 + 1e-9);
    let macro_steps = std::iter::successors(Some(0.5 / exchanges), |step| Some(2.0 * step));
    Ok(([exchanges, steps], macro_steps.take_while(|step| *step <= longest).collect()))
}

/// What a run is a form of: its scheme, and whether its contacts act over the mechanics' step or its steps are split.
pub(super) fn way_of(run: &RunSpec) -> String {
    let own = run.model.as_ref().is_some_and(|model| model.contacts_act == ContactsAct::MechanicsStep);
    let split = run.mechanics_integrator;
    let split = split.second_order().map_or_else(String::new, |_| format!(" with {split}"));
    format!("{}{}{split}", run.scheme.name, if own { " over mechanics steps" } else { "" })
}

impl Search<'_> {
    /// Tries all cells within the budget, and those of the best with twice the one or the other.
    pub(super) fn run_within(mut self) -> Result<Advice> {
        let budget @ [exchanges, steps] = self.question.budget.unwrap_or_default();
        let mut done = BTreeSet::new();
        self.try_all(&self.cells(budget, None), &mut done)?;
        if let Some(best) = self.choose(budget).first().map(|choice| (*choice).clone()) {
            // Of the doubled budgets only what is better than the best of this one is of interest.
            let doubled = [[2.0 * exchanges, steps], [exchanges, 2.0 * steps]];
            for more in doubled {
                self.try_all(&self.cells(more, Some(&best)), &mut done)?;
            }
            let of = |budget| self.choose(budget).into_iter().find(|choice| choice.way == best.way).cloned();
            self.advice.doubled = Some(doubled.map(|budget| of(budget).unwrap_or_default()));
        }
        self.best = self.choose(budget).into_iter().take(2).cloned().collect();
        self.question.error = self.best.first().and_then(|best| best.worst_error).unwrap_or(f64::INFINITY);
        self.advice.notes = self.notes();
        let mut chosen = self.best.into_iter();
        (self.advice.advised, self.advice.runner_up) = (chosen.next(), chosen.next());
        Ok(self.advice)
    }

    /// The cells within a budget, by what is counted beforehand, or of these the cells of one way.
    fn cells(&self, [exchanges, steps]: [f64; 2], like: Option<&Choice>) -> Vec<(usize, usize)> {
        let mut cells = Vec::new();
        for (step, macro_step) in self.question.macro_steps.iter().enumerate() {
            let spends = |count: u32| f64::from(count) / macro_step <= steps * (1.0 + 1e-9);
            if 1.0 / macro_step > exchanges * (1.0 + 1e-9) || !spends(1) {
                continue;
            }
            let count = |place: usize| match self.forms[place].1.mechanics_steps {
                MechanicsSteps::Count(count) => Some(count.get()),
                own => u32::try_from(own.within(*macro_step, self.forms[place].1.micro_step)).ok(),
            };
            let within = |place: &usize| count(*place).is_some_and(spends);
            let places: Vec<usize> = (0..self.forms.len()).filter(within).collect();
            let most = places.iter().filter_map(|place| count(*place)).max();
            // Who takes as many steps as are counted gains nothing by fewer.
            let varies = |place: &usize| {
                let run = &self.forms[*place].1;
                run.scheme.needs.contains(&Requirement::Trials)
                    || !run.scheme.real_time()
                    || run.mechanics_integrator.second_order().is_some()
            };
            let is_tried = |place: &usize| {
                (varies(place) || count(*place) == most || count(*place) == Some(1))
                    && like.is_none_or(|like| way_of(&self.forms[*place].1) == like.way)
            };
            cells.extend(places.into_iter().filter(is_tried).map(|place| (place, step)));
        }
        // What is often best goes first: others then are soon seen to be worse.
        cells.sort_by_key(|(place, _)| !self.forms[*place].1.scheme.acts_over_mechanics_step);
        cells
    }

    /// Runs cells, each at one phase after another until it is worse than two others.
    fn try_all(&mut self, cells: &[(usize, usize)], done: &mut BTreeSet<(usize, usize)>) -> Result<()> {
        let open: Vec<_> = cells.iter().copied().filter(|cell| done.insert(*cell)).collect();
        let budget = self.question.budget.unwrap_or_default();
        // A number of its own, so that what is found does not depend on how many threads there are.
        for batch in open.chunks(16) {
            self.question.error =
                self.choose(budget).get(1).and_then(|second| second.worst_error).unwrap_or(f64::INFINITY);
            let judged: Vec<Choice> = batch.par_iter().map(|&cell| self.judge(cell)).collect::<Result<_>>()?;
            batch.iter().zip(judged).for_each(|(place, cell)| self.learn(*place, cell));
        }
        Ok(())
    }

    /// The best cell of each way within a budget, the best way first.
    fn choose(&self, budget: [f64; 2]) -> Vec<&Choice> {
        let mut forms = Vec::with_capacity(self.met.len());
        for (place, Choice { way, spent_per_s, worst_error, .. }) in self.met.iter().enumerate() {
            forms.push(Form { way, place, spent: *spent_per_s, error: worst_error.unwrap_or(f64::INFINITY) });
        }
        best_within(&forms, budget).into_iter().map(|form| &self.met[form.place]).collect()
    }
}
