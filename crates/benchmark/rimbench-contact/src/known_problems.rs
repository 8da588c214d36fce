//! Contact problems with known answers, for any solver, those of other crates too.
//!
//! ```text
//! w = H P + b        0 ≤ w ⟂ P ≥ 0        w is unique, P is not where contacts are redundant
//! ```
//! Problems of the literature are written down here; those of simulations, taken out of runs of fifteen cases, are in
//! `known_problems.txt` with all digits.

/// A contact problem with its answer.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownProblem {
    /// Where it is from.
    pub name: String,
    /// Delassus operator by rows, 1/kg.
    pub h: Vec<f64>,
    /// Velocities without contact impulses, m/s.
    pub b: Vec<f64>,
    /// Velocities with them, m/s.
    pub w: Vec<f64>,
}

/// Lists forty-two problems of 1 to 32 contacts, regular, redundant and degenerate.
///
/// # Source
/// Murty, *Linear Complementarity, Linear and Nonlinear Programming* (1988); Fathi, *Computational complexity of LCPs
/// associated with positive definite symmetric matrices* (1979).
pub fn known_problems() -> Vec<KnownProblem> {
    let ones = |n: usize| vec![1.0; n * n];
    let of = |name: &str, h: Vec<f64>, b: Vec<f64>, w: Vec<f64>| KnownProblem { name: name.to_owned(), h, b, w };
    let mut problems = vec![
        of("Murty, 2 × 2", vec![2.0, 1.0, 1.0, 2.0], vec![-5.0, -6.0], vec![0.0; 2]),
        of("a free pair pushed together", vec![1.0, -1.0, -1.0, 1.0], vec![-1.0, 1.0], vec![0.0; 2]),
        of("four times the same contact", ones(4), vec![-1.0; 4], vec![0.0; 4]),
        of("three times, of different gaps", ones(3), vec![-1.0, 0.0, -2.0], vec![1.0, 2.0, 0.0]),
        of("at rest", ones(3), vec![0.0; 3], vec![0.0; 3]),
    ];
    for n in 1..=9 {
        // Positive definite, exponentially many pivots for Lemke's and Murty's methods; P = (1, 0 … 0).
        let fathi = |i: usize, j: usize| 4.0 * i.min(j) as f64 + if i == j { 1.0 } else { 2.0 };
        let w = (0..n).map(|i| if i == 0 { 0.0 } else { 1.0 }).collect();
        problems.push(of(&format!("Fathi, {n}"), (0..n * n).map(|k| fathi(k / n, k % n)).collect(), vec![-1.0; n], w));
        // Bodies in a row, all contacts closed.
        let row = |i: usize, j: usize| [2.0, -1.0, 0.0][i.abs_diff(j).min(2)];
        let h = (0..n * n).map(|k| row(k / n, k % n)).collect();
        problems.push(of(&format!("row of {n}"), h, vec![-1.0; n], vec![0.0; n]));
    }
    for n in [4, 8, 16, 32] {
        // One rigid board on n points, pressed in the middle: rank 2.
        let x = |i: usize| 2.0 * i as f64 / (n - 1) as f64 - 1.0;
        let h = (0..n * n).map(|k| 1.0 + 3.0 * x(k / n) * x(k % n)).collect();
        problems.push(of(&format!("board on {n}"), h, vec![-1.0; n], vec![0.0; n]));
    }
    for line in include_str!("known_problems.txt").lines().filter(|line| !line.starts_with('#')) {
        let numbers = |text: &str| text.split(' ').filter_map(|number| number.parse().ok()).collect::<Vec<f64>>();
        match (line.split_once(' '), problems.last_mut()) {
            (Some(("H", row)), Some(problem)) => problem.h.extend(numbers(row)),
            (Some(("b", row)), Some(problem)) => problem.b = numbers(row),
            (Some(("w", row)), Some(problem)) => problem.w = numbers(row),
            _ => problems.push(of(line, Vec::new(), Vec::new(), Vec::new())),
        }
    }
    problems
}
