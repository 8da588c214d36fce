//! Solution of a small dense system by Gaussian elimination with row pivoting.

/// Replaces `b` by `A⁻¹ b` and destroys `a` (row-major); false if `A` is singular to working precision.
///
/// `row` is room for one row.
pub(super) fn solve_in_place(a: &mut [f64], b: &mut [f64], row: &mut [f64]) -> bool {
    let n = b.len();
    let largest = a.iter().fold(0.0_f64, |max, entry| max.max(entry.abs()));
    for k in 0..n {
        let pivot = (k..n).fold(k, |best, i| if a[i * n + k].abs() > a[best * n + k].abs() { i } else { best });
        let size = a[pivot * n + k].abs();
        if size.is_nan() || size <= f64::EPSILON * largest {
            return false;
        }
        if pivot != k {
            let (above, below) = a.split_at_mut(pivot * n);
            above[k * n..(k + 1) * n].swap_with_slice(&mut below[..n]);
            b.swap(k, pivot);
        }
        let tail = n - k;
        row[..tail].copy_from_slice(&a[k * n + k..(k + 1) * n]);
        for i in k + 1..n {
            let target = &mut a[i * n + k..(i + 1) * n];
            let factor = target[0] / row[0];
            for (entry, above) in target.iter_mut().zip(&row[..tail]) {
                *entry -= factor * above;
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k * n + j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k * n + k];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use rand::{RngExt, SeedableRng};

    #[test]
    fn solves_like_lu_of_nalgebra() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(8);
        for n in [1, 2, 5, 17] {
            let a = DMatrix::from_fn(n, n, |_, _| rng.random_range(-1.0..1.0));
            let b = DVector::from_fn(n, |_, _| rng.random_range(-1.0..1.0));
            let (mut rows, mut x) = (a.transpose().as_slice().to_vec(), b.as_slice().to_vec());
            assert!(solve_in_place(&mut rows, &mut x, &mut vec![0.0; n]));
            assert!((DVector::from_vec(x) - a.lu().solve(&b).unwrap()).amax() < 1e-10);
        }
    }

    #[test]
    fn a_singular_or_undefined_matrix_is_refused() {
        for a in [[1.0, 2.0, 2.0, 4.0], [0.0; 4], [f64::NAN, 0.0, 0.0, 1.0]] {
            assert!(!solve_in_place(&mut a.to_vec(), &mut [1.0, 1.0], &mut [0.0; 2]), "{a:?}");
        }
    }
}
