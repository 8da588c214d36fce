//! What was checked, put where the ranking finds it, and read there.

use super::check::CheckedPackage;
use super::declaration::{DECLARATION, Declaration};
use crate::files::make_folder;
use crate::package::Rerun;
use crate::ranking::class_of_run;
use crate::results::row;
use rimbench_cases::catalogue::Catalogue;
use rimbench_core::error::{Error, Result};
use rimbench_core::numerics_version::NUMERICS_VERSION;
use rimbench_core::schemes::InformationClass;
use rimbench_results::atomic_file::write_atomically;
use rimbench_results::checksums;
use rimbench_results::results_table::ResultsTable;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Name of the table of what was computed once more.
const CHECK: &str = "check.csv";

/// Its column of the version of the numerics that computed.
const NUMERICS: &str = "numerics_version";

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
                let row = row(&[&package.experiment, run_id, label]);
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
    pub(crate) numerics: Option<String>,
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
    pub(crate) fn entry(
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
    use super::super::sample::{GOOD, parsed};
    use super::*;
    use std::collections::BTreeMap;

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
}
