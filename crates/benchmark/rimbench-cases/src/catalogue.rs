//! What a program can run, by name: cases, schemes, solvers.

use crate::cases::{Case, standard_cases};
use crate::runs::is_taken;
use rimbench_core::error::{Error, Result};
use rimbench_core::name::{Name, check_new_name, find_by_name};
use rimbench_core::schemes::{SchemeEntry, standard_schemes};
use rimbench_core::solver_entry::{SolverEntry, standard_solvers};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Cases, schemes and solvers by name. A value: whoever wants to run something of their own makes one, adds to it, and
/// hands it to whatever looks names up.
#[derive(Debug, Clone, Default)]
pub struct Catalogue {
    cases: Vec<Arc<Case>>,
    schemes: Vec<Arc<SchemeEntry>>,
    solvers: Vec<Arc<SolverEntry>>,
    files: Option<Arc<CaseFiles>>,
}

/// What makes a case of a file.
type ReadCase = Box<dyn Fn(&Path) -> Result<Case> + Send + Sync>;

/// Cases of files, each read once.
struct CaseFiles {
    read: ReadCase,
    known: Mutex<BTreeMap<PathBuf, Arc<Case>>>,
}

impl fmt::Debug for CaseFiles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("CaseFiles").field(&self.known).finish()
    }
}

impl Catalogue {
    /// Makes a catalogue of everything that is built in.
    pub fn standard() -> Self {
        Catalogue {
            cases: standard_cases().into_iter().map(Arc::new).collect(),
            schemes: standard_schemes().into_iter().map(Arc::new).collect(),
            solvers: standard_solvers().into_iter().map(Arc::new).collect(),
            files: None,
        }
    }

    /// Returns all cases, in the order in which they were added.
    pub fn cases(&self) -> &[Arc<Case>] {
        &self.cases
    }

    /// Returns all schemes, likewise.
    pub fn schemes(&self) -> &[Arc<SchemeEntry>] {
        &self.schemes
    }

    /// Returns all solvers, likewise.
    pub fn solvers(&self) -> &[Arc<SolverEntry>] {
        &self.solvers
    }

    /// Finds a case.
    ///
    /// # Errors
    /// [`Error::UnknownName`] with all names.
    pub fn case(&self, name: &str) -> Result<&Arc<Case>> {
        find_by_name("case", &self.cases, |case| &case.name, name)
    }

    /// Finds a scheme.
    ///
    /// # Errors
    /// [`Error::UnknownName`] with all names.
    pub fn scheme(&self, name: &str) -> Result<&Arc<SchemeEntry>> {
        find_by_name("scheme", &self.schemes, |scheme| &scheme.name, name)
    }

    /// Finds a solver.
    ///
    /// # Errors
    /// [`Error::UnknownName`] with all names.
    pub fn solver(&self, name: &str) -> Result<&Arc<SolverEntry>> {
        find_by_name("solver", &self.solvers, |solver| &solver.name, name)
    }

    /// Adds a case.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for a name that is not kebab-case or already taken, and for a parameter whose name
    /// another one, an option of a run or a column of results has.
    pub fn add_case(&mut self, case: Case) -> Result<()> {
        check_new_name("case", &case.name, self.cases.iter().map(|known| &*known.name))?;
        for (index, parameter) in case.parameters.iter().enumerate() {
            let name = &parameter.name;
            if is_taken(name) || case.parameters[..index].iter().any(|earlier| earlier.name == *name) {
                let expected = "a name that no other parameter, no option of a run and no column of results has";
                return Err(Error::invalid(format!("parameter of {}", case.name), name, expected));
            }
        }
        self.cases.push(Arc::new(case));
        Ok(())
    }

    /// Sets what makes a case of a file, for [`case_of_file`](Self::case_of_file).
    pub fn read_files_by(&mut self, read: impl Fn(&Path) -> Result<Case> + Send + Sync + 'static) {
        self.files = Some(Arc::new(CaseFiles { read: Box::new(read), known: Mutex::default() }));
    }

    /// Finds the case that a file makes, which is read once; one that was added by the same name must be the same.
    ///
    /// # Errors
    /// Those of what reads it; [`Error::File`] where nothing reads files; [`Error::InvalidValue`] for a name that is
    /// taken by another case.
    pub fn case_of_file(&self, path: &Path) -> Result<Arc<Case>> {
        let files =
            self.files.as_ref().ok_or_else(|| Error::file(path, "is a case file, and nothing here reads those"))?;
        let place = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let mut known = files.known.lock().unwrap_or_else(PoisonError::into_inner);
        let case = match known.get(&place) {
            Some(case) => case.clone(),
            None => {
                let case = Arc::new((files.read)(path)?);
                known.insert(place, case.clone());
                case
            }
        };
        let others = self.cases.iter().filter(|other| other.parameters != case.parameters);
        check_new_name("case", &case.name, others.map(|known| &*known.name))?;
        Ok(case)
    }

    /// Adds a scheme.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for a name that is not kebab-case or already taken, or a gain whose default is out of
    /// its range.
    pub fn add_scheme(&mut self, scheme: SchemeEntry) -> Result<()> {
        check_new_name("scheme", &scheme.name, self.schemes.iter().map(|known| &*known.name))?;
        if let Some(gain) = &scheme.gain
            && !(gain.range[0]..=gain.range[1]).contains(&gain.default)
        {
            let expected = format!("a number from {} to {}", gain.range[0], gain.range[1]);
            return Err(Error::invalid(format!("default gain of {}", scheme.name), gain.default, expected));
        }
        self.schemes.push(Arc::new(scheme));
        Ok(())
    }

    /// Adds a solver.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for a name that is not kebab-case or already taken.
    pub fn add_solver(&mut self, solver: SolverEntry) -> Result<()> {
        check_new_name("solver", &solver.name, self.solvers.iter().map(|known| &*known.name))?;
        self.solvers.push(Arc::new(solver));
        Ok(())
    }

    /// Schemes that have a gain.
    pub(crate) fn tunable_schemes(&self) -> Vec<Name> {
        self.schemes.iter().filter(|scheme| scheme.gain.is_some()).map(|scheme| scheme.name.clone()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::{CaseDefaults, Parameter, Range};

    /// In JSON and from Python a name is said once.
    #[test]
    fn a_parameter_has_a_name_of_its_own() {
        let known = Catalogue::standard().cases()[0].clone();
        let case = |names: &[&str]| {
            let parameter = |name: &&str| Parameter::number((*name).to_owned(), "-", 1.0, Range::Finite, "", "");
            let build = known.build.clone();
            let defaults: CaseDefaults = known.defaults;
            let parameters = names.iter().map(parameter).collect();
            Case::with_parameters("own", "", defaults, parameters, move |parameters, solver| build(parameters, solver))
        };
        let add = |names: &[&str]| Catalogue::standard().add_case(case(names));
        assert!(add(&["stiffness_n_m", "mass_kg"]).is_ok());
        for names in [["mass_kg", "phase"], ["mass_kg", "outcome"], ["mass_kg", "exchanges"], ["mass_kg", "mass_kg"]] {
            let message = add(&names).unwrap_err().to_string();
            assert!(message.contains(&format!("parameter of own = {}", names[1])), "{message}");
        }
        for case in Catalogue::standard().cases() {
            for parameter in &case.parameters {
                assert!(!is_taken(&parameter.name), "{} of {}", parameter.name, case.name);
            }
        }
    }
}
