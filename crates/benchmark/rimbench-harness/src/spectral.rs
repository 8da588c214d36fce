//! The spectral radius of the macro-step map of a linear case, probed through the macro loop itself.

use super::clock::monotonic_clock;
use nalgebra::DMatrix;
use rimbench_core::cosim::{Bounds, Outcome, StopFlag};
use rimbench_core::error::{Error, Result};
use rimbench_runs::{RunSpec, simulate};

/// Longest memory of past communication points that is tried (a second-order hold needs 2).
const LONGEST_MEMORY: usize = 4;

/// Macro steps at the start that may follow another rule, while samples are still missing.
const START_UP: usize = 3;

/// A recurrence is accepted if it reproduces states it was not made from to this relative accuracy.
const ACCEPTED: f64 = 1e-9;

/// Singular values below this fraction of the largest are round-off.
const ROUND_OFF: f64 = 1e-13;

/// Returns the largest factor by which one macro step can grow the state of a linear case in the long run.
///
/// ```text
/// z_{k+1} = A_0 z_k + A_1 z_{k−1} + … + A_n z_{k−n}         z: all state variables at communication point k
///
///       ⎡ A_0 A_1 … A_n ⎤
///   C = ⎢  I   0  …  0  ⎥           ρ = max |eigenvalue of C|
///       ⎣  0   I  …  0  ⎦
/// ```
/// What the scheme remembers are samples, and samples are functions of the state at their communication points, so a
/// recurrence of this form exists; `n` is the smallest for which one fits. It is read off runs of the real macro loop:
/// one from each unit state, minus one from zero (a constant load drops out), by least squares over all states after
/// start-up; directions that no run ever visits do not matter and are left out. The last states are held back and must
/// be reproduced to 1e-9. The growth rate of the run is `ln ρ / H` (1/s); it is unstable for `ρ > 1`.
///
/// The phase of `spec` is ignored (it shortens the first step only), and so is its duration.
///
/// # Errors
/// [`Error::Incompatible`] if the case has no linear state, if it is not linear with these parameters, or if the scheme
/// does not run with it.
pub fn spectral_radius(spec: &RunSpec) -> Result<f64> {
    let variables = &spec.case.linear_state;
    if variables.is_empty() {
        return Err(Error::Incompatible(format!(
            "case {} is not linear, so it has no spectral radius; its stability limit is found by running it",
            spec.case.name
        )));
    }
    let n = variables.len();
    // Enough for the longest memory, with a third to hold back.
    let steps = START_UP + 3 * (LONGEST_MEMORY + 1) + LONGEST_MEMORY;
    // A start velocity of one metre per macro step, so that all responses are of one size.
    let scale = |index: usize| if index < n / 2 { 1.0 } else { 1.0 / spec.macro_step };
    let rest = states(spec, &vec![0.0; n], steps)?;
    let mut runs = Vec::with_capacity(n);
    for index in 0..n {
        let mut start = vec![0.0; n];
        start[index] = scale(index);
        runs.push(difference(&states(spec, &start, steps)?, &rest));
    }
    check_linear(spec, &runs, &rest, steps)?;
    // Velocities in units of metres per macro step, so that all entries are of one size.
    for run in &mut runs {
        for state in run.iter_mut() {
            state.iter_mut().enumerate().for_each(|(index, value)| *value /= scale(index));
        }
    }
    for memory in 0..=LONGEST_MEMORY {
        if let Some(companion) = companion(&runs, n, memory) {
            let eigenvalues = companion.complex_eigenvalues();
            return Ok(eigenvalues.iter().map(|value| value.norm()).fold(0.0, f64::max));
        }
    }
    Err(Error::Incompatible(format!(
        "scheme {} is no linear recurrence over {LONGEST_MEMORY} past communication points on case {}",
        spec.scheme.name, spec.case.name
    )))
}

/// States at the communication points of one run.
type States = Vec<Vec<f64>>;

fn states(spec: &RunSpec, start: &[f64], steps: usize) -> Result<States> {
    let mut parameters = spec.parameters.clone();
    for (variable, value) in spec.case.linear_state.iter().zip(start) {
        parameters.set(&variable.initial, &format!("{value:?}"))?;
    }
    let duration = steps as f64 * spec.macro_step;
    let spec = spec.with(|own| (own.phase, own.duration, own.parameters) = (1.0, duration, parameters))?;
    let result = simulate(&spec, Bounds::default(), Some(monotonic_clock), StopFlag::never())?;
    if result.report.outcome != Outcome::Completed {
        return Err(Error::Incompatible(format!(
            "no spectral radius of scheme {} on case {}: {}",
            spec.scheme.name, spec.case.name, result.report.outcome
        )));
    }
    let columns: Vec<usize> =
        spec.case.linear_state.iter().filter_map(|variable| result.trajectory.index_of(&variable.column)).collect();
    Ok(result.trajectory.rows().map(|row| columns.iter().map(|&column| row[column]).collect()).collect())
}

fn difference(a: &States, b: &States) -> States {
    a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(x, y)| x - y).collect()).collect()
}

/// The run from the sum of all unit states must be the sum of their runs.
fn check_linear(spec: &RunSpec, runs: &[States], rest: &States, steps: usize) -> Result<()> {
    let start: Vec<f64> = (0..runs.len()).map(|i| runs[i][0][i]).collect();
    let sum = difference(&states(spec, &start, steps)?, rest);
    for (k, state) in sum.iter().enumerate() {
        for (index, value) in state.iter().enumerate() {
            let added: f64 = runs.iter().map(|run| run[k][index]).sum();
            let size: f64 = runs.iter().map(|run| run[k][index].abs()).sum::<f64>() + start[index].abs();
            if (value - added).abs() > 1e-8 * size {
                return Err(Error::Incompatible(format!(
                    "scheme {} on case {} is not linear with these parameters, so there is no spectral radius",
                    spec.scheme.name, spec.case.name
                )));
            }
        }
    }
    Ok(())
}

/// The companion matrix for `memory` past points, if it reproduces the states held back.
fn companion(runs: &[States], n: usize, memory: usize) -> Option<DMatrix<f64>> {
    let (width, last) = (n * (memory + 1), runs[0].len() - 1);
    let first = START_UP.max(memory);
    // The last third is held back.
    let fitted = first + (last - first) * 2 / 3;
    let stacked = |run: &States, k: usize| (0..=memory).flat_map(|back| run[k - back].clone()).collect::<Vec<f64>>();
    let samples: Vec<(&States, usize)> = runs.iter().flat_map(|run| (first..fitted).map(move |k| (run, k))).collect();
    // Each equation in units of its own size, so that a growing run does not drown its beginning.
    let size = |run: &States, k: usize| stacked(run, k).iter().map(|x| x.abs()).fold(f64::MIN_POSITIVE, f64::max);
    let inputs = DMatrix::from_fn(samples.len(), width, |row, column| {
        let (run, k) = samples[row];
        stacked(run, k)[column] / size(run, k)
    });
    let outputs = DMatrix::from_fn(samples.len(), n, |row, column| {
        let (run, k) = samples[row];
        run[k + 1][column] / size(run, k)
    });
    let svd = inputs.svd(true, true);
    let coefficients = svd.solve(&outputs, ROUND_OFF * svd.singular_values.max()).expect("both factors are there");
    for run in runs {
        for k in fitted..last {
            let known = stacked(run, k);
            for column in 0..n {
                let predicted: f64 = known.iter().enumerate().map(|(i, x)| x * coefficients[(i, column)]).sum();
                if (predicted - run[k + 1][column]).abs() > ACCEPTED * size(run, k) {
                    return None;
                }
            }
        }
    }
    let mut companion = DMatrix::zeros(width, width);
    companion.view_mut((0, 0), (n, width)).copy_from(&coefficients.transpose());
    companion.view_mut((n, 0), (width - n, width - n)).fill_with_identity();
    Some(companion)
}
