//! The schemes by name: the built-in list, and those that a program adds to it.

use super::SCHEMES;
use super::entry::SchemeEntry;
use crate::error::{Error, Result, check_new_name, find_by_name};
use std::sync::{PoisonError, RwLock};

static REGISTERED: RwLock<Vec<&'static SchemeEntry>> = RwLock::new(Vec::new());

/// Adds a scheme to those that are found by name, for as long as the program runs.
///
/// # Errors
/// [`Error::InvalidValue`] for a name that is not kebab-case or already taken, or a gain whose default is out of its range.
pub fn register(entry: &'static SchemeEntry) -> Result<()> {
    let mut registered = REGISTERED.write().unwrap_or_else(PoisonError::into_inner);
    check_new_name("scheme", entry.name, SCHEMES.iter().chain(registered.iter().copied()).map(|known| known.name))?;
    if let Some(gain) = entry.gain.filter(|gain| !(gain.range[0]..=gain.range[1]).contains(&gain.default)) {
        let expected = format!("a number from {} to {}", gain.range[0], gain.range[1]);
        return Err(Error::invalid(format!("default gain of {}", entry.name), gain.default, expected));
    }
    registered.push(entry);
    Ok(())
}

/// Every scheme: the built-in ones, then those registered.
pub fn all_schemes() -> Vec<&'static SchemeEntry> {
    let registered = REGISTERED.read().unwrap_or_else(PoisonError::into_inner);
    SCHEMES.iter().chain(registered.iter().copied()).collect()
}

/// Finds a scheme.
///
/// # Errors
/// [`Error::UnknownName`] with all names.
pub fn scheme_by_name(name: &str) -> Result<&'static SchemeEntry> {
    find_by_name("scheme", &all_schemes(), |entry| entry.name, name).copied()
}
