//! What is computed of numbers: pools, medians, intervals, orders, profiles.

use rimbench_statistics::*;

#[test]
fn quantiles_interpolate_between_order_statistics() {
    assert_eq!([0.0, 0.25, 0.5, 0.75, 1.0].map(|p| quantile(&[4.0, 1.0, 3.0, 2.0], p)), [1.0, 1.75, 2.5, 3.25, 4.0]);
    assert_eq!(quantile(&[7.0], 0.9), 7.0);
    assert!(quantile(&[], 0.5).is_nan());
    // What failed is infinite, and has no difference from the like.
    assert_eq!(
        [0.1, 0.5, 0.9].map(|p| quantile(&[1.0, 2.0, f64::INFINITY, f64::INFINITY], p)),
        [1.3, f64::INFINITY, f64::INFINITY]
    );
}

#[test]
fn the_slope_of_a_line_is_found_and_an_oscillation_has_next_to_none() {
    let points =
        |y: fn(f64) -> f64| -> Vec<[f64; 2]> { (0..=1000).map(|k| f64::from(k) * 0.01).map(|t| [t, y(t)]).collect() };
    approx::assert_relative_eq!(slope(&points(|t| 3.0 - 0.5 * t)).unwrap(), -0.5, epsilon = 1e-12);
    let swing = slope(&points(|t| (20.0 * std::f64::consts::PI * t).cos())).unwrap();
    assert!(swing.abs() < 1e-4, "{swing}");
    // Far from zero no digit is lost that the points have.
    let far: Vec<_> = (0..=1000).map(|k| f64::from(k) * 0.25).map(|t| [t + 1e9, 1e9 - 0.5 * t]).collect();
    assert_eq!(slope(&far), Some(-0.5));
    assert_eq!(slope(&[[1.0, 2.0]]), None);
    assert_eq!(slope(&[]), None);
}

#[test]
fn the_order_of_a_power_law_is_its_exponent() {
    let points: Vec<_> = (1..6).map(|i| (i as f64, 3.0 * (i as f64).powf(1.7))).collect();
    approx::assert_relative_eq!(order_of_convergence(&points).unwrap(), 1.7, epsilon = 1e-12);
    assert_eq!(order_of_convergence(&[(1.0, 1.0), (2.0, f64::NAN)]), None);
}

#[test]
fn whatever_rises_with_the_other_has_rank_correlation_one_and_whatever_falls_minus_one() {
    let pairs = |y: fn(f64) -> f64| -> Vec<[f64; 2]> { [3.0, -1.0, 2.0, 7.0, 0.5].map(|x| [x, y(x)]).to_vec() };
    assert_eq!(rank_correlation(&pairs(|x| x.powi(3))), Some(1.0));
    assert_eq!(rank_correlation(&pairs(|x| -x.exp())), Some(-1.0));
    assert_eq!(rank_correlation(&pairs(|_| 4.0)), None);
    assert_eq!(rank_correlation(&[[1.0, 2.0], [2.0, 3.0]]), None);
    assert_eq!(rank_correlation(&[[1.0, 2.0], [2.0, 3.0], [f64::NAN, 4.0]]), None);
}

/// Ranks 0 1 2 3 against 1 0 2 3: 1 − 6·2/(4·15) = 0.8. With the first two equal, 0.5 0.5 2 3 against 0 1 2 3:
/// 4.5/√(4.5·5).
#[test]
fn ranks_are_compared_as_by_hand_and_equal_values_share_theirs() {
    let swapped = [[1.0, 20.0], [2.0, 10.0], [3.0, 30.0], [4.0, 40.0]];
    approx::assert_relative_eq!(rank_correlation(&swapped).unwrap(), 0.8, epsilon = 1e-15);
    let tied = [[1.0, 10.0], [1.0, 20.0], [3.0, 30.0], [4.0, 40.0]];
    approx::assert_relative_eq!(rank_correlation(&tied).unwrap(), 4.5 / 22.5_f64.sqrt(), epsilon = 1e-15);
}

const FAILED: f64 = f64::INFINITY;

#[test]
fn a_failed_row_is_worse_than_every_number_and_two_of_them_cannot_be_compared() {
    let run =
        |case, is_other, error| PairedRun { problem: [case, ""], macro_step: 1e-3, is_other, error, floor: f64::NAN };
    let of = |own: &[f64], other: &[f64]| {
        let rows = [(own, false), (other, true)];
        PairedRatios::of(rows.iter().flat_map(|(row, is_other)| row.iter().map(|&e| run("box", *is_other, e))))
    };
    assert_eq!(of(&[1.0], &[2.0]).ratios, [0.5]);
    assert_eq!(of(&[FAILED], &[2.0]).ratios, [FAILED]);
    assert_eq!(of(&[1.0], &[FAILED]).ratios, [0.0]);
    // One phase of three that failed is the worst of them; half of them leave no median.
    assert_eq!(of(&[1.0, FAILED, 3.0], &[2.0]).ratios, [1.5]);
    assert_eq!(of(&[1.0, FAILED], &[2.0]).ratios, [FAILED]);
    let none = of(&[FAILED], &[FAILED]);
    assert_eq!((none.ratios.len(), none.both_failed, none.both_zero), (0, 1, 0));
    assert_eq!(of(&[0.0], &[0.0]).both_zero, 1);
    assert_eq!(of(&[1.0], &[]), PairedRatios::default());
}

fn mean(values: Vec<f64>) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn alone(values: impl Iterator<Item = f64>) -> Vec<Vec<f64>> {
    values.map(|value| vec![value]).collect()
}

#[test]
fn the_interval_of_a_mean_is_that_of_the_normal_distribution() {
    // 400 equally spaced values in [0, 1]: standard error √(1/12)/20; a quantile of 2000 draws is uncertain by some 3 %
    // of it.
    let values = alone((0..400).map(|k| (f64::from(k) + 0.5) / 400.0));
    let [low, high] = bootstrap_interval(&values, mean).unwrap();
    let reach = 1.96 * (1.0_f64 / 12.0).sqrt() / 20.0;
    approx::assert_relative_eq!(0.5 - low, reach, max_relative = 0.1);
    approx::assert_relative_eq!(high - 0.5, reach, max_relative = 0.1);
}

#[test]
fn copies_of_a_witness_are_no_further_witnesses() {
    let values: Vec<f64> = (0..12).map(f64::from).collect();
    let grouped: Vec<Vec<f64>> = values.iter().map(|value| vec![*value; 8]).collect();
    let apart = alone(values.iter().flat_map(|value| [*value; 8]));
    let width = |groups: &[Vec<f64>]| bootstrap_interval(groups, mean).map(|[low, high]| high - low).unwrap();
    // Eight times the witnesses, if they were any: √8 times the certainty; the intervals themselves are uncertain by
    // some 3 %.
    approx::assert_relative_eq!(width(&grouped), 8.0_f64.sqrt() * width(&apart), max_relative = 0.1);
}

#[test]
fn the_same_values_have_the_same_interval_and_one_group_has_none() {
    let values = alone([3.0, 1.0, 4.0, 1.0, 5.0].into_iter());
    assert_eq!(bootstrap_interval(&values, mean), bootstrap_interval(&values, mean));
    assert_eq!(bootstrap_interval(&values[..1], mean), None);
    assert_eq!(bootstrap_interval(&[Vec::new(), Vec::new()], mean), None);
}

#[test]
fn a_median_leaves_out_what_is_no_number_and_groups_are_drawn_as_a_whole() {
    assert_eq!(Pool::of([4.0, 1.0, f64::NAN, 3.0, 2.0]).median(), Some(2.5));
    assert_eq!(Pool::of([f64::NAN]).range(), None);
    assert!(Pool::of([1.0, 2.0, 3.0, 4.0]).interval().is_some());
    assert_eq!(Pool::grouped([vec![1.0, 2.0, 3.0, 4.0]]).interval(), None);
}

#[test]
fn values_of_one_abscissa_come_together() {
    let pairs = [(2.0, 'a'), (1.0, 'b'), (2.0, 'c'), (f64::NAN, 'd')];
    assert_eq!(by_abscissa(pairs), [(1.0, vec!['b']), (2.0, vec!['a', 'c'])]);
    let errors = [(1.0, 2.0), (2.0, 8.0), (1.0, 2.0), (2.0, 1e9), (2.0, 0.0)];
    approx::assert_relative_eq!(order_of_medians(errors).unwrap(), 2.0, epsilon = 1e-12);
}

/// The ratio of two rows of points (cost, error), each of a setting of its own.
fn ratio_at_equal_cost(own: &[[f64; 2]], other: &[[f64; 2]]) -> Option<f64> {
    let runs = [(false, own), (true, other)].into_iter().flat_map(|(is_other, points)| {
        let run = move |(k, &[cost, error]): (usize, &[f64; 2])| Costed {
            problem: ["", ""],
            setting: [k as f64, 0.0],
            is_other,
            cost,
            error,
        };
        points.iter().enumerate().map(run)
    });
    ratios_at_equal_cost(runs).first().copied()
}

/// Errors of 8/c² against 1/c² at costs between those of the other: 8, whatever the costs.
#[test]
fn a_power_law_is_met_on_its_line() {
    let other = [4.0, 1.0, 16.0].map(|cost: f64| [cost, cost.powi(-2)]);
    let own = [2.0, 3.0, 10.0].map(|cost: f64| [cost, 8.0 * cost.powi(-2)]);
    approx::assert_relative_eq!(ratio_at_equal_cost(&own, &other).unwrap(), 8.0, max_relative = 1e-14);
    approx::assert_relative_eq!(ratio_at_equal_cost(&other, &other).unwrap(), 1.0, max_relative = 1e-14);
}

#[test]
fn what_costs_more_or_less_than_all_of_the_other_is_no_comparison() {
    let other = [[1.0, 1.0], [4.0, 1.0]];
    assert_eq!(ratio_at_equal_cost(&[[0.5, 9.0], [5.0, 9.0], [2.0, 3.0]], &other).map(f64::round), Some(3.0));
    assert_eq!(ratio_at_equal_cost(&[[5.0, 9.0], [2.0, f64::NAN], [2.0, 0.0]], &other), None);
    assert_eq!(ratio_at_equal_cost(&other, &[[2.0, 1.0]]), None);
}

#[test]
fn a_threshold_tells_what_is_in_order_and_half_of_what_is_not() {
    let group =
        |holds: [bool; 4]| holds.into_iter().enumerate().map(|(k, holds)| (k as f64, holds)).collect::<Vec<_>>();
    let share = |groups: &[[bool; 4]]| share_told_by_threshold(groups.iter().copied().map(group));
    assert_eq!(share(&[[true, true, false, false]]), Some(1.0));
    assert_eq!([share(&[[true; 4]]), share(&[[false; 4]])], [Some(1.0); 2]);
    assert_eq!(share(&[[false, false, true, true]]), Some(0.5));
    // Two groups have a threshold each, and one for both is right less often.
    let (early, late) = ([true, false, false, false], [true, true, true, false]);
    assert_eq!(share(&[early, late]), Some(1.0));
    assert_eq!(share_told_by_threshold([[group(early), group(late)].concat()]), Some(0.75));
    assert_eq!(share(&[]), None);
}

#[test]
fn the_interval_of_a_share_is_wilson_s() {
    // Newcombe (1998), method 3: 81 of 263, and 0 of 20.
    let [low, high] = wilson_interval(81, 263).unwrap();
    approx::assert_abs_diff_eq!(low, 0.2553, epsilon = 5e-5);
    approx::assert_abs_diff_eq!(high, 0.3662, epsilon = 5e-5);
    let [low, high] = wilson_interval(0, 20).unwrap();
    approx::assert_abs_diff_eq!(low, 0.0, epsilon = 1e-15);
    approx::assert_abs_diff_eq!(high, 0.1611, epsilon = 5e-5);
    assert_eq!(wilson_interval(0, 0), None);
    assert_eq!(share_interval(&[]), None);
    // Groups of one are independent, but for the K − 1 of a variance that is estimated.
    let [low, high] = share_interval(&[vec![[1, 1]; 500], vec![[0, 1]; 500]].concat()).unwrap();
    let wanted = wilson_interval(500, 1000).unwrap();
    approx::assert_abs_diff_eq!(low, wanted[0], epsilon = 1e-4);
    approx::assert_abs_diff_eq!(high, wanted[1], epsilon = 1e-4);
    // Three members that always agree count once; groups that say the same are as many as they are.
    let thrice = share_interval(&[vec![[3, 3]; 50], vec![[0, 3]; 50]].concat()).unwrap();
    assert!(thrice[0] < wilson_interval(150, 300).unwrap()[0] - 0.03, "{thrice:?}");
    approx::assert_abs_diff_eq!(thrice[0], wilson_interval(50, 100).unwrap()[0], epsilon = 1e-3);
    assert_eq!(share_interval(&[[3, 3]; 20]), wilson_interval(20, 20));
}

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
    // One point has no strata to permute: the first outputs for this seed of the authors' program, as
    // java.util.SplittableRandom has them.
    let known = [6_457_827_717_110_365_317_u64, 3_203_168_211_198_807_973];
    assert_eq!(latin_hypercube(1, 2, 1_234_567)[0], known.map(|bits| (bits >> 11) as f64 * 2.0_f64.powi(-53)));
    // The correlation of two coordinates has the standard deviation 1/√(n − 1) of random permutations.
    let drawn = latin_hypercube(400, 2, 1);
    let correlation: f64 = drawn.iter().map(|point| 12.0 * (point[0] - 0.5) * (point[1] - 0.5) / 400.0).sum();
    assert!(correlation.abs() < 5.0 / 399.0_f64.sqrt(), "{correlation}");
}

#[test]
fn settings_are_compared_by_medians_a_failure_is_infinite_and_ties_are_told_apart() {
    let failed = f64::INFINITY;
    // Per setting the errors of one, of the other, and what the reference can tell.
    let settings: [(&[f64], &[f64], f64); 7] = [
        (&[1.0, 2.0, 9.0], &[3.0, 3.0, 3.0], 0.1),
        (&[1.0, 2.0], &[1.0, failed], f64::NAN),
        (&[4.0], &[3.0], 0.1),
        (&[failed], &[failed], 0.1),
        (&[0.05], &[0.09], 0.1),
        (&[2.0], &[2.0], 0.1),
        (&[f64::NAN], &[2.0], 0.1),
    ];
    let mut runs = Vec::new();
    for (index, (own, other, floor)) in settings.into_iter().enumerate() {
        for (is_other, errors) in [(false, own), (true, other)] {
            let macro_step = 1e-3 * (1.0 + index as f64);
            let run = |&error| PairedRun { problem: ["box", ""], macro_step, is_other, error, floor };
            runs.extend(errors.iter().map(run));
        }
    }
    // One failure among two runs is as bad as two, and no difference of percents.
    assert_eq!(Share::of(runs.clone(), 0.4), Share { better: 1, worse: 0, ties: 5 });
    let share = Share::of(runs, 0.0);
    assert_eq!(share, Share { better: 2, worse: 1, ties: 3 });
    assert_eq!(share.share(), Some(2.0 / 3.0));
    assert_eq!(Share::of([], 0.0).share(), None);
}
