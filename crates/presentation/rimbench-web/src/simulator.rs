//! Simulates what a few lines of text ask for.

use crate::gallery;
use rimbench_cases::cases::Case;
use rimbench_core::cosim::StopFlag;
use rimbench_core::error::{Error, Result};
use rimbench_runs::catalogue::Catalogue;
use rimbench_runs::metrics::{METRICS, USABLE};
use rimbench_runs::{
    EvaluatedRun, Reference, RunRequest, RunSpec, TrueState, believed, evaluate, simulate, what_happens,
};
use std::fmt::Write;
use std::sync::Arc;

/// Answers requests one after the other, and keeps the last reference and the last true state.
pub struct Simulator {
    catalogue: Catalogue,
    reference: Option<Kept>,
    state: Option<(RunSpec, f64, TrueState)>,
}

/// What the runs of a machine are held against, and how many times as long as the program's its steps are.
struct Kept {
    of: RunSpec,
    reference: Reference,
    coarser: f64,
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
        Simulator { catalogue: Catalogue::standard(), reference: None, state: None }
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
    /// believe SECONDS          with the same lines: what happens in the macro step that starts there, and below it what
    ///                          the scheme believes, from the same true state
    /// ```
    /// A run is answered by `run_id`, `outcome`, `outcome_class`, `outcome_at_s`, `reason`, every metric that has a
    /// value, `reference_force_uncertainty_n`, `reference_force_peak_n`, `without_peak` where no error is related to one,
    /// the exact counters, `columns`, and its rows at communication points; a reference by `columns` and rows to draw; a
    /// belief by `columns` and a row per micro step.
    ///
    /// What runs are held against is made as the program does it and compared at the program's rows, by [`COARSER`]
    /// times its steps at first, so that a page need not wait. Until the uncertainty is a tenth of the force error that
    /// is shown the steps are halved, down to the program's own: the reference is that of the program then.
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
                let trajectory = &self.reference_of(&spec)?.reference.trajectory;
                let words = columns(trajectory.columns());
                let last = trajectory.len() - 1;
                let shown = trajectory.rows().enumerate().filter(|(k, _)| k % SHOWN_ROWS == 0 || *k == last);
                Ok(Answer { words, numbers: shown.flat_map(|(_, row)| row).copied().collect() })
            }
            other => match other.strip_prefix("believe ").and_then(|start| start.parse().ok()) {
                Some(start) => self.believe(start, &self.spec(lines)?),
                None => {
                    Err(Error::unknown("request", other, ["schemes", "cases", "run", "reference", "believe SECONDS"]))
                }
            },
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

    fn reference_of(&mut self, spec: &RunSpec) -> Result<&Kept> {
        let at_hand = self.reference.take().filter(|kept| kept.of.shares_reference_with(spec));
        let kept = match at_hand {
            Some(kept) => kept,
            None => Kept::by(spec, COARSER)?,
        };
        Ok(self.reference.insert(kept))
    }

    /// What happens is known over the longest macro step that was asked for, of which a shorter one is the beginning.
    fn believe(&mut self, start: f64, spec: &RunSpec) -> Result<Answer> {
        let kept = self.state.take().filter(|(of, at, _)| *at == start && of.shares_reference_with(spec));
        let from = |spec: &RunSpec| what_happens(spec, &self.catalogue, start, StopFlag::never());
        let (mut of, _, mut state) = kept.map_or_else(|| Ok((spec.clone(), start, from(spec)?)), Ok)?;
        let belief = believed(spec, &state)?;
        let is_covered = |state: &TrueState| {
            let there = (state.happens.len() >= belief.len()).then(|| state.happens.row(belief.len() - 1)[0]);
            there.zip(belief.end_time()).is_some_and(|(there, end)| (there - end).abs() <= 1e-9 * end)
        };
        if !is_covered(&state) {
            (of, state) = (spec.clone(), from(spec)?);
        }
        let happens = state.happens.rows().take(belief.len()).chain(belief.rows());
        let numbers = happens.flatten().copied().collect();
        self.state = Some((of, start, state));
        Ok(Answer { words: columns(belief.columns()), numbers })
    }

    fn run(&mut self, spec: &RunSpec) -> Result<Answer> {
        loop {
            let Kept { reference, coarser, .. } = self.reference_of(spec)?;
            // Errors inside macro steps are not shown, and where the reference is a closed form they take most of the
            // time.
            let result = simulate(spec, reference.bounds(spec)?, None, StopFlag::never())?;
            let run = evaluate(spec, result, reference)?;
            if *coarser <= 1.0 || is_certain(&run, !reference.contacts.is_empty()) {
                let mut words = words(spec, &run);
                if let Some(row) = spec.case.interface_columns.first()
                    && let Some(column) = reference.trajectory.index_of(&row.force)
                {
                    words = format!("reference_force_peak_n {:?}\n{words}", reference.largest[column]);
                }
                if let (None, Some(reason)) = (run.found.metric(SHARE), reference.without_peak(&spec.case)) {
                    words = format!("without_peak {reason}\n{words}");
                }
                return Ok(Answer { words, numbers: run.trajectory.data().to_vec() });
            }
            let finer = Kept::by(spec, 0.5 * coarser)?;
            self.reference = Some(finer);
        }
    }
}

/// How many times as long as the program's the steps of a page's reference are at first, and its rows at most.
pub const COARSER: f64 = 8.0;
const MOST_BETWEEN_ROWS: f64 = 4.0;

/// Every so-manieth row of a reference is drawn.
const SHOWN_ROWS: usize = 4;

/// Share of what is shown that the uncertainty of the reference may be.
const CERTAIN: f64 = 0.1;

/// The metric that a verdict rests on.
const SHARE: &str = "force_error_rms_of_peak";

/// Tells whether the reference is certain enough for the force error of a run, and for the side of the usable share on
/// which it lies; and, of a machine that has contacts, whether its rows show one that closes, as a blow may last less
/// than theirs.
fn is_certain(run: &EvaluatedRun, has_contacts: bool) -> bool {
    if has_contacts && run.found.metric("touch_down_peak_ratio").is_none() {
        return false;
    }
    let [uncertainty, _] = run.found.reference_uncertainty;
    let Some(uncertainty) = uncertainty else { return true };
    match (run.found.metric("force_error_rms_n"), run.found.metric(SHARE)) {
        (Some(error), Some(share)) => {
            let from_usable = error * (1.0 - USABLE / share).abs();
            uncertainty <= (CERTAIN * error).min(from_usable)
        }
        // Whether it is known to a tenth.
        _ => false,
    }
}

impl Kept {
    /// By steps so many times as long as the program's, or less where there is no reference by these.
    fn by(spec: &RunSpec, coarser: f64) -> Result<Kept> {
        let of = spec.clone();
        if let Some(reference) = Reference::exact(spec, StopFlag::never())? {
            return Ok(Kept { of, reference, coarser: 1.0 });
        }
        match Reference::coarse(spec, [coarser, coarser.min(MOST_BETWEEN_ROWS)], StopFlag::never()) {
            Ok(reference) => Ok(Kept { of, reference, coarser }),
            // An impact in the heap of the crane takes the program's step.
            Err(_) if coarser > 1.0 => Kept::by(spec, 0.5 * coarser),
            Err(error) => Err(error),
        }
    }
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
    if let [Some(uncertainty), _] = run.found.reference_uncertainty {
        let _ = writeln!(words, "reference_force_uncertainty_n {uncertainty:?}");
    }
    for counter in run.found.counters() {
        let _ = writeln!(words, "{} {}", counter.name, counter.cell());
    }
    words + &columns(run.trajectory.columns())
}

fn columns(names: &[String]) -> String {
    format!("columns {}\n", names.join(" "))
}
