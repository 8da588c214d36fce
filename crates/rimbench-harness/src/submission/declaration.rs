//! What a submission declares, and what of a scheme and its packages is held against that.

use super::places::inside;
use crate::files::read_text;
use crate::package::{Citation, Package};
use rimbench_cases::catalogue::Catalogue;
use rimbench_core::error::{Error, Result, said_at};
use rimbench_core::name::check_new_name;
use rimbench_core::schemes::{InformationClass, SchemeEntry};
use serde::Deserialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Name of the declaration.
pub const DECLARATION: &str = "submission.toml";

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
    pub(super) text: String,
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
    pub(super) fn check_package(&self, package: &Package) -> Result<()> {
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

#[cfg(test)]
mod tests {
    use super::super::sample::{GOOD, parsed};
    use super::*;

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
