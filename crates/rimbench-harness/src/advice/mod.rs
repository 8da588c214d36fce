//! Which macro step, which scheme? The cheapest scheme and macro step that stay within an error at every phase.
//!
//! ```text
//! forms of all schemes → what information and needs leave (form) → search over H, cheapest first (search) → phases kept aside
//! → up to where it stays stable (limit)
//! ```
//! Runs are made once and kept by their ids (probe). The search looks at one phase first and at the others only where that one
//! passes, and asks of each form no more than whether it can be cheaper than what has been found.

mod account;
mod candidate;
mod form;
mod limit;
mod price;
mod probe;
mod search;

pub use form::Information;
pub use limit::LimitFound;
pub use price::{Prices, Work};
pub use probe::{METRIC, Probe};
pub use search::milliseconds;

use super::cache::Cache;
use super::grid::phase_ensemble;
use super::job::Progress;
use super::references::obtain_reference;
use candidate::Candidate;
use probe::Prober;
use rimbench_cases::catalogue::Catalogue;
use rimbench_cases::runs::{Reference, RunRequest};
use rimbench_core::cosim::StopFlag;
use rimbench_core::error::{Error, Result};
use search::Search;
use std::time::Duration;

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
    /// What work costs.
    pub prices: Prices,
    /// Macro steps that are tried, s, ascending.
    pub macro_steps: &'a [f64],
    /// Phases of the search; the first members of the phase ensemble.
    pub phases: usize,
    /// Phases kept aside, the members that follow, at which the advice must hold as well.
    pub kept_aside: usize,
    /// Try every macro step at which a form would be cheaper than what is advised, as if the error did not grow with H.
    pub exhaustive: bool,
    /// When to stop searching.
    pub budget: Budget,
    /// Where references and runs are kept.
    pub cache: &'a Cache,
    /// Told of what is to be done and of each run that is done.
    pub progress: Progress<'a>,
    /// Who may end it.
    pub stop: StopFlag<'a>,
}

/// When a search ends before it is done; what was found by then is told, with what was left open.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Budget {
    /// Wall time.
    pub wall: Option<Duration>,
    /// Runs asked for, stored ones included, so that a search comes to the same end whatever is stored.
    pub runs: Option<usize>,
}

/// What comes of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Advice {
    /// Largest interface force of the reference, N; of several rows the smallest: each row's error is relative to its own.
    pub reference_peak_n: Option<f64>,
    /// Rms uncertainty of the reference's force over its peak; the worst row.
    pub reference_uncertainty: Option<f64>,
    /// The cheapest, if any meets the error.
    pub best: Option<Choice>,
    /// The cheapest of another scheme.
    pub runner_up: Option<Choice>,
    /// All other forms, in the order of the catalogue, and schemes that were not tried.
    pub fallen: Vec<Fallen>,
    /// Runs made now.
    pub computed: usize,
    /// Runs that were stored.
    pub reused: usize,
    /// Forms about which the search was not done when the budget was spent.
    pub open: usize,
    /// Forms of which nothing is known because a run took longer than it may.
    pub timed_out: usize,
}

/// A scheme in a form at a macro step.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// What to ask of a run, phase aside.
    pub request: RunRequest,
    /// The form in words.
    pub form: String,
    /// H, s.
    pub macro_step: f64,
    /// Its runs at the phases of the search.
    pub runs: Vec<Probe>,
    /// Its runs at the phases kept aside.
    pub kept_aside: Vec<Probe>,
    /// Work of the dearest of these runs, kind by kind.
    pub work: Work,
    /// Its cost.
    pub cost: f64,
    /// What it is expected to cost at the next macro step of the grid, where there is one: anything dearer than this is within one
    /// step of the grid of what is advised.
    pub cost_one_step_on: Option<f64>,
    /// Spectral radius of the macro-step map, on linear cases.
    pub spectral_radius: Option<f64>,
    /// Up to where it stays stable.
    pub limit: LimitFound,
}

impl Choice {
    /// The largest error at any phase.
    pub fn worst_error(&self) -> f64 {
        self.runs.iter().chain(&self.kept_aside).filter_map(|run| run.error).fold(0.0, f64::max)
    }
}

/// A scheme that is not advised.
#[derive(Debug, Clone, PartialEq)]
pub struct Fallen {
    /// The scheme.
    pub scheme: String,
    /// What to ask of a run; none where no run is possible or allowed.
    pub request: Option<RunRequest>,
    /// The form in words.
    pub form: String,
    /// Why.
    pub reason: String,
    /// The run that decided.
    pub run: Option<Probe>,
    /// The cost at which it meets the error, where it does.
    pub cost: Option<f64>,
}

/// Finds the advice.
///
/// # Errors
/// Bad input; a case that has no reference with these parameters; [`Error::Stopped`].
pub fn advise(question: Question<'_>) -> Result<Advice> {
    question.check()?;
    let (candidates, refused) = candidate::all(&question)?;
    let Some(spec) = candidates.first().map(|candidate| candidate.first.clone()) else {
        return Ok(Advice::none(refused));
    };
    let reference = obtain_reference(&spec, question.cache, question.stop)?;
    let (peak, uncertainty) = force_of(&reference, &candidates[0]);
    let prober = Prober::new(&spec, &reference, question.cache, question.stop)?;
    let phases = phase_ensemble(question.phases + question.kept_aside);
    let mut search = Search::new(&question, &prober, &phases, candidates);
    let told = if uncertainty.is_some_and(|own| own >= question.error) { None } else { Some(search.run()?) };
    let mut advice = Advice {
        reference_peak_n: peak,
        reference_uncertainty: uncertainty,
        open: search.open(),
        timed_out: search.timed_out(),
        ..Advice::none(Vec::new())
    };
    if let Some([best, runner_up]) = told {
        advice.best = best.map(|index| search.choice(index)).transpose()?;
        advice.runner_up = runner_up.map(|index| search.choice(index)).transpose()?;
        advice.fallen = search.fallen([best, runner_up]);
    }
    advice.fallen.extend(refused);
    advice.computed = prober.computed.into_inner();
    advice.reused = prober.reused.into_inner();
    Ok(advice)
}

impl Advice {
    fn none(fallen: Vec<Fallen>) -> Self {
        Advice {
            reference_peak_n: None,
            reference_uncertainty: None,
            best: None,
            runner_up: None,
            fallen,
            computed: 0,
            reused: 0,
            open: 0,
            timed_out: 0,
        }
    }
}

impl Question<'_> {
    fn check(&self) -> Result<()> {
        if !(self.error > 0.0 && self.error <= 1.0) {
            let expected = "a share of the reference's peak force above 0, at most 100 %: 1% or 0.01";
            return Err(Error::invalid("error", self.error, expected));
        }
        let ascending = self.macro_steps.windows(2).all(|pair| pair[0] < pair[1]);
        if self.macro_steps.is_empty() || !ascending {
            return Err(Error::Incompatible(
                "an advice needs macro steps to try, one at least, in ascending order".into(),
            ));
        }
        for (key, count, least) in [("phases", self.phases, 1), ("kept-aside", self.kept_aside, 0)] {
            if !(least..=1000).contains(&count) {
                return Err(Error::invalid(key, count, format!("a whole number from {least} to 1000")));
            }
        }
        if let Some(kind) = self.fixed.force_return.filter(|kind| !self.information.allows(Some(*kind))) {
            let message = format!("--force-return {kind} does not go with --no-feedback, which allows `held` only");
            return Err(Error::Incompatible(message));
        }
        if let Some(runs) = self.budget.runs.filter(|runs| *runs <= self.runs_to_confirm()) {
            let all = self.phases + self.kept_aside;
            let expected = format!(
                "at least {}: what is advised and its runner-up must stand {all} phases each",
                self.runs_to_confirm() + 1
            );
            return Err(Error::invalid("most-runs", runs, expected));
        }
        self.prices.check()
    }

    /// Runs that hold what is advised and its runner-up against all phases.
    fn runs_to_confirm(&self) -> usize {
        2 * (self.phases + self.kept_aside)
    }
}

/// Peak of the reference's force and its relative uncertainty, row by row: the smallest peak and the worst uncertainty.
fn force_of(reference: &Reference, candidate: &Candidate) -> (Option<f64>, Option<f64>) {
    let rows = candidate.first.case.interface_columns.iter().filter_map(|row| {
        let peak = reference.largest[reference.trajectory.index_of(&row.force)?];
        (peak > 0.0).then(|| Some((peak, reference.uncertainty_of(&row.force)? / peak)))?
    });
    let rows: Vec<(f64, f64)> = rows.collect();
    (
        rows.iter().map(|(peak, _)| *peak).reduce(f64::min),
        rows.iter().map(|(_, uncertainty)| *uncertainty).reduce(f64::max),
    )
}
