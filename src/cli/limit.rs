//! `rimbench limit`: the largest stable macro step.

use super::json::Object;
use super::number::{counted, percent, with_digits};
use super::progress::{Heartbeat, plain_time};
use super::run_options::{RunOptions, seconds};
use super::screen::{Mood, Table, headline, row};
use super::simulate::in_words;
use super::{Format, answered, print, print_json, warn_of_cache, with_files};
use clap::{Args, ValueEnum};
use rimbench::catalogue::Catalogue;
use rimbench::cosim::{Outcome, StopFlag};
use rimbench::fmi::import::SideNotes;
use rimbench::harness::{
    Cache, Instability, LimitSearch, Scan, StabilityLimit, StabilityPoint, StepVerdict, predicted_stability_limit,
    spectral_stability_limit, stability_limit,
};
use serde_json::Value;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Arguments of `limit`.
#[derive(Debug, Args)]
pub struct Limit {
    #[command(flatten)]
    run: RunOptions<true>,
    /// Smallest macro step of the scan, s [default: 1e-4, or a hundredth of the largest if that is less]
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    from: Option<f64>,
    /// Largest macro step of the scan, s [default: 0.1, or a tenth of the duration if that is less]
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    to: Option<f64>,
    /// Relative width to which the bracket around the limit is narrowed
    #[arg(long, value_name = "X", default_value_t = 0.01)]
    relative_tolerance: f64,
    /// Macro steps per decade of the scan
    #[arg(long, value_name = "N", default_value_t = 12)]
    per_decade: usize,
    /// Number of phases of the ensemble; a macro step is stable if all of them are
    #[arg(long, value_name = "K", default_value_t = 1)]
    phases: usize,
    /// Run to the end, or take the spectral radius of the macro-step map (linear cases)
    #[arg(long, value_enum, default_value_t = Method::Run)]
    method: Method,
    /// Every macro step that was tried
    #[arg(long, conflicts_with = "format")]
    all: bool,
    /// How to print
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
}

/// What is said of runs with a side of fixed step.
const FIXED_STEPS: &str = "a side takes steps of one length only: phase 1, each run to its last whole macro step";

/// How stability is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Method {
    /// A run must complete within bounds.
    Run,
    /// The spectral radius must not exceed one.
    Spectral,
}

impl Limit {
    /// Exit code 1 if the limit could not be found because a run gave no answer.
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<ExitCode> {
        let mut request = self.run.request()?;
        let catalogue = with_files(catalogue, &SideNotes::default(), &mut request.case, &mut request.scheme)?;
        let Limit { from, to, per_decade, phases, .. } = self;
        let (grid, phases) = Scan { from, to, per_decade, phases }.resolve(&request, &catalogue)?;
        let (done, scan) = (Arc::new(AtomicUsize::new(0)), grid.len());
        let told = Arc::clone(&done);
        let alive = Heartbeat::lines(move |elapsed| {
            let count = told.load(Ordering::Relaxed);
            format!("limit: {count} macro steps done, {scan} in the scan, {} elapsed", plain_time(elapsed))
        });
        let search = LimitSearch {
            request: &request,
            catalogue: &catalogue,
            macro_steps: &grid,
            relative_tolerance: self.relative_tolerance,
            progress: &|_| {
                done.fetch_add(1, Ordering::Relaxed);
            },
            stop: StopFlag::never(),
        };
        let cache = Cache::of_user();
        let found = match self.method {
            Method::Run => stability_limit(search, &phases, &cache)?,
            Method::Spectral => spectral_stability_limit(search)?,
        };
        drop(alive);
        warn_of_cache(&cache);
        let least = request.at_macro_step(grid[0]).resolve(&catalogue)?;
        let linear = self.method == Method::Run && !least.case.linear_state.is_empty();
        let unbounded = least.is_unbounded()?;
        // What else is known of the limit, without runs.
        let beside = LimitSearch { progress: &|_| (), ..search };
        let predicted = predicted_stability_limit(beside)?;
        // A scheme whose macro step is no linear map has no spectral radius.
        let radius = if linear { spectral_stability_limit(beside).ok() } else { None };
        match self.format {
            Format::Json => {
                let mut facts = facts(&found);
                facts.put("bounded", !unbounded);
                for (names, limit) in [
                    (["predicted_stable_s", "predicted_unstable_s"], predicted.as_ref().map(|(limit, _)| limit)),
                    (["spectral_stable_s", "spectral_unstable_s"], radius.as_ref()),
                ] {
                    facts.number(names[0], limit.and_then(|limit| limit.last_stable));
                    facts.number(names[1], limit.and_then(|limit| limit.first_unstable));
                }
                print_json(&Value::from(facts))?;
            }
            Format::Table => {
                let name = |name: &Option<String>| name.clone().unwrap_or_default();
                let about = format!("{} · {}", name(&request.case), name(&request.scheme));
                let shown = screen(&found, &about, phases.len(), self.all, least.case.has_fixed_steps());
                print(&if unbounded { self::unbounded(&shown) } else { shown })?;
                if let Some(predicted) = predicted {
                    print_prediction(predicted, &found)?;
                }
                if let Some(radius) = radius {
                    print_radius(&radius, &found)?;
                }
            }
        }
        Ok(answered(found.no_answer.is_none()))
    }
}

fn facts(found: &StabilityLimit) -> Object {
    let point = |point: &StabilityPoint| {
        let mut object = Object::default();
        object.number("macro_step_s", point.macro_step);
        object.number("fraction_stable", point.fraction_stable);
        object.put("failure", point.verdict.why());
        object.number("spectral_radius", point.spectral_radius);
        Value::from(object)
    };
    let mut facts = Object::default();
    facts.number(
        "stability_limit_s",
        found.last_stable.filter(|_| found.first_unstable.is_some() && found.no_answer.is_none()),
    );
    facts.number("last_stable_s", found.last_stable);
    facts.number("first_unstable_s", found.first_unstable);
    facts.number("no_answer_s", found.no_answer);
    let is_skipped = |point: &&StabilityPoint| matches!(point.verdict, StepVerdict::Skipped(_));
    facts.put("skipped", found.points.iter().filter(is_skipped).count());
    facts.put("fraction_stable", found.points.iter().map(point).collect::<Value>());
    facts
}

/// The limit in words first, then what goes wrong beyond it, then how it was found.
fn screen(found: &StabilityLimit, about: &str, phases: usize, all: bool, fixed: bool) -> String {
    let step = |step: f64| with_digits(step, "s", 4);
    let known = |low: &str| match found.first_unstable {
        Some(unstable) => format!("{low}, unstable at {}; between them no answer", step(unstable)),
        None => format!("{low}, no answer beyond"),
    };
    let (verdict, mood) = match (found.last_stable, found.first_unstable) {
        (Some(stable), _) if found.no_answer.is_some() => {
            (known(&format!("stable up to {}", step(stable))), Mood::Open)
        }
        (None, None) => ("no answer at the smallest macro step".to_owned(), Mood::Open),
        (None, Some(_)) if found.no_answer.is_some() => (known("no answer at the smallest macro step"), Mood::Open),
        (Some(stable), Some(unstable)) => {
            (format!("stable up to {}, unstable at {}", step(stable), step(unstable)), Mood::Good)
        }
        (Some(stable), None) => (format!("stable up to {}, the largest tried", step(stable)), Mood::Good),
        (None, _) => ("unstable from the smallest macro step on".to_owned(), Mood::Bad),
    };
    let mut lines = vec![headline(&verdict, about, mood)];
    let at = |macro_step: Option<f64>| found.points.iter().find(|point| Some(point.macro_step) == macro_step);
    let ended = |outcome: &Outcome| {
        in_words(outcome) + &outcome.at_s().map(|at| format!(" at {}", step(at))).unwrap_or_default()
    };
    let why = |verdict: &StepVerdict| match verdict {
        StepVerdict::Stable => String::new(),
        StepVerdict::Unstable(Instability::Run(outcome)) => ended(outcome),
        StepVerdict::Unstable(growth) => growth.to_string(),
        StepVerdict::NoAnswer(why) => format!("no answer: {why}"),
        StepVerdict::Skipped(why) => format!("skipped: {why}"),
    };
    for point in [at(found.no_answer), at(found.first_unstable)].into_iter().flatten() {
        lines.push(row(&format!("at {}", step(point.macro_step)), &why(&point.verdict)));
    }
    let tried = found.points.iter().map(|point| point.macro_step);
    let (least, most) = (tried.clone().fold(f64::INFINITY, f64::min), tried.fold(0.0, f64::max));
    let phases = if phases == 1 { "one phase".to_owned() } else { format!("{phases} phases each") };
    let more = if all { "" } else { " · --all for each" };
    let tried =
        format!("{} from {} to {}, {phases}{more}", counted(found.points.len(), "macro step"), step(least), step(most));
    lines.push(row("tried", &tried));
    let mut skipped = found.points.iter().filter_map(|point| match &point.verdict {
        StepVerdict::Skipped(why) => Some(why),
        _ => None,
    });
    if let Some(first) = skipped.next() {
        lines.push(row("skipped", &format!("{} of them, the first because {first}", 1 + skipped.count())));
    }
    if fixed {
        lines.push(row("steps", FIXED_STEPS));
    }
    if all {
        let mut table = Table::new(&["H", "stable", "first failure"]);
        for point in &found.points {
            let share = if point.fraction_stable.is_nan() { "–".to_owned() } else { percent(point.fraction_stable) };
            table.add_row([step(point.macro_step), share, why(&point.verdict)]);
        }
        lines.push(format!("\n{table}"));
    }
    lines.join("\n")
}

/// What is said of runs that no reference bounds: that their numbers are finite is all that is known.
fn unbounded(screen: &str) -> String {
    let (verdict, rest) = screen.split_once('\n').unwrap_or((screen, ""));
    let verdict = verdict.replace("unstable", "not finite").replace("stable", "finite");
    let why =
        "runs of this case are not held against a reference: they complete where all numbers are finite, however large";
    format!("{verdict}\n{rest}\n{}", row("bounds", why))
}

/// Says of a linear case where its spectral radius tells otherwise than runs, in which what grows slowly stays within
/// bounds.
fn print_radius(radius: &StabilityLimit, found: &StabilityLimit) -> anyhow::Result<()> {
    let Some(unstable) = radius.first_unstable else { return Ok(()) };
    if found.first_unstable.is_some_and(|first| first <= unstable) {
        return Ok(());
    }
    let limit = match radius.last_stable {
        Some(stable) => format!("stable up to {}", with_digits(stable, "s", 4)),
        None => "unstable from the smallest macro step on".to_owned(),
    };
    print(&row("spectral radius", &format!("{limit} (--method spectral); what grows slowly ends no run in its time")))
}

/// Says how far the linearised coupling is stable, where that is known.
fn print_prediction(
    (predicted, oscillation): (StabilityLimit, Option<[f64; 2]>),
    found: &StabilityLimit,
) -> anyhow::Result<()> {
    let limit = match (predicted.last_stable, predicted.first_unstable) {
        (Some(stable), Some(_)) => {
            let numbers = oscillation
                .map(|[frequency, damping]| format!(" (Ω = Hω = {:.2}, ζ = {damping:.2})", stable * frequency));
            format!("stable up to {}{}", with_digits(stable, "s", 4), numbers.unwrap_or_default())
        }
        (Some(_), None) => "stable over the whole scan".to_owned(),
        (None, _) => "unstable from the smallest macro step on".to_owned(),
    };
    // A run may end long after the start, with other contacts than the prediction knows.
    let ends = |point: &StabilityPoint| match &point.verdict {
        StepVerdict::Unstable(Instability::Run(outcome)) => outcome.at_s(),
        _ => None,
    };
    let first = found.points.iter().find(|point| Some(point.macro_step) == found.first_unstable).and_then(ends);
    let later = predicted.last_stable > found.last_stable;
    let why = first.filter(|at| later && *at > 0.0).map_or(String::new(), |at| {
        format!("; the run above fails at {}, by when they may be others", with_digits(at, "s", 3))
    });
    print(&row(
        "predicted",
        &format!("{limit}, by the coupling linearised at the start (contacts and oil as they are there){why}"),
    ))
}
