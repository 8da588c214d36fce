//! How often a solver is within a factor of the best, over many problems.

/// Returns for each solver the fraction of problems that it solves within `factor` times the best time, one row per
/// factor.
///
/// ```text
/// r_ps = t_ps / min_s t_ps         ρ_s(τ) = |{p : r_ps ≤ τ}| / number of problems
/// ```
/// `times[s][p]` is the time of solver `s` on problem `p`, or none if it did not solve it. A problem that nobody solves
/// counts against everybody. `ρ_s(1)` is how often a solver is the fastest, `ρ_s(∞)` how often it succeeds.
///
/// # Panics
/// If the solvers have not been given equally many problems.
/// # Source
/// Dolan, Moré, *Benchmarking optimization software with performance profiles*, Math. Programming 91 (2002).
pub fn performance_profile(times: &[Vec<Option<f64>>], factors: &[f64]) -> Vec<Vec<f64>> {
    let problems = times.first().map_or(0, Vec::len);
    assert!(times.iter().all(|times| times.len() == problems), "every solver has a time or none for every problem");
    let best = |problem: usize| times.iter().filter_map(|times| times[problem]).fold(f64::INFINITY, f64::min);
    let best: Vec<f64> = (0..problems).map(best).collect();
    let within = |times: &[Option<f64>], factor: f64| {
        let close = |(time, best): (&Option<f64>, &f64)| time.is_some_and(|time| time <= factor * best);
        times.iter().zip(&best).filter(|pair| close(*pair)).count() as f64 / problems.max(1) as f64
    };
    factors.iter().map(|&factor| times.iter().map(|times| within(times, factor)).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_follow_from_ratios_to_the_best() {
        let fast = vec![Some(1.0), Some(1.0), None, None];
        let slow = vec![Some(3.0), Some(0.5), Some(9.0), None];
        let rho = performance_profile(&[fast, slow], &[1.0, 2.0, 3.0, f64::INFINITY]);
        assert_eq!(rho, [[0.25, 0.5], [0.5, 0.5], [0.5, 0.75], [0.5, 0.75]]);
    }
}
