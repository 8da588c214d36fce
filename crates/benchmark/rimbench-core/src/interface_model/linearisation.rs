//! Everything Eq. 3 needs at one state `(t, q, v)`, in buffers that are filled again and again.

use nalgebra::Vector2;
use rimbench_contact::linear_algebra::body_dot;

/// A block of constraint rows `w = A v`, with the convective term and the position it belongs to.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rows {
    count: usize,
    columns: usize,
    /// Where only few entries of a row are not zero for good: where each row starts in `jacobian`, and the columns of
    /// its entries.
    known: Option<(Vec<usize>, Vec<u32>)>,
    /// `A`, row-major, `count × columns`; with known columns only what stands in those.
    pub jacobian: Vec<f64>,
    /// `Ȧ v`, m/s².
    pub convective: Vec<f64>,
    /// Gap (unilateral), joint error (bilateral) or interface coordinate (interface), m.
    pub position: Vec<f64>,
}

impl Rows {
    /// Makes `count` zero rows over `columns` velocities.
    pub fn zeros(count: usize, columns: usize) -> Self {
        Rows {
            count,
            columns,
            known: None,
            jacobian: vec![0.0; count * columns],
            convective: vec![0.0; count],
            position: vec![0.0; count],
        }
    }

    /// Makes zero rows over `columns` velocities that keep only the entries in these columns, row by row.
    pub fn in_columns(columns: usize, of_rows: &[Vec<usize>]) -> Self {
        let starts: Vec<usize> = std::iter::once(0)
            .chain(of_rows.iter().scan(0, |end, row| {
                *end += row.len();
                Some(*end)
            }))
            .collect();
        let known: Vec<u32> = of_rows.iter().flatten().map(|&column| column as u32).collect();
        let zeros = Rows::zeros(of_rows.len(), 0);
        Rows { columns, jacobian: vec![0.0; known.len()], known: Some((starts, known)), ..zeros }
    }

    /// Returns where the entries of the rows start, and their columns, if only those are kept.
    pub(crate) fn columns_by_row(&self) -> Option<(&[usize], &[u32])> {
        self.known.as_ref().map(|(starts, columns)| (&starts[..], &columns[..]))
    }

    /// Writes the entry in `column`, which is the `slot`-th of the row's non-zeros.
    #[inline]
    pub fn set(&mut self, index: usize, slot: usize, column: usize, value: f64) {
        let at = match &self.known {
            None => index * self.columns + column,
            Some((starts, _)) => starts[index] + slot,
        };
        self.jacobian[at] = value;
    }

    /// Returns the number of rows.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Tells whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns one row of `A`, which must keep all its entries.
    #[inline]
    pub fn row(&self, index: usize) -> &[f64] {
        &self.jacobian[index * self.columns..(index + 1) * self.columns]
    }

    /// Returns the rows of a system of two bodies in the plane, of six velocities, that keep all their entries.
    #[inline(always)]
    pub(crate) fn of_two_bodies(&self) -> Option<&[[f64; 6]]> {
        (self.columns == 6 && self.known.is_none()).then(|| self.jacobian.as_chunks().0)
    }

    /// Returns the velocity of one row, `(A v)_index`, m/s.
    #[inline(always)]
    pub fn velocity(&self, index: usize, v: &[f64]) -> f64 {
        match &self.known {
            None => body_dot(self.row(index), v),
            Some((starts, columns)) => {
                let entries = starts[index]..starts[index + 1];
                let columns = &columns[entries.clone()];
                self.jacobian[entries].iter().zip(columns).map(|(a, &column)| a * v[column as usize]).sum()
            }
        }
    }

    /// Writes the part of a row that belongs to one planar body with velocities `(ẋ, ẏ, ω)` from `first` on: the
    /// velocity, along `direction`, of the body's point at `arm` from its centre of mass.
    ///
    /// ```text
    /// row = [ n_x, n_y, r_x n_y − r_y n_x ]
    /// ```
    #[inline]
    pub fn set_planar_body(&mut self, index: usize, first: usize, direction: Vector2<f64>, arm: Vector2<f64>) {
        let at = index * self.columns + first;
        let row = &mut self.jacobian[at..at + 3];
        row[0] = direction.x;
        row[1] = direction.y;
        row[2] = arm.perp(&direction);
    }
}

/// Which entries a square matrix over the velocities has.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum MatrixForm {
    /// Those of the diagonal.
    #[default]
    Diagonal,
    /// All.
    Dense,
}

/// The mass matrix, diagonal where the coordinates allow it.
#[derive(Debug, Clone, PartialEq)]
pub enum MassMatrix {
    /// The diagonal, length n.
    Diagonal(Vec<f64>),
    /// Row-major, n×n, symmetric positive definite.
    Dense(Vec<f64>),
}

impl MassMatrix {
    /// Returns `aᵀ M b`.
    #[inline(always)]
    pub fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        match self {
            MassMatrix::Diagonal(diagonal) => {
                // Two bodies in the plane.
                if let (Ok(m), Ok(x), Ok(y)) = (<&[f64; 6]>::try_from(&diagonal[..]), a.try_into(), b.try_into()) {
                    let (x, y): (&[f64; 6], &[f64; 6]) = (x, y);
                    let part = |l: usize| m[l] * x[l] * y[l];
                    return part(0) + part(1) + part(2) + part(3) + part(4) + part(5);
                }
                diagonal.iter().zip(a.iter().zip(b)).map(|(m, (x, y))| m * x * y).sum()
            }
            MassMatrix::Dense(dense) => {
                a.iter().zip(dense.chunks_exact(b.len())).map(|(x, row)| x * body_dot(row, b)).sum()
            }
        }
    }
}

impl MassMatrix {
    /// Makes the zero matrix of `n` velocities.
    pub fn zeros(n: usize, form: MatrixForm) -> Self {
        match form {
            MatrixForm::Diagonal => MassMatrix::Diagonal(vec![0.0; n]),
            MatrixForm::Dense => MassMatrix::Dense(vec![0.0; n * n]),
        }
    }

    /// Returns which entries it has.
    pub fn form(&self) -> MatrixForm {
        match self {
            MassMatrix::Diagonal(_) => MatrixForm::Diagonal,
            MassMatrix::Dense(_) => MatrixForm::Dense,
        }
    }

    /// Returns its entries, to be written.
    pub fn entries_mut(&mut self) -> &mut [f64] {
        match self {
            MassMatrix::Diagonal(entries) | MassMatrix::Dense(entries) => entries,
        }
    }

    /// Adds `factor` times another matrix of equal size, which must be diagonal if this one is.
    pub fn add(&mut self, factor: f64, other: &MassMatrix) {
        match (self, other) {
            (MassMatrix::Diagonal(sum), MassMatrix::Diagonal(other))
            | (MassMatrix::Dense(sum), MassMatrix::Dense(other)) => {
                sum.iter_mut().zip(other).for_each(|(sum, other)| *sum += factor * other);
            }
            (MassMatrix::Dense(sum), MassMatrix::Diagonal(other)) => {
                let n = other.len();
                sum.iter_mut().step_by(n + 1).zip(other).for_each(|(sum, other)| *sum += factor * other);
            }
            (MassMatrix::Diagonal(_), MassMatrix::Dense(_)) => unreachable!("a diagonal keeps no dense matrix"),
        }
    }

    /// Adds `factor · M x` to `out`.
    pub fn add_product(&self, factor: f64, x: &[f64], out: &mut [f64]) {
        match self {
            MassMatrix::Diagonal(diagonal) => {
                out.iter_mut().zip(diagonal.iter().zip(x)).for_each(|(out, (m, x))| *out += factor * m * x);
            }
            MassMatrix::Dense(dense) => {
                out.iter_mut()
                    .zip(dense.chunks_exact(x.len()))
                    .for_each(|(out, row)| *out += factor * body_dot(row, x));
            }
        }
    }
}

/// Mass, forces and rows at one state: the data of paper Eq. 3.
#[derive(Debug, Clone, PartialEq)]
pub struct Linearisation {
    /// `M`.
    pub mass: MassMatrix,
    /// `f_a − c`, length n, N and N·m.
    pub force: Vec<f64>,
    /// Bilateral rows (joints).
    pub bilateral: Rows,
    /// Unilateral rows (contacts).
    pub unilateral: Rows,
    /// Tangential rows, one per contact, or none where there is no friction; they have no position.
    pub tangential: Rows,
    /// Interface rows.
    pub interface: Rows,
}

impl Linearisation {
    /// Returns the number of velocities n.
    pub fn velocities(&self) -> usize {
        self.force.len()
    }
}
