//! The stability limit: up to which macro step does a scheme hold, over all phases?

use super::advice::phases_of;
use super::cache::Cache;
use super::clock::monotonic_clock;
use super::grid::{logarithmic_grid, phase_ensemble};
use super::references::obtain_reference;
use super::spectral::spectral_radius;
use rayon::prelude::*;
use rimbench_core::cosim::{MechanicsSteps, Outcome, OutcomeClass, StopFlag};
use rimbench_core::error::{Error, Result};
use rimbench_runs::catalogue::Catalogue;
use rimbench_runs::{NEUTRAL, RunRequest, RunSpec, predicted_growth, simulate};
use std::fmt;

/// Why a macro step counts as unstable.
#[derive(Debug, Clone, PartialEq)]
pub enum Instability {
    /// The first outcome among the phases that is a failure.
    Run(Outcome),
    /// The macro-step map grows.
    Growth {
        /// Its spectral radius.
        radius: f64,
        /// 1/s.
        rate: f64,
    },
}

impl fmt::Display for Instability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Instability::Run(outcome) => outcome.fmt(f),
            Instability::Growth { radius, rate } => {
                write!(f, "spectral radius {radius:.9}, growth rate {rate:.4e} 1/s")
            }
        }
    }
}

/// How a scheme fares at one macro step.
#[derive(Debug, Clone, PartialEq)]
pub struct StabilityPoint {
    /// H, s.
    pub macro_step: f64,
    /// Share of the phases with an answer at which the run completed within bounds; NaN without one.
    pub fraction_stable: f64,
    /// What is known of it.
    pub verdict: StepVerdict,
    /// Spectral radius of the macro-step map, where that was the method.
    pub spectral_radius: Option<f64>,
}

impl StabilityPoint {
    fn skipped(macro_step: f64, reason: String) -> Self {
        let verdict = StepVerdict::Skipped(reason);
        StabilityPoint { macro_step, fraction_stable: f64::NAN, verdict, spectral_radius: None }
    }
}

/// What is known of a macro step.
#[derive(Debug, Clone, PartialEq)]
pub enum StepVerdict {
    /// It is stable at every phase.
    Stable,
    /// It is unstable at some phase.
    Unstable(Instability),
    /// Nothing: no phase failed, and one ended in a way that says nothing, or there is no radius.
    NoAnswer(String),
    /// It was not tried: there is no run at this macro step. The limit is that of the others.
    Skipped(String),
}

impl StepVerdict {
    /// Says why it is not stable, if that is so.
    pub fn why(&self) -> Option<String> {
        match self {
            StepVerdict::Stable => None,
            StepVerdict::Unstable(why) => Some(why.to_string()),
            StepVerdict::NoAnswer(why) => Some(format!("no answer: {why}")),
            StepVerdict::Skipped(why) => Some(format!("skipped: {why}")),
        }
    }
}

/// What a search found.
#[derive(Debug, Clone, PartialEq)]
pub struct StabilityLimit {
    /// All macro steps that were tried, ascending.
    pub points: Vec<StabilityPoint>,
    /// Largest macro step up to which all that were tried are stable at every phase, s.
    pub last_stable: Option<f64>,
    /// Smallest macro step that is unstable at some phase, s.
    pub first_unstable: Option<f64>,
    /// Smallest macro step below that of which nothing is known, s: the limit lies between the last stable one and the
    /// first unstable one, and cannot be narrowed down.
    pub no_answer: Option<f64>,
}

/// What to search for, where and how closely.
#[derive(Clone, Copy)]
pub struct LimitSearch<'a> {
    /// The run; at each macro step it is what this asks for there, with what is usual at that macro step where it asks
    /// for nothing.
    pub request: &'a RunRequest,
    /// Where its names are found.
    pub catalogue: &'a Catalogue,
    /// The scan, s, ascending.
    pub macro_steps: &'a [f64],
    /// Relative width to which the bracket between stable and unstable is narrowed.
    pub relative_tolerance: f64,
    /// Told of each macro step that is done; called from several threads.
    pub progress: &'a (dyn Fn(&StabilityPoint) + Sync),
    /// Ends the search with [`Error::Stopped`].
    pub stop: StopFlag<'a>,
}

/// Where to scan, as it is asked for; what is left out is as it is usual.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scan {
    /// Smallest macro step, s; usually 1e-4, or a hundredth of the largest if that is less.
    pub from: Option<f64>,
    /// Largest macro step, s; usually 0.1, or a tenth of the duration if that is less.
    pub to: Option<f64>,
    /// Macro steps per decade.
    pub per_decade: usize,
    /// Number of phases of the ensemble.
    pub phases: usize,
}

/// Ends of a scan where they fit, s.
const FROM_S: f64 = 1e-4;
const TO_S: f64 = 0.1;

impl Scan {
    /// The macro steps and the phases.
    ///
    /// # Errors
    /// Those of resolving the run and of [`logarithmic_grid`]; [`Error::InvalidValue`] for a number of phases that is
    /// none, or a largest macro step that does not fit into the duration.
    pub fn resolve(&self, request: &RunRequest, catalogue: &Catalogue) -> Result<(Vec<f64>, Vec<f64>)> {
        if !(1..=10_000).contains(&self.phases) {
            return Err(Error::invalid("phases", self.phases, "a whole number from 1 to 10000"));
        }
        let longest = || {
            let usual = || Ok(catalogue.case(request.case.as_deref().unwrap_or_default())?.defaults.duration_s);
            let duration = request.duration_s.map_or_else(usual, Ok)?;
            if !(duration.is_finite() && duration > 0.0) {
                request.resolve(catalogue)?;
            }
            Ok(longest_macro_step(duration))
        };
        let to = self.to.map_or_else(longest, Ok)?;
        if let (Some(from), None) = (self.from.filter(|from| *from > to), self.to) {
            return Err(Error::invalid("from", from, format!("at most {to} s, the largest macro step of the scan")));
        }
        let from = self.from.unwrap_or_else(|| shortest_macro_step(to));
        let grid = possible_steps(catalogue, request, logarithmic_grid(from, to, self.per_decade)?, [from, to])?;
        // The coarsest macro step must fit into the duration.
        let request = RunRequest { macro_step_s: grid.last().copied(), ..request.clone() };
        let spec = request.resolve(catalogue).map_err(said_of_the_scan)?;
        spec.prepare().map_err(said_of_the_scan)?;
        Ok((grid, phases_of(&spec.case, phase_ensemble(self.phases))))
    }
}

/// Takes of each macro step (s) the nearest one from `from` to `to` that both sides may be asked for, each once.
///
/// # Errors
/// An unknown case; ends between which there is none.
pub(super) fn possible_steps(
    catalogue: &Catalogue,
    request: &RunRequest,
    steps: Vec<f64>,
    [from, to]: [f64; 2],
) -> Result<Vec<f64>> {
    let Some(unit) = unit_of(catalogue, request)? else { return Ok(steps) };
    let [least, most] = [(from / unit * (1.0 - 1e-9)).ceil().max(1.0), (to / unit * (1.0 + 1e-9)).floor()];
    if most < least {
        let expected = format!("at least {unit:e} s: a side takes macro steps that are multiples of it");
        return Err(Error::invalid("to", to, expected));
    }
    let mut steps: Vec<f64> =
        steps.into_iter().map(|step| multiple((step / unit).round().clamp(least, most), unit)).collect();
    steps.dedup();
    Ok(steps)
}

/// The time (s) of which macro steps of a request must be multiples, if they must.
fn unit_of(catalogue: &Catalogue, request: &RunRequest) -> Result<Option<f64>> {
    let case = catalogue.case(request.case.as_deref().unwrap_or_default())?;
    let count = match request.mechanics_steps {
        Some(MechanicsSteps::Count(count)) => count.get(),
        _ => 1,
    };
    Ok(case.unit_of_macro_steps(count))
}

/// A multiple of a time, without the round-off of the product.
fn multiple(count: f64, unit: f64) -> f64 {
    format!("{:.12e}", count * unit).parse().unwrap_or(count * unit)
}

/// The longest macro step that is scanned within a duration (s) unless one is asked for: what goes on in less than ten
/// of them tells nothing.
pub fn longest_macro_step(duration: f64) -> f64 {
    TO_S.min(duration / 10.0)
}

/// The shortest macro step of a scan up to `to` (s) unless one is asked for.
pub fn shortest_macro_step(to: f64) -> f64 {
    FROM_S.min(to / 100.0)
}

/// An error about the macro step under the name of the option that set it.
fn said_of_the_scan(error: Error) -> Error {
    match error {
        Error::InvalidValue { key, found, expected } if key == "macro_step_s" => {
            Error::InvalidValue { key: "to".to_owned(), found, expected }
        }
        other => other,
    }
}

/// Narrower than round-off in H a bracket cannot get, and wider than this it says nothing.
const TOLERANCES: std::ops::RangeInclusive<f64> = 1e-9..=0.5;

/// Searches the stability limit of a scheme over the macro steps of a search and `phases`.
///
/// A macro step is stable if the run completes within bounds at every phase. The whole grid is scanned, because
/// stability is not monotone in H; then the bracket around the *first* unstable macro step is halved until it is narrow
/// enough.
///
/// # Errors
/// Bad input; a scheme that can be run at no macro step; a case that runs away by itself; [`Error::Stopped`].
pub fn stability_limit(search: LimitSearch<'_>, phases: &[f64], cache: &Cache) -> Result<StabilityLimit> {
    // The reference is that of all of them; the coarsest is most likely to be valid.
    let mut specs = search.macro_steps.iter().rev().map(|&macro_step| search.at(macro_step));
    let coarsest = specs.next().ok_or_else(|| Error::invalid("macro_steps", "none", "at least one"))?;
    let spec = coarsest.or_else(|error| specs.find_map(Result::ok).ok_or(error))?;
    let reference = obtain_reference(&spec, cache, search.stop)?;
    if reference.runs_away(&spec.case) {
        return Err(Error::Incompatible(format!(
            "case {} has no stability limit with these parameters: it runs away by itself, without any coupling in between",
            spec.case.name
        )));
    }
    let bounds = reference.bounds(&spec)?;
    search.run(|macro_step| {
        let run = search.at(macro_step)?;
        if let Some(refused) = run.refused_steps() {
            return Ok(StabilityPoint::skipped(macro_step, refused.to_string()));
        }
        let outcomes: Result<Vec<Outcome>> = phases
            .par_iter()
            .map(|&phase| {
                let run = run.with(|own| own.phase = phase)?;
                match simulate(&run, bounds.clone(), Some(monotonic_clock), search.stop)?.report.outcome {
                    Outcome::Stopped { .. } => Err(Error::Stopped),
                    outcome => Ok(outcome),
                }
            })
            .collect();
        let (skipped, outcomes): (Vec<_>, Vec<_>) =
            outcomes?.into_iter().partition(|outcome| !outcome.kind().was_run());
        if let (Some(skipped), true) = (skipped.first(), outcomes.is_empty()) {
            return Ok(StabilityPoint::skipped(macro_step, skipped.reason()));
        }
        let of = |class| outcomes.iter().filter(move |outcome| outcome.class() == class);
        let (stable, failed) = (of(OutcomeClass::Completed).count(), of(OutcomeClass::Failed).count());
        let verdict = match (of(OutcomeClass::Failed).next(), of(OutcomeClass::NoAnswer).next()) {
            (Some(failure), _) => StepVerdict::Unstable(Instability::Run(failure.clone())),
            (None, Some(silent)) => StepVerdict::NoAnswer(silent.to_string()),
            (None, None) => StepVerdict::Stable,
        };
        let fraction_stable = stable as f64 / (stable + failed) as f64;
        Ok(StabilityPoint { macro_step, fraction_stable, verdict, spectral_radius: None })
    })
}

/// Searches in the same way by the spectral radius ρ of the macro-step map: stable where `ρ ≤ 1` up to round-off. For
/// linear cases.
///
/// # Errors
/// Bad input; a case that is not linear; [`Error::Stopped`].
pub fn spectral_stability_limit(search: LimitSearch<'_>) -> Result<StabilityLimit> {
    search.run_by_radius(spectral_radius)
}

/// Predicts the limit without a run, by the growth of the linearised coupling, and tells how that coupling
/// [oscillates]; none where the growth is not known (see [`predicted_growth`]).
///
/// [oscillates]: rimbench_runs::LinearCoupling::oscillation
///
/// # Errors
/// Bad input.
pub fn predicted_stability_limit(search: LimitSearch<'_>) -> Result<Option<(StabilityLimit, Option<[f64; 2]>)>> {
    let Some(&finest) = search.macro_steps.first() else { return Ok(None) };
    let Some((_, coupling)) = predicted_growth(&search.at(finest)?)? else { return Ok(None) };
    let radius = |spec: &RunSpec| Ok(predicted_growth(spec)?.map_or(f64::NAN, |(growth, _)| growth));
    Ok(Some((search.run_by_radius(radius)?, coupling.oscillation())))
}

/// The macro step (s) that halves a bracket and was not tried: a multiple of `unit`, if there is one; none where no
/// such one is left.
fn between(points: &[StabilityPoint], [low, high]: [f64; 2], unit: Option<f64>) -> Option<f64> {
    let is_new = |step: &f64| *step > low && *step < high && points.iter().all(|point| point.macro_step != *step);
    let middle = (high * low).sqrt();
    let Some(unit) = unit else { return Some(middle).filter(is_new) };
    let (nearest, most) = ((middle / unit).round(), ((high - low) / unit).ceil() as u32);
    let around = (0..=most).flat_map(|away| [nearest - f64::from(away), nearest + f64::from(away)]);
    around.map(|count| multiple(count, unit)).find(is_new)
}

impl LimitSearch<'_> {
    /// Searches by the spectral radius of a map of one macro step.
    fn run_by_radius(&self, radius: impl Fn(&RunSpec) -> Result<f64> + Sync) -> Result<StabilityLimit> {
        self.run(|macro_step| {
            let radius = radius(&self.at(macro_step)?)?;
            let stable = radius <= 1.0 + NEUTRAL;
            let rate = radius.ln() / macro_step;
            Ok(StabilityPoint {
                macro_step,
                fraction_stable: f64::from(stable),
                verdict: match stable {
                    true => StepVerdict::Stable,
                    false if radius.is_nan() => StepVerdict::NoAnswer("its growth is not known there".to_owned()),
                    false => StepVerdict::Unstable(Instability::Growth { radius, rate }),
                },
                spectral_radius: Some(radius),
            })
        })
    }

    /// The run at a macro step, s.
    fn at(&self, macro_step: f64) -> Result<RunSpec> {
        self.request.at_macro_step(macro_step).resolve(self.catalogue)
    }

    /// Scans all macro steps, then halves the bracket around the first that is unstable.
    fn run(&self, probe: impl Fn(f64) -> Result<StabilityPoint> + Sync) -> Result<StabilityLimit> {
        if !TOLERANCES.contains(&self.relative_tolerance) {
            let expected = format!("a number from {:e} to {}", TOLERANCES.start(), TOLERANCES.end());
            return Err(Error::invalid("relative-tolerance", self.relative_tolerance, expected));
        }
        let probe = |macro_step: f64| {
            self.stop.check().map_err(|_| Error::Stopped)?;
            let point = probe(macro_step)?;
            (self.progress)(&point);
            Ok(point)
        };
        let mut tried: Vec<Result<StabilityPoint>> = self.macro_steps.par_iter().map(|&step| probe(step)).collect();
        if tried.iter().all(Result::is_err)
            && let Some(Err(error)) = tried.drain(..).next()
        {
            return Err(error);
        }
        // What is refused at one macro step is possible at another.
        let refused = |point: Result<StabilityPoint>, step: f64| match point {
            Err(error @ (Error::Incompatible(_) | Error::InvalidValue { .. })) => {
                Ok(StabilityPoint::skipped(step, error.to_string()))
            }
            other => other,
        };
        let points = tried.into_iter().zip(self.macro_steps).map(|(point, step)| refused(point, *step));
        let mut points = points.collect::<Result<Vec<_>>>()?;
        let is_skipped = |point: &StabilityPoint| matches!(point.verdict, StepVerdict::Skipped(_));
        if let Some(StepVerdict::Skipped(reason)) = points.first().map(|point| &point.verdict)
            && points.iter().all(is_skipped)
        {
            let name = |name: &Option<String>| name.clone().unwrap_or_default();
            let (scheme, case) = (name(&self.request.scheme), name(&self.request.case));
            return Err(Error::Incompatible(format!("scheme {scheme} does not apply to case {case}: {reason}")));
        }
        let unit = unit_of(self.catalogue, self.request)?;
        let first = |points: &[StabilityPoint], is: fn(&StepVerdict) -> bool| {
            points.iter().find(|point| is(&point.verdict)).map(|point| point.macro_step)
        };
        let is_unstable = |verdict: &StepVerdict| matches!(verdict, StepVerdict::Unstable(_));
        let is_silent = |verdict: &StepVerdict| matches!(verdict, StepVerdict::NoAnswer(_));
        loop {
            points.sort_by(|a, b| a.macro_step.total_cmp(&b.macro_step));
            let run = points.iter().filter(|point| !is_skipped(point));
            let stable = run.take_while(|point| point.verdict == StepVerdict::Stable).last();
            let (last_stable, first_unstable) = (stable.map(|point| point.macro_step), first(&points, is_unstable));
            let below = |silent: &f64| first_unstable.is_none_or(|unstable| *silent < unstable);
            let no_answer = first(&points, is_silent).filter(below);
            match (last_stable, first_unstable, no_answer) {
                // Nothing between them is unknown: the bracket is halved.
                (Some(low), Some(high), None) if high / low > 1.0 + self.relative_tolerance => {
                    let Some(step) = between(&points, [low, high], unit) else {
                        return Ok(StabilityLimit { points, last_stable, first_unstable, no_answer });
                    };
                    points.push(refused(probe(step), step)?);
                }
                _ => return Ok(StabilityLimit { points, last_stable, first_unstable, no_answer }),
            }
        }
    }
}
