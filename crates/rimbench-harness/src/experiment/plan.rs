//! The runs that an experiment file stands for.

use super::{CaseEntry, Experiment, SchemeRow};
use crate::choices::Choices;
use crate::claims::check_claims_against_plan;
use crate::grid::{parameter_grid, scalar_text};
use crate::run::{RunSpec, parse_mechanics_steps, wall_limit};
use rimbench_cases::cases::{Case, Parameters, case_by_name};
use rimbench_core::complementarity::solver_by_name;
use rimbench_core::error::{Error, Result};
use rimbench_core::schemes::scheme_by_name;
use std::collections::HashMap;

/// Most runs of one experiment.
const MOST_RUNS: usize = 1_000_000;

/// One run of the plan, with what its row in data says about it.
#[derive(Debug, Clone)]
pub struct PlannedRun {
    /// What is run.
    pub spec: RunSpec,
    /// Label of the scheme row; the scheme's name unless the file gives another.
    pub label: String,
    /// Parameters that differ from their defaults, as `key=value` separated by spaces.
    pub set: String,
    /// [`RunSpec::id`].
    pub id: String,
}

impl Experiment {
    /// Lists the runs, cases outermost, then schemes, macro steps, phases.
    ///
    /// # Errors
    /// Names, values or combinations that are not valid, each with the file and the key; an empty grid.
    pub fn plan(&self, quick: bool) -> Result<Vec<PlannedRun>> {
        let planned = || {
            self.check_options()?;
            self.check_size(quick)?;
            let runs = self.expand(quick)?;
            refuse_twins(&runs)?;
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

    /// Refuses a grid that is empty or beyond all use, before it is laid out.
    fn check_size(&self, quick: bool) -> Result<()> {
        let quick = self.quick.as_ref().filter(|_| quick);
        let phases = quick.and_then(|quick| quick.phases.as_ref()).unwrap_or(&self.phases).count();
        let steps = quick.and_then(|quick| quick.macro_steps_s.as_ref()).unwrap_or(&self.macro_steps_s).list()?.len();
        let mut cells: usize = 0;
        for case in &self.cases {
            let lengths = case.set.values().map(|value| value.as_array().map_or(1, Vec::len));
            let parameters = lengths.fold(1_usize, usize::saturating_mul);
            for row in &self.schemes {
                let own = row.macro_steps_s.as_ref().or(case.macro_steps_s.as_ref());
                let steps = own.map_or(Ok(steps), |own| Ok(own.list()?.len()))?;
                cells = cells.saturating_add(parameters.saturating_mul(steps));
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
                "the grid has {runs} runs, more than the {MOST_RUNS} that one experiment may have: split it"
            ))),
            _ => Ok(()),
        }
    }

    fn expand(&self, quick: bool) -> Result<Vec<PlannedRun>> {
        let quick = self.quick.as_ref().filter(|_| quick);
        let phases = quick.and_then(|quick| quick.phases.as_ref()).unwrap_or(&self.phases).list();
        let quick_steps = quick.and_then(|quick| quick.macro_steps_s.as_ref());
        let mut runs = Vec::new();
        for entry in &self.cases {
            let case = case_by_name(&entry.name)?;
            for parameters in parameter_grid(case, &entry.set)? {
                for row in &self.schemes {
                    let own = row.macro_steps_s.as_ref().or(entry.macro_steps_s.as_ref());
                    let steps = own.or(quick_steps).unwrap_or(&self.macro_steps_s);
                    for macro_step in steps.list()? {
                        for &phase in &phases {
                            runs.push(self.planned(case, entry, &parameters, row, [macro_step, phase])?);
                        }
                    }
                }
            }
        }
        Ok(runs)
    }

    fn planned(
        &self,
        case: &'static Case,
        entry: &CaseEntry,
        parameters: &Parameters,
        row: &SchemeRow,
        [macro_step, phase]: [f64; 2],
    ) -> Result<PlannedRun> {
        let scheme = scheme_by_name(&row.scheme)?;
        if let Some(label) = row.label.as_deref().filter(|label| label.is_empty() || label.contains(char::is_control)) {
            return Err(Error::invalid("label", format!("{label:?}"), "text without tabs or line ends"));
        }
        let solver = solver_by_name(row.solver.as_deref().unwrap_or("active-set"))?;
        let mechanics_steps = match &row.mechanics_steps {
            None => 1,
            Some(value) => parse_mechanics_steps(&scalar_text("mechanics_steps", value)?)?,
        };
        let choices = Choices {
            sequence: row.sequence.as_deref(),
            force_return: row.force_return.as_deref(),
            redundancy: row.redundancy.as_deref(),
            model_motion: row.model_motion.as_deref(),
            contacts: row.contacts.as_deref(),
            gain: row.gain,
            step_control: row.step_control.as_deref(),
            step_tolerance: row.step_tolerance,
            min_macro_step: row.min_macro_step_s,
            micro_step: entry.micro_step_s.or(self.micro_step_s),
            duration: entry.duration_s.or(self.duration_s),
        };
        let spec = RunSpec {
            parameters: parameters.clone(),
            phase,
            mechanics_steps,
            wall_limit: self.wall_limit_s.map(wall_limit).transpose()?,
            ..RunSpec::chosen(case, scheme, solver, macro_step, &choices)?
        };
        spec.check()?;
        let set = parameters
            .iter()
            .filter(|(parameter, value)| *value != parameter.default)
            .map(|(parameter, value)| format!("{}={value}", parameter.name))
            .collect::<Vec<_>>()
            .join(" ");
        let label = row.label.clone().unwrap_or_else(|| row.scheme.clone());
        Ok(PlannedRun { id: spec.id(), spec, label, set })
    }
}

/// Refuses a plan that holds one run twice: its rows could not be told apart.
fn refuse_twins(runs: &[PlannedRun]) -> Result<()> {
    let mut first = HashMap::with_capacity(runs.len());
    for run in runs {
        if let Some(earlier) = first.insert(run.id.as_str(), &run.label) {
            return Err(Error::Incompatible(format!(
                "the plan holds one run twice: `{earlier}` and `{}` at macro_step_s = {:?}, phase {:?} are the same in \
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
    use rimbench_core::schemes::SCHEMES;
    use std::path::Path;

    #[test]
    fn the_usual_run_must_be_the_one_that_a_file_with_a_case_and_a_scheme_means() {
        let (case, solver) = (case_by_name("wedge-box").unwrap(), solver_by_name("active-set").unwrap());
        for scheme in SCHEMES {
            // Below and above the micro step of the case.
            let text = format!(
                "question = \"?\"\nmacro_steps_s = [1e-5, 5e-3]\n[[cases]]\nname = \"wedge-box\"\n[[schemes]]\nscheme = \"{}\"\n",
                scheme.name
            );
            let planned = Experiment::parse(Path::new("usual.toml"), text).unwrap().plan(false).unwrap();
            assert_eq!(planned.len(), 2);
            for run in planned {
                let usual = RunSpec::usual(case, scheme, solver, run.spec.macro_step).unwrap();
                assert_eq!(usual.id(), run.id, "{} at H = {}", scheme.name, run.spec.macro_step);
            }
        }
    }
}
