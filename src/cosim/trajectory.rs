//! What a run leaves behind: one row per communication point.

/// Named columns over time; the first column is the time in seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    columns: Vec<String>,
    data: Vec<f64>,
}

impl Trajectory {
    /// An empty trajectory with room for `rows` rows.
    pub fn with_capacity(columns: Vec<String>, rows: usize) -> Self {
        let data = Vec::with_capacity(columns.len() * rows);
        Trajectory { columns, data }
    }

    /// Builds a trajectory from row-major data.
    pub fn from_data(columns: Vec<String>, data: Vec<f64>) -> Self {
        debug_assert_eq!(data.len() % columns.len().max(1), 0);
        Trajectory { columns, data }
    }

    /// Names of the columns.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Row-major data.
    pub fn data(&self) -> &[f64] {
        &self.data
    }

    /// Position of a column by name.
    pub fn index_of(&self, column: &str) -> Option<usize> {
        self.columns.iter().position(|name| name == column)
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.data.len() / self.columns.len().max(1)
    }

    /// True if there is no row.
    pub fn is_empty(&self) -> bool {
        self.data.is_empty()
    }

    /// One row.
    pub fn row(&self, index: usize) -> &[f64] {
        let width = self.columns.len();
        &self.data[index * width..(index + 1) * width]
    }

    /// All rows.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f64]> + DoubleEndedIterator {
        self.data.chunks_exact(self.columns.len().max(1))
    }

    /// One column by position.
    pub fn column(&self, index: usize) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.rows().map(move |row| row[index])
    }

    /// Appends a zero row and hands it out to be filled.
    #[inline]
    pub fn push_row(&mut self) -> &mut [f64] {
        let at = self.data.len();
        self.data.resize(at + self.columns.len(), 0.0);
        &mut self.data[at..]
    }

    /// Time of the last row, s.
    pub fn end_time(&self) -> Option<f64> {
        self.rows().next_back().map(|row| row[0])
    }

    /// Value of a column at time `t`, linear between rows, held outside.
    pub fn at(&self, column: usize, t: f64) -> f64 {
        let rows = self.len();
        if rows == 0 {
            return f64::NAN;
        }
        let after = self.partition_by_time(t);
        if after == 0 {
            return self.row(0)[column];
        }
        if after == rows {
            return self.row(rows - 1)[column];
        }
        let (before, after) = (self.row(after - 1), self.row(after));
        let share = (t - before[0]) / (after[0] - before[0]);
        // The end points exactly, also where a value is infinite.
        if share == 0.0 { before[column] } else { before[column] + share * (after[column] - before[column]) }
    }

    /// Number of rows with time ≤ `t`.
    fn partition_by_time(&self, t: f64) -> usize {
        let (mut low, mut high) = (0, self.len());
        while low < high {
            let middle = (low + high) / 2;
            if self.row(middle)[0] <= t { low = middle + 1 } else { high = middle }
        }
        low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_between_rows_are_linear_and_outside_held() {
        let columns = vec!["time_s".to_owned(), "x_m".to_owned()];
        let trajectory = Trajectory::from_data(columns, vec![0.0, 1.0, 1.0, 3.0, 2.0, -1.0]);
        assert_eq!(trajectory.len(), 3);
        for (t, x) in [(-1.0, 1.0), (0.0, 1.0), (0.5, 2.0), (1.0, 3.0), (1.25, 2.0), (2.0, -1.0), (9.0, -1.0)] {
            assert_eq!(trajectory.at(1, t), x);
        }
    }
}
