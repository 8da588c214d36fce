//! A package of a submission: what is declared of it, and a sample of the scheme's own runs, computed once more.

use super::declaration::Declaration;
use super::places::inside;
use crate::build_info::BuildInfo;
use crate::cache::Cache;
use crate::execution::Job;
use crate::experiment::PlannedRun;
use crate::package::{DESCRIPTION, Package, Rerun, rerun_sample};
use crate::ranking::{OPTIONS, first_differing};
use crate::results::{plan_cells, plan_header, tries_friction_laws};
use rimbench_cases::catalogue::Catalogue;
use rimbench_core::cosim::StopFlag;
use rimbench_core::error::{Error, Result};
use std::collections::BTreeMap;
use std::path::Path;

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
    pub(super) runs_csv: Vec<u8>,
    /// Options of each row of the scheme, on cases that nothing was tuned on, with the run that has them.
    pub(super) options: BTreeMap<String, (Vec<String>, String)>,
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
