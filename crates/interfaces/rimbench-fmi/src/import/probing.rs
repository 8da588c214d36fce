//! What is to be said of sides after a run: by how much what they were probed for may be wrong, and of what they have
//! warned.

use crate::last_words::tell_once;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// How good what was probed is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProbeQuality {
    /// How often an FMU was probed, and its error is known.
    pub count: usize,
    /// Estimated relative error that half of them stay below.
    pub median: f64,
    /// The largest; 1: no digit is right.
    pub largest: f64,
}

/// What is known of one file.
#[derive(Debug, Default)]
struct OfFile {
    errors: Vec<f64>,
    warnings: u64,
}

/// Collects what sides of cases leave behind, by their files, from runs that may go on side by side. Clones are the
/// same collection.
#[derive(Debug, Clone, Default)]
pub struct SideNotes(Arc<Mutex<BTreeMap<PathBuf, OfFile>>>);

impl SideNotes {
    fn with<T>(&self, look: impl FnOnce(&mut BTreeMap<PathBuf, OfFile>) -> T) -> T {
        look(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Forgets everything.
    pub fn clear(&self) {
        self.with(BTreeMap::clear);
    }

    /// Returns how good what files were probed for is, of those that were probed.
    pub fn probed(&self) -> BTreeMap<PathBuf, ProbeQuality> {
        let quality = |(file, of): (&PathBuf, &OfFile)| Some((file.clone(), quality(&of.errors)?));
        self.with(|all| all.iter().filter_map(quality).collect())
    }

    /// Returns how often files have warned, of those that have.
    pub fn warnings(&self) -> BTreeMap<PathBuf, u64> {
        let warned = |(file, of): (&PathBuf, &OfFile)| (of.warnings > 0).then(|| (file.clone(), of.warnings));
        self.with(|all| all.iter().filter_map(warned).collect())
    }
}

/// Relative errors of what one side was probed for, of an actuator estimated from two step sizes, of a mechanics by
/// what came; they are noted when it is done with.
#[derive(Debug)]
pub(super) struct ProbeErrors {
    file: PathBuf,
    notes: SideNotes,
    errors: Vec<f64>,
}

impl ProbeErrors {
    pub(super) fn of(file: &Path, notes: &SideNotes) -> Self {
        ProbeErrors { file: file.to_owned(), notes: notes.clone(), errors: Vec::new() }
    }

    /// What is found of it, with its file.
    pub(super) fn of_file(&self, found: &str) -> String {
        format!("{}: {found}", self.file.display())
    }

    /// Notes one.
    pub(super) fn note(&mut self, error: f64) {
        self.errors.push(error);
    }

    /// Tells, once, what an FMU has warned of, and counts it.
    pub(super) fn warned(&self, count: u64, text: &str) {
        let file = self.file.display();
        let text = if text.is_empty() { "it does not say of what" } else { text };
        tell_once(&format!("warning: {file} returned Warning: {text}\n"));
        self.notes.with(|all| all.entry(self.file.clone()).or_default().warnings += count);
    }

    /// Those that a copy begins with.
    pub(super) fn of_a_copy(&self) -> Self {
        Self::of(&self.file, &self.notes)
    }
}

impl Drop for ProbeErrors {
    fn drop(&mut self) {
        if !self.errors.is_empty() {
            self.notes.with(|all| {
                all.entry(std::mem::take(&mut self.file)).or_default().errors.append(&mut self.errors);
            });
        }
    }
}

/// None where there are no errors.
fn quality(errors: &[f64]) -> Option<ProbeQuality> {
    let mut errors = errors.to_vec();
    errors.sort_by(f64::total_cmp);
    let count = errors.len();
    Some(ProbeQuality { count, median: *errors.get(count.div_ceil(2).checked_sub(1)?)?, largest: *errors.last()? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_errors_are_at_most_the_median() {
        assert_eq!(quality(&[0.5]), Some(ProbeQuality { count: 1, median: 0.5, largest: 0.5 }));
        assert_eq!(quality(&[0.3, 1.0, 0.1, 0.2]), Some(ProbeQuality { count: 4, median: 0.2, largest: 1.0 }));
        assert_eq!(quality(&[]), None);
        let (file, notes, others) = (Path::new("some.fmu"), SideNotes::default(), SideNotes::default());
        for error in [0.25, 0.75] {
            let mut errors = ProbeErrors::of(file, &notes);
            errors.note(error);
            drop(errors.of_a_copy());
        }
        assert_eq!(notes.probed().get(file).map(|quality| (quality.count, quality.largest)), Some((2, 0.75)));
        assert!(notes.warnings().is_empty() && others.probed().is_empty());
    }
}
