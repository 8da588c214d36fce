//! Points spread over a cube.

use crate::draws::Draws;

/// Draws points in [0, 1)ᵈ of which each has a stratum of width 1/n of every coordinate to itself.
///
/// ```text
/// x_ij = (π_j(i) + u_ij) / n,    π_j random permutations of 0 … n − 1, u_ij uniform in [0, 1)
/// ```
/// The same seed has the same points on every machine.
/// # Shapes and units
/// n points of d coordinates.
/// # Source
/// McKay, Beckman, Conover: A comparison of three methods for selecting values of input variables (1979).
pub fn latin_hypercube(points: usize, dimensions: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut draws = Draws::from(seed);
    let mut drawn = vec![vec![0.0; dimensions]; points];
    for dimension in 0..dimensions {
        // Fisher and Yates.
        let mut strata: Vec<usize> = (0..points).collect();
        (1..points).rev().for_each(|last| strata.swap(last, draws.below(last + 1)));
        for (point, stratum) in drawn.iter_mut().zip(strata) {
            point[dimension] = (stratum as f64 + draws.unit()) / points as f64;
        }
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_stratum_of_each_coordinate_holds_one_point() {
        for points in [1, 7, 48] {
            let drawn = latin_hypercube(points, 5, 3);
            for dimension in 0..5 {
                let strata = drawn.iter().map(|point| (point[dimension] * points as f64) as usize);
                let mut strata: Vec<usize> = strata.collect();
                strata.sort_unstable();
                assert_eq!(strata, (0..points).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn a_seed_has_its_points_and_coordinates_are_not_alike() {
        assert_eq!(latin_hypercube(16, 3, 9), latin_hypercube(16, 3, 9));
        assert_ne!(latin_hypercube(16, 3, 9), latin_hypercube(16, 3, 10));
        // The correlation of two coordinates has the standard deviation 1/√(n − 1) of random permutations.
        let drawn = latin_hypercube(400, 2, 1);
        let correlation: f64 = drawn.iter().map(|point| 12.0 * (point[0] - 0.5) * (point[1] - 0.5) / 400.0).sum();
        assert!(correlation.abs() < 5.0 / 399.0_f64.sqrt(), "{correlation}");
    }
}
