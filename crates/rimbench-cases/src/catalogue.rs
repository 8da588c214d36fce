//! What a program can run, by name: cases, schemes, solvers.

use crate::cases::{Case, standard_cases};
use rimbench_core::error::{Error, Result};
use rimbench_core::name::{Name, check_new_name, find_by_name};
use rimbench_core::schemes::{SchemeEntry, standard_schemes};
use rimbench_core::solver_entry::{SolverEntry, standard_solvers};
use std::sync::Arc;

/// Cases, schemes and solvers by name. A value: whoever wants to run something of their own makes one, adds to it, and hands it to
/// whatever looks names up.
#[derive(Debug, Clone, Default)]
pub struct Catalogue {
    cases: Vec<Arc<Case>>,
    schemes: Vec<Arc<SchemeEntry>>,
    solvers: Vec<Arc<SolverEntry>>,
}

impl Catalogue {
    /// Makes a catalogue of everything that is built in.
    pub fn standard() -> Self {
        Catalogue {
            cases: standard_cases().into_iter().map(Arc::new).collect(),
            schemes: standard_schemes().into_iter().map(Arc::new).collect(),
            solvers: standard_solvers().into_iter().map(Arc::new).collect(),
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
    /// [`Error::InvalidValue`] for a name that is not kebab-case or already taken.
    pub fn add_case(&mut self, case: Case) -> Result<()> {
        check_new_name("case", &case.name, self.cases.iter().map(|known| &*known.name))?;
        self.cases.push(Arc::new(case));
        Ok(())
    }

    /// Adds a scheme.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] for a name that is not kebab-case or already taken, or a gain whose default is out of its range.
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
    use rimbench_core::schemes::Gain;

    #[test]
    fn every_name_stands_once_and_is_found() {
        let catalogue = Catalogue::standard();
        let names: [Vec<&str>; 3] = [
            catalogue.cases().iter().map(|case| &*case.name).collect(),
            catalogue.schemes().iter().map(|scheme| &*scheme.name).collect(),
            catalogue.solvers().iter().map(|solver| &*solver.name).collect(),
        ];
        for list in names {
            for (index, name) in list.iter().enumerate() {
                assert!(check_new_name("entry", name, list[..index].iter().copied()).is_ok(), "{name}");
            }
        }
        let message = catalogue.case("wedge-bax").unwrap_err().to_string();
        assert!(message.contains("did you mean `wedge-box`"), "{message}");
    }

    #[test]
    fn what_is_added_is_found_and_what_cannot_be_is_refused() {
        let mut catalogue = Catalogue::standard();
        let mine = |name: String| SchemeEntry { name: name.into(), ..standard_schemes().swap_remove(0) };
        // A name made at run time, as a script would make it.
        catalogue.add_scheme(mine(format!("my-{}", "scheme"))).unwrap();
        assert_eq!(catalogue.scheme("my-scheme").unwrap().name, "my-scheme");
        assert!(catalogue.add_scheme(mine("my-scheme".to_owned())).unwrap_err().to_string().contains("not taken yet"));
        assert!(catalogue.add_scheme(mine("My Scheme".to_owned())).unwrap_err().to_string().contains("kebab-case"));
        let gain = Some(Gain { about: "".into(), default: 2.0, range: [0.0, 1.0] });
        let absurd = SchemeEntry { gain, ..mine("absurd".to_owned()) };
        assert!(catalogue.add_scheme(absurd).unwrap_err().to_string().contains("default gain of absurd"));
        // Another catalogue knows nothing of it.
        assert!(Catalogue::standard().scheme("my-scheme").is_err());
    }
}
