//! What a program can run, by name: cases, schemes, solvers.

use crate::is_taken;
use rimbench_cases::cases::{Case, standard_cases};
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
    /// How many of the cases, schemes and solvers are built in: the first ones.
    built_in: [usize; 3],
    case_files: Option<Arc<OfFiles<PathBuf, Case>>>,
    scheme_files: Option<Arc<OfFiles<SchemeFile, SchemeEntry>>>,
}

/// What makes something of a file.
type Read<K, T> = dyn Fn(&K) -> Result<T> + Send + Sync;

/// What files make, each read once.
struct OfFiles<K, T> {
    read: Box<Read<K, T>>,
    known: Mutex<BTreeMap<(PathBuf, String), Arc<T>>>,
}

impl<K, T> OfFiles<K, T> {
    fn read_by(read: impl Fn(&K) -> Result<T> + Send + Sync + 'static) -> Option<Arc<Self>> {
        Some(Arc::new(OfFiles { read: Box::new(read), known: Mutex::default() }))
    }

    /// What is made of `file`, of which `path` and `part` tell it from others.
    fn find(&self, file: &K, path: &Path, part: &str) -> Result<Arc<T>> {
        let place = (path.canonicalize().unwrap_or_else(|_| path.to_owned()), part.to_owned());
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(made) = known.get(&place) {
            return Ok(made.clone());
        }
        let made = Arc::new((self.read)(file)?);
        known.insert(place, made.clone());
        Ok(made)
    }
}

impl<K, T> fmt::Debug for OfFiles<K, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OfFiles").finish_non_exhaustive()
    }
}

/// A scheme that is a class in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct SchemeFile {
    /// The file.
    pub path: PathBuf,
    /// The class.
    pub class: String,
    /// How the scheme is called.
    pub name: String,
    /// After so long without an answer its process is ended, s.
    pub answer_within_s: f64,
}

impl SchemeFile {
    /// Names a class, whose scheme is called as it is, `MidHold` mid-hold.
    pub fn new(path: impl Into<PathBuf>, class: impl Into<String>) -> Self {
        let class = class.into();
        let mut name = String::with_capacity(class.len() + 4);
        let mut before = '_';
        for letter in class.chars() {
            if letter.is_uppercase() && !before.is_uppercase() && before != '_' {
                name.push('-');
            }
            name.extend(letter.to_lowercase().map(|letter| if letter == '_' { '-' } else { letter }));
            before = letter;
        }
        let name = name.trim_matches('-').to_owned();
        SchemeFile { path: path.into(), class, name, answer_within_s: 60.0 }
    }

    /// Reads `mine.py:MidHold`; none for what is no such thing.
    pub fn parse(text: &str) -> Option<Self> {
        let (path, class) = text.rsplit_once(':')?;
        path.ends_with(".py").then(|| SchemeFile::new(path, class))
    }
}

impl Catalogue {
    /// Makes a catalogue of everything that is built in.
    pub fn standard() -> Self {
        let cases: Vec<_> = standard_cases().into_iter().map(Arc::new).collect();
        let schemes: Vec<_> = standard_schemes().into_iter().map(Arc::new).collect();
        let solvers: Vec<_> = standard_solvers().into_iter().map(Arc::new).collect();
        Catalogue {
            built_in: [cases.len(), schemes.len(), solvers.len()],
            cases,
            schemes,
            solvers,
            ..Catalogue::default()
        }
    }

    /// Tells whether anything was added to what is built in.
    pub fn has_added(&self) -> bool {
        self.built_in != [self.cases.len(), self.schemes.len(), self.solvers.len()]
    }

    /// Says from which code everything is made that was added and says nothing of it.
    pub fn say_code(&mut self, digest: &str) {
        let own = |said: &mut Option<Name>| {
            said.get_or_insert_with(|| digest.to_owned().into());
        };
        let [cases, schemes, solvers] = self.built_in;
        self.cases[cases..].iter_mut().for_each(|case| own(&mut Arc::make_mut(case).digest));
        self.schemes[schemes..].iter_mut().for_each(|scheme| own(&mut Arc::make_mut(scheme).digest));
        self.solvers[solvers..].iter_mut().for_each(|solver| own(&mut Arc::make_mut(solver).digest));
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
    pub fn read_cases_by(&mut self, read: impl Fn(&PathBuf) -> Result<Case> + Send + Sync + 'static) {
        self.case_files = OfFiles::read_by(read);
    }

    /// Sets what makes a scheme of a class in a file, for [`add_scheme_of_file`](Self::add_scheme_of_file).
    pub fn read_schemes_by(&mut self, read: impl Fn(&SchemeFile) -> Result<SchemeEntry> + Send + Sync + 'static) {
        self.scheme_files = OfFiles::read_by(read);
    }

    /// Finds the case that a file makes, which is read once; one that was added by the same name must be the same.
    ///
    /// # Errors
    /// Those of what reads it; [`Error::File`] where nothing reads files; [`Error::InvalidValue`] for a name that is
    /// taken by another case.
    pub fn case_of_file(&self, path: &Path) -> Result<Arc<Case>> {
        let files = self.case_files.as_ref();
        let files = files.ok_or_else(|| Error::file(path, "is a case file, and nothing here reads those"))?;
        let case = files.find(&path.to_owned(), path, "")?;
        let others = self.cases.iter().filter(|other| other.parameters != case.parameters);
        check_new_name("case", &case.name, others.map(|known| &*known.name))?;
        Ok(case)
    }

    /// Adds the scheme that a class in a file makes, which is read once; one that is there by the same name must be of
    /// the same code.
    ///
    /// # Errors
    /// Those of what reads it; [`Error::File`] where nothing reads files, and for a name that is not kebab-case or taken
    /// by another scheme.
    pub fn add_scheme_of_file(&mut self, file: &SchemeFile) -> Result<()> {
        let SchemeFile { path, class, name, answer_within_s } = file;
        let others = self.schemes.iter().filter(|known| known.digest.is_none());
        check_new_name("scheme", name, others.map(|known| &*known.name)).map_err(|error| Error::file(path, error))?;
        let files = self.scheme_files.as_ref();
        let files = files.ok_or_else(|| Error::file(path, "is a scheme in Python, and nothing here reads those"))?;
        let scheme = files.find(file, path, &format!("{class} {name} {answer_within_s}"))?;
        match self.scheme(name) {
            Ok(known) if known.digest == scheme.digest => Ok(()),
            Ok(_) => check_new_name("scheme", name, [&**name].into_iter()).map_err(|error| Error::file(path, error)),
            Err(_) => {
                self.schemes.push(scheme);
                Ok(())
            }
        }
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
    use crate::RunRequest;
    use rimbench_cases::cases::CaseDefaults;
    use rimbench_cases::parameter::{Parameter, Range};

    /// Ids of what is built in know nothing of code that was added.
    #[test]
    fn other_code_of_what_was_added_makes_other_runs_and_of_what_is_built_in_none() {
        let id = |scheme: &str, case: &str, digest: Option<&str>| {
            let mut catalogue = Catalogue::standard();
            let hold = SchemeEntry::clone(catalogue.scheme("zero-order-hold").unwrap());
            let ball = Case::clone(catalogue.case("bouncing-ball").unwrap());
            catalogue.add_scheme(SchemeEntry { name: "mine".into(), ..hold }).unwrap();
            catalogue.add_case(Case { name: "own".into(), ..ball }).unwrap();
            digest.into_iter().for_each(|digest| catalogue.say_code(digest));
            RunRequest::of(case, scheme).resolve(&catalogue).unwrap().id()
        };
        for (scheme, case) in [("mine", "bouncing-ball"), ("zero-order-hold", "own")] {
            let ids = [None, Some("1"), Some("2")].map(|digest| id(scheme, case, digest));
            assert!(ids[0] != ids[1] && ids[1] != ids[2] && ids[0] != ids[2], "{ids:?}");
            assert_eq!(ids[1], id(scheme, case, Some("1")));
        }
        let built_in = id("zero-order-hold", "bouncing-ball", Some("1"));
        let of_standard = RunRequest::of("bouncing-ball", "zero-order-hold").resolve(&Catalogue::standard());
        assert_eq!(built_in, of_standard.unwrap().id());
        assert!(!Catalogue::standard().has_added());
    }

    #[test]
    fn a_class_gives_its_scheme_a_name() {
        for (class, name) in
            [("MidHold", "mid-hold"), ("RIMScheme", "rimscheme"), ("hold_2", "hold-2"), ("_Own", "own")]
        {
            assert_eq!(SchemeFile::new("mine.py", class).name, name);
        }
        assert!(SchemeFile::parse("mine.toml:A").is_none() && SchemeFile::parse("mine.py").is_none());
        assert_eq!(SchemeFile::parse("C:\\x y.py:A").unwrap().path, Path::new("C:\\x y.py"));
    }

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
