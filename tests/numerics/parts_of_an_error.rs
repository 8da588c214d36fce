//! The error of a run in two parts: that of the coupling and that of the mechanics' own step.

use crate::support::*;
use rimbench::harness::{Cache, obtain_reference};

/// The run with its error divided, and the peak of the force, N.
fn divided(spec: &RunSpec) -> (EvaluatedRun, f64) {
    let spec = spec.with(|own| own.divide_error = true).unwrap();
    let reference = obtain_reference(&spec, &Cache::of_user(), StopFlag::never()).unwrap();
    let run = spec.prepare().unwrap().evaluate(&reference, false, false, None, StopFlag::never()).unwrap();
    let [rms, share] = ["force_error_rms_n", "force_error_rms_of_peak"].map(|name| run.found.metric(name).unwrap());
    (run, rms / share)
}

/// The parts over the peak, and the coupling's share.
fn parts(spec: &RunSpec) -> [f64; 3] {
    let (run, peak) = divided(spec);
    let of = |name: &str| run.found.metric(name).unwrap_or_else(|| panic!("{name}: {:?}", run.undivided));
    [of("coupling_distance_rms_n") / peak, of("mechanics_distance_rms_n") / peak, of("coupling_share")]
}

/// Projections on the error: with that of the other part the share is one, whatever the parts are.
#[test]
fn shares_of_the_parts_sum_to_one_at_every_phase() {
    for (scheme, phase, steps) in
        [("rim-nonsmooth", "1", "1"), ("interface-mass", "0.3", "4"), ("zero-order-hold", "0.7", "5")]
    {
        let options = [("macro_step_s", "2e-3"), ("phase", phase), ("mechanics_steps", steps), ("duration_s", "0.4")];
        let spec = spec_with("gripper", scheme, &options, &[]);
        let (run, _) = divided(&spec);
        let metric = |name: &str| run.found.metric(name).unwrap();
        let [error, a, b] = ["force_error_rms_n", "coupling_distance_rms_n", "mechanics_distance_rms_n"].map(metric);
        // |b|² = |e − a|² = |e|² − 2⟨e, a⟩ + |a|², all of the row with the largest error.
        let share = (error * error + a * a - b * b) / (2.0 * error * error);
        approx::assert_relative_eq!(metric("coupling_share"), share, epsilon = 1e-9, max_relative = 1e-9);
    }
}

/// With one step of the mechanics per macro step the centre is the own-step model itself.
#[test]
fn the_own_step_model_with_one_step_is_its_own_centre() {
    for phase in ["1", "0.4"] {
        let options = [("macro_step_s", "5e-3"), ("phase", phase), ("contacts_act", "mechanics-step")];
        let [coupling, mechanics, share] = parts(&spec_with("wedge-box", "rim-nonsmooth-gap", &options, &[]));
        assert!(coupling <= 1e-6 && share.abs() <= 1e-6 && mechanics > 1e-3, "{coupling} {mechanics} {share}");
    }
}

/// Measured in a trial: 5e-7 and 4e-8 of the peak; where rows turn within the macro step there is a coupling to speak of.
#[test]
fn where_no_row_turns_the_own_step_model_with_several_steps_is_its_centre_too() {
    let options = [
        ("macro_step_s", "10e-3"),
        ("mechanics_step_s", "1e-3"),
        ("force_return", "profile"),
        ("contacts_act", "mechanics-step"),
    ];
    for case in ["disc-row", "lift-table"] {
        let [coupling, ..] = parts(&spec_with(case, "rim-nonsmooth-gap", &options, &[]));
        assert!(coupling <= 1e-5, "{case}: {coupling}");
    }
    let [coupling, ..] = parts(&spec_with("wedge-box", "rim-nonsmooth-gap", &options, &[]));
    approx::assert_relative_eq!(coupling, 0.28e-2, max_relative = 0.1);
}

/// A run can be nearer to the reference than its centre: then the parts cancel, and the share says so.
#[test]
fn parts_that_cancel_have_a_share_beyond_one() {
    let spec = spec_with("lift-table", "rim-nonsmooth", &[("macro_step_s", "10e-3")], &[]);
    let [coupling, mechanics, share] = parts(&spec);
    let (run, _) = divided(&spec);
    let error = run.found.metric("force_error_rms_of_peak").unwrap();
    assert!(share > 1.5 && error < mechanics && error < coupling, "{error}: {coupling}, {mechanics}, {share}");
}

#[test]
fn without_a_centre_there_is_no_division_and_the_reason_is_said() {
    for (options, why) in [
        (&[("mechanics_integrator", "event-split"), ("actuator_integrator", "midpoint")][..], "event-split"),
        (&[("step_control", "energy-residual"), ("step_tolerance", "1e-3")][..], "step control"),
    ] {
        let options = [&[("macro_step_s", "5e-3"), ("duration_s", "0.2")][..], options].concat();
        let (run, _) = divided(&spec_with("wedge-box", "rim-nonsmooth-gap", &options, &[]));
        assert!(run.undivided.as_ref().unwrap().contains(why), "{:?}", run.undivided);
        assert_eq!(run.found.metric("coupling_share"), None);
    }
}

/// Dividing is another run beside it: of the run itself no digit and no count changes, nor its id.
#[test]
fn a_run_is_the_same_whether_its_error_is_divided_or_not() {
    let spec = spec_with("wedge-box", "rim-nonsmooth", &[("macro_step_s", "5e-3"), ("duration_s", "0.3")], &[]);
    let reference = obtain_reference(&spec, &Cache::of_user(), StopFlag::never()).unwrap();
    let evaluate =
        |spec: &RunSpec| spec.prepare().unwrap().evaluate(&reference, true, true, None, StopFlag::never()).unwrap();
    let with = spec.with(|own| own.divide_error = true).unwrap();
    let (plain, divided) = (evaluate(&spec), evaluate(&with));
    assert_eq!((spec.id(), &plain.trajectory, plain.found.work), (with.id(), &divided.trajectory, divided.found.work));
}
