//! A reference at the times of runs, brought there once for all runs on the same grid.

use rimbench_core::cosim::Trajectory;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// Numbers that are kept of one reference: some 16 MB. Runs of one grid that follow each other find it.
const MOST_NUMBERS: usize = 1 << 21;

/// Columns of one trajectory at times that were asked for lately.
#[derive(Debug, Default)]
pub(super) struct Samples(Mutex<VecDeque<Kept>>);

/// The bits of the first time and the columns that were asked for, and what was made.
type Kept = (u64, Vec<usize>, Arc<Trajectory>);

impl Samples {
    /// Returns some columns of `of`, the time first, at these times at least: a run that ended early has fewer than
    /// others of its grid. Only what was made of this trajectory must be here.
    pub(super) fn at<I>(&self, of: &Trajectory, columns: Vec<usize>, times: I) -> Arc<Trajectory>
    where
        I: ExactSizeIterator<Item = f64> + Clone,
    {
        let serves = |known: &Trajectory| {
            let same = known.column(0).zip(times.clone()).all(|(known, time)| known.to_bits() == time.to_bits());
            same && known.len() >= times.len()
        };
        let first = times.clone().next().map_or(u64::MAX, f64::to_bits);
        let kept = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // Looked at outside of the lock: other threads look as well.
        let known: Vec<_> = kept()
            .iter()
            .rev()
            .filter(|(begin, of, _)| *begin == first && *of == columns)
            .map(|(.., known)| known.clone())
            .collect();
        if let Some(known) = known.into_iter().find(|known| serves(known)) {
            return known;
        }
        let made = Arc::new(of.columns_at(&columns, times));
        if made.data().len() <= MOST_NUMBERS / 4 {
            let mut kept = kept();
            kept.push_back((first, columns, made.clone()));
            while kept.iter().map(|(.., known)| known.data().len()).sum::<usize>() > MOST_NUMBERS {
                kept.pop_front();
            }
        }
        made
    }
}

/// What is kept says nothing of the reference.
impl Clone for Samples {
    fn clone(&self) -> Self {
        Samples::default()
    }
}

impl PartialEq for Samples {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_on_one_grid_share_what_is_made_of_a_reference_and_others_get_their_own() {
        let columns = ["time_s", "x", "y"].map(str::to_owned).to_vec();
        let of = Trajectory::from_data(
            columns,
            (0..300).map(|k| f64::from(k / 3) * [0.1, 1.0, 2.0][k as usize % 3]).collect(),
        );
        let samples = Samples::default();
        let grid = |step: f64, count: usize| (0..count).map(move |k| k as f64 * step);
        let at = |columns: &[usize], step, count| samples.at(&of, columns.to_vec(), grid(step, count));
        let first = at(&[0, 1], 0.03, 200);
        assert_eq!(*first, of.columns_at(&[0, 1], grid(0.03, 200)));
        // The same grid, one that ended early, one that went on, other times, another column.
        assert!(Arc::ptr_eq(&first, &at(&[0, 1], 0.03, 200)) && Arc::ptr_eq(&first, &at(&[0, 1], 0.03, 7)));
        let on = at(&[0, 1], 0.03, 201);
        assert_eq!(*on, of.columns_at(&[0, 1], grid(0.03, 201)));
        assert_eq!(*at(&[0, 1], 0.02, 200), of.columns_at(&[0, 1], grid(0.02, 200)));
        assert_eq!(*at(&[0, 2], 0.03, 200), of.columns_at(&[0, 2], grid(0.03, 200)));
        // The memory is bounded, whatever is asked for.
        for k in 0..40 {
            at(&[0, 1], 1e-5 * f64::from(k), 100_000);
        }
        let numbers = || samples.0.lock().unwrap().iter().map(|(.., known)| known.data().len()).sum::<usize>();
        assert!((1..=MOST_NUMBERS).contains(&numbers()));
        let before = numbers();
        at(&[0, 1, 2], 1e-6, MOST_NUMBERS);
        assert_eq!(numbers(), before, "what is too long is not kept");
    }
}
