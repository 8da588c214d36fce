//! The performance profile: how often a solver is within a factor of the best, failures included.

/// Ratio of each cost to the best on the same problem; +∞ for a failure.
///
/// ```text
/// r_ps = t_ps / min_s t_ps            ρ_s(τ) = |{p : r_ps ≤ τ}| / |{p}|
/// ```
/// `costs[s][p]` is the cost of solver s on problem p, +∞ or NaN where it failed. A problem that nobody solves tells nothing
/// about anyone and is left out. Two costs of zero have the ratio 1.
///
/// # Source
/// Dolan, Moré: Benchmarking optimization software with performance profiles, Math. Program. 91 (2002).
pub fn performance_ratios(costs: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let problems = costs.iter().map(Vec::len).min().unwrap_or(0);
    let finite = |cost: f64| if cost.is_nan() { f64::INFINITY } else { cost };
    let best = |p: usize| costs.iter().map(|of_solver| finite(of_solver[p])).fold(f64::INFINITY, f64::min);
    let solved: Vec<(usize, f64)> = (0..problems).map(|p| (p, best(p))).filter(|(_, best)| best.is_finite()).collect();
    let ratio = |cost: f64, best: f64| if cost == best { 1.0 } else { finite(cost) / best };
    costs.iter().map(|of_solver| solved.iter().map(|&(p, best)| ratio(of_solver[p], best)).collect()).collect()
}

/// The corners (τ, ρ) of the profile of one solver, from its ratios: a step function that starts at τ = 1.
pub fn performance_profile(ratios: &[f64]) -> Vec<(f64, f64)> {
    let mut reached: Vec<f64> = ratios.iter().copied().filter(|ratio| ratio.is_finite()).collect();
    reached.sort_by(f64::total_cmp);
    let share = |count: usize| count as f64 / ratios.len().max(1) as f64;
    let at_best = reached.partition_point(|ratio| *ratio <= 1.0);
    let mut corners = vec![(1.0, share(at_best))];
    let mut count = at_best;
    for group in reached[at_best..].chunk_by(|a, b| a == b) {
        count += group.len();
        corners.push((group[0], share(count)));
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    const FAILED: f64 = f64::INFINITY;

    #[test]
    fn the_profile_of_two_solvers_on_four_problems_is_the_one_counted_by_hand() {
        // The third problem is solved by nobody, the fourth by the second alone.
        let costs = [vec![1.0, 4.0, FAILED, f64::NAN], vec![2.0, 1.0, FAILED, 7.0]];
        let ratios = performance_ratios(&costs);
        assert_eq!(ratios, [vec![1.0, 4.0, FAILED], vec![2.0, 1.0, 1.0]]);
        let third = 1.0 / 3.0;
        assert_eq!(performance_profile(&ratios[0]), [(1.0, third), (4.0, 2.0 * third)]);
        assert_eq!(performance_profile(&ratios[1]), [(1.0, 2.0 * third), (2.0, 1.0)]);
    }

    #[test]
    fn nothing_to_compare_is_no_profile_above_zero() {
        assert_eq!(performance_ratios(&[]), Vec::<Vec<f64>>::new());
        assert_eq!(performance_profile(&performance_ratios(&[vec![FAILED]])[0]), [(1.0, 0.0)]);
        assert_eq!(performance_ratios(&[vec![0.0], vec![0.0]]), [[1.0], [1.0]]);
    }
}
