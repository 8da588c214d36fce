//! Submissions: a third party's scheme, its results, and what it declares of both.
//!
//! ```text
//! <folder>/
//!     submission.toml     the declaration
//!     scheme.toml, …      the scheme file that it names, with its program
//!     <package>/          data packages, as `export` writes them
//! ```
//! A scheme is always a program of its own that answers line by line: nothing of it runs in this process, and every number is computed
//! here. A submission that computed its own numbers would have to be believed.

use super::build_info::BuildInfo;
use super::cache::Cache;
use super::execution::Job;
use super::experiment::PlannedRun;
use super::files::{make_folder, read_text};
use super::package::{Citation, DESCRIPTION, Package, Rerun, rerun_sample};
use super::ranking::{OPTIONS, class_of_run, first_differing};
use super::results::{plan_cells, plan_header, tries_friction_laws};
use rimbench_cases::catalogue::Catalogue;
use rimbench_core::cosim::StopFlag;
use rimbench_core::error::{Error, Result, said_at};
use rimbench_core::name::check_new_name;
use rimbench_core::numerics_version::NUMERICS_VERSION;
use rimbench_core::schemes::{InformationClass, SchemeEntry};
use rimbench_results::atomic_file::write_atomically;
use rimbench_results::checksums;
use rimbench_results::results_table::ResultsTable;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

/// Name of the declaration.
pub const DECLARATION: &str = "submission.toml";

/// Name of the table of what was computed once more.
const CHECK: &str = "check.csv";

/// Its column of the version of the numerics that computed.
const NUMERICS: &str = "numerics_version";

/// Keys of a scheme file: what is started, and which further files its digits depend on.
const COMMAND: &str = "command";
const FILES: &str = "files";

/// Key of a scheme file: how long its program may take for an answer.
const PATIENCE: &str = "answer_within_s";

/// The most that it may ask for, s.
pub const LONGEST_ANSWER_S: f64 = 60.0;

/// Longest text of a declaration that is taken for a name, characters.
const LONGEST: usize = 200;

/// What a submission declares, as it is written.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    name: String,
    about: String,
    authors: Vec<String>,
    licence: String,
    information: String,
    scheme: String,
    packages: Vec<String>,
    #[serde(default)]
    tuned: Vec<Tuned>,
}

/// Something that was chosen after looking at results.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tuned {
    /// What was chosen: a constant of the scheme, its form.
    pub what: String,
    /// Cases whose results were looked at.
    pub cases: Vec<String>,
}

/// What a submission declares.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Declaration {
    /// Name of the scheme: that of its scheme file, and of no built-in one.
    pub name: String,
    /// What it does, in a line.
    pub about: String,
    /// `Family, Given`, or the name of a group.
    pub authors: Vec<String>,
    /// Licence of the scheme, an SPDX identifier.
    pub licence: String,
    /// What the scheme must know of the other side.
    pub information: InformationClass,
    /// Scheme file, relative to the folder.
    pub scheme: PathBuf,
    /// Folders of the data packages, relative to the folder.
    pub packages: Vec<String>,
    /// What was tuned; nothing if all was fixed beforehand.
    pub tuned: Vec<Tuned>,
    /// As it was read: the program may write to the file afterwards.
    text: String,
}

impl Declaration {
    /// Reads the declaration of a submission.
    ///
    /// # Errors
    /// Those of [`parse`](Self::parse).
    pub fn read(folder: &Path, catalogue: &Catalogue) -> Result<Self> {
        let path = folder.join(DECLARATION);
        Self::parse(&path, &read_text(&path)?, catalogue)
    }

    /// Reads the text of a declaration; `path` is what errors name.
    ///
    /// # Errors
    /// [`Error::File`] with what is wrong and what would be valid: unknown keys, a name that is taken, authors or a licence that are none,
    /// a class that does not exist, files outside of the folder, unknown cases.
    pub fn parse(path: &Path, text: &str, catalogue: &Catalogue) -> Result<Self> {
        let raw: Raw = toml::from_str(text).map_err(|error: toml::de::Error| {
            Error::file(path, format!("is no declaration: {}", said_at(text, error.span(), error.message())))
        })?;
        Self::checked(raw, text, catalogue).map_err(|error| Error::file(path, error))
    }

    fn checked(raw: Raw, text: &str, catalogue: &Catalogue) -> Result<Self> {
        let Raw { name, about, authors, licence, information, scheme, packages, tuned } = raw;
        check_new_name("scheme", &name, catalogue.schemes().iter().map(|scheme| &*scheme.name))?;
        in_words("about", &about, "what the scheme does, in a line")?;
        Citation { title: None, authors: authors.clone(), licence: licence.clone(), released: None }.check()?;
        let information = information.parse()?;
        let scheme = inside("scheme", &scheme)?;
        if packages.is_empty() {
            return Err(Error::invalid("packages", "[]", "at least one folder that `rimbench export` has written"));
        }
        for (index, package) in packages.iter().enumerate() {
            inside("packages", package)?;
            if packages[..index].contains(package) {
                return Err(Error::invalid("packages", package, "each folder once"));
            }
        }
        for tuned in &tuned {
            in_words("tuned.what", &tuned.what, "what was chosen, in a line")?;
            if tuned.cases.is_empty() {
                return Err(Error::invalid("tuned.cases", "[]", "the cases whose results were looked at"));
            }
            tuned.cases.iter().try_for_each(|case| catalogue.case(case).map(drop))?;
        }
        let text = text.to_owned();
        Ok(Declaration { name, about, authors, licence, information, scheme, packages, tuned, text })
    }

    /// Cases that something was tuned on.
    pub fn tuned_on(&self) -> BTreeSet<String> {
        self.tuned.iter().flat_map(|tuned| tuned.cases.iter().cloned()).collect()
    }

    /// Looks at where its files are, links followed, before the program is started: whoever has the folder has all of the submission.
    ///
    /// # Errors
    /// [`Error::File`] for a declaration, a scheme file, a package, or a file that the scheme file names, which lies elsewhere. What is not
    /// there at all is for its reader to say.
    pub fn check_places(&self, folder: &Path) -> Result<()> {
        let whole = folder.canonicalize().map_err(|error| Error::file(folder, format!("cannot be found: {error}")))?;
        let lies_inside =
            |path: &Path| path.canonicalize().is_ok_and(|path| path.starts_with(&whole)) || !path.exists();
        let path = folder.join(DECLARATION);
        if !lies_inside(&path) {
            return Err(Error::file(path, "leads out of the folder of the submission: put the file itself there"));
        }
        for (key, name) in std::iter::once(("scheme", self.scheme.as_path()))
            .chain(self.packages.iter().map(|package| ("packages", Path::new(package))))
        {
            if !lies_inside(&folder.join(name)) {
                return Err(Error::file(path, Error::invalid(key, name.display(), INSIDE)));
            }
        }
        let (path, file) = self.scheme_file(folder)?;
        let beside = path.parent().unwrap_or(folder);
        let words = |key: &str| -> Vec<String> {
            let words = file.get(key).and_then(toml::Value::as_array).into_iter().flatten();
            words.filter_map(|word| word.as_str().map(str::to_owned)).collect()
        };
        for file in words(FILES) {
            // Whether or not it is there, no file of a submission is named so.
            if Path::new(&file).is_absolute() || !lies_inside(&beside.join(&file)) {
                return Err(Error::file(&path, Error::invalid(FILES, file, INSIDE)));
            }
        }
        for word in words(COMMAND) {
            // The value of an option is a path as well, and what has no slash is one where there is such a file.
            for part in std::iter::once(&*word).chain(word.split_once('=').map(|(_, value)| value)) {
                if Path::new(part).is_absolute() || !lies_inside(&beside.join(part)) {
                    return Err(Error::file(
                        &path,
                        Error::invalid(COMMAND, &word, format!("{INSIDE}, or a name on the path")),
                    ));
                }
            }
        }
        Ok(())
    }

    /// Path and keys of the scheme file; no keys if it is no TOML, which is for its reader to say.
    fn scheme_file(&self, folder: &Path) -> Result<(PathBuf, toml::Table)> {
        let path = folder.join(&self.scheme);
        let text = read_text(&path)?;
        Ok((path, toml::from_str(&text).unwrap_or_default()))
    }

    /// Looks at how long the program may take for an answer, before it is started: nobody is kept waiting for longer than
    /// [`LONGEST_ANSWER_S`].
    ///
    /// # Errors
    /// [`Error::File`] naming the scheme file. What else is wrong with it is for its reader to say.
    pub fn check_patience(&self, folder: &Path) -> Result<()> {
        let (path, file) = self.scheme_file(folder)?;
        let asked = file.get(PATIENCE).and_then(|value| value.as_float().or(value.as_integer().map(|s| s as f64)));
        match asked.filter(|seconds| seconds.is_nan() || *seconds > LONGEST_ANSWER_S) {
            None => Ok(()),
            Some(seconds) => {
                let expected = format!("at most {LONGEST_ANSWER_S} s in a submission");
                Err(Error::file(&path, Error::invalid(PATIENCE, seconds, expected)))
            }
        }
    }

    /// Holds the scheme against what is declared of it.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for another name, and for a scheme that asks for more than it is declared to need.
    pub fn check_scheme(&self, scheme: &SchemeEntry) -> Result<()> {
        if scheme.name != self.name {
            return Err(Error::Incompatible(format!(
                "name = {}: the scheme file describes a scheme called `{}`",
                self.name, scheme.name
            )));
        }
        let asks = InformationClass::of(scheme);
        if asks > self.information {
            return Err(Error::Incompatible(format!(
                "information = {}: the scheme asks for more, which is `{asks}`: declare that, or ask for less",
                self.information
            )));
        }
        Ok(())
    }

    /// Holds a package against what is declared, and says which of its runs, by their places, are the scheme's.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for a package without a run of the scheme; for runs that take steps again although less is declared, or have
    /// a gain that is not the default although nothing is declared tuned; for references that are not those of the cases.
    fn check_package(&self, package: &Package) -> Result<()> {
        let own: Vec<_> = package.planned.iter().filter(|run| run.spec.scheme.name == self.name).collect();
        if own.is_empty() {
            return Err(Error::Incompatible(format!("holds no run of `{}`", self.name)));
        }
        if !package.experiment.reference_identity().is_empty() {
            return Err(Error::Incompatible(
                "has a reference_step_s of its own: only what is held against the cases' own references can be compared".to_owned(),
            ));
        }
        for run in own {
            if run.spec.step_control.rule().is_some() && self.information < InformationClass::Repetition {
                return Err(Error::Incompatible(format!(
                    "information = {}: row `{}` controls its macro step, and so takes steps again: declare `{}`",
                    self.information,
                    run.label,
                    InformationClass::Repetition
                )));
            }
            let usual = run.spec.scheme.gain.as_ref().map(|gain| gain.default);
            if let Some(gain) = run.spec.gain.filter(|gain| Some(*gain) != usual && self.tuned.is_empty()) {
                return Err(Error::Incompatible(format!(
                    "row `{}` has gain = {gain}, which is not the default, and nothing is declared tuned: add [[tuned]]",
                    run.label
                )));
            }
        }
        Ok(())
    }
}

fn in_words(key: &str, text: &str, expected: &str) -> Result<()> {
    let good = !text.trim().is_empty() && text.chars().count() <= LONGEST && !text.contains(char::is_control);
    if good { Ok(()) } else { Err(Error::invalid(key, text, format!("{expected}, at most {LONGEST} characters"))) }
}

/// What a path in a submission is.
const INSIDE: &str = "a path below the folder of the submission";

/// A path that does not lead out of the folder.
fn inside(key: &str, text: &str) -> Result<PathBuf> {
    let path = Path::new(text);
    let plain = |part: Component<'_>| matches!(part, Component::Normal(_));
    if !text.is_empty() && path.components().all(plain) && !text.contains(char::is_control) {
        return Ok(path.to_owned());
    }
    Err(Error::invalid(key, text, INSIDE))
}

/// A package of a submission that was looked at.
#[derive(Debug)]
pub struct CheckedPackage {
    /// Folder of the package, as declared.
    pub name: String,
    /// The experiment.
    pub experiment: String,
    /// Runs of the package.
    pub runs: usize,
    /// Files that do not follow from its results.
    pub changed: Vec<String>,
    /// Runs that were computed once more.
    pub reruns: Vec<Rerun>,
    /// Its `runs.csv` as it was before the first of these runs: the program may write to what lies on the disk.
    runs_csv: Vec<u8>,
    /// Options of each row of the scheme, on cases that nothing was tuned on, with the run that has them.
    options: BTreeMap<String, (Vec<String>, String)>,
}

impl CheckedPackage {
    /// Whether runs came out again, all of them, and every file follows from the results.
    pub fn holds(&self) -> bool {
        self.changed.is_empty() && !self.reruns.is_empty() && self.reruns.iter().all(|rerun| rerun.differing.is_empty())
    }
}

/// With what a submission is checked.
#[derive(Debug, Clone, Copy)]
pub struct Workplace<'a> {
    /// With the scheme in it.
    pub catalogue: &'a Catalogue,
    /// A folder of its own, empty.
    pub scratch: &'a Path,
    /// Where references are kept.
    pub cache: &'a Cache,
    /// What the program was built from.
    pub build: &'a BuildInfo,
}

/// Options of the rows of a package that are the scheme's, by label, each with the run that has them, on cases that nothing was tuned on.
/// `earlier` are the packages before.
///
/// # Errors
/// [`Error::Incompatible`] for a label that has one value of an option in one run and another in another: it would be several schemes,
/// each where it is best.
fn options_of(
    package: &Package,
    (name, declaration): (&str, &Declaration),
    earlier: &[CheckedPackage],
) -> Result<BTreeMap<String, (Vec<String>, String)>> {
    let (header, laws) = (plan_header(&package.planned), tries_friction_laws(&package.planned));
    let places = OPTIONS.map(|option| header.iter().position(|column| *column == option));
    let tuned_on = declaration.tuned_on();
    let mut found: BTreeMap<String, (Vec<String>, String)> = BTreeMap::new();
    for run in &package.planned {
        if run.spec.scheme.name != declaration.name || tuned_on.contains(&*run.spec.case.name) {
            continue;
        }
        let cells = plan_cells(run, laws);
        let own: Vec<String> = places.map(|place| place.map_or_else(String::new, |place| cells[place].clone())).into();
        let here = format!("{name}, {}", run.spec.case.name);
        let before = earlier.iter().map(|package| &package.options).chain([&found]);
        for (options, there) in before.filter_map(|options| options.get(&run.label)) {
            if let Some((option, was, is)) = first_differing(options, &own) {
                return Err(Error::Incompatible(format!(
                    "row `{}` has {option} = `{was}` in {there} and `{is}` in {here}: give each a label, or declare as [[tuned]] what \
                     was chosen for that case",
                    run.label
                )));
            }
        }
        found.entry(run.label.clone()).or_insert((own, here));
    }
    Ok(found)
}

/// Checks a package of a submission: its files, what is declared of it, and a sample of the scheme's own runs, chosen by a seed. `earlier`
/// are its packages that were checked before.
///
/// # Errors
/// Those of [`Package::read`], [`Package::unpack`] and [`rerun_sample`]; what is declared and is not so.
pub fn check_package(
    (folder, name): (&Path, &str),
    declaration: &Declaration,
    Workplace { catalogue, scratch, cache, build }: Workplace<'_>,
    (sample, seed): (usize, u64),
    earlier: &[CheckedPackage],
    stop: StopFlag<'_>,
) -> Result<CheckedPackage> {
    let place = folder.join(name);
    if !place.join(DESCRIPTION).is_file() {
        return Err(Error::file(place, format!("is no data package: it holds no {DESCRIPTION}")));
    }
    let package = Package::read(&place, catalogue)?;
    declaration.check_package(&package).map_err(|error| Error::file(&place, error))?;
    let options = options_of(&package, (name, declaration), earlier).map_err(|error| Error::file(&place, error))?;
    // It becomes the name of a folder.
    let experiment = package.experiment.name();
    inside("rimbench.experiment", &experiment).map_err(|error| Error::file(place.join(DESCRIPTION), error))?;
    let [results, anew, again] = ["results", "anew", "again"].map(|part| scratch.join(name).join(part));
    package.unpack_named(catalogue, &results)?;
    let table = results.join("runs.csv");
    let read = || std::fs::read(&table).map_err(|error| Error::file(&table, format!("cannot be read: {error}")));
    let runs_csv = read()?;
    let changed = package.not_as_exported(catalogue, &results, &anew)?;
    let job = Job { quick: package.quick, ..Job::new(&package.experiment, catalogue, &again, cache, build) };
    // Rows of other schemes are no matter of the submission.
    let own = |run: &PlannedRun| run.spec.scheme.name == declaration.name;
    let reruns = rerun_sample(job, &package.planned, own, &results, (sample, seed), stop)?;
    // What was held against the runs is what is kept.
    if read()? != runs_csv {
        return Err(Error::file(
            table,
            "has been changed while its runs were computed: by the program, if by nobody else",
        ));
    }
    Ok(CheckedPackage {
        name: name.to_owned(),
        experiment,
        runs: package.planned.len(),
        changed,
        reruns,
        runs_csv,
        options,
    })
}

/// Puts what was checked where the ranking finds it: `<folder>/<name of the scheme>`, which must not be there yet.
///
/// # Errors
/// [`Error::File`].
pub fn accept(declaration: &Declaration, checked: &[CheckedPackage], seed: u64, folder: &Path) -> Result<PathBuf> {
    let out = folder.join(&declaration.name);
    if out.exists() {
        return Err(Error::file(
            &out,
            "is there already: move it away, so that nobody's rows are replaced without a word",
        ));
    }
    for (index, package) in checked.iter().enumerate() {
        if checked[..index].iter().any(|earlier| earlier.experiment == package.experiment) {
            let message = format!("would hold two packages of the experiment `{}`: give it one", package.experiment);
            return Err(Error::file(&out, message));
        }
    }
    make_folder(&out)?;
    let mut names = vec![DECLARATION.to_owned(), CHECK.to_owned()];
    // Nothing is read again: since the program was started, what lies on the disk may be its work.
    write_atomically(&out.join(DECLARATION), |file| file.write_all(declaration.text.as_bytes()))?;
    for package in checked {
        make_folder(&out.join(&package.experiment))?;
        let name = format!("{}/runs.csv", package.experiment);
        write_atomically(&out.join(&name), |file| file.write_all(&package.runs_csv))?;
        names.push(name);
    }
    write_atomically(&out.join(CHECK), |file| {
        writeln!(file, "experiment,run_id,label,macro_step_s,{NUMERICS},seed,equal")?;
        for package in checked {
            for Rerun { run_id, label, macro_step_s, differing } in &package.reruns {
                let row = super::results::row(&[&package.experiment, run_id, label]);
                writeln!(file, "{row},{macro_step_s:?},{NUMERICS_VERSION},{seed},{}", differing.is_empty())?;
            }
        }
        Ok(())
    })?;
    // Written last: what lacks it is not believed.
    checksums::write(&out, names)?;
    Ok(out)
}

/// A submission that was checked: what the ranking takes of it.
#[derive(Debug)]
pub struct Accepted {
    /// Name of the scheme.
    pub name: String,
    information: InformationClass,
    tuned_on: BTreeSet<String>,
    /// Version of the numerics that it was checked by; none if nobody wrote it down.
    pub(super) numerics: Option<String>,
    /// Its runs, and those of other schemes beside them.
    pub runs: Vec<ResultsTable>,
}

impl Accepted {
    /// Reads all submissions in a folder; none if it is not there.
    ///
    /// # Errors
    /// [`Error::File`] for one that is not as it was accepted.
    pub fn read_all(folder: &Path, catalogue: &Catalogue) -> Result<Vec<Self>> {
        let entries = std::fs::read_dir(folder).into_iter().flatten();
        let mut places: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
        places.retain(|place| place.join(DECLARATION).is_file());
        places.sort();
        places.iter().map(|place| Self::read(place, catalogue)).collect()
    }

    fn read(folder: &Path, catalogue: &Catalogue) -> Result<Self> {
        checksums::verify_with(folder, DECLARATION, "check the submission again")?;
        let declaration = Declaration::read(folder, catalogue)?;
        let files = checksums::read(folder)?.unwrap_or_default();
        let tables = files.keys().filter(|name| name.ends_with("/runs.csv"));
        let runs = tables.map(|name| ResultsTable::read(&folder.join(name))).collect::<Result<Vec<_>>>()?;
        let tuned_on = declaration.tuned_on();
        let check = ResultsTable::read(&folder.join(CHECK))?;
        let version = |row: usize, column: usize| check.text(row, column).to_owned();
        let numerics = check.column(NUMERICS).ok().filter(|_| !check.is_empty()).map(|column| version(0, column));
        Ok(Accepted { name: declaration.name, information: declaration.information, tuned_on, numerics, runs })
    }

    /// Class and tuning of a run; none if it is of another scheme.
    ///
    /// # Errors
    /// [`Error::File`] for a table without the columns.
    pub(super) fn entry(
        &self,
        runs: &ResultsTable,
        row: usize,
    ) -> Result<Option<(InformationClass, BTreeSet<String>)>> {
        if runs.text(row, runs.column("scheme")?) != self.name {
            return Ok(None);
        }
        Ok(Some((class_of_run(self.information, runs, row)?, self.tuned_on.clone())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
name = "mine"
about = "Holds, but better"
authors = ["Doe, Jane"]
licence = "MIT"
information = "samples"
scheme = "scheme.toml"
packages = ["package"]

[[tuned]]
what = "the share of a new sample"
cases = ["wedge-box"]
"#;

    fn parsed(text: &str) -> Result<Declaration> {
        Declaration::parse(Path::new("submission.toml"), text, &Catalogue::standard())
    }

    #[test]
    fn what_is_wrong_with_a_declaration_is_said_with_what_would_be_valid() {
        let good = parsed(GOOD).unwrap();
        assert_eq!(good.tuned_on(), BTreeSet::from(["wedge-box".to_owned()]));
        for (from, to, wanted) in [
            (
                "name = \"mine\"",
                "name = \"nepce\"",
                "name of the scheme = `nepce` is not valid; valid: a name that is not taken yet",
            ),
            ("name = \"mine\"", "name = \"../mine\"", "kebab-case"),
            ("name = \"mine\"", "nam = \"mine\"", "unknown field `nam`"),
            ("Holds, but better", "", "about = "),
            ("[\"Doe, Jane\"]", "[]", "author = "),
            ("\"MIT\"", "\"do what you like\"", "license = "),
            ("\"samples\"", "\"sample\"", "unknown class of information `sample` (did you mean `samples`?)"),
            (
                "\"scheme.toml\"",
                "\"../scheme.toml\"",
                "scheme = ../scheme.toml is not valid; valid: a path below the folder",
            ),
            ("\"scheme.toml\"", "\"/etc/passwd\"", "scheme = /etc/passwd"),
            ("[\"package\"]", "[]", "packages = []"),
            ("[\"package\"]", "[\"p\", \"p\"]", "each folder once"),
            ("[\"package\"]", "[\"..\"]", "packages = .."),
            ("[\"wedge-box\"]", "[]", "tuned.cases = []"),
            ("[\"wedge-box\"]", "[\"wedge-bx\"]", "did you mean `wedge-box`"),
            ("the share of a new sample", "", "tuned.what"),
        ] {
            let said = parsed(&GOOD.replace(from, to)).unwrap_err().to_string();
            assert!(said.starts_with("submission.toml: ") && said.contains(wanted), "{wanted}: {said}");
        }
    }

    #[test]
    fn a_program_that_wants_to_be_waited_for_is_not_started() {
        let (folder, declaration) = (tempfile::tempdir().unwrap(), parsed(GOOD).unwrap());
        let check = |text: &str| {
            std::fs::write(folder.path().join("scheme.toml"), text).unwrap();
            declaration.check_patience(folder.path()).map_err(|error| error.to_string())
        };
        for text in ["", "no toml", "answer_within_s = 60", "answer_within_s = 0.5", "answer_within_s = \"long\""] {
            assert_eq!(check(text), Ok(()), "{text}");
        }
        for text in ["answer_within_s = 61", "answer_within_s = 1e9", "answer_within_s = inf", "answer_within_s = nan"]
        {
            let said = check(text).unwrap_err();
            assert!(said.contains("scheme.toml: answer_within_s = ") && said.contains("at most 60 s"), "{said}");
        }
        std::fs::remove_file(folder.path().join("scheme.toml")).unwrap();
        assert!(declaration.check_patience(folder.path()).unwrap_err().to_string().contains("cannot be read"));
    }

    #[cfg(unix)]
    #[test]
    fn a_submission_all_of_which_is_not_in_its_folder_is_refused_links_followed() {
        use std::os::unix::fs::symlink;
        let (above, declaration) = (tempfile::tempdir().unwrap(), parsed(GOOD).unwrap());
        let folder = above.path().join("mine");
        std::fs::create_dir_all(folder.join("package")).unwrap();
        for name in ["mine/lines.py", "mine/submission.toml", "elsewhere.py"] {
            std::fs::write(above.path().join(name), "").unwrap();
        }
        symlink("../elsewhere.py", folder.join("linked.py")).unwrap();
        let check = |text: &str| {
            std::fs::write(folder.join("scheme.toml"), text).unwrap();
            declaration.check_places(&folder).map_err(|error| error.to_string())
        };
        for text in [
            "",
            "command = [\"python3\", \"lines.py\", \"module:Class\", \"--rate=1/2\"]\nfiles = [\"lines.py\"]",
            "command = [\"./lines.py\"]",
            "command = [\"python3\"]\nfiles = [\"is-not-there.py\"]",
        ] {
            assert_eq!(check(text), Ok(()), "{text}");
        }
        for text in [
            "command = [\"python3\", \"../elsewhere.py\"]",
            "command = [\"python3\", \"linked.py\"]",
            "command = [\"python3\", \"/no/such/file.py\"]",
            "command = [\"python3\", \"--from=../elsewhere.py\"]",
            "files = [\"../elsewhere.py\"]",
            "files = [\"linked.py\"]",
            "files = [\"/etc/hostname\"]",
        ] {
            let said = check(text).unwrap_err();
            let key = text.split(' ').next().unwrap();
            let wanted = format!("scheme.toml: {key} = ");
            assert!(said.contains(&wanted) && said.contains("below the folder of the submission"), "{text}: {said}");
        }
        check("").unwrap();
        std::fs::remove_dir(folder.join("package")).unwrap();
        symlink("..", folder.join("package")).unwrap();
        let said = check("").unwrap_err();
        assert!(said.contains("submission.toml: packages = package is not valid"), "{said}");
    }

    /// Whatever is done to the files after they were read and checked.
    #[test]
    fn what_is_accepted_is_what_was_checked_and_says_which_numerics_computed_it() {
        let (folder, declaration) = (tempfile::tempdir().unwrap(), parsed(GOOD).unwrap());
        let package = CheckedPackage {
            name: "package".into(),
            experiment: "sweep".into(),
            runs: 1,
            changed: Vec::new(),
            reruns: vec![Rerun { run_id: "a".into(), label: "mine".into(), macro_step_s: 1e-3, differing: Vec::new() }],
            runs_csv: b"run_id,scheme\na,mine\n".to_vec(),
            options: BTreeMap::new(),
        };
        let out = accept(&declaration, &[package], 5, folder.path()).unwrap();
        assert_eq!(std::fs::read_to_string(out.join(DECLARATION)).unwrap(), GOOD);
        assert_eq!(std::fs::read(out.join("sweep/runs.csv")).unwrap(), b"run_id,scheme\na,mine\n");
        let accepted = Accepted::read_all(folder.path(), &Catalogue::standard()).unwrap();
        assert_eq!(accepted.len(), 1);
        assert_eq!(accepted[0].numerics, Some(NUMERICS_VERSION.to_string()));
        // One whose checksums were not written was not whole.
        std::fs::remove_file(out.join(checksums::CHECKSUMS)).unwrap();
        assert!(Accepted::read_all(folder.path(), &Catalogue::standard()).is_err());
    }

    #[test]
    fn a_scheme_that_asks_for_more_than_is_declared_is_refused_and_one_that_asks_for_less_is_not() {
        let catalogue = Catalogue::standard();
        let named = |scheme: &str| SchemeEntry { name: "mine".into(), ..(**catalogue.scheme(scheme).unwrap()).clone() };
        let declared = |class: &str| parsed(&GOOD.replace("samples", class)).unwrap();
        declared("samples").check_scheme(&named("zero-order-hold")).unwrap();
        declared("model").check_scheme(&named("zero-order-hold")).unwrap();
        declared("model").check_scheme(&named("rim-nonsmooth")).unwrap();
        let said = declared("samples").check_scheme(&named("rim-nonsmooth")).unwrap_err().to_string();
        assert!(said.contains("information = samples") && said.contains("`model`"), "{said}");
        let said = declared("model").check_scheme(&named("iterated-aitken")).unwrap_err().to_string();
        assert!(said.contains("`repetition`"), "{said}");
        let other = catalogue.scheme("nepce").unwrap();
        assert!(declared("samples").check_scheme(other).unwrap_err().to_string().contains("called `nepce`"));
    }
}
