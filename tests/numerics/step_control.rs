//! Step control: the error must stay near the tolerance, no step may go uncounted, and the times must add up.

use crate::support::*;

use StepControlKind::{EnergyResidual, StepDoubling};

/// The quarter car over its step, chassis and wheel integrated exactly, so that all error is the coupling's.
fn quarter_car(scheme: &str, coupling: &str, macro_step: f64, control: StepControl) -> RunSpec {
    RunSpec {
        step_control: control,
        micro_step: 1e-3,
        mechanics_steps: MechanicsSteps::AsActuator,
        sequence: Sequence::Jacobi,
        force_return: ForceReturn::Held,
        duration: 2.0,
        ..set_spec("quarter-car", &[("coupling", coupling)], scheme, macro_step)
    }
}

fn control(kind: StepControlKind, tolerance: f64, macro_step: f64) -> StepControl {
    StepControl::new(kind, Some(tolerance), None, macro_step).unwrap()
}

/// Largest error of the wheel's position over the run, m; the step in the road is 0.1 m.
fn error(result: &RunResult) -> f64 {
    let case = case_by_name("quarter-car");
    let solution = exact_solution(case, &case.default_parameters());
    let wheel = result.trajectory.index_of("x2_m").unwrap();
    let mut exact = vec![0.0; result.trajectory.columns().len()];
    largest(result.trajectory.rows().map(|row| {
        solution(row[0], &mut exact);
        (row[wheel] - exact[wheel]).abs()
    }))
}

#[test]
fn a_smaller_tolerance_must_buy_a_smaller_error_with_more_steps() {
    // The first step is short (φ = 0.02): the energy residual takes nothing back, so what a long first step costs at the
    // step of the road would stay, whatever the tolerance.
    for (name, tolerances) in [(StepDoubling, [1e-2, 1e-3, 1e-4]), (EnergyResidual, [1e-1, 1e-2, 1e-3])] {
        for scheme in ["zero-order-hold", "first-order-hold"] {
            let mut last = (f64::INFINITY, 0);
            for tolerance in tolerances {
                let control = control(name, tolerance, 2e-2);
                let result =
                    completed(&RunSpec { phase: 0.02, ..quarter_car(scheme, "force-displacement", 2e-2, control) });
                let (error, steps) = (error(&result), result.report.work.cosim.macro_steps);
                assert!(
                    error < last.0 && steps > last.1,
                    "{name} {scheme} {tolerance:e}: {error:e} m in {steps} steps"
                );
                last = (error, steps);
            }
        }
    }
}

#[test]
fn times_must_add_up_and_every_step_must_be_counted() {
    for name in [StepDoubling, EnergyResidual] {
        for phase in [1.0, 0.3] {
            let control = control(name, 1e-2, 1e-2);
            let result = run(&RunSpec { phase, ..quarter_car("zero-order-hold", "force-displacement", 1e-2, control) });
            let (counters, rule) = (result.report.work.cosim, *control.rule().unwrap());
            let time = column(&result.trajectory, "time_s");
            assert_eq!((time[0], *time.last().unwrap(), result.report.ended_at_s), (0.0, 2.0, 2.0));
            assert_eq!(time.len() as u64, counters.macro_steps + 1);
            let lengths: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let whole = if name == StepDoubling { 2.0 } else { 1.0 };
            // Differences of times up to 2 s are rounded to 4e-16 s.
            assert!(largest(lengths.iter().copied()) <= 1e-2 / whole + 1e-15);
            let shortest = smallest(lengths[..lengths.len() - whole as usize].iter().copied());
            assert!(shortest >= rule.shortest / whole - 1e-15, "{name}: {shortest}");
            assert!(lengths.iter().any(|length| *length < 0.9e-2 / whole), "{name}: nothing was controlled");
            // The longest first step, φH, is what the run starts from; doubling may already have taken it back.
            if name == EnergyResidual {
                assert_eq!((time[1], counters.repeated_macro_steps), (phase * 1e-2, 0));
                assert_eq!(counters.exchanges, counters.macro_steps + 1);
            } else {
                // An accepted pair costs one whole step besides, a rejected one three.
                let rejected = counters.repeated_macro_steps - counters.macro_steps / 2;
                assert_eq!((counters.macro_steps % 2, rejected % 3), (0, 0));
                assert!(rejected > 0, "nothing was ever rejected");
                assert_eq!(counters.exchanges, counters.macro_steps + counters.repeated_macro_steps + 1);
            }
            assert!(
                result.report.work.sides.actuator.micro_steps >= counters.macro_steps + counters.repeated_macro_steps
            );
        }
    }
}

#[test]
fn a_tolerance_that_nothing_exceeds_must_leave_the_steps_of_half_the_grid() {
    // The accepted solution of step doubling is that of the grid of H/2, bit for bit, if nothing shortens the steps.
    let control = control(StepDoubling, 1e9, 1e-2);
    let doubled = run(&quarter_car("first-order-hold", "force-displacement", 1e-2, control));
    let plain = run(&quarter_car("first-order-hold", "force-displacement", 5e-3, StepControl::None));
    assert_eq!(doubled.report.work.cosim.macro_steps, plain.report.work.cosim.macro_steps);
    // Times are sums in one and products in the other: 400 roundings of 2 s, with velocities of 2 m/s.
    let (own, other) = (column(&doubled.trajectory, "x2_m"), column(&plain.trajectory, "x2_m"));
    assert!(max_difference(&own, &other) < 400.0 * 4e-16 * 10.0, "{}", max_difference(&own, &other));
    assert_eq!(doubled.report.work.cosim.repeated_macro_steps * 2, doubled.report.work.cosim.macro_steps);
}

#[test]
fn a_control_that_cannot_work_must_be_skipped_with_the_reason() {
    let control = control(EnergyResidual, 1e-2, 1e-2);
    let result = run(&quarter_car("zero-order-hold", "displacement-displacement", 1e-2, control));
    assert!(result.report.outcome.reason().contains("work both sides count"), "{}", result.report.outcome);
}

#[test]
fn a_step_control_must_change_the_run_id_and_nothing_else_may() {
    let plain = quarter_car("zero-order-hold", "force-displacement", 1e-2, StepControl::None);
    let controlled = |tolerance| RunSpec { step_control: control(StepDoubling, tolerance, 1e-2), ..plain.clone() };
    assert_ne!(plain.id(), controlled(1e-2).id());
    assert_ne!(controlled(1e-3).id(), controlled(1e-2).id());
    assert_eq!(controlled(1e-3).id(), controlled(1e-3).id());
}
