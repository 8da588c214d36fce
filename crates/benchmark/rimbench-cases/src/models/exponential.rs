//! The exponential of a small matrix.

use nalgebra::SMatrix;

/// Largest entry of which there is an exponential: the tenth power of a larger one, by which its scaling is chosen, is
/// beyond every number, and the scaling would never end.
const LARGEST: f64 = 1e28;

/// Returns the exponential; not a number where an entry is not finite, or beyond what there is one of.
pub fn exponential<const N: usize>(matrix: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N>
where
    nalgebra::Const<N>: nalgebra::DimMin<nalgebra::Const<N>, Output = nalgebra::Const<N>>,
{
    if matrix.iter().all(|entry| entry.abs() <= LARGEST) { matrix.exp() } else { SMatrix::repeat(f64::NAN) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix2;

    #[test]
    fn the_exponential_of_whatever_is_asked_for_ends() {
        assert_eq!(exponential(&Matrix2::<f64>::zeros()), Matrix2::identity());
        for entry in [1e28, -1e28, 1e29, 1e300, f64::INFINITY, f64::NAN] {
            let found = exponential(&Matrix2::new(0.0, 1.0, entry, 0.0));
            assert!(entry.abs() <= 1e28 || found.iter().all(|entry| entry.is_nan()), "{entry}: {found}");
        }
    }
}
