//! What an actuator put out within a macro step, in parts and in pieces.

use crate::support::*;

#[test]
fn means_share_out_straddling_micro_steps_and_keep_the_impulse() {
    let mut history = OutputHistory::new(1, 3);
    for force in [1.0, 2.0, 6.0] {
        history.push(&[force]);
    }
    let mean = |index, parts| {
        let mut out = [0.0];
        history.mean_over(index, parts, &mut out);
        out[0]
    };
    approx::assert_relative_eq!(mean(0, 1), 3.0, epsilon = 1e-15);
    // Halves: (1 + ½·2)/1.5 and (½·2 + 6)/1.5.
    approx::assert_relative_eq!(mean(0, 2), 2.0 / 1.5, epsilon = 1e-15);
    approx::assert_relative_eq!(mean(1, 2), 7.0 / 1.5, epsilon = 1e-15);
    for parts in 1..8 {
        let total: f64 = (0..parts).map(|index| mean(index, parts)).sum();
        approx::assert_relative_eq!(total / parts as f64, 3.0, epsilon = 1e-14);
    }
}

proptest::proptest! {
    #[test]
    fn the_parts_of_a_macro_step_hand_over_its_impulse_whatever_the_outputs_and_their_number(
        outputs in proptest::collection::vec([-1e4f64..1e4, -1e4f64..1e4], 1..60),
        parts in 1usize..80,
    ) {
        let mut history = OutputHistory::new(2, outputs.len());
        outputs.iter().for_each(|output| history.push(output));
        let (mut mean, mut total) = ([0.0; 2], [0.0; 2]);
        for index in 0..parts {
            history.mean_over(index, parts, &mut mean);
            for row in 0..2 {
                total[row] += mean[row] / parts as f64;
                // A mean lies among what it is made of.
                let least = outputs.iter().map(|output| output[row]).fold(f64::INFINITY, f64::min);
                let greatest = outputs.iter().map(|output| output[row]).fold(f64::NEG_INFINITY, f64::max);
                proptest::prop_assert!(mean[row] >= least - 1e-9 && mean[row] <= greatest + 1e-9);
            }
        }
        for row in 0..2 {
            let exact = outputs.iter().map(|output| output[row]).sum::<f64>() / outputs.len() as f64;
            // Each of at most 140 shares is rounded a few times: 1e4 * 140 * 1e-16 * a few.
            proptest::prop_assert!((total[row] - exact).abs() < 1e-9, "{} against {exact}", total[row]);
        }
    }
}
