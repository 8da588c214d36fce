//! The search: batches of runs, the same whatever the number of threads, until nothing left can be cheaper.
//!
//! A form's largest macro step that meets the error is closed in between one that does and one that does not, as if the error grew
//! with H. Of each form only that is asked which could make it better than the cheapest of two schemes found so far: whether it
//! meets the error, at the first phase, at the smallest macro step at which it would be cheaper. Most forms need one run. What leads
//! in the end is held against all phases, and falls back if it does not stand them.

use super::Question;
use super::candidate::{Candidate, Fall};
use super::price::Work;
use super::probe::{Probe, Prober};
use crate::job::Step;
use crate::spectral::spectral_radius;
use rayon::prelude::*;
use rimbench_cases::runs::NEUTRAL;
use rimbench_core::cosim::OutcomeKind;
use rimbench_core::error::{Error, Result};
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Forms that are looked at together; a number of its own, so that what is found does not depend on how many threads there are.
const BATCH: usize = 16;

/// Phases kept aside that are looked at together.
const AT_A_TIME: usize = 4;

/// Below this share two costs are one.
const SAME_COST: f64 = 1e-9;

/// A search under way.
pub(super) struct Search<'a> {
    pub(super) question: &'a Question<'a>,
    prober: &'a Prober<'a>,
    pub(super) phases: &'a [f64],
    pub(super) candidates: Vec<Candidate>,
    began: Instant,
    /// The budget was spent.
    spent: bool,
    /// Macro steps of forms beyond one that missed the error that an exhaustive search had no budget for.
    left_beyond: usize,
}

/// Runs of a form at a macro step; else why there are none.
pub(super) type Runs = Result<Vec<Probe>, String>;

/// The cheapest of two schemes, by their places.
pub(super) type Leaders = [Option<usize>; 2];

impl<'a> Search<'a> {
    pub(super) fn new(
        question: &'a Question<'a>,
        prober: &'a Prober<'a>,
        phases: &'a [f64],
        candidates: Vec<Candidate>,
    ) -> Self {
        Search { question, prober, phases, candidates, began: Instant::now(), spent: false, left_beyond: 0 }
    }

    /// The phases of the search.
    pub(super) fn search_phases(&self) -> &'a [f64] {
        &self.phases[..self.question.phases]
    }

    /// Forms about which nothing is decided, and macro steps of forms that should still have been tried.
    pub(super) fn open(&self) -> usize {
        if !self.spent {
            return 0;
        }
        let leaders = self.leaders();
        (0..self.candidates.len()).filter(|&index| self.next(index, leaders).is_some()).count() + self.left_beyond
    }

    /// Forms whose search ended with a run that took longer than it may.
    pub(super) fn timed_out(&self) -> usize {
        let timed_out = |candidate: &&Candidate| {
            let run = candidate.fall.as_ref().and_then(|(_, run)| run.as_ref());
            candidate.met.is_none() && run.is_some_and(|run| run.timed_out())
        };
        self.candidates.iter().filter(timed_out).count()
    }

    /// Runs that may still be asked for.
    pub(super) fn room(&self) -> usize {
        self.question.budget.runs.map_or(usize::MAX, |runs| runs.saturating_sub(self.prober.asked()))
    }

    /// Runs that may still be asked for in the search: what leads must stand all phases afterwards.
    fn room_to_search(&self) -> usize {
        self.room().saturating_sub(self.question.runs_to_confirm())
    }

    /// Searches until nothing can be cheaper than the leaders, and these have stood the phases kept aside.
    pub(super) fn run(&mut self) -> Result<Leaders> {
        loop {
            let leaders = self.leaders();
            let mut open: Vec<(f64, usize, usize)> = (0..self.candidates.len())
                .filter_map(|index| {
                    let step = self.next(index, leaders)?;
                    let best = self.cost_at(index, self.candidates[index].missed - 1);
                    Some((best, index, step))
                })
                .collect();
            if open.is_empty() {
                let stood = self.stand_all_phases(leaders)?;
                if self.spent {
                    return Ok(self.confirmed(leaders));
                }
                if stood {
                    self.spent |= self.question.exhaustive && self.budget_is_spent();
                    if self.spent || !(self.question.exhaustive && self.find_beyond(leaders)?) {
                        return Ok(leaders);
                    }
                }
                continue;
            }
            self.spent |= self.budget_is_spent();
            if self.spent {
                // What has been found so far, if it stands all phases.
                self.stand_all_phases(leaders)?;
                return Ok(self.confirmed(leaders));
            }
            // What has been begun is brought to its end, so that there is soon something to beat; then the cheapest hope first.
            let begun = |index: usize| self.candidates[index].tries > 0;
            open.sort_by(|a, b| begun(b.1).cmp(&begun(a.1)).then(a.0.total_cmp(&b.0)).then(a.1.cmp(&b.1)));
            open.truncate(BATCH.min(self.room_to_search()));
            (self.question.progress)(Step::ToDo(self.expected_runs(open.len())));
            let tries: Vec<(usize, usize)> = open.into_iter().map(|(_, index, step)| (index, step)).collect();
            self.try_all(&tries)?;
        }
    }

    /// Those of the leaders that have stood all phases; where the first has not, the second is the best that is known.
    fn confirmed(&self, leaders: Leaders) -> Leaders {
        let [first, second] = leaders.map(|index| index.filter(|&index| self.candidates[index].checked));
        if first.is_some() { [first, second] } else { [second, None] }
    }

    /// Runs made so far, and those that a look at each open form would take: a guess, for a bar.
    fn expected_runs(&self, open: usize) -> usize {
        let untried = self.candidates.iter().filter(|candidate| candidate.tries == 0 && !candidate.out).count();
        let made = self.prober.computed.load(Ordering::Relaxed) + self.prober.reused.load(Ordering::Relaxed);
        made + untried.max(open)
    }

    fn budget_is_spent(&self) -> bool {
        let budget = self.question.budget;
        budget.wall.is_some_and(|wall| self.began.elapsed() >= wall) || self.room_to_search() == 0
    }

    /// What a form costs, or is expected to cost, at a macro step.
    pub(super) fn cost_at(&self, index: usize, step: usize) -> f64 {
        let candidate = &self.candidates[index];
        let work = match (candidate.met == Some(step)).then_some(candidate.work).flatten() {
            Some(work) => work,
            None => candidate.expected(self.question.macro_steps[step]),
        };
        self.question.prices.of(&work)
    }

    /// The cheapest form that meets the error, and the cheapest of another scheme; of equals the first in the catalogue.
    fn leaders(&self) -> Leaders {
        let mut met: Vec<(f64, usize)> = (0..self.candidates.len())
            .filter_map(|index| Some((self.cost_at(index, self.candidates[index].met?), index)))
            .collect();
        met.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let best = met.first().map(|(_, index)| *index);
        let another =
            |index: usize| best.is_some_and(|best| self.candidates[best].scheme() != self.candidates[index].scheme());
        [best, met.iter().map(|(_, index)| *index).find(|&index| another(index))]
    }

    /// What a form has to beat: the leader of its own scheme, else the runner-up; with its cost.
    fn rival(&self, index: usize, [best, runner_up]: Leaders) -> (Option<usize>, Option<f64>) {
        let own = |best: &usize| self.candidates[*best].scheme() == self.candidates[index].scheme();
        let rival = best.filter(own).or(runner_up);
        (rival, rival.map(|rival| self.cost_at(rival, self.candidates[rival].leading_step())))
    }

    /// The macro step to try next of a form; none if it cannot become better than what has been found.
    fn next(&self, index: usize, leaders: Leaders) -> Option<usize> {
        let candidate = &self.candidates[index];
        if candidate.out {
            return None;
        }
        let (rival, cost) = self.rival(index, leaders);
        let from = candidate.met.map_or(0, |met| met + 1);
        let cheaper = |step: &usize| cost.is_none_or(|cost| self.cost_at(index, *step) < cost * (1.0 - SAME_COST));
        let steps: Vec<usize> =
            (from..candidate.missed).filter(|step| !candidate.grows[*step]).filter(cheaper).collect();
        let (first, middle) = (*steps.first()?, steps[steps.len() / 2]);
        Some(match (cost, candidate.met, candidate.tries) {
            // Whoever leads looks for its own end.
            _ if rival == Some(index) => middle,
            (Some(_), ..) => first,
            // Nothing has been found yet: can this one do it at all?
            (None, None, 1) => first,
            (None, ..) => middle,
        })
    }

    /// Tries forms at macro steps, at the first phase.
    fn try_all(&mut self, tries: &[(usize, usize)]) -> Result<()> {
        let steps = self.question.macro_steps;
        let growing: Vec<Option<Vec<usize>>> =
            tries.par_iter().map(|&(index, step)| self.growing_steps(&self.candidates[index], step)).collect();
        let stable: Vec<(usize, usize)> =
            tries.iter().zip(&growing).filter(|(_, growing)| growing.is_none()).map(|(at, _)| *at).collect();
        let pairs: Vec<(&Candidate, f64)> =
            stable.iter().map(|&(index, step)| (&self.candidates[index], steps[step])).collect();
        let runs = self.probes(&pairs, &self.phases[..1])?;
        let judged: Vec<_> = pairs.iter().zip(&runs).map(|(pair, runs)| self.within(*pair, runs)).collect();
        for (&(index, step), growing) in tries.iter().zip(growing) {
            let Some(growing) = growing else { continue };
            let reason = self.growth(&self.candidates[index], steps[step]).1.map(|reason| (reason, None));
            let candidate = &mut self.candidates[index];
            candidate.fall = reason.or(candidate.fall.take());
            growing.into_iter().for_each(|step| candidate.grows[step] = true);
        }
        for ((&(index, step), pass), runs) in stable.iter().zip(judged).zip(runs) {
            let candidate = &mut self.candidates[index];
            candidate.tries += 1;
            if let Some(run) = runs.iter().flatten().find(|run| run.completed()) {
                candidate.seen = Some((steps[step], run.work));
            }
            match pass {
                Ok(()) => {
                    candidate.met = Some(step);
                    candidate.checked = false;
                    candidate.work = runs.ok().map(|runs| dearest(&runs));
                }
                Err(fall) => {
                    candidate.out = fall.1.as_ref().is_some_and(|run| run.skipped());
                    candidate.missed = step;
                    candidate.fall = Some(fall);
                }
            }
        }
        Ok(())
    }

    /// If a linear case grows with a form at a macro step: all macro steps still open at which it does. The error of a run says
    /// nothing about that: short macro steps may grow, slowly, where longer ones are damped.
    fn growing_steps(&self, candidate: &Candidate, step: usize) -> Option<Vec<usize>> {
        let steps = self.question.macro_steps;
        let grows = |step: &usize| self.growth(candidate, steps[*step]).1.is_some();
        grows(&step).then(|| (0..candidate.missed).into_par_iter().filter(grows).collect())
    }

    /// Whether a form is stable at a macro step and its runs meet the error; else where and why not, and which run says so.
    fn pass(&self, pair: (&Candidate, f64), runs: &Runs) -> Result<(), Fall> {
        self.within(pair, runs)?;
        self.growth(pair.0, pair.1).1.map_or(Ok(()), |reason| Err((reason, None)))
    }

    /// The same but for the spectral radius.
    fn within(&self, (_, step): (&Candidate, f64), runs: &Runs) -> Result<(), Fall> {
        let runs = runs.as_ref().map_err(|reason| (format!("at {}: {reason}", milliseconds(step)), None))?;
        let Some(run) = runs.iter().find(|run| !run.meets(self.question.error)) else { return Ok(()) };
        let reason = match run.error {
            _ if !run.completed() => run.reason.clone(),
            Some(error) => format!("error {:.3} % of the peak force", 100.0 * error),
            None => "no error relative to a peak: the interface carries no force".to_owned(),
        };
        Err((format!("at {}, phase {:.4}: {reason}", milliseconds(step), run.phase), Some(Box::new(run.clone()))))
    }

    /// The spectral radius of a linear case, and what is wrong with it, if it exceeds one.
    pub(super) fn growth(&self, candidate: &Candidate, step: f64) -> (Option<f64>, Option<String>) {
        if candidate.first.case.linear_state.is_empty() {
            return (None, None);
        }
        let radius = candidate.spec(self.question, step, 1.0).and_then(|spec| spectral_radius(&spec)).ok();
        let growing = radius.filter(|radius| *radius > 1.0 + NEUTRAL);
        let said = |radius: f64| {
            format!("at {}: spectral radius 1 + {:.1e}, it grows without end", milliseconds(step), radius - 1.0)
        };
        (radius, growing.map(said))
    }

    /// Runs of forms at macro steps and phases, all in parallel; the reason, where a form has no such run.
    pub(super) fn probes(&self, pairs: &[(&Candidate, f64)], phases: &[f64]) -> Result<Vec<Runs>> {
        let wanted: Vec<(usize, f64)> =
            (0..pairs.len()).flat_map(|at| phases.iter().map(move |&phase| (at, phase))).collect();
        let probed: Result<Vec<(usize, Result<Probe, String>)>> = wanted
            .into_par_iter()
            .map(|(at, phase)| {
                let (candidate, step) = pairs[at];
                let probe = match candidate.spec(self.question, step, phase) {
                    Ok(spec) => Ok(self.prober.probe(&spec)?),
                    Err(Error::Stopped) => return Err(Error::Stopped),
                    Err(error) => Err(error.to_string()),
                };
                if let Ok(probe) = &probe {
                    (self.question.progress)(Step::Done(probe.outcome.parse::<OutcomeKind>()?.class()));
                }
                Ok((at, probe))
            })
            .collect();
        let mut found: Vec<Runs> = pairs.iter().map(|_| Ok(Vec::new())).collect();
        for (at, probe) in probed? {
            match (&mut found[at], probe) {
                (Ok(runs), Ok(probe)) => runs.push(probe),
                (runs, Err(reason)) => *runs = Err(reason),
                (Err(_), Ok(_)) => {}
            }
        }
        Ok(found)
    }

    /// Holds the leaders against all phases, those kept aside last; one that fails there has missed its macro step. Tells whether
    /// all stood.
    fn stand_all_phases(&mut self, leaders: Leaders) -> Result<bool> {
        let mut stood = true;
        let (own, aside) = self.phases.split_at(self.question.phases);
        for index in leaders.into_iter().flatten() {
            let Some(step) = self.candidates[index].met.filter(|_| !self.candidates[index].checked) else { continue };
            let pair = (&self.candidates[index], self.question.macro_steps[step]);
            let mut work = Work::default();
            let mut fall = None;
            // Few at a time: what fails mostly fails soon.
            let aside = aside.chunks(AT_A_TIME).map(|phases| (phases, ", at a phase kept aside"));
            for (phases, said) in std::iter::once((own, "")).chain(aside) {
                if self.room() < phases.len() {
                    self.spent = true;
                    return Ok(false);
                }
                let runs = self.probes(&[pair], phases)?.remove(0);
                if let Err((reason, run)) = self.pass(pair, &runs) {
                    fall = Some((format!("{reason}{said}"), run));
                    break;
                }
                work = work.max(&dearest(runs.as_deref().unwrap_or_default()));
            }
            let candidate = &mut self.candidates[index];
            candidate.checked = fall.is_none();
            candidate.work = Some(work);
            if fall.is_some() {
                stood = false;
                (candidate.met, candidate.missed, candidate.fall) = (None, step, fall);
            }
        }
        // What costs more at another phase may not lead any more.
        Ok(stood && self.leaders() == leaders)
    }

    /// Tries every macro step beyond one that missed the error at which a form would be cheaper than the leaders. Tells whether one
    /// met it, at all phases; that form then leads.
    fn find_beyond(&mut self, leaders: Leaders) -> Result<bool> {
        let steps = self.question.macro_steps;
        let mut beyond: Vec<(f64, usize, usize)> = Vec::new();
        for index in (0..self.candidates.len()).filter(|&index| !self.candidates[index].out) {
            let cost = self.rival(index, leaders).1;
            let further = self.candidates[index].missed..steps.len();
            let costs = further.map(|step| (self.cost_at(index, step), index, step));
            beyond.extend(costs.filter(|(own, ..)| cost.is_none_or(|cost| *own < cost * (1.0 - SAME_COST))));
        }
        beyond.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (batch, tries) in beyond.chunks(BATCH).enumerate() {
            self.spent |= self.budget_is_spent() || self.room_to_search() < BATCH;
            if self.spent {
                self.left_beyond = beyond.len() - batch * BATCH;
                break;
            }
            let pairs: Vec<(&Candidate, f64)> =
                tries.iter().map(|&(_, index, step)| (&self.candidates[index], steps[step])).collect();
            let first = self.probes(&pairs, &self.phases[..1])?;
            for ((&(_, index, step), pair), runs) in tries.iter().zip(&pairs).zip(&first) {
                if self.pass(*pair, runs).is_err() {
                    continue;
                }
                if self.room() < self.phases.len() {
                    (self.spent, self.left_beyond) = (true, beyond.len() - batch * BATCH);
                    return Ok(false);
                }
                let runs = self.probes(&[*pair], self.phases)?.remove(0);
                if self.pass(*pair, &runs).is_ok() {
                    let candidate = &mut self.candidates[index];
                    candidate.work = runs.ok().map(|runs| dearest(&runs));
                    (candidate.met, candidate.missed, candidate.checked) = (Some(step), step + 1, true);
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }
}

/// The largest count of each kind of work.
pub(super) fn dearest(runs: &[Probe]) -> Work {
    runs.iter().fold(Work::default(), |most, run| most.max(&run.work))
}

/// Writes a macro step (s) in milliseconds; six digits behind the point are more than a grid has, but for the shortest steps.
pub fn milliseconds(step: f64) -> String {
    let milliseconds = 1e3 * step;
    if milliseconds < 1e-3 {
        return format!("{milliseconds:.3e} ms");
    }
    format!("{} ms", (1e6 * milliseconds).round() / 1e6)
}
