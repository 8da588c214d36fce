//! Simulates what a few lines of text ask for.

use crate::gallery;
use rimbench_cases::cases::Case;
use rimbench_cases::catalogue::Catalogue;
use rimbench_cases::metrics::METRICS;
use rimbench_cases::runs::{EvaluatedRun, Reference, RunRequest, RunSpec, evaluate, simulate};
use rimbench_core::cosim::StopFlag;
use rimbench_core::error::{Error, Result};
use std::fmt::Write;
use std::sync::Arc;

/// Answers requests one after the other, and keeps the last reference.
pub struct Simulator {
    catalogue: Catalogue,
    reference: Option<(RunSpec, Reference)>,
}

/// What comes back: words, and numbers in rows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Answer {
    /// One `key value` a line; `error …` alone if the request makes no sense.
    pub words: String,
    /// The trajectory row by row, in the columns that `columns` names.
    pub numbers: Vec<f64>,
}

impl Default for Simulator {
    fn default() -> Self {
        Simulator { catalogue: Catalogue::standard(), reference: None }
    }
}

impl Simulator {
    /// Answers a request.
    ///
    /// ```text
    /// schemes                  words: `scheme NAME model|plain`, one line each
    /// cases                    words: a JSON list of the cases with their drawings, at their defaults
    /// run                      and then a line each:
    ///   KEY VALUE              an option of a run as in an experiment file, `macro_step_s 5e-3`
    ///   set.PARAMETER VALUE    a parameter of the case
    /// reference                with the same lines: the trajectory that runs are held against
    /// ```
    /// A run is answered by `run_id`, `outcome`, `outcome_class`, `outcome_at_s`, `reason`, every metric that has a
    /// value, the exact counters, `columns`, and its rows at communication points; a reference by `columns` and its
    /// rows. What runs are held against here are both sides stepped together by the case's own reference method at
    /// [`COARSER`] times its coarsest step, so that a page need not wait: on the wedge box that is within 0.02 N rms of
    /// the program's reference.
    pub fn answer(&mut self, request: &str) -> Answer {
        self.try_answer(request).unwrap_or_else(|error| {
            let one_line = error.to_string().replace(char::is_control, " ");
            Answer { words: format!("error {one_line}\n"), numbers: Vec::new() }
        })
    }

    fn try_answer(&mut self, request: &str) -> Result<Answer> {
        let mut lines = request.lines().map(str::trim).filter(|line| !line.is_empty());
        match lines.next().unwrap_or_default() {
            "schemes" => Ok(self.schemes()),
            "cases" => Ok(self.cases()),
            "run" => self.run(&self.spec(lines)?),
            "reference" => {
                let spec = self.spec(lines)?;
                let trajectory = &self.reference_of(&spec)?.trajectory;
                let words = columns(trajectory.columns());
                Ok(Answer { words, numbers: trajectory.data().to_vec() })
            }
            other => Err(Error::unknown("request", other, ["schemes", "cases", "run", "reference"])),
        }
    }

    fn schemes(&self) -> Answer {
        let mut words = String::new();
        for scheme in self.catalogue.schemes() {
            let kind = if scheme.has_model() { "model" } else { "plain" };
            let _ = writeln!(words, "scheme {} {kind}", scheme.name);
        }
        Answer { words, numbers: Vec::new() }
    }

    fn cases(&self) -> Answer {
        let one = |case: &Arc<Case>| {
            let drawing = (case.drawing)(&case.default_parameters())?;
            let refuses = |scheme: &&str| {
                let lines = [format!("case {}", case.name), format!("scheme {scheme}")];
                self.spec(lines.iter().map(String::as_str)).is_err()
            };
            let schemes = self.catalogue.schemes().iter().map(|scheme| &*scheme.name);
            Some(gallery::case(case, &drawing, &schemes.filter(refuses).collect::<Vec<_>>()))
        };
        let cases: serde_json::Value = self.catalogue.cases().iter().filter_map(one).collect();
        Answer { words: cases.to_string(), numbers: Vec::new() }
    }

    fn spec<'a>(&self, lines: impl Iterator<Item = &'a str>) -> Result<RunSpec> {
        let mut request = RunRequest::default();
        for line in lines {
            let (key, value) = line.split_once(' ').unwrap_or((line, ""));
            match key.strip_prefix("set.") {
                Some(parameter) => request.set.push((parameter.to_owned(), value.trim().to_owned())),
                None => request.put(key, value.trim())?,
            }
        }
        Ok(request.resolve(&self.catalogue)?.with_drawn_coordinates())
    }

    fn reference_of(&mut self, spec: &RunSpec) -> Result<&Reference> {
        let at_hand = self.reference.take().filter(|(known, _)| known.shares_reference_with(spec));
        let entry = match at_hand {
            Some(entry) => entry,
            None => (spec.clone(), reference(spec)?),
        };
        Ok(&self.reference.insert(entry).1)
    }

    fn run(&mut self, spec: &RunSpec) -> Result<Answer> {
        let reference = self.reference_of(spec)?;
        // Errors inside macro steps are not shown, and where the reference is a closed form they take most of the time.
        let result = simulate(spec, reference.bounds(spec)?, None, StopFlag::never())?;
        let run = evaluate(spec, result, reference)?;
        Ok(Answer { words: words(spec, &run), numbers: run.trajectory.data().to_vec() })
    }
}

/// How many times as long as the program's the reference steps of a page are.
pub const COARSER: f64 = 4.0;

/// One solution with the longer step; of its uncertainty nothing is known here.
fn reference(spec: &RunSpec) -> Result<Reference> {
    if let Some(exact) = Reference::exact(spec, StopFlag::never())? {
        return Ok(exact);
    }
    let solved = |coarser: f64| {
        let mut case = (*spec.case).clone();
        case.defaults.reference_step_s *= coarser;
        case.defaults.reference_sampling_s *= coarser;
        let step = case.defaults.reference_step_s;
        let solution = Reference::solution(&spec.with(|own| own.case = case.into())?, 1, StopFlag::never())?;
        Ok::<_, Error>((solution, step))
    };
    // An impact in the heap of the crane takes the program's step.
    let (solution, step) = solved(COARSER).or_else(|_| solved(1.0))?;
    Reference::of_one(spec, solution, step)
}

fn words(spec: &RunSpec, run: &EvaluatedRun) -> String {
    let mut words = String::new();
    let _ = writeln!(words, "run_id {}", spec.id());
    let _ = writeln!(words, "outcome {}\noutcome_class {}", run.outcome.name(), run.outcome.class());
    if let Some(at_s) = run.outcome.at_s() {
        let _ = writeln!(words, "outcome_at_s {at_s:?}");
    }
    if !run.outcome.reason().is_empty() {
        let _ = writeln!(words, "reason {}", run.outcome.reason().replace(char::is_control, " "));
    }
    for (metric, value) in METRICS.iter().zip(&run.found.metrics) {
        if let Some(value) = value {
            let _ = writeln!(words, "{} {value:?}", metric.name);
        }
    }
    for counter in run.found.counters() {
        let _ = writeln!(words, "{} {}", counter.name, counter.cell());
    }
    words + &columns(run.trajectory.columns())
}

fn columns(names: &[String]) -> String {
    format!("columns {}\n", names.join(" "))
}
