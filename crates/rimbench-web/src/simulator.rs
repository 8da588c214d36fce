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
    /// A run is answered by `run_id`, `outcome`, `outcome_class`, `outcome_at_s`, `reason`, every metric that has a value, the exact counters, `columns`, and its rows
    /// at communication points; a reference by `columns` and its rows. What runs are held against here are both sides stepped together
    /// by the case's own reference method at [`COARSER`] times its coarsest step, so that a page need not wait: on the wedge box that
    /// is within 0.02 N rms of the program's reference.
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
        Answer { words: gallery::list(self.catalogue.cases().iter().filter_map(one)), numbers: Vec::new() }
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
        request.resolve(&self.catalogue)
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

#[cfg(test)]
mod tests {
    use super::*;
    use rimbench_cases::cases::offered_steps_ms;
    use rimbench_cases::metrics::USABLE;
    use std::path::Path;

    const RUN: &str =
        "run\ncase wedge-box\nscheme rim-nonsmooth-gap\nmacro_step_s 5e-3\nphase 0.5\nset.box_mass_kg 180\n";

    fn value<'a>(answer: &'a Answer, key: &str) -> &'a str {
        let line = answer.words.lines().find(|line| line.split(' ').next() == Some(key));
        line.and_then(|line| line.split_once(' ')).map_or("", |(_, value)| value)
    }

    #[test]
    fn a_run_is_that_of_the_program_to_the_bit() {
        let mut simulator = Simulator::default();
        let answer = simulator.answer(RUN);
        assert_eq!(value(&answer, "outcome"), "completed", "{}", answer.words);
        let request = RunRequest {
            macro_step_s: Some(5e-3),
            phase: Some(0.5),
            set: vec![("box_mass_kg".to_owned(), "180".to_owned())],
            ..RunRequest::of("wedge-box", "rim-nonsmooth-gap")
        };
        let spec = request.resolve(&Catalogue::standard()).unwrap();
        assert_eq!(value(&answer, "run_id"), spec.id());
        let bounds = simulator.reference.as_ref().unwrap().1.bounds(&spec).unwrap();
        let result = rimbench_cases::runs::simulate_inside(&spec, bounds, None, StopFlag::never()).unwrap();
        assert_eq!(answer.numbers, result.trajectory.data());
        assert_eq!(value(&answer, "columns").split(' ').count(), result.trajectory.columns().len());
        // The error is that of the program, but for what the references differ by: 25 N, and at most a tenth of a newton.
        let error: f64 = value(&answer, "force_error_rms_n").parse().unwrap();
        let reference = Reference::solution(&spec, 1, StopFlag::never()).unwrap();
        let unknown = vec![f64::NAN; reference.columns().len()];
        let packed = [reference.data(), &unknown, &unknown, &[2.5e-5]].concat();
        let of_program = evaluate(&spec, result, &Reference::unpack(&spec.case, packed).unwrap()).unwrap();
        let of_program = of_program.found.metric("force_error_rms_n").unwrap();
        assert!(of_program > 1.0 && (error - of_program).abs() < 0.1, "{error} {of_program}");
    }

    #[test]
    fn a_reference_is_kept_while_it_serves_and_made_anew_where_it_does_not() {
        let mut simulator = Simulator::default();
        simulator.answer(RUN);
        let kept = |simulator: &Simulator| simulator.reference.as_ref().unwrap().1.clone();
        let first = kept(&simulator);
        simulator.answer(&RUN.replace("5e-3", "2e-3").replace("rim-nonsmooth-gap", "zero-order-hold"));
        assert!(first.trajectory == kept(&simulator).trajectory);
        simulator.answer(&RUN.replace("180", "220"));
        assert!(first.trajectory != kept(&simulator).trajectory);
    }

    #[test]
    fn nonsense_is_one_error_that_says_what_would_be_valid() {
        let mut simulator = Simulator::default();
        for (request, named) in [
            ("dance", "reference"),
            ("", "run"),
            ("run\ncase wedge-bx\nscheme zero-order-hold", "wedge-box"),
            ("run\ncase wedge-box\nscheme zero-order-hold\nmacro_step_s much", "a number"),
            ("run\ncase wedge-box\nscheme zero-order-hold\nmacro_step_s -1", "macro-step"),
            ("run\ncase wedge-box\nscheme zero-order-hold\nset.box_mass_kg -3", "box_mass_kg"),
        ] {
            let answer = simulator.answer(request);
            assert!(answer.words.starts_with("error ") && answer.words.lines().count() == 1, "{}", answer.words);
            assert!(answer.words.contains(named), "{request}: {}", answer.words);
            assert!(answer.numbers.is_empty());
        }
    }

    #[test]
    fn cases_are_listed_in_json_with_the_schemes_they_are_not_run_with() {
        let words = Simulator::default().answer("cases").words;
        let (open, shut) = (words.matches(['{', '[']).count(), words.matches(['}', ']']).count());
        assert!(open == shut && words.starts_with("[{\"name\":\"wedge-box\","), "{words}");
        assert!(!words.contains("NaN") && !words.contains("inf"), "{words}");
    }

    #[test]
    fn the_step_that_a_case_is_shown_at_is_where_the_first_scheme_gets_worse() {
        let mut simulator = Simulator::default();
        let cases: Vec<Arc<Case>> = simulator.catalogue.cases().to_vec();
        // A case without a picture in the book has not been looked at yet.
        let pictures = Path::new("../../docs/cases/pictures");
        for case in cases.into_iter().filter(|case| pictures.join(format!("{}.svg", case.name)).is_file()) {
            let Some(drawing) = (case.drawing)(&case.default_parameters()) else { continue };
            let mut became = |step_ms: f64| {
                let [first, _] = drawing.schemes;
                let answer =
                    simulator.answer(&format!("run\ncase {}\nscheme {first}\nmacro_step_s {step_ms}e-3", case.name));
                let error: f64 = value(&answer, "force_error_rms_of_peak").parse().unwrap_or(f64::INFINITY);
                match value(&answer, "outcome") {
                    "completed" => 1 + usize::from(error > USABLE),
                    "" => panic!("{}: {}", case.name, answer.words),
                    _ => 3,
                }
            };
            let steps = offered_steps_ms(case.defaults.macro_step_s);
            let shown = case.shown_step_ms;
            let place =
                steps.iter().position(|step| *step == shown).unwrap_or_else(|| panic!("{}: {shown}", case.name));
            assert!(became(steps[place - 1]) < became(shown), "{} at {shown} ms", case.name);
        }
    }

    #[test]
    fn all_schemes_are_listed_with_what_they_are() {
        let answer = Simulator::default().answer("schemes");
        assert!(answer.words.contains("scheme zero-order-hold plain\n"));
        assert!(answer.words.contains("scheme rim-nonsmooth-gap model\n"));
        assert_eq!(answer.words.lines().count(), Catalogue::standard().schemes().len());
    }
}
