//! Which macro step, which scheme? The cheapest cell of a grid, forms of all schemes by macro steps, within an error at
//! every phase.
//!
//! Nothing is assumed of how errors grow with H: a cell is left out only where it is expected to cost more than what
//! has been found, the cheapest of two schemes.
//!
//! Or, of a [budget](Question::budget): which cell of those within it errs least?

mod forms;
mod prices;
mod question;
mod within;

pub use forms::{Information, as_a_master};
pub use prices::{USUAL_PRICES, prices_of};
pub use question::{share_of_peak, steps_to_try};
pub use within::budget_of;

use super::cache::Cache;
use super::clock::{monotonic_clock, processor_clock};
use super::execution::evaluated;
use super::grid::phase_ensemble;
use super::job::{Progress, Step};
use super::references::obtain_reference;
use super::spectral::spectral_radius;
use forms::least_work;
use rayon::prelude::*;
use rimbench_cases::cases::Case;
use rimbench_core::cosim::{Outcome, OutcomeClass, OutcomeKind, StopFlag, Work};
use rimbench_core::error::{Error, Result};
use rimbench_runs::catalogue::Catalogue;
use rimbench_runs::{NEUTRAL, Peak, Reference, RunRequest, RunSpec};
use serde::Serialize;
use std::collections::BTreeMap;
use std::time::Duration;

/// The metric by which a run is judged.
pub const METRIC: &str = "force_error_rms_of_peak";

/// The error at communication points and the one inside macro steps too, N: a budget is judged by the second.
const SAMPLED: &str = "force_error_rms_n";
const INSIDE: &str = "force_error_inside_rms_n";

/// What is asked.
#[derive(Clone, Copy)]
pub struct Question<'a> {
    /// Where cases and schemes are found.
    pub catalogue: &'a Catalogue,
    /// The case and its parameters, and what is asked of every run. A scheme named here competes alone.
    pub fixed: &'a RunRequest,
    /// Rms force error allowed at every phase, over the reference's peak.
    pub error: f64,
    /// Instead of an error: communication points and mechanics steps that may be had, each per second of simulated time.
    pub budget: Option<[f64; 2]>,
    /// What may be known.
    pub information: Information,
    /// Prices of an exchange, a step of the mechanics, a micro step of the actuator, and a contact problem of an
    /// interface model.
    pub prices: [f64; 4],
    /// Macro steps that are tried, s, ascending.
    pub macro_steps: &'a [f64],
    /// Phases at which the error must be met.
    pub phases: usize,
    /// Where references are kept.
    pub cache: &'a Cache,
    /// Told of each run that is done.
    pub progress: Progress<'a>,
    /// Who may end it.
    pub stop: StopFlag<'a>,
}

/// What comes of it.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Advice {
    /// Rms uncertainty of the reference's force over its peak, of the worst row; none where there is no force to speak
    /// of.
    pub reference_uncertainty_of_peak: Option<f64>,
    /// The cheapest cell that meets the error.
    pub advised: Option<Choice>,
    /// The cheapest of another scheme.
    pub runner_up: Option<Choice>,
    /// The cheapest of the cells tried that has at most half the error of the advised one: what more accuracy costs.
    pub finer: Option<Choice>,
    /// Of a budget, what the advised scheme comes to with twice the communication points, and with twice the mechanics
    /// steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub doubled: Option<[Choice; 2]>,
    /// Runs made.
    pub runs_made: usize,
    /// Cells of which nothing is known, having taken too long.
    pub undecided: usize,
    /// Cells that could not be run, by the reason.
    pub skipped: BTreeMap<String, usize>,
    /// Phases at which the error is met: those asked for, or one where a side takes steps of one length.
    pub phases: usize,
    /// What has to be said of the choice, or why there is none.
    pub notes: Vec<String>,
}

/// A form of a scheme at a macro step, at its worst phase.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Choice {
    /// What to ask of a run.
    #[serde(skip)]
    pub request: RunRequest,
    /// The scheme by name.
    pub scheme: String,
    /// The scheme in words, with what its forms are of besides: contacts over the mechanics' step, or steps that are split.
    pub way: String,
    /// The form in words.
    pub form: String,
    /// H, s.
    pub macro_step_s: f64,
    /// [`RunSpec::id`].
    pub run_id: String,
    /// Rms force error over the reference's peak; none where there is none.
    pub worst_error: Option<f64>,
    /// Counts of what has a [price](Question::prices), each the largest of any phase.
    pub work: [f64; 4],
    /// Their cost.
    pub cost: f64,
    /// Communication points and steps of the mechanics, each per second of simulated time, the most of any phase.
    pub spent_per_s: [f64; 2],
    /// Mean time per macro step on this machine, s.
    pub time_per_macro_step_s: f64,
    /// `processor`, or `wall` where a side is from outside.
    pub time_is_of: &'static str,
    /// Place of the form.
    #[serde(skip)]
    place: usize,
    /// Macro steps in a run.
    #[serde(skip)]
    points: f64,
    #[serde(skip)]
    model_exact: bool,
    #[serde(skip)]
    runs: usize,
    #[serde(skip)]
    last: Option<OutcomeKind>,
    /// What is wrong with the last run, if anything is.
    #[serde(skip)]
    fault: Option<String>,
    /// Whether there was a run at all.
    #[serde(skip)]
    skipped: bool,
}

/// A run of fewer macro steps is judged at so few points that it has to be said.
const FEW_POINTS: f64 = 30.0;

/// Finds the advice.
///
/// # Errors
/// Bad input, also where nothing that is asked for may compete; a case that has no reference with these parameters;
/// [`Error::Stopped`].
pub fn advise(question: Question<'_>) -> Result<Advice> {
    if !(1..=1000).contains(&question.phases) {
        return Err(Error::invalid("phases", question.phases, "a whole number from 1 to 1000"));
    }
    let Question { prices, .. } = question;
    if !prices.iter().all(|price| price.is_finite() && *price >= 0.0) || prices == [0.0; 4] {
        return Err(Error::invalid("costs", format!("{prices:?}"), "finite numbers, 0 or above and not all 0"));
    }
    let forms = forms::all(&question)?;
    let first = forms[0].1.clone();
    let reference = obtain_reference(&first, question.cache, question.stop)?;
    let uncertainty = uncertainty_of_peak(&reference, &first);
    let phases = phases_of(&first.case, phase_ensemble(question.phases));
    let mut advice = Advice { reference_uncertainty_of_peak: uncertainty, phases: phases.len(), ..Advice::default() };
    let reason = match uncertainty {
        None => "the interface carries no force to speak of, and errors are relative to its peak".to_owned(),
        Some(uncertainty) if uncertainty < question.error => {
            let seen = vec![[1.0, 1.0, 1.0, 0.0]; forms.len()];
            let (best, met, nearest) = (Vec::new(), Vec::new(), None);
            let search = Search { question, reference, phases, forms, seen, best, met, nearest, advice };
            return if question.budget.is_some() { search.run_within() } else { search.run() };
        }
        Some(uncertainty) => format!("the reference itself is uncertain by {uncertainty:.1e} of its peak"),
    };
    advice.notes.push(format!("None can be told: {reason}."));
    Ok(advice)
}

/// The phases at which a case can be run, of those asked for.
pub(super) fn phases_of(case: &Case, asked: Vec<f64>) -> Vec<f64> {
    if case.has_fixed_steps() { vec![1.0] } else { asked }
}

/// Uncertainty of the reference's force over its peak, of the worst row; none where the interface carries no force.
fn uncertainty_of_peak(reference: &Reference, spec: &RunSpec) -> Option<f64> {
    let rows = spec.case.interface_columns.iter().filter_map(|row| {
        let peak = reference.largest[reference.trajectory.index_of(&row.force)?];
        let nothing = reference.force_peak(&spec.case, &row.force) == Peak::Nothing;
        (!nothing).then(|| Some(reference.uncertainty_of(&row.force)? / peak))?
    });
    rows.reduce(f64::max)
}

struct Search<'a> {
    question: Question<'a>,
    reference: Reference,
    phases: Vec<f64>,
    forms: Vec<(RunRequest, RunSpec)>,
    /// Work of a completed run of each form over the least that it can be.
    seen: Vec<[f64; 4]>,
    /// The cheapest choice of each scheme, by cost; of equals the first in the catalogue.
    best: Vec<Choice>,
    /// All that meet the error.
    met: Vec<Choice>,
    /// The least error that was missed, or of runs without one the shortest macro step, and how.
    nearest: Option<([f64; 2], String)>,
    advice: Advice,
}

impl Search<'_> {
    /// Tries cells (form, macro step), the cheapest first, until none is left that could be cheaper than the cheapest
    /// of two schemes.
    fn run(mut self) -> Result<Advice> {
        let steps = self.question.macro_steps.len();
        let mut open: Vec<_> = (0..self.forms.len() * steps).map(|place| (place / steps, place % steps)).collect();
        loop {
            open.retain(|&cell| self.may_be_chosen(cell));
            open.sort_by(|a, b| self.expected(*a).total_cmp(&self.expected(*b)).then(a.cmp(b)));
            // A number of its own, so that what is found does not depend on how many threads there are.
            let batch: Vec<(usize, usize)> = open.drain(..open.len().min(16)).collect();
            if batch.is_empty() {
                break;
            }
            let judged: Vec<Choice> = batch.par_iter().map(|&cell| self.judge(cell)).collect::<Result<_>>()?;
            batch.into_iter().zip(judged).for_each(|(place, cell)| self.learn(place, cell));
        }
        self.advice.notes = self.notes();
        let mut best = self.best.into_iter();
        (self.advice.advised, self.advice.runner_up) = (best.next(), best.next());
        let error = |choice: &Choice| choice.worst_error.unwrap_or(0.0);
        let most = self.advice.advised.as_ref().map_or(0.0, |advised| 0.5 * error(advised));
        let finer = self.met.into_iter().filter(|choice| most > 0.0 && error(choice) <= most);
        self.advice.finer = finer.min_by(|a, b| a.cost.total_cmp(&b.cost).then(a.place.cmp(&b.place)));
        Ok(self.advice)
    }

    fn cost(&self, work: [f64; 4]) -> f64 {
        self.question.prices.iter().zip(work).map(|(price, count)| price * count).sum()
    }

    /// What a cell costs by the least work that it can be, and by how much more completed runs of its form were.
    fn expected(&self, (form, step): (usize, usize)) -> f64 {
        let least = least_work(&self.forms[form].1, self.question.macro_steps[step]);
        self.cost(std::array::from_fn(|kind| least[kind] * self.seen[form][kind]))
    }

    /// Whether a cell may be better than the best of its own scheme, and than the runner-up.
    fn may_be_chosen(&self, (form, step): (usize, usize)) -> bool {
        let cost = self.expected((form, step));
        let own = self.best.iter().find(|choice| choice.scheme == self.forms[form].1.scheme.name);
        let mut rivals = own.into_iter().chain(self.best.get(1));
        cost.is_finite() && rivals.all(|rival| cost < rival.cost * (1.0 - 1e-9))
    }

    /// Runs a cell at one phase after another until it misses the error.
    fn judge(&self, (place, step): (usize, usize)) -> Result<Choice> {
        let ((request, first), macro_step_s) = (&self.forms[place], self.question.macro_steps[step]);
        let budget = self.question.budget;
        // Waiting for another program takes no processor time of this one.
        let (clock, time_is_of): (fn() -> Duration, _) = if first.case.waits || first.scheme.waits {
            (monotonic_clock, "wall")
        } else {
            (processor_clock, "processor")
        };
        let (request, scheme) = (request.at_macro_step(macro_step_s), first.scheme.name.to_string());
        let way = within::way_of(first);
        let form = format!("{}, {}, mechanics steps: {}", first.sequence, first.force_return, first.mechanics_steps);
        let (mut cell, mut time, mut points) =
            (Choice { request, place, scheme, way, form, macro_step_s, time_is_of, ..Choice::default() }, 0.0, 1.0);
        for &phase in &self.phases {
            let spec = match self.spec(&RunRequest { phase: Some(phase), ..cell.request.clone() }, cell.runs == 0) {
                Ok(spec) => spec,
                Err((reason, skipped)) => return Ok(Choice { fault: Some(reason), skipped, ..cell }),
            };
            points = if first.case.has_fixed_steps() {
                spec.communication_points().macro_steps() as f64
            } else {
                (first.duration / macro_step_s).max(1.0)
            };
            let begun = clock();
            let run = evaluated(&spec, &self.reference, budget.is_some(), false, self.question.stop)?;
            time += (clock() - begun).as_secs_f64();
            if matches!(run.outcome, Outcome::Stopped { .. }) {
                return Err(Error::Stopped);
            }
            (self.question.progress)(Step::Done(run.outcome.class()));
            (cell.runs, cell.last) = (cell.runs + 1, Some(run.outcome.kind()));
            // What a run had come to before it failed is no error of the form.
            let has_completed = run.outcome.class() == OutcomeClass::Completed;
            let of_peak = run.found.metric(METRIC);
            let error = match (budget, [SAMPLED, INSIDE].map(|metric| run.found.metric(metric))) {
                (None, _) => of_peak,
                (Some(_), [sampled, inside]) => {
                    of_peak.zip(sampled).zip(inside).map(|((share, sampled), inside)| inside * share / sampled)
                }
            };
            let error = error.filter(|error| error.is_finite() && has_completed);
            cell.fault = match error {
                _ if !run.outcome.kind().was_run() => {
                    cell.skipped = true;
                    Some(run.outcome.reason())
                }
                _ if !has_completed => {
                    let fault = format!("{}: {}", run.outcome.kind(), run.outcome.reason());
                    Some(fault.trim_end_matches(": ").to_owned())
                }
                Some(error) if error <= self.question.error => None,
                Some(error) => Some(format!("error {:.3} % of the peak force", 100.0 * error)),
                None => Some("no error relative to a peak".to_owned()),
            };
            if cell.fault.is_some() || error > cell.worst_error {
                (cell.request.phase, cell.run_id, cell.worst_error) = (Some(phase), spec.id(), error);
            }
            let Work { cosim, sides, scheme } = run.found.work;
            let solves = scheme.solves + scheme.parametric;
            let work = [cosim.exchanges, sides.mechanics.micro_steps, sides.actuator.micro_steps, solves];
            cell.work.iter_mut().zip(work).for_each(|(most, count)| *most = most.max(count as f64));
            let spent =
                [cosim.macro_steps, sides.mechanics.micro_steps].map(|count| count as f64 / run.found.ended_at_s);
            cell.spent_per_s.iter_mut().zip(spent).for_each(|(most, own)| *most = most.max(own));
            cell.model_exact |= run.found.model_exact;
            if cell.fault.is_some() {
                return Ok(cell);
            }
        }
        cell.cost = self.cost(cell.work);
        cell.points = points;
        cell.time_per_macro_step_s = time / cell.runs as f64 / cell.points;
        Ok(cell)
    }

    /// What is to be run, or why it is not: at the first phase it is seen whether a linear case grows without end.
    fn spec(&self, request: &RunRequest, is_first: bool) -> std::result::Result<RunSpec, (String, bool)> {
        let refused = |reason: String| (reason, true);
        let spec = request.resolve(self.question.catalogue).map_err(|error| refused(error.to_string()))?;
        if let Some(steps) = spec.refused_steps() {
            return Err(refused(steps.reason));
        }
        let radius = (is_first && !spec.case.linear_state.is_empty()).then(|| spectral_radius(&spec).ok()).flatten();
        match radius.filter(|radius| *radius > 1.0 + NEUTRAL) {
            Some(radius) => Err((format!("spectral radius 1 + {:.1e}, it grows without end", radius - 1.0), false)),
            None => Ok(spec),
        }
    }

    /// Takes note of a cell.
    fn learn(&mut self, (form, step): (usize, usize), cell: Choice) {
        self.advice.runs_made += cell.runs;
        if cell.last == Some(OutcomeKind::Completed) {
            let least = least_work(&self.forms[form].1, self.question.macro_steps[step]);
            self.seen[form] = std::array::from_fn(|kind| cell.work[kind] / least[kind]);
        }
        let Some(fault) = &cell.fault else {
            self.met.push(cell.clone());
            if self.best.iter().all(|other| other.scheme != cell.scheme || cell.cost < other.cost) {
                self.best.retain(|other| other.scheme != cell.scheme);
                self.best.push(cell);
                self.best.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.place.cmp(&b.place)));
            }
            return;
        };
        // Nothing follows for other macro steps: a side may refuse one and take the next.
        if cell.skipped {
            *self.advice.skipped.entry(fault.to_owned()).or_default() += 1;
            return;
        }
        let no_answer = cell.last.filter(|outcome| outcome.class() == OutcomeClass::NoAnswer);
        self.advice.undecided += usize::from(no_answer.is_some());
        let distance = [cell.worst_error.unwrap_or(f64::INFINITY), cell.macro_step_s];
        if self.nearest.as_ref().is_none_or(|(known, _)| distance < *known) {
            let phase = cell.request.phase.map_or_else(String::new, |phase| format!(", phase {phase:.4}"));
            let cell = format!("{}, {}, at H = {}", cell.scheme, cell.form, ms(cell.macro_step_s));
            self.nearest = Some((distance, format!("{cell}{phase}: {fault}")));
        }
    }

    /// What has to be said of the choice, or why there is none.
    fn notes(&self) -> Vec<String> {
        let (steps, mut notes) = (self.question.macro_steps, Vec::new());
        let [from, to] = [steps[0], steps[steps.len() - 1]];
        if let Some(best) = self.best.first() {
            if best.macro_step_s == to && self.question.budget.is_none() {
                notes.push(format!("{} is the largest macro step that was tried: --to asks for larger ones.", ms(to)));
            }
            if best.points < FEW_POINTS {
                notes.push(format!(
                    "The error is judged at the ends of {:.0} macro steps, nowhere within one.",
                    best.points.ceil()
                ));
            }
            let uncertainty = self.advice.reference_uncertainty_of_peak.unwrap_or(0.0);
            if 3.0 * uncertainty > self.question.error {
                notes.push(format!("The reference is uncertain by {uncertainty:.1e} of its peak, much of the error."));
            }
            if best.model_exact {
                notes.push("Here the model is the mechanics itself (model_exact): elsewhere expect more.".to_owned());
            }
        } else {
            let [from, to] = [from, to].map(ms);
            notes.push(match self.question.budget {
                None => format!("None: no form meets the error at every phase between H = {from} and {to}."),
                Some(_) => "None: no form within the budget completes at every phase.".to_owned(),
            });
            notes.push(match &self.nearest {
                Some((_, reason)) => format!("The nearest: {reason}."),
                None => "No form could be run.".to_owned(),
            });
        }
        if self.forms[0].1.case.has_fixed_steps() {
            notes.push(
                "A side takes steps of one length only: runs are at phase 1 alone and end with their last whole macro step; where an event \
                 falls between two exchanges was not varied."
                    .to_owned(),
            );
        }
        // Of a budget forms are tried that not every scheme has.
        if !self.advice.skipped.is_empty() && (self.question.budget.is_none() || self.best.is_empty()) {
            let mut reasons: Vec<_> = self.advice.skipped.iter().collect();
            reasons.sort_by_key(|(_, cells)| std::cmp::Reverse(**cells));
            let all = self.forms.len() * steps.len();
            let (first, cells) = (reasons[0], self.advice.skipped.values().sum::<usize>());
            let more = match reasons.len() - 1 {
                0 => String::new(),
                more => format!(", and {more} more reasons (--format json)"),
            };
            notes.push(format!("Skipped: {cells} of {all} cells; {} of them because {}{more}.", first.1, first.0));
        }
        if self.advice.undecided > 0 {
            notes.push("Cells took longer than the wall limit (undecided), which says nothing of them.".to_owned());
        }
        notes
    }
}

/// A macro step in milliseconds, without the round-off of the factor.
fn ms(step: f64) -> String {
    format!("{} ms", format!("{:.9e}", step * 1e3).parse::<f64>().unwrap_or(step * 1e3))
}
