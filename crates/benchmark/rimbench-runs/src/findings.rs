//! What is kept of a run, as one list of columns: tables, the store and JSON write it by that list, and the store reads
//! it back.

use super::fact::{Fact, FactValue};
use super::facts::CODE;
use super::options::{RunRequest, SETTLED};
use crate::metrics::METRICS;
use rimbench_core::cosim::{Latencies, Outcome, OutcomeKind, Work};
use std::sync::Arc;

/// What was found of a run, the same on every machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Findings {
    /// How it ended.
    pub outcome: OutcomeKind,
    /// When it left the path of a completed run, s.
    pub outcome_at_s: Option<f64>,
    /// Why, in words; empty for a completed run.
    pub reason: String,
    /// Time of the last communication point reached, s.
    pub ended_at_s: f64,
    /// Whether the model was the mechanics itself, so that there was nothing to be wrong about.
    pub model_exact: bool,
    /// One value per entry of [`METRICS`].
    pub metrics: Box<[Option<f64>]>,
    /// Uncertainty of the reference's interface force, N, and position, m; of several rows the largest.
    pub reference_uncertainty: [Option<f64>; 2],
    /// All work; what is no column of it is 0 where it was read.
    pub work: Work,
}

/// What a run cost on its machine.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Costs {
    /// Wall time of the macro loop, s.
    pub wall_s: f64,
    /// Simulated time over wall time; none of a run that was not begun.
    pub real_time_factor: Option<f64>,
    /// Latency of its macro steps; deadline H.
    pub latency: Option<Latency>,
}

/// Latency of single macro steps: the wall time from the exchange at `t_k` until both sides have covered the macro
/// step.
///
/// What observers do at the communication point is not part of it. Depends on machine and load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Latency {
    /// Median, s.
    pub p50_s: f64,
    /// 99th percentile, s.
    pub p99_s: f64,
    /// Longest, s.
    pub max_s: f64,
    /// Macro steps that took longer than the deadline.
    pub missed_deadlines: u64,
}

impl Latency {
    /// Statistics of the macro steps of a run; none of none.
    pub fn of(latencies: &Latencies) -> Option<Self> {
        let [p50_s, p99_s] = [50.0, 99.0].map(|percent| latencies.percentile_s(percent));
        Some(Latency {
            p50_s: p50_s?,
            p99_s: p99_s?,
            max_s: latencies.longest_s(),
            missed_deadlines: latencies.missed(),
        })
    }
}

/// What stands in a column.
pub trait Cell {
    /// Says what it is; nothing where it does not apply.
    fn value(&self) -> Option<FactValue>;

    /// Reads what [`value`](Self::value) was written as; tells whether it could.
    fn read(&mut self, text: &str) -> bool;
}

/// Is called with the name of each column and its cell.
pub type Columns<'a> = &'a mut dyn FnMut(&'static str, &mut dyn Cell);

/// Lists columns as facts.
pub fn facts_of(columns: impl FnOnce(Columns<'_>)) -> Vec<Fact> {
    let mut facts = Vec::new();
    columns(&mut |name, cell| facts.push(Fact::new(name, cell.value())));
    facts
}

/// Tells whether a name means something already where parameters of a case are asked for or told: an option of a run,
/// or what is said of one.
pub fn is_taken(name: &str) -> bool {
    const SAID: [&str; 8] = ["run_id", "case", "set", "label", "scheme", "parameters", "not_finite", "diverged_at_s"];
    let is_column = || Findings::nothing(&Outcome::Completed).facts().iter().any(|fact| fact.name == name);
    SAID.contains(&name)
        || CODE.contains(&name)
        || RunRequest::OPTIONS.iter().any(|option| option.key == name)
        || SETTLED.iter().any(|(settled, ..)| *settled == name)
        || is_column()
}

/// Lists the names of columns.
pub fn names_of(columns: impl FnOnce(Columns<'_>)) -> Vec<&'static str> {
    let mut names = Vec::new();
    columns(&mut |name, _| names.push(name));
    names
}

impl Findings {
    /// Makes those of a run of which nothing is known but how it ended.
    pub fn nothing(outcome: &Outcome) -> Self {
        Findings {
            outcome: outcome.kind(),
            outcome_at_s: outcome.at_s(),
            reason: outcome.reason(),
            ended_at_s: 0.0,
            model_exact: false,
            metrics: vec![None; METRICS.len()].into(),
            reference_uncertainty: [None; 2],
            work: Work::default(),
        }
    }

    /// Goes through its columns.
    pub fn columns(&mut self, each: Columns<'_>) {
        each("outcome", &mut self.outcome);
        each("outcome_at_s", &mut self.outcome_at_s);
        each("reason", &mut self.reason);
        each("ended_at_s", &mut self.ended_at_s);
        each("model_exact", &mut self.model_exact);
        METRICS.iter().zip(&mut self.metrics).for_each(|(metric, value)| each(metric.name, value));
        UNCERTAINTIES.into_iter().zip(&mut self.reference_uncertainty).for_each(|(name, value)| each(name, value));
        counter_columns(&mut self.work, each);
    }

    /// Lists them as facts.
    pub fn facts(&self) -> Vec<Fact> {
        facts_of(|each| self.clone().columns(each))
    }

    /// Lists exact counts of the work.
    pub fn counters(&self) -> Vec<Fact> {
        facts_of(|each| counter_columns(&mut { self.work }, each))
    }

    /// Returns a metric by its name in data, if it has a value.
    pub fn metric(&self, name: &str) -> Option<f64> {
        METRICS.iter().zip(&self.metrics).find(|(metric, _)| metric.name == name).and_then(|(_, value)| *value)
    }
}

/// Columns of the uncertainty of the reference's force and position.
pub(super) const UNCERTAINTIES: [&str; 2] = ["reference_force_uncertainty_n", "reference_position_uncertainty_m"];

fn counter_columns(work: &mut Work, each: Columns<'_>) {
    counters(work).into_iter().for_each(|(name, count)| each(name, count));
}

/// The counters with their names.
pub(super) fn counters(Work { cosim, sides, scheme }: &mut Work) -> [(&'static str, &mut u64); 16] {
    let (mechanics, actuator) = (&mut sides.mechanics, &mut sides.actuator);
    [
        ("macro_steps", &mut cosim.macro_steps),
        ("repeated_macro_steps", &mut cosim.repeated_macro_steps),
        ("exchanges", &mut cosim.exchanges),
        ("catch_up_steps", &mut cosim.catch_up_steps),
        ("mechanics_micro_steps", &mut mechanics.micro_steps),
        ("actuator_micro_steps", &mut actuator.micro_steps),
        ("eliminations", &mut mechanics.eliminations),
        ("mechanics_lcp_solves", &mut mechanics.solver.solves),
        ("mechanics_lcp_pivots", &mut mechanics.solver.pivots),
        ("mechanics_lcp_factorisations", &mut mechanics.solver.factorisations),
        ("mechanics_lcp_fallbacks", &mut mechanics.solver.fallbacks),
        ("scheme_lcp_solves", &mut scheme.solves),
        ("scheme_lcp_pivots", &mut scheme.pivots),
        ("scheme_lcp_factorisations", &mut scheme.factorisations),
        ("scheme_lcp_fallbacks", &mut scheme.fallbacks),
        ("scheme_parametric_steps", &mut scheme.parametric),
    ]
}

impl Costs {
    /// Makes those of a run that ended at a simulated time (s).
    pub(super) fn of(ended_at_s: f64, wall_s: f64, latency: Option<Latency>) -> Self {
        let factor = ended_at_s / wall_s;
        Costs { wall_s, real_time_factor: Some(factor).filter(|factor| factor.is_finite()), latency }
    }

    /// Goes through its columns.
    pub fn columns(&mut self, each: Columns<'_>) {
        each("wall_s", &mut self.wall_s);
        each("real_time_factor", &mut self.real_time_factor);
        let latency = self.latency;
        let mut times = [latency.map(|of| of.p50_s), latency.map(|of| of.p99_s), latency.map(|of| of.max_s)];
        let mut missed = latency.map(|of| of.missed_deadlines);
        let names = ["latency_p50_s", "latency_p99_s", "latency_max_s"];
        names.into_iter().zip(&mut times).for_each(|(name, time)| each(name, time));
        each("missed_deadlines", &mut missed);
        self.latency = match (times, missed) {
            ([Some(p50_s), Some(p99_s), Some(max_s)], Some(missed_deadlines)) => {
                Some(Latency { p50_s, p99_s, max_s, missed_deadlines })
            }
            _ => None,
        };
    }

    /// Lists them as facts.
    pub fn facts(mut self) -> Vec<Fact> {
        facts_of(|each| self.columns(each))
    }
}

impl Cell for String {
    fn value(&self) -> Option<FactValue> {
        Some(FactValue::Text(self.clone()))
    }

    fn read(&mut self, text: &str) -> bool {
        text.clone_into(self);
        true
    }
}

/// Stays the one it is where it says the same: what rows have in common is held once.
impl Cell for Arc<str> {
    fn value(&self) -> Option<FactValue> {
        Some(FactValue::Text(self.to_string()))
    }

    fn read(&mut self, text: &str) -> bool {
        if **self != *text {
            *self = text.into();
        }
        true
    }
}

/// What is written as it is displayed and read by its parser.
macro_rules! cells {
    ($($kind:ty, $own:ident => $value:expr;)+) => {
        $(impl Cell for $kind {
            fn value(&self) -> Option<FactValue> {
                let $own = *self;
                Some($value)
            }

            fn read(&mut self, text: &str) -> bool {
                text.parse().map(|found| *self = found).is_ok()
            }
        })+
    };
}

cells! {
    OutcomeKind, own => FactValue::Text(own.to_string());
    bool, own => FactValue::Truth(own);
    f64, own => FactValue::Number(own);
    u64, own => FactValue::Count(own);
}

/// Nothing is an empty cell.
impl<T: Cell + Default> Cell for Option<T> {
    fn value(&self) -> Option<FactValue> {
        self.as_ref().and_then(Cell::value)
    }

    fn read(&mut self, text: &str) -> bool {
        *self = None;
        text.is_empty() || self.insert(T::default()).read(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_column_by_column_is_read_as_the_same() {
        let mut findings = Findings::nothing(&Outcome::Skipped { reason: "too, far".to_owned() });
        (findings.outcome_at_s, findings.work.sides.mechanics.eliminations) = (Some(0.1), 12);
        (findings.metrics[0], findings.metrics[1], findings.metrics[2]) = (Some(1e-7), Some(f64::INFINITY), Some(-0.0));
        let mut again = Findings::nothing(&Outcome::Completed);
        let facts = findings.facts();
        let mut cells = facts.iter().map(|fact| (fact.name, fact.cell()));
        again.columns(&mut |name, cell| {
            let (own, text) = cells.next().unwrap();
            assert!(own == name && cell.read(&text), "{name} = {text}");
        });
        assert_eq!((again, cells.next()), (findings, None));
        let latency = Latency { p50_s: 1e-6, p99_s: 2e-6, max_s: 3e-6, missed_deadlines: 4 };
        let costs = Costs { wall_s: 0.5, real_time_factor: None, latency: Some(latency) };
        let mut other = Costs::default();
        let mut cells = costs.facts().into_iter();
        other.columns(&mut |_, cell| assert!(cell.read(&cells.next().unwrap().cell())));
        assert_eq!(other, costs);
    }

    #[test]
    fn a_cell_that_must_be_there_and_is_not_is_no_row() {
        let mut refused = Vec::new();
        Findings::nothing(&Outcome::Completed)
            .columns(&mut |name, cell| refused.extend((!cell.read("")).then_some(name)));
        let mut wanted = vec!["outcome", "ended_at_s", "model_exact"];
        wanted.extend(counters(&mut Work::default()).map(|(name, _)| name));
        assert_eq!(refused, wanted);
    }
}
