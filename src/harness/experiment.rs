//! The experiment file: a question, a grid of runs, and what is claimed of them.

use super::claims::{Claim, check_claims_against_plan};
use super::run::{RunSpec, parse_mechanics_steps, wall_limit};
use super::stability::logarithmic_grid;
use crate::atomic_file::write_atomically;
use crate::cases::{Case, Parameters, case_by_name};
use crate::complementarity::{SolverEntry, solver_by_name};
use crate::cosim::StepControl;
use crate::error::{Error, Result};
use crate::interface_model::Redundancy;
use crate::schemes::{SchemeOptions, scheme_by_name};
use serde::Deserialize;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

/// Most runs of one experiment.
const MOST_RUNS: usize = 1_000_000;

/// Relative compliance of the `regularised` redundancy treatment.
const REGULARISATION: f64 = 1e-8;

/// An experiment file as it is written. The format is explained in `experiments/README.md`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// What the experiment answers, in words.
    pub question: String,
    cases: Vec<CaseEntry>,
    schemes: Vec<SchemeRow>,
    macro_steps_s: MacroSteps,
    #[serde(default = "one_phase")]
    phases: Phases,
    duration_s: Option<f64>,
    micro_step_s: Option<f64>,
    /// Store a trace of each run, one row per this many seconds; none if absent.
    pub trace_every_s: Option<f64>,
    /// Labels of the scheme rows whose traces are stored; all of them if absent.
    traces: Option<Vec<String>>,
    /// Coarsest of the three steps of the reference, s; the case's own if absent.
    reference_step_s: Option<f64>,
    /// Wall time after which a run ends with outcome `timeout`, s; none if absent.
    wall_limit_s: Option<f64>,
    quick: Option<Quick>,
    #[serde(default)]
    claims: Vec<Claim>,
    #[serde(skip)]
    path: PathBuf,
    #[serde(skip)]
    source: String,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct CaseEntry {
    name: String,
    #[serde(default)]
    set: BTreeMap<String, toml::Value>,
    /// Instead of those of the experiment: cases have time scales of their own.
    macro_steps_s: Option<MacroSteps>,
    duration_s: Option<f64>,
    micro_step_s: Option<f64>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct SchemeRow {
    scheme: String,
    label: Option<String>,
    sequence: Option<String>,
    force_return: Option<String>,
    mechanics_steps: Option<toml::Value>,
    redundancy: Option<String>,
    model_motion: Option<String>,
    solver: Option<String>,
    gain: Option<f64>,
    macro_steps_s: Option<MacroSteps>,
    step_control: Option<String>,
    step_tolerance: Option<f64>,
    min_macro_step_s: Option<f64>,
}

/// Macro steps one by one, or evenly spread in logarithms.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
enum MacroSteps {
    List(Vec<f64>),
    Range(MacroStepRange),
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct MacroStepRange {
    from: f64,
    to: f64,
    per_decade: usize,
}

impl MacroSteps {
    fn list(&self) -> Result<Vec<f64>> {
        match self {
            MacroSteps::List(steps) => Ok(steps.clone()),
            MacroSteps::Range(range) => logarithmic_grid(range.from, range.to, range.per_decade)
                .map_err(|error| Error::Incompatible(format!("macro_steps_s: {error}"))),
        }
    }
}

/// A number of phases, or the phases themselves.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
enum Phases {
    Count(usize),
    List(Vec<f64>),
}

/// What `--quick` replaces.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Quick {
    macro_steps_s: Option<MacroSteps>,
    phases: Option<Phases>,
}

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
    /// Reads an experiment file.
    ///
    /// # Errors
    /// [`Error::File`] with path, line and what is wrong; unknown keys are errors.
    pub fn read(path: &Path) -> Result<Self> {
        let text =
            std::fs::read_to_string(path).map_err(|error| Error::file(path, format!("cannot be read: {error}")))?;
        Self::parse(path, text)
    }

    fn parse(path: &Path, text: String) -> Result<Self> {
        let mut experiment: Experiment =
            toml::from_str(&text).map_err(|error| Error::file(path, format!("is no experiment: {error}")))?;
        experiment.path = path.to_owned();
        experiment.source = text;
        Ok(experiment)
    }

    /// The same experiment with one more scheme, as if its file had one more `[[schemes]]`.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for a scheme that is neither built in nor registered.
    pub fn with_scheme(&self, name: &str) -> Result<Self> {
        scheme_by_name(name)?;
        Self::parse(&self.path, format!("{}\n[[schemes]]\nscheme = \"{name}\"\n", self.source))
    }

    /// The same experiment with one more case at its defaults, as if its file had one more `[[cases]]`.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for a case that is neither built in nor registered.
    pub fn with_case(&self, name: &str) -> Result<Self> {
        case_by_name(name)?;
        Self::parse(&self.path, format!("{}\n[[cases]]\nname = \"{name}\"\n", self.source))
    }

    /// Reads the copy of an experiment file that lies in a results folder; the folder's name is the experiment's.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub fn read_as(copy: &Path, folder: &Path) -> Result<Self> {
        let name =
            folder.canonicalize().ok().and_then(|folder| folder.file_name().map(PathBuf::from)).unwrap_or_default();
        Ok(Experiment { path: name.with_extension("toml"), ..Self::read(copy)? })
    }

    /// Name of the experiment: that of its file.
    pub fn name(&self) -> String {
        self.path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
    }

    /// Whether two files say the same to the letter.
    pub fn is_same_as(&self, other: &Self) -> bool {
        self.source == other.source
    }

    /// Where its results go: `<results>/<group>/<name>`, the group being the folder that the file lies in.
    pub fn results_folder(&self, results: &Path) -> PathBuf {
        let group = self.path.parent().and_then(Path::file_name).map(PathBuf::from).unwrap_or_default();
        results.join(group).join(self.name())
    }

    /// What the experiment claims.
    pub fn claims(&self) -> &[Claim] {
        &self.claims
    }

    /// The file it was read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

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

    /// Copies the experiment file beside its results, so that they can be merged and checked without it.
    ///
    /// # Errors
    /// [`Error::File`].
    pub(super) fn copy_to(&self, folder: &Path) -> Result<()> {
        std::fs::create_dir_all(folder).map_err(|error| Error::file(folder, format!("cannot be made: {error}")))?;
        let path = folder.join("experiment.toml");
        if std::fs::read_to_string(&path).is_ok_and(|text| text == self.source) {
            return Ok(());
        }
        write_atomically(&path, |file| file.write_all(self.source.as_bytes()))
    }

    /// The case with the reference step of this experiment.
    pub(super) fn with_own_reference(&self, case: &Case) -> Case {
        let mut case = *case;
        case.defaults.reference_step_s = self.reference_step_s.unwrap_or(case.defaults.reference_step_s);
        case
    }

    /// Whether the trace of a scheme row is to be stored, and at which distance of rows (s).
    pub(super) fn trace_of(&self, label: &str) -> Option<f64> {
        let wanted = self.traces.as_ref().is_none_or(|labels| labels.iter().any(|known| known == label));
        self.trace_every_s.filter(|_| wanted)
    }

    /// What the rows depend on besides the run: part of the identity of the store.
    pub(super) fn reference_identity(&self) -> String {
        self.reference_step_s.map(|step| format!("reference_step_s = {step:?}")).unwrap_or_default()
    }

    fn check_options(&self) -> Result<()> {
        for (key, value) in [("reference_step_s", self.reference_step_s), ("trace_every_s", self.trace_every_s)] {
            if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
                return Err(Error::invalid(key, value, "a finite time above 0 s"));
            }
        }
        let labels = || self.schemes.iter().map(|row| row.label.as_deref().unwrap_or(&row.scheme));
        let unknown = self.traces.iter().flatten().find(|wanted| !labels().any(|label| label == wanted.as_str()));
        unknown.map_or(Ok(()), |label| Err(Error::unknown("label in traces", label, labels())))
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
        let sequence = row.sequence.as_deref().map(str::parse).transpose()?;
        let force_return = row.force_return.as_deref().map(str::parse).transpose()?;
        let (sequence, force_return) = scheme.sequence_and_return(sequence, force_return)?;
        let solver = solver_by_name(row.solver.as_deref().unwrap_or("active-set"))?;
        let mechanics_steps = match &row.mechanics_steps {
            None => 1,
            Some(value) => parse_mechanics_steps(&scalar_text("mechanics_steps", value)?)?,
        };
        let options = scheme_options(row.redundancy.as_deref(), row.model_motion.as_deref(), solver)?;
        let step_control = StepControl::new(
            row.step_control.as_deref(),
            row.step_tolerance,
            row.min_macro_step_s,
            macro_step,
            scheme.order,
        )?;
        let spec = RunSpec {
            step_control,
            case,
            parameters: parameters.clone(),
            scheme,
            options: SchemeOptions { gain: scheme.gain_value(row.gain)?, ..options },
            macro_step,
            phase,
            // A macro step below the usual micro step is its own micro step, unless one is asked for.
            micro_step: entry.micro_step_s.or(self.micro_step_s).unwrap_or(case.defaults.micro_step_s.min(macro_step)),
            mechanics_steps,
            sequence,
            force_return,
            duration: entry.duration_s.or(self.duration_s).unwrap_or(case.defaults.duration_s),
            solver,
            wall_limit: self.wall_limit_s.map(wall_limit).transpose()?,
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

/// Options of the schemes from their names; the gain is left to its default.
///
/// # Errors
/// [`Error::UnknownName`] with all names.
pub fn scheme_options(
    redundancy: Option<&str>,
    motion: Option<&str>,
    solver: &'static SolverEntry,
) -> Result<SchemeOptions> {
    let redundancy = match redundancy.unwrap_or("drop") {
        "drop" => Redundancy::Drop,
        "pseudo-inverse" => Redundancy::PseudoInverse,
        "regularised" => Redundancy::Regularised { epsilon: REGULARISATION },
        other => return Err(Error::unknown("redundancy", other, ["drop", "pseudo-inverse", "regularised"])),
    };
    let motion = motion.map(str::parse).transpose()?.unwrap_or_default();
    Ok(SchemeOptions { redundancy, motion, solver, gain: None })
}

impl Phases {
    fn count(&self) -> usize {
        match self {
            Phases::Count(count) => *count,
            Phases::List(phases) => phases.len(),
        }
    }

    fn list(&self) -> Vec<f64> {
        match self {
            Phases::Count(count) => phase_ensemble(*count),
            Phases::List(phases) => phases.clone(),
        }
    }
}

fn one_phase() -> Phases {
    Phases::Count(1)
}

/// The first `count` members of the phase ensemble, a low-discrepancy set in (0, 1].
///
/// ```text
/// φ_j = 1 − frac(j (√5 − 1)/2),   j = 0 … count − 1
/// ```
/// The first member is 1: no shortened step.
pub fn phase_ensemble(count: usize) -> Vec<f64> {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    (0..count).map(|j| 1.0 - (j as f64 * golden).fract()).collect()
}

/// Every combination of the values that are lists.
fn parameter_grid(case: &'static Case, set: &BTreeMap<String, toml::Value>) -> Result<Vec<Parameters>> {
    let mut grid = vec![case.default_parameters()];
    for (key, value) in set {
        let values = match value {
            toml::Value::Array(values) => values.as_slice(),
            single => std::slice::from_ref(single),
        };
        let mut next = Vec::with_capacity(grid.len() * values.len());
        for parameters in &grid {
            for value in values {
                let mut changed = parameters.clone();
                changed.set(key, &scalar_text(key, value)?)?;
                next.push(changed);
            }
        }
        grid = next;
    }
    Ok(grid)
}

/// A TOML scalar as the text that `--set` would take.
fn scalar_text(key: &str, value: &toml::Value) -> Result<String> {
    match value {
        toml::Value::String(text) => Ok(text.clone()),
        toml::Value::Integer(number) => Ok(number.to_string()),
        toml::Value::Float(number) => Ok(format!("{number:?}")),
        toml::Value::Boolean(flag) => Ok(flag.to_string()),
        other => Err(Error::invalid(key, other, "a number or a name")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_phase_ensemble_starts_at_one_and_spreads() {
        let phases = phase_ensemble(16);
        assert_eq!(phases[0], 1.0);
        assert!(phases.iter().all(|phase| *phase > 0.0 && *phase <= 1.0));
        let mut sorted = phases.clone();
        sorted.sort_by(f64::total_cmp);
        let largest_hole = sorted.windows(2).map(|pair| pair[1] - pair[0]).fold(sorted[0], f64::max);
        assert!(largest_hole < 2.0 / 16.0 * 1.2, "{largest_hole}");
    }

    #[test]
    fn the_shipped_experiments_are_valid_plans() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/paper");
        let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let mut count = 0;
        for path in files.filter(|path| path.extension().is_some_and(|extension| extension == "toml")) {
            let experiment = Experiment::read(&path).unwrap();
            for quick in [false, true] {
                assert!(!experiment.plan(quick).unwrap().is_empty());
            }
            count += 1;
        }
        assert!(count >= 3);
    }
}
