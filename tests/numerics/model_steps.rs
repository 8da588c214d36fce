//! Macro steps placed by the scheme's own model: what the defect is, where it settles, and where communication points
//! then lie.

use crate::support::*;

/// A run with its steps placed by the model, both sides of the second order.
fn placed(case: &str, kind: StepControl, tolerance: f64, macro_step: f64) -> RunSpec {
    let step_control = StepRule::new(kind, Some(tolerance), None, macro_step).unwrap();
    usual_spec(case, "rim-nonsmooth-gap", macro_step).changed(|own| {
        (own.step_control, own.mechanics_integrator, own.actuator_integrator) =
            (step_control, MechanicsIntegrator::EventSplit, ActuatorIntegrator::Midpoint)
    })
}

/// The spring of the impact oscillator is all there is between the sides: e = k |s_model − s|, s_model being what the
/// actuator was told in the last micro step, s what the mechanics says at the communication point. Both are read from
/// what a run stores anyway.
#[test]
fn the_defect_must_be_the_spring_constant_times_what_the_actuator_was_told_wrong() {
    let kind = StepControl::ModelDefectBlind;
    let spec = placed("impact-oscillator", kind, 1e-4, 1e-2)
        .changed(|own| (own.actuator_integrator, own.duration) = (ActuatorIntegrator::Euler, 1.0));
    let result = simulate_inside(&spec, Bounds::default(), None, StopFlag::never()).unwrap();
    let stiffness = spec.parameters.setting::<f64>("spring_stiffness_n_m").unwrap();
    let (told, defects) = (result.report.inside.unwrap(), &result.report.model_defect);
    let (time, position) = (column(&result.trajectory, "time_s"), column(&result.trajectory, "interface_position_m"));
    assert_eq!(defects.len(), time.len() - 1);
    let told_position = told.index_of("interface_position_m").unwrap();
    let mut micro_steps = told.rows();
    let mut last = f64::NAN;
    let mut next = micro_steps.next();
    for (k, [at, defect]) in defects.iter().enumerate() {
        assert_eq!(*at, time[k + 1]);
        while let Some(row) = next.filter(|row| row[0] < at - 1e-12) {
            (last, next) = (row[told_position], micro_steps.next());
        }
        // Positions of a few centimetres are rounded to 1e-17 m.
        let expected = stiffness * (last - position[k + 1]).abs();
        assert!((defect - expected).abs() < 1e-13, "at {at} s: {defect:e} N, {expected:e} N");
    }
    assert!(defects.iter().any(|[_, defect]| *defect > 1e-3), "there was nothing to see");
}

/// Where nothing happens and no limit binds, the defect in units of what is allowed settles at 1; it wanders about it
/// by what the motion changes from step to step.
#[test]
fn the_rule_must_keep_the_defect_of_the_model_at_the_tolerance() {
    for tolerance in [1e-4, 1e-5] {
        let spec = placed("crane-set-down", StepControl::ModelDefectBlind, tolerance, 2e-2);
        let result = completed(&spec);
        let (time, force) = (column(&result.trajectory, "time_s"), column(&result.trajectory, "actuator_force_n"));
        let mut largest = 0.0_f64;
        let mut settled = Vec::new();
        for (k, [_, defect]) in result.report.model_defect.iter().enumerate() {
            largest = largest.max(force[k].abs()).max(force[k + 1].abs());
            let length = time[k + 1] - time[k];
            if length < 0.99 * spec.macro_step && length > 1.01 * spec.step_control.unwrap().shortest {
                settled.push(defect / (tolerance * largest));
            }
        }
        settled.sort_by(f64::total_cmp);
        let median = settled[settled.len() / 2];
        assert!((0.5..=2.0).contains(&median), "{tolerance:e}: {median}");
    }
}

/// A ball that falls on the floor at v > 1 m/s: from height, speed and g alone one can say when it will arrive. The
/// communication point after it comes a twentieth of that time later, or after the shortest step; without looking at
/// closings it comes anywhere.
#[test]
fn a_communication_point_must_lie_just_after_each_impact_that_the_model_foresees() {
    let late = |kind| {
        let spec = placed("bouncing-ball", kind, 1.0, 1e-2).changed(|own| own.duration = 1.5);
        let shortest = spec.step_control.unwrap().shortest;
        let result = completed(&spec);
        let [time, gap, velocity] =
            ["time_s", "gap_floor_m", "interface_velocity_m_s"].map(|name| column(&result.trajectory, name));
        let impacts = (0..time.len() - 1).filter(|&k| velocity[k] < -1.0 && velocity[k + 1] > 0.0);
        let late: Vec<f64> = impacts
            .map(|k| {
                let arrival = 2.0 * gap[k] / ((velocity[k].powi(2) + 2.0 * 9.81 * gap[k]).sqrt() - velocity[k]);
                let length = time[k + 1] - time[k];
                (length / arrival.max(shortest / 1.05)) - 1.0
            })
            .collect();
        assert!(late.len() >= 2, "only {} impacts", late.len());
        late
    };
    // The springs add up to 3 m/s² to the 10 of gravity, which changes an arrival within 10 ms by 0.4 % at 4 m/s.
    let foreseen = late(StepControl::ModelDefect);
    assert!(foreseen.iter().all(|late| (0.04..=0.06).contains(late)), "{foreseen:?}");
    let blind = late(StepControl::ModelDefectBlind);
    assert!(blind.iter().any(|late| !(0.04..=0.06).contains(late)), "{blind:?}");
}

#[test]
fn nothing_must_be_taken_back_or_exchanged_for_it_and_a_smaller_tolerance_must_take_more_steps() {
    let mut last = 0;
    for tolerance in [1e-2, 1e-4, 1e-6] {
        let counters =
            completed(&placed("impact-oscillator", StepControl::ModelDefect, tolerance, 2e-2)).report.work.cosim;
        assert_eq!((counters.repeated_macro_steps, counters.exchanges), (0, counters.macro_steps + 1));
        assert!(counters.macro_steps > last, "{tolerance:e}: {} steps", counters.macro_steps);
        last = counters.macro_steps;
    }
}
