//! The runs that an experiment file stands for.

use super::claims_of_plan::check_claims_against_plan;
use super::draw::{Drawn, Search};
use super::planned_run::PlannedRun;
use super::{CaseEntry, Experiment};
use crate::grid::parameter_grid;
use crate::references::content_key;
use rayon::prelude::*;
use rimbench_cases::cases::{Case, Parameters};
use rimbench_cases::catalogue::Catalogue;
use rimbench_cases::metrics::Only;
use rimbench_cases::runs::{Reference, RunRequest, RunSpec, only_of};
use rimbench_core::cosim::StopFlag;
use rimbench_core::error::{Error, Result};
use rimbench_results::checksums::sha256;
use std::collections::HashSet;
use std::sync::Arc;

/// Most runs of one experiment: plan, records and tables are held in memory, some 3 kB for each run.
pub const MOST_RUNS: usize = 100_000;

impl Experiment {
    /// Lists the runs, cases outermost, then schemes, macro steps, tolerances, phases; names are those of the catalogue.
    ///
    /// # Errors
    /// Names, values or combinations that are not valid, each with the file and the key; an empty grid.
    pub fn plan(&self, catalogue: &Catalogue, quick: bool) -> Result<Vec<PlannedRun>> {
        let planned = || {
            self.check_options()?;
            self.check_labels(catalogue)?;
            self.check_size(quick)?;
            let runs = self.lay_out(catalogue, quick)?;
            refuse_duplicates(&runs)?;
            // A quick plan may leave out what a claim is about.
            if !quick {
                check_claims_against_plan(&self.claims, &runs)?;
            }
            Ok(runs)
        };
        planned().map_err(|error| match error {
            error @ Error::File { .. } => error,
            other => Error::file(&self.path, other),
        })
    }

    /// Refuses a label under which something else is looked for: another scheme, or the reference.
    fn check_labels(&self, catalogue: &Catalogue) -> Result<()> {
        for row in &self.schemes {
            let label = row.label.as_str();
            let own = row.request.scheme.as_deref() == Some(label);
            let why = match label {
                "reference" => "is the name of the trace of the reference",
                _ if label.trim() != label => "begins or ends with a blank",
                _ if !own && catalogue.scheme(label).is_ok() => "is the name of another scheme",
                _ => continue,
            };
            return Err(row.misnamed(why));
        }
        Ok(())
    }

    /// Refuses a grid that is empty or beyond all use, before it is laid out.
    fn check_size(&self, quick: bool) -> Result<()> {
        let quick = self.quick.as_ref().filter(|_| quick);
        let phases = quick.and_then(|quick| quick.phases.as_ref()).unwrap_or(&self.phases).count();
        let steps = quick.and_then(|quick| quick.macro_steps_s.as_ref()).unwrap_or(&self.macro_steps_s).list()?.len();
        let mut cells: usize = 0;
        for case in &self.cases {
            let lengths = case.set.values().map(|value| value.as_array().map_or(1, Vec::len));
            let draws = case.draw.as_ref().map_or(1, |draw| draw.settings);
            let parameters = lengths.fold(draws, usize::saturating_mul);
            for row in &self.schemes {
                let own = row.macro_steps_s.as_ref().or(case.macro_steps_s.as_ref());
                let steps = own.map_or(Ok(steps), |own| Ok(own.list()?.len()))?;
                let tolerances = row.step_tolerances.as_ref().map_or(1, Vec::len);
                cells = cells.saturating_add(parameters.saturating_mul(steps).saturating_mul(tolerances));
            }
        }
        match cells.saturating_mul(phases) {
            0 => Err(Error::Incompatible(format!(
                "the grid is empty: {} cases, {} schemes, {cells} combinations of them with parameters and macro steps, \
                 {phases} phases",
                self.cases.len(),
                self.schemes.len()
            ))),
            runs if runs > MOST_RUNS => Err(Error::Incompatible(format!(
                "the grid has {runs} runs, more than the {MOST_RUNS} that one experiment may have: split it into several files"
            ))),
            _ => Ok(()),
        }
    }

    /// Lays the grid out.
    fn lay_out(&self, catalogue: &Catalogue, quick: bool) -> Result<Vec<PlannedRun>> {
        let quick = self.quick.as_ref().filter(|_| quick);
        let phases = quick.and_then(|quick| quick.phases.as_ref()).unwrap_or(&self.phases).list();
        let quick_steps = quick.and_then(|quick| quick.macro_steps_s.as_ref());
        let predict_growth = self.claims.iter().any(|claim| only_of(&claim.metric) == Some(Only::Claimed));
        let mut runs = Vec::new();
        for entry in &self.cases {
            let case = catalogue.case(&entry.name).map_err(|error| entry.place(&error))?;
            let case = &self.with_own_reference(case);
            let settings = entry.settings(case, |parameters| self.any_run(entry, catalogue, case, parameters));
            for Setting { parameters, pooled_set, rejected_draws } in &settings.map_err(|error| entry.place(&error))? {
                for row in &self.schemes {
                    let own = row.macro_steps_s.as_ref().or(entry.macro_steps_s.as_ref());
                    let steps = own.or(quick_steps).unwrap_or(&self.macro_steps_s);
                    let (steps, requests) = (steps.list()?, row.requests());
                    for (macro_step, request) in
                        steps.iter().flat_map(|step| requests.iter().map(move |of| (*step, of)))
                    {
                        // Phases are what there may be many of. The first error is that of the first phase.
                        let of_phase = |&phase: &f64| {
                            let request = self.request(entry, request, macro_step, phase);
                            let spec = request.resolve_for(catalogue, case, parameters);
                            let mut spec = spec.map_err(|error| row.place(&error, &entry.name))?;
                            let audit = self.audit && spec.not_auditable().is_none();
                            if audit || predict_growth {
                                spec = spec.with(|own| (own.audit, own.predict_growth) = (audit, predict_growth))?;
                            }
                            let (label, pooled_set) = (row.label.clone(), pooled_set.clone());
                            let rejected_draws = *rejected_draws;
                            Ok(PlannedRun { id: spec.id(), spec, label, pooled_set, rejected_draws })
                        };
                        runs.extend(phases.par_iter().map(of_phase).collect::<Result<Vec<_>>>()?);
                    }
                }
            }
        }
        if self.audit && !runs.iter().any(|run| run.spec.audit) {
            return Err(Error::Incompatible(
                "audit = true: no scheme has an interface model that can be audited".to_owned(),
            ));
        }
        Ok(runs)
    }

    /// A run of a case with these parameters, for what all of its runs have in common: the reference.
    fn any_run(&self, entry: &CaseEntry, catalogue: &Catalogue, case: &Arc<Case>, set: &Parameters) -> Result<RunSpec> {
        let request = self.schemes.first().and_then(|row| row.requests().into_iter().next()).unwrap_or_default();
        let duration_s = entry.duration_s.or(self.duration_s);
        RunRequest { scheme: request.scheme, duration_s, ..RunRequest::default() }.resolve_for(catalogue, case, set)
    }

    /// What the file asks of one run: the row goes before the case, the case before the experiment.
    fn request(&self, entry: &CaseEntry, row: &RunRequest, macro_step: f64, phase: f64) -> RunRequest {
        let row = row.clone();
        RunRequest {
            macro_step_s: Some(macro_step),
            phase: Some(phase),
            micro_step_s: row.micro_step_s.or(entry.micro_step_s).or(self.micro_step_s),
            duration_s: row.duration_s.or(entry.duration_s).or(self.duration_s),
            wall_limit_s: row.wall_limit_s.or(self.wall_limit_s),
            ..row
        }
    }
}

/// A set of parameters of a case, with what its runs say of it.
struct Setting {
    parameters: Parameters,
    /// See [`PlannedRun`].
    pooled_set: Option<Arc<str>>,
    rejected_draws: Option<usize>,
}

impl CaseEntry {
    /// Every point of its grid with every setting drawn; `any_run` makes a run of parameters.
    fn settings(&self, case: &Case, any_run: impl Fn(&Parameters) -> Result<RunSpec> + Sync) -> Result<Vec<Setting>> {
        let grid = parameter_grid(case, &self.set)?;
        let Some(draw) = &self.draw else {
            let alone = |parameters| Setting { parameters, pooled_set: None, rejected_draws: None };
            return Ok(grid.into_iter().map(alone).collect());
        };
        let with = |point: &Parameters, values: &[(String, String)]| -> Result<Parameters> {
            let mut parameters = point.clone();
            values.iter().try_for_each(|(name, value)| parameters.set(name, value))?;
            Ok(parameters)
        };
        let has_event = |event, values: &[(String, String)]| {
            let mut happens = None;
            for point in &grid {
                happens = Reference::has_event(&any_run(&with(point, values)?)?, event, StopFlag::never())?;
                if happens != Some(true) {
                    break;
                }
            }
            Ok(happens)
        };
        // Without an event nothing has to be found out.
        let runs = grid.iter().filter(|_| draw.requires.is_some()).map(|point| Ok(content_key(&any_run(point)?)));
        let search = Search { has_event: &has_event, key: runs.collect::<Result<Vec<_>>>()?.concat() };
        let drawn = draw.settings(case, &self.set, &search)?;
        let mut settings = Vec::with_capacity(grid.len() * drawn.len());
        for point in &grid {
            let pooled_set: Arc<str> = point.given().into();
            for Drawn { values, rejected } in &drawn {
                let (pooled_set, rejected_draws) = (Some(pooled_set.clone()), *rejected);
                settings.push(Setting { parameters: with(point, values)?, pooled_set, rejected_draws });
            }
        }
        Ok(settings)
    }
}

/// Checksum of a plan: which runs under which labels, held against which reference.
pub(crate) fn plan_sha256(experiment: &Experiment, planned: &[PlannedRun]) -> String {
    let runs = planned.iter().map(|run| format!("{} {}\n", run.id, run.label));
    sha256(std::iter::once(experiment.reference_identity() + "\n").chain(runs).collect::<String>())
}

/// Refuses a plan that holds one run twice under one label: its rows could not be told apart. Under two labels it is computed once.
fn refuse_duplicates(runs: &[PlannedRun]) -> Result<()> {
    let mut seen = HashSet::with_capacity(runs.len());
    for run in runs {
        if !seen.insert((run.id.as_str(), &run.label)) {
            return Err(Error::Incompatible(format!(
                "the plan holds one run twice: `{}` at macro_step_s = {:?}, phase {:?} are the same in \
                 everything that determines a run",
                run.label, run.spec.macro_step, run.spec.phase
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn parsed(schemes: &str) -> Result<Experiment> {
        let text = format!(
            "question = \"?\"\nmacro_steps_s = [1e-5, 5e-3]\n[[cases]]\nname = \"wedge-box\"\n[[schemes]]\n{schemes}\n"
        );
        Experiment::parse(Path::new("usual.toml"), text)
    }

    #[test]
    fn a_label_is_not_the_name_of_something_else() {
        let plan = |label: &str| {
            parsed(&format!("scheme = \"rim-smooth\"\nlabel = \"{label}\""))
                .and_then(|experiment| experiment.plan(&Catalogue::standard(), false))
        };
        for (label, said) in [
            ("zero-order-hold", "is the name of another scheme"),
            ("reference", "the trace of the reference"),
            (" smooth", "begins or ends with a blank"),
            ("  ", "no label at all"),
            ("", "no label at all"),
        ] {
            let message = plan(label).unwrap_err().to_string();
            assert!(message.contains(said) && message.contains("[[schemes]] in line"), "`{label}`: {message}");
        }
        assert!(plan("rim-smooth").is_ok() && plan("my smooth").is_ok());
    }

    #[test]
    fn a_run_asked_for_by_name_must_be_the_one_that_a_file_with_a_case_and_a_scheme_means() {
        let catalogue = Catalogue::standard();
        for scheme in catalogue.schemes() {
            // Below and above the micro step of the case.
            let planned = parsed(&format!("scheme = \"{}\"", scheme.name)).unwrap().plan(&catalogue, false).unwrap();
            assert_eq!(planned.len(), 2);
            for run in planned {
                let step = run.spec.macro_step;
                let asked = RunRequest { macro_step_s: Some(step), ..RunRequest::of("wedge-box", &*scheme.name) };
                assert_eq!(asked.resolve(&catalogue).unwrap().id(), run.id, "{} at H = {step}", scheme.name);
            }
        }
    }

    #[test]
    fn rows_of_one_scheme_get_labels_of_what_differs() {
        let labels = |schemes: &str| {
            let planned = parsed(schemes).and_then(|experiment| experiment.plan(&Catalogue::standard(), false));
            let mut labels: Vec<String> = planned.unwrap().into_iter().map(|run| run.label).collect();
            labels.dedup();
            labels
        };
        let two =
            "scheme = \"nepce\"\ngain = 0.5\nsolver = \"lemke\"\n[[schemes]]\nsolver = \"lemke\"\nscheme = \"nepce\"\n";
        assert_eq!(labels(two), ["nepce/gain=0.5", "nepce"]);
        assert_eq!(labels(&format!("{two}gain = 1.5\n")), ["nepce/gain=0.5", "nepce/gain=1.5"]);
        assert_eq!(labels("scheme = \"nepce\"\ngain = 0.5\nlabel = \"half\""), ["half"]);
        // One scheme, one setting, other macro steps: one label.
        let steps =
            "scheme = \"nepce\"\nmacro_steps_s = [1e-3]\n[[schemes]]\nscheme = \"nepce\"\nmacro_steps_s = [2e-3]";
        assert_eq!(labels(steps), ["nepce"]);
    }

    #[test]
    fn a_row_with_several_tolerances_is_run_with_each_at_each_macro_step() {
        let row = |keys: &str| {
            let row = format!(
                "scheme = \"zero-order-hold\"\nstep_control = \"energy-residual\"\nmin_macro_step_s = 1e-5\n{keys}"
            );
            parsed(&row).and_then(|experiment| experiment.plan(&Catalogue::standard(), false))
        };
        let planned = row("step_tolerances = [0.1, 0.01]").unwrap();
        let settings: Vec<_> =
            planned.iter().map(|run| (run.spec.macro_step, run.spec.step_control.unwrap().tolerance)).collect();
        assert_eq!(settings, [(1e-5, 0.1), (1e-5, 0.01), (5e-3, 0.1), (5e-3, 0.01)]);
        assert!(planned.iter().all(|run| run.label == "zero-order-hold"));
        for (keys, wanted) in [
            ("step_tolerances = [0.1]\nstep_tolerance = 0.2", "give one of the two"),
            ("step_tolerances = 0.1", "step_tolerances: invalid type"),
            ("step_tolerances = []", "the grid is empty"),
            ("step_tolerances = [0.1, 0.1]", "the plan holds one run twice"),
            ("step_tolerances = [-1.0]", "step_tolerance = -1 is not valid"),
        ] {
            let message = row(keys).unwrap_err().to_string();
            assert!(message.contains(wanted), "{message}");
        }
    }

    #[test]
    fn what_is_wrong_with_a_row_is_said_with_its_line() {
        let refused = |schemes: &str| {
            let planned = parsed(schemes).and_then(|experiment| experiment.plan(&Catalogue::standard(), false));
            planned.unwrap_err().to_string()
        };
        for (row, wanted) in [
            (
                "scheme = \"nepce\"\ngian = 0.5",
                "unknown key of [[schemes]] `gian` (did you mean `gain`?); valid: label, ",
            ),
            ("scheme = \"nepce\"\nphase = 0.5", "unknown key of [[schemes]] `phase`"),
            ("scheme = \"nepce\"\ngain = \"high\"", "gain = high is not valid; valid: a number"),
            (
                "scheme = \"nepcee\"",
                "in line 5 (`nepcee` on case `wedge-box`): unknown scheme `nepcee` (did you mean `nepce`?)",
            ),
            ("label = \"mine\"", "scheme = nothing is not valid; valid: the name of a scheme"),
            ("scheme = \"nepce\"\nmacro_steps_s = 3", "macro_steps_s: one macro step is a list of one: [3.0]"),
            ("scheme = \"nepce\"\ngain = 1e300", "(`nepce` on case `wedge-box`): gain = 1e300 is not valid"),
            ("scheme = \"\"", "scheme = nothing"),
        ] {
            let message = refused(row);
            assert!(message.starts_with("usual.toml: [[schemes]] in line 5"), "{message}");
            assert!(message.contains(wanted), "{message}");
        }
        let message = refused("scheme = \"nepce\"\n[[schemes]]\nscheme = \"nepce\"\nlabel = \"nepce\"\ngain = 0.5");
        assert!(message.contains("line 7: label `nepce` is that of line 5"), "{message}");
        let message = refused("scheme = \"nepce\"\nlabel = \"nepce\"\n[[schemes]]\nscheme = \"nepce\"\ngain = 0.5");
        assert!(message.contains("could not be told apart"), "{message}");
    }

    #[test]
    fn a_reference_step_that_is_no_step_is_refused_before_anything_runs() {
        for (step, wanted) in
            [("1.0", "reference_step_s = 1e0"), ("1e-300", "reference_step_s = 1e-300"), ("2.5e299", "5e-5 s")]
        {
            let text = format!(
                "question = \"?\"\nmacro_steps_s = [1e-3]\nreference_step_s = {step}\n[[cases]]\nname = \"wedge-box\"\n\
                 [[schemes]]\nscheme = \"nepce\"\n"
            );
            let planned = Experiment::parse(Path::new("usual.toml"), text).unwrap().plan(&Catalogue::standard(), false);
            let message = planned.unwrap_err().to_string();
            assert!(message.contains(wanted), "{message}");
        }
    }

    #[test]
    fn a_file_whose_name_is_nothing_but_dots_names_no_experiment() {
        let text = "question = \"?\"\nmacro_steps_s = [1e-3]\n[[cases]]\nname = \"wedge-box\"\n[[schemes]]\nscheme = \"nepce\"\n";
        for name in ["..toml", "...toml"] {
            let message = Experiment::parse(Path::new(name), text.to_owned()).unwrap_err().to_string();
            assert!(message.contains("is no name for an experiment"), "{message}");
        }
    }

    /// The newcomer's most likely slips, and input that is long: one line that says where and what, and how long it was.
    #[test]
    fn what_is_no_experiment_is_told_by_line_with_what_would_be_valid() {
        let refused = |text: &str| {
            let planned = Experiment::parse(Path::new("mine.toml"), text.to_owned())
                .and_then(|experiment| experiment.plan(&Catalogue::standard(), false));
            planned.unwrap_err().to_string()
        };
        let good = "question = \"?\"\nmacro_steps_s = [5e-3]\n[[cases]]\nname = \"wedge-box\"\n[[schemes]]\nscheme = \"nepce\"\n";
        let long = format!("\"{}\"", "x".repeat(400_000));
        for (from, to, wanted) in [
            ("[5e-3]", "5e-3", "line 2, column 17: `macro_steps_s = 5e-3`: one macro step is a list of one: [0.005]"),
            ("[5e-3]", "5", "one macro step is a list of one: [5.0]"),
            ("[5e-3]", "\"5 ms\"", "expected a list of macro steps in s, [1e-3, 5e-3], or a range"),
            ("[5e-3]", "{ from = 1e-3 }", "missing field `to`"),
            ("[5e-3]", "[5e-3]\nphases = 0.5", "line 3, column 10: `phases = 0.5`: one phase is a list of one, [0.5]"),
            ("[5e-3]", "[5e-3]\nphases = -1", "a number of phases is not below 0: -1"),
            ("[5e-3]", "[5e-3]\nphasis = 1", "unknown field `phasis`"),
            (
                "wedge-box",
                "wedge-bx",
                "[[cases]] in line 3 (`wedge-bx`): unknown case `wedge-bx` (did you mean `wedge-box`?)",
            ),
            (
                "\"wedge-box\"",
                "\"wedge-box\"\nset = { box_mass_kg = -1e300 }",
                "[[cases]] in line 3 (`wedge-box`): box_mass_kg = -1e300 is not valid",
            ),
            (
                "[5e-3]",
                "[1e300]",
                "[[schemes]] in line 5 (`nepce` on case `wedge-box`): macro-step = 1e300 is not valid",
            ),
            ("\"?\"", &long, "unknown"),
            ("[5e-3]", &long, "expected a list of macro steps"),
            ("\"nepce\"", &long, "… (400000 characters)"),
            ("\"wedge-box\"", &long, "… (400000 characters)"),
        ] {
            // A long question is no fault, one without an end is.
            let text = good.replace(from, if wanted == "unknown" { &to[..to.len() - 1] } else { to });
            let message = refused(&text);
            assert!(message.starts_with("mine.toml: "), "{message}");
            assert!(message.contains(wanted) || wanted == "unknown", "{wanted}: {message}");
            assert!(message.len() < 2500 && message.lines().count() == 1, "{} characters: {message}", message.len());
        }
    }
}
