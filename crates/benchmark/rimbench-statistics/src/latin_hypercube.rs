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
