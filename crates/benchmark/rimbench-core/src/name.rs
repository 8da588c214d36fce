//! Names in data: of schemes, solvers, cases, ports, columns.

use crate::error::{Error, Result};
use std::borrow::Cow;

/// A name in data. Built-in ones are literals; those of a case file, an FMU or a script are owned.
pub type Name = Cow<'static, str>;

/// Makes a list of literal names.
pub fn names(list: &[&'static str]) -> Vec<Name> {
    list.iter().copied().map(Name::from).collect()
}

/// Makes a list of literal names, written with spaces between them.
pub fn words(list: &'static str) -> Vec<Name> {
    list.split_whitespace().map(Name::from).collect()
}

/// Looks a name up in a list of entries, or explains which names are valid.
///
/// # Errors
/// [`Error::UnknownName`] with all names.
pub fn find_by_name<'a, T>(
    kind: &'static str,
    entries: &'a [T],
    name_of: impl Fn(&T) -> &str,
    wanted: &str,
) -> Result<&'a T> {
    entries
        .iter()
        .find(|entry| name_of(entry) == wanted)
        .ok_or_else(|| Error::unknown(kind, wanted, entries.iter().map(&name_of)))
}

/// Writes and reads a kind by its name in a list of its own, `[(name, kind); _]` in the order of the variants; `what`
/// is what an error calls it.
///
/// ```text
/// by_name!(ModelMotion, NAMES, "model motion");
/// ```
#[macro_export]
macro_rules! by_name {
    ($kind:ty, $list:ident, $what:literal) => {
        impl ::std::fmt::Display for $kind {
            fn fmt(&self, f: &mut ::std::fmt::Formatter<'_>) -> ::std::fmt::Result {
                f.write_str(Self::$list[*self as usize].0)
            }
        }

        impl ::std::str::FromStr for $kind {
            type Err = $crate::error::Error;

            fn from_str(text: &str) -> $crate::error::Result<Self> {
                $crate::name::find_by_name($what, &Self::$list, |(name, _)| name, text).map(|(_, kind)| *kind)
            }
        }
    };
}

pub use crate::by_name;

/// Checks a name that is to be added to a list: kebab-case, and not in the list yet.
///
/// # Errors
/// [`Error::InvalidValue`] saying which of both it is not.
pub fn check_new_name<'a>(kind: &'static str, name: &str, mut taken: impl Iterator<Item = &'a str>) -> Result<()> {
    let word = |word: &str| !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit());
    if !(name.starts_with(|c: char| c.is_ascii_lowercase()) && name.split('-').all(word)) {
        let expected = "kebab-case: lower-case letters and digits in words joined by single hyphens, a letter first";
        return Err(Error::invalid(format!("name of the {kind}"), format!("`{name}`"), expected));
    }
    if taken.any(|known| known == name) {
        return Err(Error::invalid(format!("name of the {kind}"), format!("`{name}`"), "a name that is not taken yet"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_name_is_kebab_case_and_not_taken() {
        assert!(check_new_name("scheme", "my-scheme-2", ["other"].into_iter()).is_ok());
        for name in ["", "My-scheme", "my_scheme", "my--scheme", "-scheme", "scheme-", "2nd-scheme", "my scheme"] {
            let message = check_new_name("scheme", name, [].into_iter()).unwrap_err().to_string();
            assert!(message.contains("kebab-case"), "{name}: {message}");
        }
        let message = check_new_name("scheme", "taken", ["taken"].into_iter()).unwrap_err().to_string();
        assert!(message.contains("not taken yet"), "{message}");
    }
}
