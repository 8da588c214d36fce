//! What is to be said of FMUs after a run: by how much what they were probed for may be wrong, and of what they have warned.

use crate::last_words::tell_once;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Estimates of the relative error of what one FMU was probed for, each from two step sizes.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct ProbeErrors {
    file: PathBuf,
    errors: Vec<f64>,
}

impl ProbeErrors {
    pub(super) fn of(file: &Path) -> Self {
        ProbeErrors { file: file.to_owned(), errors: Vec::new() }
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
        *WARNINGS.lock().unwrap_or_else(PoisonError::into_inner).entry(self.file.clone()).or_default() += count;
    }

    /// Those that a copy begins with.
    pub(super) fn of_a_copy(&self) -> Self {
        Self::of(&self.file)
    }
}

impl Drop for ProbeErrors {
    fn drop(&mut self) {
        if !self.errors.is_empty() {
            let mut all = ALL.lock().unwrap_or_else(PoisonError::into_inner);
            all.entry(std::mem::take(&mut self.file)).or_default().append(&mut self.errors);
        }
    }
}

/// How good what was probed is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProbeQuality {
    /// How often an FMU was probed.
    pub count: usize,
    /// Estimated relative error that half of them stay below.
    pub median: f64,
    /// The largest; 1: no digit is right.
    pub largest: f64,
}

static WARNINGS: Mutex<BTreeMap<PathBuf, u64>> = Mutex::new(BTreeMap::new());

/// Takes how often FMUs have warned since this was last asked, by their files.
pub fn take_warnings() -> BTreeMap<PathBuf, u64> {
    std::mem::take(&mut *WARNINGS.lock().unwrap_or_else(PoisonError::into_inner))
}

static ALL: Mutex<BTreeMap<PathBuf, Vec<f64>>> = Mutex::new(BTreeMap::new());

/// Takes what is known of all FMUs that were probed since this was last asked, by their files.
pub fn take_probe_errors() -> BTreeMap<PathBuf, ProbeQuality> {
    let all = std::mem::take(&mut *ALL.lock().unwrap_or_else(PoisonError::into_inner));
    all.into_iter().map(|(file, errors)| (file, quality(errors))).collect()
}

fn quality(mut errors: Vec<f64>) -> ProbeQuality {
    errors.sort_by(f64::total_cmp);
    let count = errors.len();
    ProbeQuality { count, median: errors[count.div_ceil(2) - 1], largest: errors[count - 1] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_errors_are_at_most_the_median() {
        let quality = |errors: &[f64]| quality(errors.to_vec());
        assert_eq!(quality(&[0.5]), ProbeQuality { count: 1, median: 0.5, largest: 0.5 });
        assert_eq!(quality(&[0.3, 1.0, 0.1, 0.2]), ProbeQuality { count: 4, median: 0.2, largest: 1.0 });
        let file = Path::new("some.fmu");
        for error in [0.25, 0.75] {
            let mut errors = ProbeErrors::of(file);
            errors.note(error);
            drop(errors.of_a_copy());
        }
        assert_eq!(take_probe_errors().get(file).map(|quality| (quality.count, quality.largest)), Some((2, 0.75)));
    }
}
