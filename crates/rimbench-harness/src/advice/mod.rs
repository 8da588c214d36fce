//! Which macro step, which scheme? The cheapest row of a grid that stays within an error at every phase.
//!
//! ```text
//! forms of all schemes (forms) × macro steps → grid, cheapest first → what meets the error at one phase, then at all
//! ```
//! Nothing is assumed of how errors grow with H: a cell of the grid is left out only where it is expected to cost more than what has been
//! found. The search ends when no cell is left that could be cheaper than the cheapest of two schemes.

mod forms;
mod prices;

pub use forms::Information;
pub use prices::{USUAL_PRICES, measured_prices};

use super::cache::Cache;
use super::clock::{monotonic_clock, processor_clock};
use super::execution::evaluated;
use super::grid::phase_ensemble;
use super::job::{Progress, Step};
use super::references::obtain_reference;
use super::spectral::spectral_radius;
use rayon::prelude::*;
use rimbench_cases::catalogue::Catalogue;
use rimbench_cases::runs::{NEUTRAL, Reference, RunRequest, RunSettings, RunSpec, simulate};
use rimbench_core::cosim::{Bounds, MechanicsSteps, Outcome, OutcomeClass, OutcomeKind, StopFlag, Work};
use rimbench_core::error::{Error, Result};
use rimbench_statistics::Pool;

/// The metric by which a run is judged.
pub const METRIC: &str = "force_error_rms_of_peak";

/// What is counted: exchanges of the coupling variables, steps of the mechanics with their contact problem, micro steps of the actuator, contact
/// problems of the scheme's interface model.
pub const WORK: [&str; 4] = ["exchanges", "mechanics_solves", "micro_steps", "model_solves"];

/// Cells that are looked at together; a number of its own, so that what is found does not depend on how many threads there are.
const BATCH: usize = 16;

/// Below this share two costs are one.
const SAME_COST: f64 = 1e-9;

/// What is asked.
#[derive(Clone, Copy)]
pub struct Question<'a> {
    /// Where cases and schemes are found.
    pub catalogue: &'a Catalogue,
    /// The case and its parameters, and what is asked of every run. A scheme named here competes alone.
    pub fixed: &'a RunRequest,
    /// Rms force error allowed at every phase, over the reference's peak.
    pub error: f64,
    /// What may be known.
    pub information: Information,
    /// What each kind of [`WORK`] costs.
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
#[derive(Debug, Clone, Default)]
pub struct Advice {
    /// Largest interface force of the reference, N; of several rows the smallest: each row's error is relative to its own. None where
    /// there is no force to speak of.
    pub reference_peak_n: Option<f64>,
    /// Rms uncertainty of the reference's force over its peak; the worst row.
    pub reference_uncertainty: Option<f64>,
    /// All forms of schemes, in the order of the catalogue.
    pub rows: Vec<AdviceRow>,
    /// Schemes that do not compete, and why.
    pub refused: Vec<(String, String)>,
    /// Places of the cheapest row that meets the error, and of the cheapest of another scheme.
    pub chosen: Vec<usize>,
    /// Runs made.
    pub runs: usize,
}

/// A form of a scheme, and what has been learnt of it.
#[derive(Debug, Clone)]
pub struct AdviceRow {
    /// What to ask of a run, macro step and phase aside.
    pub request: RunRequest,
    /// Its run at the smallest macro step.
    pub first: RunSpec,
    /// Where it meets the error at all phases, and at the least cost.
    pub met: Option<Met>,
    /// Where and why it missed the error at the smallest macro step that was tried, and with which run.
    pub missed: Option<(f64, String, Option<Probe>)>,
    /// Work of a run that completed, with its macro step.
    seen: Option<(f64, [f64; 4])>,
}

/// A macro step at which a form meets the error.
#[derive(Debug, Clone)]
pub struct Met {
    /// H, s.
    pub macro_step: f64,
    /// Whether no larger macro step was tried.
    pub is_largest: bool,
    /// Its runs, by phase.
    pub runs: Vec<Probe>,
    /// The largest count of each kind of [`WORK`] in any of them.
    pub work: [f64; 4],
    /// Its cost.
    pub cost: f64,
}

/// A run of the search.
#[derive(Debug, Clone)]
pub struct Probe {
    /// [`RunSpec::id`].
    pub run_id: String,
    /// φ.
    pub phase: f64,
    /// How it ended.
    pub outcome: OutcomeKind,
    /// Rms force error over the reference's peak; none where there is none.
    pub error: Option<f64>,
    /// Whether the model was the mechanics itself.
    pub model_exact: bool,
    /// Time per macro step on this machine, s: of the processor, or by the wall clock where a side is from outside.
    pub time_per_step_s: f64,
    work: [f64; 4],
}

impl Met {
    /// The run with the largest error.
    pub fn worst(&self) -> Option<&Probe> {
        self.runs.iter().max_by(|a, b| a.error.unwrap_or(0.0).total_cmp(&b.error.unwrap_or(0.0)))
    }

    /// Median [time per macro step](Probe::time_per_step_s), s.
    pub fn time_per_step_s(&self) -> Option<f64> {
        Pool::of(self.runs.iter().map(|run| run.time_per_step_s)).median()
    }
}

/// Finds the advice.
///
/// # Errors
/// Bad input; a case that has no reference with these parameters; [`Error::Stopped`].
pub fn advise(question: Question<'_>) -> Result<Advice> {
    question.check()?;
    let (rows, refused) = forms::all(&question)?;
    let mut advice = Advice { refused, ..Advice::default() };
    let Some(first) = rows.first().map(|row| row.first.clone()) else { return Ok(advice) };
    let reference = obtain_reference(&first, question.cache, question.stop)?;
    if let Some((peak, uncertainty)) = force_to_speak_of(&reference, &first) {
        (advice.reference_peak_n, advice.reference_uncertainty) = (Some(peak), Some(uncertainty));
        if uncertainty < question.error {
            let (bounds, phases) = (reference.bounds(&first)?, phase_ensemble(question.phases));
            let mut search = Search { question: &question, reference: &reference, bounds, phases, rows, runs: 0 };
            advice.chosen = search.run()?;
            (advice.rows, advice.runs) = (search.rows, search.runs);
        }
    }
    Ok(advice)
}

/// Peak of the reference's force and its relative uncertainty, row by row: the smallest peak and the worst uncertainty; none where the
/// interface carries no force, to which no error can be relative.
fn force_to_speak_of(reference: &Reference, spec: &RunSpec) -> Option<(f64, f64)> {
    let rows = spec.case.interface_columns.iter().filter_map(|row| {
        let peak = reference.largest[reference.trajectory.index_of(&row.force)?];
        (peak > 0.0).then(|| Some((peak, reference.uncertainty_of(&row.force)? / peak)))?
    });
    rows.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

impl Question<'_> {
    fn check(&self) -> Result<()> {
        if !(self.error > 0.0 && self.error <= 1.0) {
            let expected = "a share of the reference's peak force above 0, at most 100 %: 1% or 0.01";
            return Err(Error::invalid("error", self.error, expected));
        }
        if self.macro_steps.is_empty() || !self.macro_steps.is_sorted_by(|a, b| a < b) {
            let message = "an advice needs macro steps to try, one at least, in ascending order";
            return Err(Error::Incompatible(message.to_owned()));
        }
        if !(1..=1000).contains(&self.phases) {
            return Err(Error::invalid("phases", self.phases, "a whole number from 1 to 1000"));
        }
        if let Some(kind) = self.fixed.force_return.filter(|kind| !self.information.allows(*kind)) {
            let message = format!("--force-return {kind} does not go with --no-feedback, which allows `held` only");
            return Err(Error::Incompatible(message));
        }
        if let Some(price) = self.prices.into_iter().find(|price| !(price.is_finite() && *price >= 0.0)) {
            return Err(Error::invalid("costs", price, "finite numbers, 0 or above"));
        }
        if self.prices == [0.0; 4] {
            let message = "nothing costs anything, so nothing is cheapest: set one cost above 0";
            return Err(Error::Incompatible(message.to_owned()));
        }
        Ok(())
    }

    fn cost(&self, work: [f64; 4]) -> f64 {
        self.prices.iter().zip(work).map(|(price, count)| price * count).sum()
    }
}

struct Search<'a> {
    question: &'a Question<'a>,
    reference: &'a Reference,
    bounds: Bounds,
    phases: Vec<f64>,
    rows: Vec<AdviceRow>,
    runs: usize,
}

/// Runs of a cell, phase by phase, and what is wrong with the last, if anything is.
type Judged = (Vec<Probe>, Option<String>);

impl Search<'_> {
    /// Tries cells, cheapest first, until none is left that could be cheaper than the cheapest of two schemes; returns these.
    fn run(&mut self) -> Result<Vec<usize>> {
        let steps = self.question.macro_steps;
        let mut open: Vec<(usize, usize)> =
            (0..self.rows.len()).flat_map(|row| (0..steps.len()).map(move |step| (row, step))).collect();
        loop {
            let leaders = self.leaders();
            let cost = |&(row, step): &(usize, usize)| self.question.cost(self.rows[row].expected(steps[step]));
            open.retain(|cell| !self.rows[cell.0].no_answer(false) && self.is_cheaper(cell.0, cost(cell), &leaders));
            open.sort_by(|a, b| cost(a).total_cmp(&cost(b)).then(a.cmp(b)));
            let batch: Vec<(usize, usize)> = open.drain(..BATCH.min(open.len())).collect();
            if batch.is_empty() {
                return Ok(leaders);
            }
            let judged: Vec<Judged> = batch.par_iter().map(|&cell| self.judge(cell)).collect::<Result<_>>()?;
            batch.into_iter().zip(judged).for_each(|(cell, judged)| self.learn(cell, judged));
        }
    }

    /// The cheapest row that meets the error, and the cheapest of another scheme; of equals the first in the catalogue.
    fn leaders(&self) -> Vec<usize> {
        let cost = |&row: &usize| self.rows[row].met.as_ref().map_or(f64::INFINITY, |met| met.cost);
        let mut met: Vec<usize> = (0..self.rows.len()).filter(|&row| self.rows[row].met.is_some()).collect();
        met.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        let another =
            met.iter().copied().find(|&row| self.rows[row].first.scheme.name != self.rows[met[0]].first.scheme.name);
        met.first().copied().into_iter().chain(another).collect()
    }

    /// Whether a row at some cost would be better than the leader of its own scheme, else than the runner-up.
    fn is_cheaper(&self, row: usize, cost: f64, leaders: &[usize]) -> bool {
        let own = |&&leader: &&usize| self.rows[leader].first.scheme.name == self.rows[row].first.scheme.name;
        let rival = leaders.iter().find(own).or(leaders.get(1)).and_then(|&leader| self.rows[leader].met.as_ref());
        rival.is_none_or(|rival| cost < rival.cost * (1.0 - SAME_COST))
    }

    /// Runs a cell at one phase after another until it misses the error. A linear case that grows without end is not run.
    fn judge(&self, (row, step): (usize, usize)) -> Result<Judged> {
        let (row, step, mut runs) = (&self.rows[row], self.question.macro_steps[step], Vec::new());
        for &phase in &self.phases {
            let request = RunRequest { macro_step_s: Some(step), phase: Some(phase), ..row.request.clone() };
            let spec = match request.resolve_for(self.question.catalogue, &row.first.case, &row.first.parameters) {
                Ok(spec) => spec,
                Err(Error::Stopped) => return Err(Error::Stopped),
                Err(error) => return Ok((runs, Some(error.to_string()))),
            };
            if runs.is_empty()
                && !spec.case.linear_state.is_empty()
                && let Some(radius) = spectral_radius(&spec).ok().filter(|radius| *radius > 1.0 + NEUTRAL)
            {
                return Ok((runs, Some(format!("spectral radius 1 + {:.1e}, it grows without end", radius - 1.0))));
            }
            // Waiting for another program takes no processor time of this one.
            let clock = if spec.case.waits { monotonic_clock } else { processor_clock };
            let begun = clock();
            let run = evaluated(&spec, &self.bounds, self.reference, simulate, self.question.stop)?;
            let time = (clock() - begun).as_secs_f64();
            if matches!(run.outcome, Outcome::Stopped { .. }) {
                return Err(Error::Stopped);
            }
            (self.question.progress)(Step::Done(run.outcome.class()));
            let error = run.found.metric(METRIC).filter(|error| error.is_finite());
            let outcome = run.outcome.kind();
            let fault = match error {
                _ if outcome.class() != OutcomeClass::Completed => {
                    Some(format!("{outcome}: {}", run.outcome.reason()).trim_end_matches(": ").to_owned())
                }
                Some(error) if error <= self.question.error => None,
                Some(error) => Some(format!("error {:.3} % of the peak force", 100.0 * error)),
                None => Some("no error relative to a peak".to_owned()),
            };
            let Work { cosim, sides, scheme } = run.found.work;
            let solves = scheme.solves + scheme.parametric;
            let work = [cosim.exchanges, sides.mechanics.micro_steps, sides.actuator.micro_steps, solves];
            runs.push(Probe {
                run_id: spec.id(),
                phase,
                outcome,
                error,
                model_exact: run.found.model_exact,
                time_per_step_s: time / (spec.duration / step).ceil().max(1.0),
                work: work.map(|count| count as f64),
            });
            if fault.is_some() {
                return Ok((runs, fault));
            }
        }
        Ok((runs, None))
    }

    /// Takes note of the runs of a cell.
    fn learn(&mut self, (row, step): (usize, usize), (mut runs, fault): Judged) {
        let (question, row) = (self.question, &mut self.rows[row]);
        let macro_step = question.macro_steps[step];
        self.runs += runs.len();
        if let Some(run) = runs.iter().rfind(|run| run.outcome.class() == OutcomeClass::Completed) {
            row.seen = Some((macro_step, run.work));
        }
        if let Some(fault) = fault {
            if row.missed.as_ref().is_none_or(|(known, ..)| macro_step <= *known) {
                row.missed = Some((macro_step, fault, runs.pop()));
            }
            return;
        }
        let most = |most: [f64; 4], run: &Probe| std::array::from_fn(|kind| most[kind].max(run.work[kind]));
        let work = runs.iter().fold([0.0; 4], most);
        let (cost, is_largest) = (question.cost(work), step + 1 == question.macro_steps.len());
        if row.met.as_ref().is_none_or(|known| cost < known.cost) {
            row.met = Some(Met { macro_step, is_largest, runs, work, cost });
        }
    }
}

impl AdviceRow {
    fn new(request: RunRequest, first: RunSpec) -> Self {
        AdviceRow { request, first, met: None, missed: None, seen: None }
    }

    /// Whether it gave no answer: having taken longer than it may if it `was_run`, else because it cannot be run at all.
    pub fn no_answer(&self, was_run: bool) -> bool {
        let run = self.missed.as_ref().and_then(|(.., run)| run.as_ref());
        run.is_some_and(|run| run.outcome.class() == OutcomeClass::NoAnswer && run.outcome.was_run() == was_run)
    }

    /// The form in words.
    pub fn form(&self) -> String {
        let RunSettings { sequence, force_return, mechanics_steps, .. } = &*self.first;
        let steps = match mechanics_steps {
            MechanicsSteps::AsActuator => "as many mechanics steps as micro steps".to_owned(),
            MechanicsSteps::Count(count) if count.get() == 1 => "1 mechanics step".to_owned(),
            MechanicsSteps::Count(count) => format!("{count} mechanics steps"),
        };
        format!("{sequence}, {force_return}, {steps}")
    }

    /// Why it is not advised.
    pub fn reason(&self) -> String {
        match (&self.met, &self.missed) {
            (Some(met), _) => format!("meets it at {}, for a cost of {:.0}", milliseconds(met.macro_step), met.cost),
            (None, Some((_, reason, _))) if self.no_answer(false) => reason.clone(),
            (None, Some((step, reason, run))) => {
                let phase = run.as_ref().map_or(String::new(), |run| format!(", phase {:.4}", run.phase));
                format!("at {}{phase}: {reason}", milliseconds(*step))
            }
            (None, None) => "not run: costs more at every macro step".to_owned(),
        }
    }

    /// Work that a run at this macro step is expected to be: by a run that was made, else the least it can be.
    fn expected(&self, macro_step: f64) -> [f64; 4] {
        let first = &self.first;
        let usual = first.case.defaults.micro_step_s.max(first.micro_step);
        let micro = |step: f64| (first.duration / step).max(1.0) * (step / step.min(usual)).ceil();
        let steps = (first.duration / macro_step).max(1.0);
        let is_fine = first.mechanics_steps == MechanicsSteps::AsActuator;
        if let Some((seen_at, [exchanges, mechanics, micro_steps, model])) = self.seen {
            let (factor, fine) = (seen_at / macro_step, micro(macro_step) / micro(seen_at));
            return [
                exchanges * factor,
                mechanics * if is_fine { fine } else { factor },
                micro_steps * fine,
                model * fine,
            ];
        }
        let own = match first.mechanics_steps {
            MechanicsSteps::AsActuator => micro(macro_step),
            MechanicsSteps::Count(count) => steps * f64::from(count.get()),
        };
        // What is taken again is taken twice at least.
        let times = if first.scheme.real_time() { 1.0 } else { 2.0 };
        [steps, own * times, micro(macro_step) * times, 0.0]
    }
}

/// Writes a macro step (s) in milliseconds; six digits behind the point are more than a grid has, but for the shortest steps.
pub fn milliseconds(step: f64) -> String {
    let milliseconds = 1e3 * step;
    if milliseconds < 1e-3 {
        return format!("{milliseconds:.3e} ms");
    }
    format!("{} ms", (1e6 * milliseconds).round() / 1e6)
}
