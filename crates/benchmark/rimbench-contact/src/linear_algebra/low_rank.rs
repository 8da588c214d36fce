//! Factor `A = L Lᵀ` of a symmetric positive semidefinite matrix of low rank.

/// Diagonal, in parts of the largest entry, below which what is left of A is rounding.
const ROUNDING: f64 = 1e-13;

/// `L` of `A = L Lᵀ`, by Cholesky's method with the largest diagonal entry as pivot: n rows, as many columns as A has
/// rank. The contacts of one body have at most rank 6, however many there are.
#[derive(Debug, Clone, Default)]
pub struct LowRank {
    /// Column after column.
    columns: Vec<f64>,
    left: Vec<f64>,
    rank: usize,
}

impl LowRank {
    /// Reserves n rows and up to this many columns.
    pub fn grow(&mut self, n: usize, columns: usize) {
        if self.left.len() < n {
            self.left.resize(n, 0.0);
            self.columns.resize(n * columns, 0.0);
        }
    }

    /// Factorises `a` (n×n, row-major); false if it has more than `most` columns, or is not positive semidefinite.
    pub fn factorise(&mut self, a: &[f64], n: usize, most: usize) -> bool {
        self.grow(n, most);
        let left = &mut self.left[..n];
        left.iter_mut().enumerate().for_each(|(row, left)| *left = a[row * n + row]);
        let largest = left.iter().fold(0.0, |most: f64, entry| if *entry > most { *entry } else { most });
        if !largest.is_finite() {
            return false;
        }
        for rank in 0..=most {
            let pivot = (0..n).fold(0, |best, row| if left[row] > left[best] { row } else { best });
            if left[pivot] <= ROUNDING * largest {
                self.rank = rank;
                return left.iter().all(|left| *left >= -ROUNDING * largest);
            }
            if rank == most {
                return false;
            }
            let (before, column) = self.columns.split_at_mut(rank * n);
            let column = &mut column[..n];
            column.copy_from_slice(&a[pivot * n..(pivot + 1) * n]);
            for before in before.chunks_exact(n) {
                let at_pivot = before[pivot];
                column.iter_mut().zip(before).for_each(|(entry, before)| *entry -= at_pivot * before);
            }
            let root = left[pivot].sqrt();
            for (entry, left) in column.iter_mut().zip(&mut *left) {
                *entry /= root;
                *left -= *entry * *entry;
            }
            left[pivot] = 0.0;
        }
        false
    }

    /// Returns the number of columns.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Returns the columns, each of n entries.
    pub fn columns(&self, n: usize) -> impl Iterator<Item = &[f64]> {
        self.columns[..self.rank * n].chunks_exact(n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_of_low_rank_is_the_product_of_its_columns_and_others_are_refused() {
        let n = 12;
        let of_rank = |rank: usize| -> Vec<f64> {
            let line = |row: usize, k: usize| ((row * (2 * k + 1) * 7) % 13) as f64 - 6.0;
            (0..n * n).map(|at| (0..rank).map(|k| line(at / n, k) * line(at % n, k)).sum()).collect()
        };
        let mut factor = LowRank::default();
        for rank in [0, 1, 3, 4] {
            let a = of_rank(rank);
            assert!(factor.factorise(&a, n, 4) && factor.rank() == rank);
            for (at, a) in a.iter().enumerate() {
                let product: f64 = factor.columns(n).map(|column| column[at / n] * column[at % n]).sum();
                approx::assert_abs_diff_eq!(product, *a, epsilon = 1e-10);
            }
        }
        assert!(!factor.factorise(&of_rank(5), n, 4));
        let mut indefinite = of_rank(2);
        indefinite[n * n - 1] -= 1.0;
        assert!(!factor.factorise(&indefinite, n, 4));
        for bad in [f64::NAN, f64::INFINITY] {
            let mut other = of_rank(2);
            other[3 * n + 3] = bad;
            assert!(!factor.factorise(&other, n, 4));
        }
    }
}
