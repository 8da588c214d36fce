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

    /// Returns all rows, to be changed.
    pub fn rows_mut(&mut self) -> impl ExactSizeIterator<Item = &mut [f64]> {
        self.data.chunks_exact_mut(self.columns.len().max(1))
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

    /// Returns all columns at other times, as [`columns_at`](Self::columns_at) does.
    pub fn resampled(&self, times: impl ExactSizeIterator<Item = f64>) -> Trajectory {
        self.columns_at(&(0..self.columns.len()).collect::<Vec<_>>(), times)
    }

    /// Returns some of the columns, by position and the time first, at other times: cubic between rows, held outside.
    ///
    /// A piece ends where two rows have one time, before and after an event, and no cubic goes through rows of two
    /// pieces. Of the three through four neighbouring rows that cover a time the middle one is taken, unless one beside
    /// it has a third difference of less than a quarter: then what kinks or jumps lies between them (essentially
    /// non-oscillatory interpolation; Harten, Engquist, Osher and Chakravarthy, 1987). A piece of three rows or two has
    /// a parabola or a line, and so has a time beside a value that is not finite.
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
            if !(share > 0.0 && share < 1.0) {
                resampled.data.extend(values.iter().map(|&column| before[column]));
                continue;
            }
            let cubics = Cubics::around(self, passed - 1, t);
            resampled.data.extend(values.iter().map(|&column| {
                let (a, b) = (before[column], after[column]);
                match cubics.offset(self, column, a) {
                    offset if offset.is_finite() => a + offset,
                    _ if a.is_finite() => a + share * (b - a),
                    _ => a,
                }
            }));
        }
        resampled
    }

    /// Tells whether a row and the next one are the two of an event.
    fn is_event(&self, row: usize) -> bool {
        let width = self.columns.len();
        self.data[(row + 1) * width] <= self.data[row * width].next_up()
    }

    /// Number of rows with time ≤ `t`, of which there were `passed` at the time that was looked for before: mostly
    /// there are as many, or one more.
    #[inline]
    fn rows_until_after(&self, passed: usize, t: f64) -> usize {
        let (width, rows) = (self.columns.len(), self.len());
        let time = |row: usize| self.data[row * width];
        let passed = if passed < rows && time(passed) <= t { passed + 1 } else { passed };
        let is_it = (passed == 0 || time(passed - 1) <= t) && (passed == rows || time(passed) > t);
        if is_it { passed } else { self.rows_until(passed, t) }
    }

    /// Number of rows with time ≤ `t`, looked for at equal distances from the one that was found last: but for the two
    /// rows of each event it is there, and else near.
    fn rows_until(&self, near: usize, t: f64) -> usize {
        let (width, rows) = (self.columns.len(), self.len());
        let is_later = |row: usize| row >= rows || self.data[row * width] > t;
        let spacing = (self.data[(rows - 1) * width] - self.data[0]) / (rows.max(2) - 1) as f64;
        let from = near.clamp(1, rows) - 1;
        let guess = from as f64 + (t - self.data[from * width]) / spacing;
        let guess = if guess >= 0.0 { (guess as usize).min(rows - 1) } else { 0 };
        // Doubled until the number lies within: at most `high`, at least `low`.
        let (mut low, mut high, mut reach) = (guess, guess, 1);
        while !is_later(high) {
            (low, high) = (high, (high + reach).min(rows));
            reach *= 2;
        }
        reach = 1;
        while low > 0 && is_later(low - 1) {
            (low, high) = (low.saturating_sub(reach), low - 1);
            reach *= 2;
        }
        while low < high {
            let middle = (low + high) / 2;
            if is_later(middle) { high = middle } else { low = middle + 1 }
        }
        low
    }
}

/// The polynomials through neighbouring rows that cover a time, as weights of these rows.
struct Cubics {
    /// The first row of each, how many rows it goes through, and of each row the weights of the third difference and of
    /// the value.
    of: [(usize, usize, [f64; 4], [f64; 4]); 3],
    /// How many there are, and which of them is the middle one.
    count: usize,
    middle: usize,
}

impl Cubics {
    /// Those of the time `t` between `row` and the next.
    fn around(trajectory: &Trajectory, row: usize, t: f64) -> Self {
        let joined = |row: usize| !trajectory.is_event(row);
        let left = if row > 0 && joined(row - 1) { 1 + usize::from(row > 1 && joined(row - 2)) } else { 0 };
        let (last, next) = (trajectory.len() - 1, row + 1);
        let right = if next < last && joined(next) { 1 + usize::from(next + 1 < last && joined(next + 1)) } else { 0 };
        let mut found = Cubics { of: [(0, 0, [0.0; 4], [0.0; 4]); 3], count: 0, middle: 0 };
        let time = |row: usize| trajectory.data[row * trajectory.columns.len()];
        let mut add = |first: usize, rows: usize| {
            let (mut at, mut difference, mut value) = ([0.0; 4], [0.0; 4], [0.0; 4]);
            (0..rows).for_each(|j| at[j] = time(first + j));
            for j in 0..rows {
                let (mut apart, mut ahead) = (1.0, 1.0);
                for k in (0..rows).filter(|&k| k != j) {
                    apart *= at[j] - at[k];
                    ahead *= t - at[k];
                }
                difference[j] = 1.0 / apart;
                value[j] = difference[j] * ahead;
            }
            found.of[found.count] = (first, rows, difference, value);
            found.count += 1;
            found.count - 1
        };
        let mut middle = 0;
        if left + right < 2 {
            add(row - left, 2 + left + right);
        } else {
            if left > 1 {
                add(row - 2, 4);
            }
            if left > 0 && right > 0 {
                middle = add(row - 1, 4);
            }
            if right > 1 {
                add(row, 4);
            }
        }
        found.middle = middle;
        found
    }

    /// By how much a column differs there from `base`, the value that it has in the row before.
    #[inline]
    fn offset(&self, trajectory: &Trajectory, column: usize, base: f64) -> f64 {
        let width = trajectory.columns.len();
        let sum = |first: usize, rows: usize, weights: &[f64; 4]| {
            let mut place = first * width + column;
            let mut sum = 0.0;
            for weight in &weights[..rows] {
                sum += weight * (trajectory.data[place] - base);
                place += width;
            }
            sum
        };
        let mut chosen = self.middle;
        if self.count > 1 {
            let third = |(first, rows, difference, _): &(usize, usize, [f64; 4], [f64; 4])| {
                sum(*first, *rows, difference).abs()
            };
            let mut least = 0.25 * third(&self.of[self.middle]);
            for (index, cubic) in self.of[..self.count].iter().enumerate().filter(|(index, _)| *index != self.middle) {
                let own = third(cubic);
                if own < least {
                    (chosen, least) = (index, own);
                }
            }
        }
        let (first, rows, _, value) = &self.of[chosen];
        sum(*first, *rows, value)
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
    fn values_between_rows_are_those_of_cubics_that_cross_no_event_and_outside_held() {
        let columns = || ["time_s", "x"].map(str::to_owned).to_vec();
        let at = |rows: &[[f64; 2]], times: &[f64]| {
            let trajectory = Trajectory::from_data(columns(), rows.concat());
            let resampled = trajectory.resampled(times.iter().copied());
            resampled.column(1).collect::<Vec<_>>()
        };
        let near = |found: &[f64], wanted: &[f64]| {
            let apart = found.iter().zip(wanted).map(|(found, wanted)| (found - wanted).abs());
            assert!(found.len() == wanted.len() && apart.fold(0.0, f64::max) < 1e-12, "{found:?} {wanted:?}");
        };
        // Two rows have a line, three a parabola; rows themselves and what is outside stand.
        assert_eq!(at(&[[0.0, 1.0], [1.0, 3.0]], &[-1.0, 0.0, 0.5, 1.0, 9.0]), [1.0, 1.0, 2.0, 3.0, 3.0]);
        near(&at(&[[0.0, 0.0], [1.0, 1.0], [3.0, 9.0]], &[0.5, 2.0]), &[0.25, 4.0]);
        // A cubic before an event within a row and another after it, each exactly; a jump at rows and a kink likewise,
        // without a mark.
        let (first, second) = (|t: f64| t * t * t - t, |t: f64| 5.0 - t * t * (t - 7.0));
        let mut rows: Vec<[f64; 2]> =
            (0..10).map(f64::from).map(|t| [t, if t < 4.3 { first(t) } else { second(t) }]).collect();
        rows.splice(5..5, [[4.3, first(4.3)], [4.3, second(4.3)]]);
        let times: Vec<f64> = (0..90).map(|k| f64::from(k) * 0.1 + 0.05).collect();
        let wanted: Vec<f64> = times.iter().map(|&t| if t < 4.3 { first(t) } else { second(t) }).collect();
        near(&at(&rows, &times), &wanted);
        let kinked = |t: f64| if t < 5.0 { t * t } else { 25.0 + 40.0 * (t - 5.0) };
        let rows: Vec<[f64; 2]> = (0..10).map(f64::from).map(|t| [t, kinked(t)]).collect();
        near(&at(&rows, &times), &times.iter().map(|&t| kinked(t)).collect::<Vec<_>>());
        let steps: Vec<[f64; 2]> = (0..10).map(f64::from).map(|t| [t, f64::from(t > 4.5)]).collect();
        let found = at(&steps, &[0.5, 3.5, 4.5, 5.5, 8.5]);
        assert!(
            found[2] > 0.0 && found[2] < 1.0 && [0, 1, 3, 4].map(|k| found[k]) == [0.0, 0.0, 1.0, 1.0],
            "{found:?}"
        );
        // Beside a value that is infinite a line, and the value before where that one is.
        let infinite = [[0.0, 1.0], [0.1, 2.0], [7.0, f64::INFINITY], [8.0, 5.0]];
        let there = [1.5, 2.0, f64::INFINITY, f64::INFINITY, f64::INFINITY];
        assert_eq!(at(&infinite, &[0.05, 0.1, 3.0, 7.0, 7.5]), there);
    }
}
