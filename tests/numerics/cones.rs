//! Contacts with friction in space: problems of Siconos, and Clarabel's opinion. Closed forms are unit tests of the
//! contact crate.

use crate::friction_of_others::{OfOthers, problems};
use crate::support::*;
use rimbench::friction::space::{SpaceProblem, SpaceSolver};

/// Contacts up to which the problems of Siconos are solved here; their matrices are symmetric to 1e-5 at worst. Those
/// of the capsules, with 225 to 296 contacts, are not, and one of five is solved.
const MOST_CONTACTS: usize = 107;

/// `H P + b`.
fn velocities(problem: SpaceProblem<'_>, impulses: &[f64]) -> Vec<f64> {
    let product = |row: usize| problem.delassus.row(row).iter().zip(impulses).map(|(h, p)| h * p).sum::<f64>();
    problem.b.iter().enumerate().map(|(row, b)| b + product(row)).collect()
}

#[test]
fn the_problems_in_space_of_others_must_be_solved() {
    let Some(problems) = problems::<2>("siconos-space") else { return };
    let mut solved = 0;
    for OfOthers { name, mut h, b, friction } in problems {
        let (n, size) = (friction.len(), b.len());
        if n > MOST_CONTACTS {
            continue;
        }
        for i in 0..size {
            for j in 0..i {
                let mean = 0.5 * (h[i * size + j] + h[j * size + i]);
                (h[i * size + j], h[j * size + i]) = (mean, mean);
            }
        }
        let problem = SpaceProblem::with_friction(&h, &b, &friction);
        let mut impulses = vec![0.0; size];
        let found = SpaceSolver::new(n, 1e-8).solve(problem, &mut impulses);
        assert!(found.is_ok() && problem.natural_residual(&impulses) <= 1e-8, "{name}: {found:?}");
        solved += 1;
    }
    assert!(solved >= 27, "{solved}");
}

/// Feet of one body of 300 kg on a floor, and what they would move with: redundant from the fourth on.
pub fn feet(n: usize, turn: f64) -> (Vec<f64>, Vec<f64>) {
    let arm = |k: usize| {
        let angle = 2.0 * std::f64::consts::PI * (k as f64 / n as f64 + 0.07);
        [0.5 * angle.cos(), 0.5 * angle.sin(), -0.4]
    };
    let row = |row: usize| {
        let [x, y, z] = arm(row % n);
        match row / n {
            0 => [0.0, 0.0, 1.0, y, -x, 0.0],
            1 => [1.0, 0.0, 0.0, 0.0, z, -y],
            _ => [0.0, 1.0, 0.0, -z, 0.0, x],
        }
    };
    let inverse = [1.0 / 300.0, 1.0 / 300.0, 1.0 / 300.0, 1.0 / 31.25, 1.0 / 31.25, 1.0 / 50.0];
    let product = |a: [f64; 6], b: [f64; 6]| (0..6).map(|i| a[i] * inverse[i] * b[i]).sum::<f64>();
    let h = (0..9 * n * n).map(|k| product(row(k / (3 * n)), row(k % (3 * n)))).collect();
    let v = [0.02 * turn.sin(), 0.02 * (1.3 * turn).cos(), -0.01, 0.01 * turn.cos(), 0.01, 0.05 * (0.7 * turn).sin()];
    (h, (0..3 * n).map(|k| row(k).iter().zip(v).map(|(a, v)| a * v).sum()).collect())
}

#[test]
fn an_interior_point_must_find_the_answer_once_it_is_told_the_correction_and_not_before() {
    let mut lifts = 0;
    for n in [3, 4, 8] {
        for turn in 0..20 {
            let (h, b) = feet(n, f64::from(turn));
            let friction = vec![0.3; n];
            let problem = SpaceProblem::with_friction(&h, &b, &friction);
            let mut impulses = vec![0.0; 3 * n];
            SpaceSolver::new(n, 1e-9).solve(problem, &mut impulses).unwrap();
            let w = velocities(problem, &impulses);
            let mut corrected = b.clone();
            for contact in 0..n {
                corrected[contact] += friction[contact] * w[n + contact].hypot(w[2 * n + contact]);
            }
            let differs = |c: &[f64]| {
                let relaxed = velocities(problem, &relaxed_cones(problem, c).unwrap());
                let scale = problem.scale();
                relaxed.iter().zip(&w).map(|(a, b)| (a - b).abs() / scale).fold(0.0, f64::max)
            };
            // Velocities follow the root of the gap, of which an interior point leaves 1e-9 where feet are redundant or
            // degenerate.
            assert!(differs(&corrected) <= 1e-4, "{n} feet, {turn}: {}", differs(&corrected));
            lifts += usize::from(differs(&b) > 0.01);
        }
    }
    assert!(lifts >= 30, "the associated law is another one where feet slide: {lifts} of 60");
}
