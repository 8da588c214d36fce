//! The shifted geometric mean of errors, with a charge for failures.

/// Returns the geometric mean with a shift, which keeps errors that are all but zero from deciding it; none of an empty list.
///
/// ```text
/// exp(mean ln(x + s)) − s
/// ```
/// `shift` is in the unit of the values and above 0.
pub fn shifted_geometric_mean(values: &[f64], shift: f64) -> Option<f64> {
    let sum: f64 = values.iter().map(|value| (value + shift).ln()).sum();
    (!values.is_empty()).then(|| (sum / values.len() as f64).exp() - shift)
}

/// Returns the errors of all methods on the same problems with every failure (none, or not finite) charged: `factor` times the
/// largest error of anybody who completed that problem. A problem on which everybody failed says nothing and is left out.
///
/// # Panics
/// If the methods have not been given equally many problems.
pub fn charged(errors: &[Vec<Option<f64>>], factor: f64) -> Vec<Vec<f64>> {
    let problems = errors.first().map_or(0, Vec::len);
    assert!(errors.iter().all(|of_method| of_method.len() == problems), "every method has an entry for every problem");
    let completed = |error: Option<f64>| error.filter(|error| error.is_finite());
    let worst = |p: usize| errors.iter().filter_map(|of_method| completed(of_method[p])).reduce(f64::max);
    let charges: Vec<(usize, f64)> = (0..problems).filter_map(|p| Some((p, factor * worst(p)?))).collect();
    let of_method = |of_method: &Vec<Option<f64>>| {
        charges.iter().map(|&(p, charge)| completed(of_method[p]).unwrap_or(charge)).collect()
    };
    errors.iter().map(of_method).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_shift_to_speak_of_it_is_the_geometric_mean_and_zeros_do_not_decide_it() {
        approx::assert_relative_eq!(shifted_geometric_mean(&[1.0, 100.0], 1e-9).unwrap(), 10.0, max_relative = 1e-6);
        // (0 + 1)(3 + 1) = 4: root 2, less 1.
        approx::assert_relative_eq!(shifted_geometric_mean(&[0.0, 3.0], 1.0).unwrap(), 1.0, epsilon = 1e-14);
        assert_eq!(shifted_geometric_mean(&[], 1.0), None);
    }

    #[test]
    fn a_failure_costs_ten_times_the_worst_that_completed_and_a_problem_without_a_winner_is_left_out() {
        let errors = [vec![Some(1.0), None, None], vec![Some(2.0), Some(3.0), Some(f64::NAN)]];
        assert_eq!(charged(&errors, 10.0), [vec![1.0, 30.0], vec![2.0, 3.0]]);
    }
}
