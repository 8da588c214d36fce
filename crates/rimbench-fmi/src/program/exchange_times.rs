//! How long exchanges with programs take, kept apart from what runs compute.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Parts of an octave, each a bin: a quantile is known to 3 %.
const PARTS: usize = 16;
/// Bins for all that 64 bits of nanoseconds hold.
const BINS: usize = 64 * PARTS;

/// Exchanges with one program, by how long they took.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExchangeTimes {
    counts: Vec<u64>,
}

impl Default for ExchangeTimes {
    fn default() -> Self {
        ExchangeTimes { counts: vec![0; BINS] }
    }
}

impl ExchangeTimes {
    /// Notes one.
    pub(super) fn note(&mut self, time: Duration) {
        let nanoseconds = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX).max(1);
        let octave = nanoseconds.ilog2() as usize;
        // The four bits behind the first.
        let part = ((u128::from(nanoseconds) * PARTS as u128) >> octave) as usize - PARTS;
        self.counts[octave * PARTS + part] += 1;
    }

    fn add(&mut self, other: &ExchangeTimes) {
        self.counts.iter_mut().zip(&other.counts).for_each(|(sum, count)| *sum += count);
    }

    /// Returns how many there were.
    pub fn count(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Returns the time within which this share of them was done, s, to 3 %; none if there were none.
    pub fn quantile_s(&self, share: f64) -> Option<f64> {
        let total = self.count();
        let rank = (share * total as f64).ceil().max(1.0) as u64;
        let mut seen = 0;
        let bin = self.counts.iter().position(|count| {
            seen += count;
            seen >= rank && total > 0
        })?;
        let (octave, part) = (bin / PARTS, bin % PARTS);
        Some(2f64.powi(octave as i32) * (1.0 + (part as f64 + 0.5) / PARTS as f64) * 1e-9)
    }
}

/// By the words of the command and the file that names it: those of two files may be the same, and their programs not.
type ByProgram = BTreeMap<(String, PathBuf), ExchangeTimes>;

static ALL: Mutex<ByProgram> = Mutex::new(BTreeMap::new());

/// Adds the exchanges of a conversation that has ended to those with the same program.
pub(super) fn add_exchange_times(words: &str, file: &Path, times: &ExchangeTimes) {
    if times.count() > 0 {
        let program = (words.to_owned(), file.to_owned());
        ALL.lock().unwrap_or_else(PoisonError::into_inner).entry(program).or_default().add(times);
    }
}

/// Takes what is known of all conversations that have ended since this was last asked, by their commands; where those of two programs
/// are the same, with the files that name them.
pub fn take_exchange_times() -> BTreeMap<String, ExchangeTimes> {
    told_apart(std::mem::take(&mut *ALL.lock().unwrap_or_else(PoisonError::into_inner)))
}

fn told_apart(all: ByProgram) -> BTreeMap<String, ExchangeTimes> {
    let mut of_words: BTreeMap<String, usize> = BTreeMap::new();
    all.keys().for_each(|(words, _)| *of_words.entry(words.clone()).or_default() += 1);
    let named = all.into_iter().map(|((words, file), times)| {
        let alone = of_words.get(&words) == Some(&1);
        (if alone { words } else { format!("{words} of {}", file.display()) }, times)
    });
    named.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_what_was_noted_to_three_per_cent() {
        let mut times = ExchangeTimes::default();
        assert_eq!((times.count(), times.quantile_s(0.5)), (0, None));
        for microseconds in 1..=1000 {
            times.note(Duration::from_micros(microseconds));
        }
        for (share, wanted) in [(0.5, 500e-6), (0.99, 990e-6), (0.0, 1e-6), (1.0, 1e-3)] {
            approx::assert_relative_eq!(times.quantile_s(share).unwrap(), wanted, max_relative = 0.032);
        }
        // The least and the most that there is a bin for.
        [Duration::ZERO, Duration::from_nanos(1), Duration::MAX].into_iter().for_each(|time| times.note(time));
        assert_eq!(times.count(), 1003);
    }

    #[test]
    fn programs_with_the_same_words_are_told_apart_by_their_files() {
        let of = |words: &str, file: &str| ((words.to_owned(), PathBuf::from(file)), ExchangeTimes::default());
        let all = [of("python3 x.py", "a/x.toml"), of("python3 x.py", "b/x.toml"), of("y", "a/y.toml")];
        let told: Vec<String> = told_apart(all.into()).into_keys().collect();
        assert_eq!(told, ["python3 x.py of a/x.toml", "python3 x.py of b/x.toml", "y"]);
    }
}
