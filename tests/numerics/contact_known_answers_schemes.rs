//! Every contact case with every scheme by name, and geometries that cannot be.

use crate::support::*;
use rimbench::cosim::Outcome;
use rimbench::runs::RunSpec;
use rimbench::schemes::Family;

const CASES: [&str; 10] = [
    "bouncing-ball",
    "impact-oscillator",
    "slider-between-stops",
    "cradle",
    "elastic-bar",
    "rocking-block",
    "beam-on-stops",
    "n-wedge-box",
    "wedge-box-two-ledges",
    "wedge-box-reversal",
];

fn spec(case: &str, scheme: &str, macro_steps: usize) -> RunSpec {
    let macro_step = case_by_name(case).defaults.macro_step_s;
    RunSpec { duration: macro_step * macro_steps as f64, phase: 0.6, ..usual_spec(case, scheme, macro_step) }
}

#[test]
fn every_case_must_run_with_every_scheme_or_say_why_not() {
    for name in CASES {
        for scheme in schemes() {
            let run = run(&spec(name, &scheme.name, 60));
            let outcome = &run.report.outcome;
            if let Outcome::Skipped { reason } = outcome {
                println!("{name} with {}: skipped, {reason}", scheme.name);
                assert!(!reason.is_empty());
                assert_ne!(scheme.family, Family::Model, "{name}: every contact case offers an interface model");
                continue;
            }
            assert!(!run.trajectory.is_empty(), "{name} with {}: {outcome:?} without a row", scheme.name);
            if matches!(outcome, Outcome::Completed) {
                // An effective mass may be infinite, nothing may be NaN.
                let sound = run.trajectory.rows().all(|row| row.iter().all(|value| !value.is_nan()));
                assert!(sound, "{name} with {}: a completed run holds NaN", scheme.name);
            }
            if scheme.name.starts_with("rim-nonsmooth") {
                assert!(matches!(outcome, Outcome::Completed), "{name} with {}: {outcome:?}", scheme.name);
            }
        }
    }
}

/// Case, what is set, what the message must say.
type Refusal = (&'static str, &'static [(&'static str, &'static str)], &'static [&'static str]);

#[test]
fn impossible_geometry_must_be_refused_with_the_numbers() {
    let refused: [Refusal; 15] = [
        ("bouncing-ball", &[("start_height_m", "-0.25")], &["start_height_m = -0.25", "0.25 m inside"]),
        (
            "bouncing-ball",
            &[("base_stiffness_n_m", "0"), ("base_amplitude_m", "0.3")],
            &["0.3 m", "base_stiffness_n_m"],
        ),
        ("impact-oscillator", &[("start_position_m", "0.06")], &["start_position_m = 0.06", "at most 0.05"]),
        ("slider-between-stops", &[("start_position_m", "-0.3")], &["start_position_m = -0.3", "at least -0.1"]),
        ("cradle", &[("start_position_m", "0.02")], &["start_position_m = 0.02", "0.02 m inside"]),
        ("elastic-bar", &[("elements", "2.5")], &["elements = 2.5", "whole number"]),
        ("rocking-block", &[("start_angle_rad", "0.5")], &["start_angle_rad = 0.5", "0.380506"]),
        ("rocking-block", &[("cylinder_length_m", "5")], &["cylinder_length_m = 5", "below 3.6"]),
        ("beam-on-stops", &[("stop_1_position_m", "2.5")], &["stop_1_position_m = 2.5", "from 0 to 2 m"]),
        ("beam-on-stops", &[("modes", "40")], &["modes = 40", "from 1 to 20"]),
        ("n-wedge-box", &[("supports", "65")], &["supports = 65", "from 2 to 64"]),
        ("n-wedge-box", &[("ledge_height_m", "3")], &["impossible geometry", "3.2"]),
        ("n-wedge-box", &[("spool_ramp_end_s", "0.05")], &["spool_ramp_end_s = 0.05", "0.1"]),
        ("wedge-box-two-ledges", &[("wedge_tip_y_m", "-0.5")], &["gap_right_support_m", "-0.05"]),
        ("wedge-box-two-ledges", &[("disc_pin_x_m", "0.1")], &["disc_pin_x_m = 0.1", "radius 0.2"]),
    ];
    for (name, set, wanted) in refused {
        let case = case_by_name(name);
        let mut parameters = case.default_parameters();
        let set_to = set.iter().try_for_each(|(key, value)| parameters.set(key, value));
        let built = set_to.and_then(|()| (case.build)(&parameters, solver()).map(drop));
        let Err(error) = built else { panic!("{name} with {set:?} was built") };
        let message = error.to_string();
        assert!(wanted.iter().all(|part| message.contains(part)), "{name} with {set:?}: {message}");
    }
}
