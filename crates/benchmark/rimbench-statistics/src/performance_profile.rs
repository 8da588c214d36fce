//! Performance profiles: how often a solver is within a factor of the best, failures included.

/// Returns the ratio of each cost to the best on the same problem; +∞ for a failure.
///
/// ```text
/// r_ps = t_ps / min_s t_ps            ρ_s(τ) = |{p : r_ps ≤ τ}| / |{p}|
/// ```
/// `costs[s][p]` is the cost of solver s on problem p, +∞ or NaN where it failed. A problem that nobody solves is a
/// failure of everybody: it stays among the |{p}|, as in the source, so that what nobody can do shows. Two costs of
/// zero have the ratio 1.
///
/// # Panics
/// If the solvers have not been given equally many problems.
/// # Source
/// Dolan, Moré: Benchmarking optimization software with performance profiles, Math. Program. 91 (2002).
pub fn performance_ratios(costs: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let problems = costs.first().map_or(0, Vec::len);
    assert!(costs.iter().all(|costs| costs.len() == problems), "every solver has a cost for every problem");
    // NaN is passed over by the minimum.
    let best = |p: usize| costs.iter().map(|of_solver| of_solver[p]).fold(f64::INFINITY, f64::min);
    let best: Vec<f64> = (0..problems).map(best).collect();
    let ratio = |(&cost, &best): (&f64, &f64)| match cost {
        _ if !cost.is_finite() => f64::INFINITY,
        _ if cost == best => 1.0,
        _ => cost / best,
    };
    costs.iter().map(|of_solver| of_solver.iter().zip(&best).map(ratio).collect()).collect()
}

/// Lists the corners (τ, ρ) of the profile of one solver, from its ratios: a step function that starts at τ = 1.
pub fn performance_profile(ratios: &[f64]) -> Vec<(f64, f64)> {
    let mut reached: Vec<f64> = ratios.iter().copied().filter(|ratio| ratio.is_finite()).collect();
    reached.sort_by(f64::total_cmp);
    let at_best = reached.partition_point(|ratio| *ratio <= 1.0);
    let mut corners = vec![(1.0, share(at_best, ratios))];
    let mut count = at_best;
    for group in reached[at_best..].chunk_by(|a, b| a == b) {
        count += group.len();
        corners.push((group[0], share(count, ratios)));
    }
    corners
}

fn share(count: usize, ratios: &[f64]) -> f64 {
    count as f64 / ratios.len().max(1) as f64
}
