//! The trajectory of a run: one row per communication point.

use std::ops::Range;

/// Named columns over time; the first column is the time in seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    columns: Vec<String>,
    data: Vec<f64>,
}

impl Trajectory {
    /// Makes an empty trajectory with room for `rows` rows.
    pub fn with_capacity(columns: Vec<String>, rows: usize) -> Self {
        let data = Vec::with_capacity(columns.len() * rows);
        Trajectory { columns, data }
    }

    /// Builds a trajectory from row-major data.
    pub fn from_data(columns: Vec<String>, data: Vec<f64>) -> Self {
        debug_assert_eq!(data.len() % columns.len().max(1), 0);
        Trajectory { columns, data }
    }

    /// Returns the names of the columns.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Returns the row-major data.
    pub fn data(&self) -> &[f64] {
        &self.data
    }

    /// Returns the position of a column by name.
    pub fn index_of(&self, column: &str) -> Option<usize> {
        self.columns.iter().position(|name| name == column)
    }

    /// Returns the number of rows.
    #[inline]
    pub fn len(&self) -> usize {
        self.data.len() / self.columns.len().max(1)
    }

    /// Tells whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.data.is_empty()
    }

    /// Returns one row.
    #[inline]
    pub fn row(&self, index: usize) -> &[f64] {
        let width = self.columns.len();
        &self.data[index * width..(index + 1) * width]
    }

    /// Returns all rows.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f64]> + DoubleEndedIterator + Clone {
        self.data.chunks_exact(self.columns.len().max(1))
    }

    /// Returns one column by position.
    pub fn column(&self, index: usize) -> impl ExactSizeIterator<Item = f64> + Clone + '_ {
        self.rows().map(move |row| row[index])
    }

    /// Returns what some rows have in one column by position.
    pub fn column_of(&self, rows: Range<usize>, index: usize) -> impl ExactSizeIterator<Item = f64> + Clone + '_ {
        let width = self.columns.len();
        self.data[rows.start * width..rows.end * width].chunks_exact(width.max(1)).map(move |row| row[index])
    }

    /// Appends a row of these parts, which are as long as a row in all.
    #[inline]
    pub(crate) fn push_parts(&mut self, [times, outputs, inputs]: [&[f64]; 3]) {
        debug_assert_eq!(times.len() + outputs.len() + inputs.len(), self.columns.len());
        match (times, outputs, inputs) {
            // Mostly one row of an interface.
            (&[start, middle], &[force], &[position, velocity]) => {
                self.data.extend_from_slice(&[start, middle, force, position, velocity]);
            }
            (times, outputs, inputs) => self.push_many_parts([times, outputs, inputs]),
        }
    }

    #[inline(never)]
    fn push_many_parts(&mut self, parts: [&[f64]; 3]) {
        self.data.extend(parts.into_iter().flatten());
    }

    /// Appends a zero row and hands it out to be filled.
    #[inline]
    pub fn push_row(&mut self) -> &mut [f64] {
        let at = self.data.len();
        self.data.resize(at + self.columns.len(), 0.0);
        &mut self.data[at..]
    }

    /// Returns the last row, to be changed.
    #[inline]
    pub fn last_row_mut(&mut self) -> Option<&mut [f64]> {
        let start = self.data.len().checked_sub(self.columns.len())?;
        Some(&mut self.data[start..])
    }

    /// Returns rows from one on, at most so many.
    pub fn slice(&self, from: usize, most: usize) -> Trajectory {
        let (width, end) = (self.columns.len(), self.len().min(from + most));
        Trajectory::from_data(self.columns.clone(), self.data[from * width..end * width].to_vec())
    }

    /// Forgets the first rows.
    pub fn forget(&mut self, rows: usize) {
        self.data.drain(..rows * self.columns.len());
    }

    /// Returns the time of the last row, s.
    pub fn end_time(&self) -> Option<f64> {
        self.rows().next_back().map(|row| row[0])
    }

    /// Returns some of the columns, by position.
    pub fn selected(&self, columns: &[usize]) -> Trajectory {
        let names = columns.iter().map(|&column| self.columns[column].clone()).collect();
        let data = self.rows().flat_map(|row| columns.iter().map(|&column| row[column])).collect();
        Trajectory { columns: names, data }
    }

    /// Returns all columns at other times, linear between rows, held outside.
    pub fn resampled(&self, times: impl ExactSizeIterator<Item = f64>) -> Trajectory {
        self.columns_at(&(0..self.columns.len()).collect::<Vec<_>>(), times)
    }

    /// Returns some of the columns, by position and the time first, at other times, linear between rows, held outside.
    pub fn columns_at(&self, columns: &[usize], times: impl ExactSizeIterator<Item = f64>) -> Trajectory {
        let names = columns.iter().map(|&column| self.columns[column].clone()).collect();
        let mut resampled = Trajectory::with_capacity(names, times.len());
        let values = columns.get(1..).unwrap_or_default();
        let mut passed = 0;
        for t in times {
            resampled.data.push(t);
            if self.is_empty() {
                resampled.data.extend(values.iter().map(|_| f64::NAN));
                continue;
            }
            passed = self.rows_until_after(passed, t);
            let (before, after) = (self.row(passed.max(1) - 1), self.row(passed.min(self.len() - 1)));
            let share = (t - before[0]) / (after[0] - before[0]);
            // The end points exactly, also where a value is infinite.
            let exact = !(share > 0.0 && share < 1.0);
            resampled.data.extend(values.iter().map(|&column| {
                let (a, b) = (before[column], after[column]);
                if exact || !a.is_finite() { a } else { a + share * (b - a) }
            }));
        }
        resampled
    }

    /// Number of rows with time ≤ `t`, of which there were `passed` at the time that was looked for before: mostly
    /// there are as many, or one more.
    #[inline]
    fn rows_until_after(&self, passed: usize, t: f64) -> usize {
        let (width, rows) = (self.columns.len(), self.len());
        let time = |row: usize| self.data[row * width];
        let passed = if passed < rows && time(passed) <= t { passed + 1 } else { passed };
        let is_it = (passed == 0 || time(passed - 1) <= t) && (passed == rows || time(passed) > t);
        if is_it { passed } else { self.rows_until(t) }
    }

    /// Number of rows with time ≤ `t`.
    fn rows_until(&self, t: f64) -> usize {
        let (mut low, mut high) = (0, self.len());
        // Rows at equal distances, as in a reference, are found at once, up to the rounding of their times.
        if high > 1 {
            let spacing = self.row(1)[0] - self.row(0)[0];
            let guess = ((t - self.row(0)[0]) / spacing).clamp(0.0, (high - 1) as f64) as usize;
            (low, high) = self.bracket(guess, t);
        }
        while low < high {
            let middle = (low + high) / 2;
            if self.row(middle)[0] <= t { low = middle + 1 } else { high = middle }
        }
        low
    }

    /// Bounds of the number of rows with time ≤ `t`, equal if row `guess` or one beside it is the last of them.
    fn bracket(&self, guess: usize, t: f64) -> (usize, usize) {
        let is_later = |row: usize| row >= self.len() || self.row(row)[0] > t;
        match (is_later(guess), is_later(guess + 1)) {
            (false, true) => (guess + 1, guess + 1),
            (false, false) if is_later(guess + 2) => (guess + 2, guess + 2),
            (false, false) => (guess + 3, self.len()),
            (true, _) if guess == 0 || !is_later(guess - 1) => (guess, guess),
            (true, _) => (0, guess - 1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_found_wherever_the_one_before_was() {
        let columns = || vec!["time_s".to_owned(), "x".to_owned()];
        for spread in [|k: usize| k as f64 * 0.1, |k: usize| (k / 2 * k) as f64 * 0.03] {
            let rows: Vec<f64> = (0..40).flat_map(|k| [spread(k), (k * 7 % 11) as f64]).collect();
            let trajectory = Trajectory::from_data(columns(), rows);
            let end = trajectory.end_time().unwrap();
            // Steps of less than a row, of rows, of many, back, and beyond both ends; times of rows themselves.
            let mut times: Vec<f64> = (0..400).map(|k| (k * k % 173) as f64 / 173.0 * 1.1 * end - 0.05 * end).collect();
            times.extend(trajectory.column(0));
            times.extend((0..300).map(|k| f64::from(k) * 0.01));
            let found = trajectory.resampled(times.iter().copied());
            for (row, &t) in found.rows().zip(&times) {
                let alone = trajectory.resampled([t].into_iter());
                assert_eq!(row, alone.row(0), "{t}");
            }
        }
        let bare = Trajectory::with_capacity(columns(), 0).resampled([1.0].into_iter());
        assert!(bare.row(0)[1].is_nan());
    }

    #[test]
    fn values_between_rows_are_linear_and_outside_held() {
        let columns = vec!["time_s".to_owned(), "x_m".to_owned()];
        let trajectory = Trajectory::from_data(columns, vec![0.0, 1.0, 1.0, 3.0, 2.0, -1.0]);
        assert_eq!(trajectory.len(), 3);
        let wanted = [(-1.0, 1.0), (0.0, 1.0), (0.5, 2.0), (1.0, 3.0), (1.25, 2.0), (2.0, -1.0), (9.0, -1.0)];
        let resampled = trajectory.resampled(wanted.iter().map(|(t, _)| *t));
        for (row, (t, x)) in resampled.rows().zip(wanted) {
            assert_eq!(row, [t, x]);
        }
        // Uneven rows, and a value that is infinite on one side.
        let columns = vec!["time_s".to_owned(), "x".to_owned()];
        let uneven = Trajectory::from_data(columns, vec![0.0, 1.0, 0.1, 2.0, 7.0, f64::INFINITY, 8.0, 5.0]);
        let resampled = uneven.resampled([0.05, 0.1, 3.0, 7.0, 7.5].into_iter());
        assert_eq!(resampled.column(1).collect::<Vec<_>>(), [1.5, 2.0, f64::INFINITY, f64::INFINITY, f64::INFINITY]);
    }
}
