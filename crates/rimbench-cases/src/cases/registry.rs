//! The cases by name: the built-in list, and those that a program adds to it.

use super::CASES;
use super::case::Case;
use rimbench_core::error::{Result, check_new_name, find_by_name};
use std::sync::{PoisonError, RwLock};

static REGISTERED: RwLock<Vec<&'static Case>> = RwLock::new(Vec::new());

/// Adds a case to those that are found by name, for as long as the program runs.
///
/// # Errors
/// [`Error::InvalidValue`](rimbench_core::error::Error::InvalidValue) for a name that is not kebab-case or already taken.
pub fn register(case: &'static Case) -> Result<()> {
    let mut registered = REGISTERED.write().unwrap_or_else(PoisonError::into_inner);
    check_new_name("case", case.name, CASES.iter().chain(registered.iter().copied()).map(|known| known.name))?;
    registered.push(case);
    Ok(())
}

/// Every case: the built-in ones, then those registered.
pub fn all_cases() -> Vec<&'static Case> {
    let registered = REGISTERED.read().unwrap_or_else(PoisonError::into_inner);
    CASES.iter().chain(registered.iter().copied()).collect()
}

/// Finds a case.
///
/// # Errors
/// [`Error::UnknownName`](rimbench_core::error::Error::UnknownName) with all names.
pub fn case_by_name(name: &str) -> Result<&'static Case> {
    find_by_name("case", &all_cases(), |case| case.name, name).copied()
}
