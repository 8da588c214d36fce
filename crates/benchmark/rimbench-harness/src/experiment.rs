//! The experiment file: a question, a grid of runs, and what is claimed of them.

mod claim;
mod claims_of_plan;
mod draw;
mod needs;
mod plan;
mod planned_run;
mod scheme_row;

pub use claim::Claim;
pub(crate) use claim::{AtEqual, Statistic, Witnesses};
pub(crate) use claims_of_plan::check_claim_id;
pub use needs::{Needs, named_python};
pub use planned_run::PlannedRun;

use super::grid::{MacroSteps, Phases, one_phase};
use super::store::Store;
use draw::Draw;
use rimbench_cases::cases::Case;
use rimbench_core::error::{Error, Result, shortened};
use rimbench_results::budget::Budgets;
pub use rimbench_results::claims::{Claimant, Verdict};
use rimbench_results::input::{beside, read_text};
use rimbench_results::text_place::{line_of, said_at};
use rimbench_runs::catalogue::Catalogue;
use rimbench_runs::metrics::ContactEvent;
use scheme_row::{Logs, RawRow, SchemeRow};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use toml::Spanned;

/// Name of the copy of the file in a results folder.
pub(super) const COPY: &str = "experiment.toml";

/// With what the table begins that a copy has of the files of cases and schemes.
const CASE_FILES: &str = "\n[case_files]\n";

/// The path from a folder to a file, by way of what both have in common.
fn path_from(folder: &Path, file: &Path) -> PathBuf {
    let whole =
        |path: &Path| path.canonicalize().or_else(|_| std::path::absolute(path)).unwrap_or_else(|_| path.to_owned());
    // The file itself may be a link, from which what it names is found.
    let parent = whole(&std::path::absolute(file).unwrap_or_default().parent().unwrap_or(Path::new("")).join("."));
    let (folder, file) = (whole(folder), parent.join(file.file_name().unwrap_or_default()));
    let both = folder.components().zip(file.components()).take_while(|(one, other)| one == other);
    let common: PathBuf = both.map(|(one, _)| one).collect();
    match (folder.strip_prefix(&common), file.strip_prefix(&common)) {
        (Ok(up), Ok(down)) if common != Path::new("") => {
            up.components().map(|_| Component::ParentDir).chain(down.components()).collect()
        }
        _ => file,
    }
}

/// An experiment file as it is written. The format is explained in `experiments/README.md`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// What the experiment answers, in words.
    pub question: String,
    cases: Vec<CaseEntry>,
    #[serde(rename = "schemes")]
    raw_schemes: Vec<RawRow>,
    #[serde(skip)]
    schemes: Vec<SchemeRow>,
    macro_steps_s: MacroSteps,
    #[serde(default = "one_phase")]
    phases: Phases,
    /// Simulated time, s; the case's own if absent.
    duration_s: Option<f64>,
    /// Longest micro step of the actuator side, s; the case's own if absent.
    micro_step_s: Option<f64>,
    /// Longest step of the mechanics, s, of schemes that say nothing of its steps; as usual if absent.
    mechanics_step_s: Option<f64>,
    /// Store a trace of each run, one row per this many seconds; none if absent.
    pub trace_every_s: Option<f64>,
    /// Labels of the scheme rows whose traces are stored; all of them if absent.
    traces: Option<Vec<String>>,
    /// Macro steps in which it is stored what schemes believe of the mechanics.
    #[serde(default)]
    beliefs: Vec<BeliefEntry>,
    /// Coarsest of the three steps of the reference, s; the case's own if absent.
    reference_step_s: Option<f64>,
    /// Wall time after which a run ends with outcome `timeout`, s; none if absent.
    wall_limit_s: Option<f64>,
    /// What its cases need that not every machine has.
    #[serde(default)]
    pub needs: Needs,
    /// Whether the wall times of its runs are to be compared, so that nothing else may run beside them.
    #[serde(default)]
    pub timed: bool,
    /// Whether there is an account of what interface models create, where they can be audited.
    #[serde(default)]
    audit: bool,
    /// Whether force errors are divided into that of the coupling and that of the mechanics' own step.
    #[serde(default)]
    divide_error: bool,
    /// Budgets of which it is told what they buy.
    budgets: Option<Budgets>,
    /// What `--quick` replaces.
    quick: Option<Quick>,
    /// Whether numbers of such runs were known, from a trial or from earlier runs, when bounds of its claims were set.
    #[serde(default)]
    numbers_known: bool,
    /// What should come out.
    #[serde(default)]
    claims: Vec<Claim>,
    /// Runs whose work and instructions are recorded.
    perf: Option<Perf>,
    /// Logs that `delivery` names, name and text, so that a copy of the file holds them; read from their files if
    /// absent.
    #[serde(default)]
    logs: BTreeMap<String, String>,
    /// In a copy: where files of cases and schemes are from there.
    #[serde(default)]
    case_files: BTreeMap<PathBuf, PathBuf>,
    #[serde(skip)]
    path: PathBuf,
    #[serde(skip)]
    source: String,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct CaseEntry {
    /// That of the file where there is one and no name.
    #[serde(default)]
    name: String,
    /// A case file, by its path from this one.
    file: Option<PathBuf>,
    /// Where that is.
    #[serde(skip)]
    place: PathBuf,
    /// Parameters; a list makes a grid.
    #[serde(default)]
    set: BTreeMap<String, toml::Value>,
    /// Settings of other parameters, drawn at random for each point of that grid.
    draw: Option<Draw>,
    /// Instead of those of the experiment: cases have time scales of their own.
    macro_steps_s: Option<MacroSteps>,
    /// Simulated time, s.
    duration_s: Option<f64>,
    /// Longest micro step of the actuator side, s.
    micro_step_s: Option<f64>,
    /// Longest step of the mechanics, s.
    mechanics_step_s: Option<f64>,
    /// Line of the file in which it begins, from 1.
    #[serde(skip)]
    line: usize,
}

impl Experiment {
    /// Tells what of a case and a set was drawn, which other sets of the case share; all of it where nothing was.
    pub(crate) fn draw_of(&self, [case, set]: [&str; 2]) -> String {
        let draws: Vec<&Draw> =
            self.cases.iter().filter(|entry| entry.name == case).filter_map(|entry| entry.draw.as_ref()).collect();
        let is_drawn = |word: &&str| draws.iter().any(|draw| draw.draws(word.split('=').next().unwrap_or(word)));
        let drawn: Vec<&str> = set.split(' ').filter(is_drawn).collect();
        format!("{case} {}", if drawn.is_empty() { set.to_owned() } else { drawn.join(" ") })
    }
}

impl CaseEntry {
    /// An error about this case, with its place.
    fn place(&self, error: &Error) -> Error {
        let name = self.file.as_ref().filter(|_| self.name.is_empty()).map(|file| file.display().to_string());
        let name = name.unwrap_or_else(|| self.name.clone());
        Error::Incompatible(format!("[[cases]] in line {} (`{}`): {error}", self.line, shortened(&name)))
    }

    /// The case that is meant.
    fn find(&self, catalogue: &Catalogue) -> Result<Arc<Case>> {
        if let Some(file) = self.file.as_ref().filter(|file| file.as_os_str().is_empty()) {
            return Err(Error::invalid("file", file.display(), "the path of a case file"));
        }
        if self.file.is_none() && self.name.is_empty() {
            return Err(Error::invalid("name", "nothing", "the name of a case, or file = \"….toml\", a case file"));
        }
        // One that is given by `--case-file` is not looked for.
        let given = catalogue.case(&self.name).map(Arc::clone);
        if given.as_ref().is_ok_and(|case| self.file.is_none() || (case.from_outside && !self.place.exists())) {
            return given;
        }
        match given {
            Err(Error::UnknownName { kind, found, mut valid }) if self.file.is_none() => {
                valid.insert(0, "file = \"….toml\" for one that a case file makes".to_owned());
                Err(Error::UnknownName { kind, found, valid })
            }
            _ => {
                let case = catalogue.case_of_file(&self.place)?;
                if self.name.is_empty() || case.name == self.name.as_str() {
                    return Ok(case);
                }
                Err(Error::invalid("name", &self.name, format!("{}, as the file has it, or no name", case.name)))
            }
        }
    }
}

/// One macro step of a case, and whose beliefs within it are stored.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct BeliefEntry {
    /// The case, with its default parameters.
    case: String,
    /// Where the macro step starts, s.
    at_s: f64,
    /// How long it is, s.
    macro_step_s: f64,
    /// Labels of scheme rows, or names of schemes.
    schemes: Vec<String>,
}

/// Where the tables of a file stand.
#[derive(Deserialize)]
struct Places {
    cases: Vec<Spanned<IgnoredAny>>,
}

/// Which of the runs are recorded.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Perf {
    /// Labels.
    schemes: Vec<String>,
    /// All of theirs if absent.
    macro_steps_s: Option<MacroSteps>,
}

/// What `--quick` replaces.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Quick {
    macro_steps_s: Option<MacroSteps>,
    phases: Option<Phases>,
}

impl Experiment {
    /// Reads an experiment file.
    ///
    /// # Errors
    /// [`Error::File`] with path, line and what is wrong; unknown keys are errors.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(path, read_text(path)?)
    }

    /// Reads the text of an experiment file; `path` gives its name and group, and is what errors name.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub fn parse(path: &Path, text: String) -> Result<Self> {
        let wrong = |error: toml::de::Error| {
            Error::file(path, format!("is no experiment: {}", said_at(&text, error.span(), error.message())))
        };
        let mut experiment: Experiment = toml::from_str(&text).map_err(wrong)?;
        let numbers_known = experiment.numbers_known;
        experiment.claims.iter_mut().for_each(|claim| claim.numbers_known |= numbers_known);
        let places: Places = toml::from_str(&text).map_err(wrong)?;
        for (case, place) in experiment.cases.iter_mut().zip(places.cases) {
            case.line = line_of(&text, place.span().start);
            let Some(file) = &case.file else { continue };
            case.place = beside(path, experiment.case_files.get(file).unwrap_or(file));
        }
        let mut logs =
            Logs { file: path, kept: &experiment.logs, read: BTreeMap::new(), moved: &experiment.case_files };
        let rows = std::mem::take(&mut experiment.raw_schemes).into_iter();
        let rows = rows.map(|row| SchemeRow::read(row, &text, &mut logs));
        let rows = rows.collect::<Result<Vec<_>>>().and_then(scheme_row::with_labels);
        let logs = logs.table();
        experiment.schemes = rows.map_err(|error| Error::file(path, error))?;
        let texts = experiment.claims.iter().map(|claim| (format!("text of claim `{}`", claim.id), &claim.text));
        if let Some((key, text)) = [("question".to_owned(), &experiment.question)]
            .into_iter()
            .chain(texts)
            .find(|(_, text)| text.trim().is_empty())
        {
            return Err(Error::file(path, Error::invalid(key, format!("{text:?}"), "what it is, in words")));
        }
        if let Some(pair) = experiment.budgets.iter().find_map(Budgets::wrong) {
            let valid = "exchanges and mechanics steps per second, numbers above 0";
            return Err(Error::file(path, Error::invalid("budgets.per_s", format!("{pair:?}"), valid)));
        }
        experiment.path = path.to_owned();
        let name = experiment.name();
        if name.trim_matches('.').is_empty() || name.contains(char::is_control) {
            let wanted = "is no name for an experiment: results go to a folder of that name";
            return Err(Error::file(shortened(&path.to_string_lossy()), format!("`{}` {wanted}", shortened(&name))));
        }
        // A copy holds the logs themselves. Paths of case files, which depend on its folder, are no part of the source.
        let own = text.split_once(CASE_FILES).map_or(&*text, |(own, _)| own);
        experiment.source = own.to_owned() + &logs.unwrap_or_default();
        Ok(experiment)
    }

    /// Reads the copy of an experiment file that lies in a results folder. Its name is that under which the records of
    /// the folder were stored, else that of the folder.
    ///
    /// # Errors
    /// Those of [`read`](Self::read).
    pub fn read_from_results(folder: &Path) -> Result<Self> {
        let copy = folder.join(COPY);
        if !copy.is_file() {
            return Err(Error::file(folder, format!("is no results folder: it holds no {COPY}")));
        }
        let of_folder = || Some(folder.canonicalize().ok()?.file_name()?.to_string_lossy().into_owned());
        let name = Store::experiment_in(folder).or_else(of_folder).unwrap_or_default();
        Ok(Experiment { path: PathBuf::from(format!("{name}.toml")), ..Self::read(&copy)? })
    }

    /// Returns the name of the experiment: that of its file.
    pub fn name(&self) -> String {
        self.path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
    }

    /// Returns the name of the folder it lies in: that of its group.
    pub fn group(&self) -> String {
        let folder = self.path.parent().and_then(Path::file_name);
        folder.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
    }

    /// Returns `<group>/<name>`.
    pub fn full_name(&self) -> String {
        format!("{}/{}", self.group(), self.name())
    }

    /// Tells whether two files say the same to the letter.
    pub fn is_same_as(&self, other: &Self) -> bool {
        self.source == other.source
    }

    /// Says where its results go: `<results>/<group>/<name>`, the group being the folder that the file lies in.
    pub fn results_folder(&self, results: &Path) -> PathBuf {
        results.join(self.group()).join(self.name())
    }

    /// The budgets of which it is told what they buy.
    pub(crate) fn budgets(&self) -> Option<&Budgets> {
        self.budgets.as_ref()
    }

    /// Says what the experiment claims.
    pub fn claims(&self) -> &[Claim] {
        &self.claims
    }

    /// Returns the file it was read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The text of a copy in a folder, by which results can be merged and checked without the file; from there files of
    /// cases and schemes are elsewhere.
    pub(super) fn copy_in(&self, folder: &Path) -> String {
        let mut text = self.source.clone();
        let schemes = self.schemes.iter().filter_map(|row| row.of_file.as_ref()).map(|(file, of)| (file, &of.path));
        let cases = self.cases.iter().filter_map(|case| Some((case.file.as_ref()?, &case.place)));
        let files: BTreeMap<&PathBuf, &PathBuf> = cases.chain(schemes).collect();
        if !files.is_empty() {
            text += CASE_FILES;
        }
        for (file, place) in files {
            let quoted =
                |path: &Path| serde_json::Value::from(path.to_string_lossy()).to_string().replace('\x7f', "\\u007f");
            text += &format!("{} = {}\n", quoted(file), quoted(&path_from(folder, place)));
        }
        text
    }

    /// The catalogue with the schemes that are classes in files. One that was given by its name is not looked for.
    fn with_own_schemes<'a>(&self, catalogue: &'a Catalogue) -> Result<Cow<'a, Catalogue>> {
        let mut catalogue = Cow::Borrowed(catalogue);
        for row in &self.schemes {
            let Some((_, scheme)) = &row.of_file else { continue };
            if catalogue.scheme(&scheme.name).is_ok_and(|known| known.waits) && !scheme.path.exists() {
                continue;
            }
            catalogue.to_mut().add_scheme_of_file(scheme).map_err(|error| row.place_of_file(&error))?;
        }
        Ok(catalogue)
    }

    /// The case with the reference step of this experiment.
    fn with_own_reference(&self, case: &Arc<Case>) -> Arc<Case> {
        let Some(reference_step_s) = self.reference_step_s else { return case.clone() };
        let mut case = (**case).clone();
        case.defaults.reference_step_s = reference_step_s;
        Arc::new(case)
    }

    /// Whether the trace of a scheme row is to be stored, and at which distance of rows (s).
    pub(super) fn trace_of(&self, label: &str) -> Option<f64> {
        let wanted = self.traces.as_ref().is_none_or(|labels| labels.iter().any(|known| known == label));
        self.trace_every_s.filter(|_| wanted)
    }

    /// Whether there is a plan of its own for a quick look.
    pub(super) fn has_quick_plan(&self) -> bool {
        self.quick.is_some()
    }

    /// What must happen in settings that are drawn, case by case.
    pub(super) fn events_required(&self) -> impl Iterator<Item = ContactEvent> {
        self.cases.iter().filter_map(|case| case.draw.as_ref()?.requires)
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
        // Also those that every case replaces by its own.
        self.macro_steps_s.check()?;
        self.phases.check()?;
        let in_quick = |error: Error| Error::Incompatible(format!("[quick]: {error}"));
        if let Some(quick) = &self.quick {
            quick.macro_steps_s.as_ref().map_or(Ok(()), MacroSteps::check).map_err(in_quick)?;
            quick.phases.as_ref().map_or(Ok(()), Phases::check).map_err(in_quick)?;
        }
        for case in &self.cases {
            case.macro_steps_s.as_ref().map_or(Ok(()), MacroSteps::check).map_err(|error| case.place(&error))?;
        }
        let labels = || self.schemes.iter().map(|row| row.label.as_str());
        let unknown = self.traces.iter().flatten().find(|wanted| !labels().any(|label| label == wanted.as_str()));
        if let Some(label) = unknown {
            return Err(Error::unknown("label in traces", label, labels()));
        }
        if let Some(wanted) = self.traces.as_ref().filter(|wanted| self.trace_every_s.is_none() || wanted.is_empty()) {
            let expected = "labels of schemes, with trace_every_s beside it, the time between two rows";
            return Err(Error::invalid("traces", format!("{wanted:?}"), expected));
        }
        Ok(())
    }
}
