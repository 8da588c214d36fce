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
use super::package::{Citation, DESCRIPTION, Package, Rerun, rerun_sample};
use super::ranking::class_of_run;
use rimbench_cases::catalogue::Catalogue;
use rimbench_core::cosim::StopFlag;
use rimbench_core::error::{Error, Result, said_at};
use rimbench_core::name::check_new_name;
use rimbench_core::schemes::{InformationClass, SchemeEntry};
use rimbench_results::atomic_file::write_atomically;
use rimbench_results::checksums;
use rimbench_results::results_table::ResultsTable;
use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

/// Name of the declaration.
pub const DECLARATION: &str = "submission.toml";

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
}

impl Declaration {
    /// Reads the declaration of a submission.
    ///
    /// # Errors
    /// Those of [`parse`](Self::parse).
    pub fn read(folder: &Path, catalogue: &Catalogue) -> Result<Self> {
        let path = folder.join(DECLARATION);
        let text =
            std::fs::read_to_string(&path).map_err(|error| Error::file(&path, format!("cannot be read: {error}")))?;
        Self::parse(&path, &text, catalogue)
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
        Self::checked(raw, catalogue).map_err(|error| Error::file(path, error))
    }

    fn checked(raw: Raw, catalogue: &Catalogue) -> Result<Self> {
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
        Ok(Declaration { name, about, authors, licence, information, scheme, packages, tuned })
    }

    /// Cases that something was tuned on.
    pub fn tuned_on(&self) -> BTreeSet<String> {
        self.tuned.iter().flat_map(|tuned| tuned.cases.iter().cloned()).collect()
    }

    /// Looks at how long the program may take for an answer, before it is started: nobody is kept waiting for longer than
    /// [`LONGEST_ANSWER_S`].
    ///
    /// # Errors
    /// [`Error::File`] naming the scheme file. What else is wrong with it is for its reader to say.
    pub fn check_patience(&self, folder: &Path) -> Result<()> {
        let path = folder.join(&self.scheme);
        let text =
            std::fs::read_to_string(&path).map_err(|error| Error::file(&path, format!("cannot be read: {error}")))?;
        let file: toml::Table = toml::from_str(&text).unwrap_or_default();
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

/// A path that does not lead out of the folder.
fn inside(key: &str, text: &str) -> Result<PathBuf> {
    let path = Path::new(text);
    let plain = |part: Component<'_>| matches!(part, Component::Normal(_));
    if !text.is_empty() && path.components().all(plain) && !text.contains(char::is_control) {
        return Ok(path.to_owned());
    }
    Err(Error::invalid(key, text, "a path below the folder of the submission"))
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
    /// Where its results folder was unpacked to.
    pub results: PathBuf,
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

/// Checks a package of a submission: its files, what is declared of it, and a sample of the scheme's own runs, chosen by a seed.
///
/// # Errors
/// Those of [`Package::read`], [`Package::unpack`] and [`rerun_sample`]; what is declared and is not so.
pub fn check_package(
    (folder, name): (&Path, &str),
    declaration: &Declaration,
    Workplace { catalogue, scratch, cache, build }: Workplace<'_>,
    (sample, seed): (usize, u64),
    stop: StopFlag<'_>,
) -> Result<CheckedPackage> {
    let place = folder.join(name);
    if !place.join(DESCRIPTION).is_file() {
        return Err(Error::file(place, format!("is no data package: it holds no {DESCRIPTION}")));
    }
    let package = Package::read(&place, catalogue)?;
    declaration.check_package(&package).map_err(|error| Error::file(&place, error))?;
    let [results, anew, again] = ["results", "anew", "again"].map(|part| scratch.join(name).join(part));
    package.unpack_named(catalogue, &results)?;
    let changed = package.not_as_exported(catalogue, &results, &anew)?;
    let job = Job { quick: package.quick, ..Job::new(&package.experiment, catalogue, &again, cache, build) };
    // Rows of other schemes are no matter of the submission.
    let own = |run: &PlannedRun| run.spec.scheme.name == declaration.name;
    let reruns = rerun_sample(job, &package.planned, own, &results, (sample, seed), stop)?;
    Ok(CheckedPackage {
        name: name.to_owned(),
        experiment: package.experiment.name(),
        runs: package.planned.len(),
        changed,
        reruns,
        results,
    })
}

/// Puts what was checked where the ranking finds it: `<folder>/<name of the scheme>`, which must not be there yet.
///
/// # Errors
/// [`Error::File`].
pub fn accept(
    submission: &Path,
    declaration: &Declaration,
    checked: &[CheckedPackage],
    seed: u64,
    folder: &Path,
) -> Result<PathBuf> {
    let out = folder.join(&declaration.name);
    if out.exists() {
        return Err(Error::file(
            &out,
            "is there already: move it away, so that nobody's rows are replaced without a word",
        ));
    }
    // Whole or not at all: what is there is believed.
    let half = folder.join(format!(".{}", declaration.name));
    let wrong = |error: std::io::Error| Error::file(&out, format!("cannot be written: {error}"));
    let _ = std::fs::remove_dir_all(&half);
    std::fs::create_dir_all(&half).map_err(wrong)?;
    std::fs::copy(submission.join(DECLARATION), half.join(DECLARATION)).map_err(wrong)?;
    let mut names = vec![DECLARATION.to_owned(), "check.csv".to_owned()];
    for (index, package) in checked.iter().enumerate() {
        if checked[..index].iter().any(|earlier| earlier.experiment == package.experiment) {
            let message = format!("would hold two packages of the experiment `{}`: give it one", package.experiment);
            return Err(Error::file(&out, message));
        }
        let to = half.join(&package.experiment);
        std::fs::create_dir_all(&to).map_err(wrong)?;
        std::fs::copy(package.results.join("runs.csv"), to.join("runs.csv")).map_err(wrong)?;
        names.push(format!("{}/runs.csv", package.experiment));
    }
    write_atomically(&half.join("check.csv"), |file| {
        writeln!(file, "experiment,run_id,label,macro_step_s,seed,equal")?;
        for package in checked {
            for Rerun { run_id, label, macro_step_s, differing } in &package.reruns {
                let row = super::results::row(&[&package.experiment, run_id, label]);
                writeln!(file, "{row},{macro_step_s:?},{seed},{}", differing.is_empty())?;
            }
        }
        Ok(())
    })?;
    checksums::write(&half, names)?;
    std::fs::rename(&half, &out).map_err(wrong)?;
    Ok(out)
}

/// A submission that was checked: what the ranking takes of it.
#[derive(Debug)]
pub struct Accepted {
    /// Name of the scheme.
    pub name: String,
    information: InformationClass,
    tuned_on: BTreeSet<String>,
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
        Ok(Accepted { name: declaration.name, information: declaration.information, tuned_on, runs })
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
