//! `hydraulic-line`: one result whatever the sequence, order 2 against the chambers, an account that closes.

use crate::support::*;

fn spec(case: &str, macro_step: f64, sequence: Sequence) -> RunSpec {
    let spec = in_sequence(usual_spec(case, "hydraulic-line", macro_step), sequence);
    spec.changed(|own| (own.mechanics_steps, own.phase) = (ALL, 0.3))
}

#[test]
fn the_three_sequences_give_one_result() {
    for (case, duration) in [("wedge-box", 1.72), ("gripper", 0.6), ("hydraulic-crane", 0.5)] {
        let runs = SEQUENCES.map(|sequence| run(&spec(case, 1e-3, sequence).changed(|own| own.duration = duration)));
        for other in &runs {
            assert_eq!(other.report.outcome, Outcome::Completed, "{case}");
            assert_eq!(other.trajectory, runs[0].trajectory, "{case}");
        }
    }
}

/// The opening of the valve on the wedge box, without contact events, against the monolithic stepper with the same
/// micro step.
#[test]
fn against_the_chambers_the_order_is_two() {
    let (duration, micro_step) = (0.3, 1e-5);
    let at = |scheme: &str, macro_step: f64| {
        let usual = usual_spec("wedge-box", scheme, macro_step);
        let run = completed(
            &usual.changed(|own| (own.micro_step, own.duration, own.mechanics_steps) = (micro_step, duration, ALL)),
        );
        run.trajectory
    };
    let points: Vec<(f64, f64)> = [2e-3, 1e-3, 5e-4]
        .into_iter()
        .map(|macro_step| {
            let (own, chambers) = (at("hydraulic-line", macro_step), at("monolithic", macro_step));
            let of = |run: &_| column(run, "actuator_length_m");
            (macro_step, rms_difference(&of(&own), &of(&chambers)))
        })
        .collect();
    let order = order_of_convergence(&points).unwrap();
    assert!((1.8..2.3).contains(&order), "{points:?}: order {order}");
}

#[test]
fn the_account_closes_with_and_without_smoothing() {
    for (case, duration) in [("wedge-box", 1.72), ("gripper", 0.6)] {
        for gain in [0.0, 0.2] {
            let name = format!("{case}, α = {gain}");
            let result =
                run(&spec(case, 1e-3, Sequence::Jacobi)
                    .changed(|own| (own.duration, own.gain) = (duration, Some(gain))));
            assert_eq!(result.report.outcome, Outcome::Completed, "{name}");
            let audit = result.report.audit;
            let (closure, pump) = (audit.closure().unwrap(), audit.accounts.actuator.unwrap().pump);
            // Sums of some 2e5 roundings of the energy that passes the pump.
            assert!(closure.abs() < 2e5 * f64::EPSILON * pump.abs().max(1.0), "{name}: {closure:e} of {pump}");
        }
    }
}
