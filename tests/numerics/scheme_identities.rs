//! What schemes have in common and where they differ: identities that keep one scheme from going by two names, and the
//! limits of each on the two-mass oscillator (force–displacement, damped, both sides exact) as an independent
//! computation has them.

use crate::support::*;
use rimbench::harness::spectral_radius;

/// The damped oscillator from its own start, 1 s, 20 micro steps on both sides.
fn oscillator(scheme: &str, gain: Option<f64>, macro_step: f64) -> RunSpec {
    let spec = set_spec("linear-oscillator", &[("variant", "1")], scheme, macro_step);
    let gain = spec.scheme.gain_value(gain).unwrap();
    spec.changed(|own| (own.gain, own.micro_step, own.duration) = (gain, macro_step / 20.0, 1.0))
}

fn with_sequence(spec: RunSpec, sequence: &str, force_return: &str) -> RunSpec {
    spec.changed(|own| (own.sequence, own.force_return) = (sequence.parse().unwrap(), force_return.parse().unwrap()))
}

fn trajectory_of(spec: &RunSpec) -> Trajectory {
    completed(spec).trajectory
}

/// Largest difference of two runs in any column, relative to the largest magnitude in it.
fn difference(a: &Trajectory, b: &Trajectory) -> f64 {
    assert_eq!(a.len(), b.len());
    let of_column = |column: usize| {
        let size = a.column(column).fold(f64::MIN_POSITIVE, |size, value| size.max(value.abs()));
        a.column(column).zip(b.column(column)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / size
    };
    (0..a.columns().len()).map(of_column).fold(0.0, f64::max)
}

/// A thousand steps amplify a rounding by no more than this where the runs are stable.
const ROUND_OFF: f64 = 1e-10;

#[test]
fn with_their_gain_at_zero_schemes_are_what_they_are_built_on() {
    for (scheme, gain, base) in [
        ("nepce", 0.0, "zero-order-hold"),
        ("integral-correction-first-order", 0.0, "first-order-hold"),
        ("energy-leak-damper", 0.0, "zero-order-hold"),
    ] {
        for sequence in ["jacobi", "gauss-seidel-mechanics-first"] {
            let of = |scheme, gain| trajectory_of(&with_sequence(oscillator(scheme, gain, 2e-3), sequence, "held"));
            let difference = difference(&of(scheme, Some(gain)), &of(base, None));
            assert!(difference < ROUND_OFF, "{scheme} and {base}, {sequence}: {difference:e}");
        }
    }
}

/// κ = 0 leaves the acceleration held, but in the micro steps of an interface model: the same up to δ.
#[test]
fn an_infinite_interface_mass_is_the_true_acceleration() {
    let off = |micro_steps: f64| {
        let fine = |spec: RunSpec| {
            let spec = spec.changed(|own| own.micro_step = 2e-3 / micro_steps);
            trajectory_of(&with_sequence(spec, "gauss-seidel", "mean"))
        };
        let mass = fine(oscillator("interface-mass", Some(0.0), 2e-3));
        difference(&mass, &fine(oscillator("true-acceleration", None, 2e-3)))
    };
    let (coarse, fine) = (off(20.0), off(40.0));
    assert!((coarse / fine - 2.0).abs() < 0.1, "{coarse:e}, then {fine:e}");
}

#[test]
fn the_true_interface_mass_without_contacts_is_a_reduced_interface_model() {
    for force_return in ["mean", "profile"] {
        let of = |scheme: &str, gain| {
            trajectory_of(&with_sequence(oscillator(scheme, gain, 5e-3), "gauss-seidel", force_return))
        };
        let difference = difference(&of("interface-mass", Some(1.0)), &of("rim-nonsmooth", None));
        assert!(difference < ROUND_OFF, "{force_return}: {difference:e}");
    }
    let [one, other] = ["interface-mass", "rim-nonsmooth"].map(|scheme| scheme_by_name(scheme).order);
    assert_eq!(one, other, "what is the same has one order");
}

/// Corrected outputs differ from sent ones by mobility times missing impulse: mechanics that nothing moves leaves the
/// true acceleration, and what is left otherwise falls as the mobility does.
#[test]
fn outputs_of_immovable_mechanics_corrected_without_repayment_are_the_true_acceleration() {
    let off = |mass: &str, gain: f64| {
        let of = |scheme: &str, gain| {
            let mut spec = with_sequence(oscillator(scheme, gain, 2e-3), "jacobi", "held");
            // The mechanics is the side of mass 2, on a spring that would move a light one as far as ever.
            spec = spec.changed(|own| own.parameters.set("mass_2_kg", mass).unwrap());
            trajectory_of(&spec)
        };
        difference(&of("model-corrected-outputs", Some(gain)), &of("true-acceleration", None))
    };
    let [light, heavy] = ["1e3", "1e5"].map(|mass| off(mass, 0.0));
    assert!((heavy / light * 100.0 - 1.0).abs() < 0.1, "{light:e}, then {heavy:e}");
    assert!(off("1e12", 0.0) < ROUND_OFF, "{:e}", off("1e12", 0.0));
    let [one, other] = ["model-corrected-outputs", "true-acceleration"].map(|scheme| scheme_by_name(scheme).order);
    assert_eq!(one, other, "what becomes the same has one order");
    // With repayment something else is told to the mechanics.
    assert!(off("1e3", 1.0) > 2.0 * light, "{:e} and {light:e}", off("1e3", 1.0));
}

/// A backward difference of the velocity in its place would have every digit of linear extrapolation in the velocity;
/// the true acceleration must differ from it, most of all after an impact.
#[test]
fn a_true_acceleration_is_not_linear_extrapolation() {
    let far = difference(
        &trajectory_of(&oscillator("true-acceleration", None, 2e-3)),
        &trajectory_of(&oscillator("first-order-hold", None, 2e-3)),
    );
    assert!(far > 1e-5, "{far:e}");
}

/// Scheme, gain, sequence, limit in ms, relative width within which it must be met, micro steps per macro step.
type Limit = (&'static str, Option<f64>, &'static str, f64, f64, f64);

/// From the specification's independent computation (linear maps with exact subsystems).
const LIMITS: &[Limit] = &[
    ("interface-exponential", None, "jacobi", 39.6, 1e-2, 8.0),
    ("model-corrected-outputs", None, "jacobi", 40.7, 1e-2, 200.0),
    ("interface-mass", Some(1.0), "jacobi", 37.8, 2e-2, 400.0),
    ("nepce", None, "jacobi", 5.50, 1e-2, 400.0),
    ("nepce", Some(0.5), "jacobi", 0.52, 2e-2, 400.0),
    ("integral-correction-first-order", None, "jacobi", 27.87, 1e-2, 200.0),
    ("integral-correction-first-order", Some(0.5), "jacobi", 12.34, 1e-2, 200.0),
];

/// Schemes that have no limit up to 45 ms.
const STABLE: &[(&str, Option<f64>, &str)] = &[
    ("true-acceleration", None, "jacobi"),
    ("true-acceleration", None, "gauss-seidel"),
    ("interface-mass", Some(0.5), "gauss-seidel"),
];

#[test]
fn the_limits_of_the_schemes_are_those_of_the_independent_computation() {
    let radius = |scheme: &str, gain, sequence: &str, h: f64, micro_steps: f64| {
        let force_return = if sequence == "gauss-seidel" { "mean" } else { "held" };
        let spec = oscillator(scheme, gain, h).changed(|own| own.micro_step = h / micro_steps);
        spectral_radius(&with_sequence(spec, sequence, force_return))
    };
    let mut faults = Vec::new();
    for &(scheme, gain, sequence, limit, width, micro_steps) in LIMITS {
        let at = |h: f64| radius(scheme, gain, sequence, 1e-3 * h, micro_steps);
        match (at(limit * (1.0 - width)), at(limit * (1.0 + width))) {
            (Ok(below), Ok(above)) if below < 1.0 && above > 1.0 => {}
            found => faults.push(format!("{scheme} {gain:?} {sequence} at {limit} ms: {found:?}")),
        }
    }
    for &(scheme, gain, sequence) in STABLE {
        for step in 1..=9 {
            let found = radius(scheme, gain, sequence, 5e-3 * f64::from(step), 40.0);
            if !found.as_ref().is_ok_and(|radius| *radius < 1.0 + 1e-9) {
                faults.push(format!("{scheme} {gain:?} {sequence} at {} ms: {found:?}", 5 * step));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The exactness theorem: where nothing in the mechanics changes within a macro step, the model with all contacts is
/// the mechanics, and the co-simulation the monolithic stepper. The cases that claim it must show it, and no other may.
#[test]
fn a_run_whose_model_is_exact_is_the_monolithic_stepper_and_others_are_not() {
    let mut exact_cases = Vec::new();
    for case in cases().iter().filter(|case| case.linear_state.is_empty()) {
        let macro_step = case.defaults.macro_step_s;
        let usual = usual_spec(&case.name, "rim-nonsmooth-gap", macro_step);
        let profile = with_sequence(usual, "gauss-seidel", "profile").changed(|own| own.mechanics_steps = ALL);
        assert_eq!(profile.model_is_exact(), case.constant_mechanics, "{}", case.name);
        if !case.constant_mechanics {
            continue;
        }
        exact_cases.push(case.name.clone());
        let together = trajectory_of(&usual_spec(&case.name, "monolithic", macro_step));
        let own = trajectory_of(&profile);
        let (off, peak) = apart(&together, &own, &case.interface_columns[0].force);
        // Round-off, amplified by impacts.
        assert!(off < 1e-4 * peak, "{}: {off:e} of {peak:e} N", case.name);
    }
    assert!(exact_cases.len() > 5, "{exact_cases:?}");
    let mean = usual_spec("bouncing-ball", "rim-nonsmooth-gap", 1e-2);
    assert!(!mean.model_is_exact());
}

/// Rms force errors of the independent implementation, wedge box, median over 4 phases, N; H in ms.
#[test]
fn the_hold_with_the_mechanics_first_has_the_errors_of_the_independent_implementation() {
    let median_error = |sequence: &str, force_return: &str, macro_step: f64| {
        let errors = [1.0, 0.381966, 0.763932, 0.145898].map(|phase| {
            let spec = with_sequence(wedge_box_spec("zero-order-hold", macro_step), sequence, force_return);
            let spec = spec.changed(|own| own.phase = phase);
            metric(&spec, completed(&spec), wedge_box_reference(), "force_error_rms_n")
        });
        Pool::of(errors).median().unwrap()
    };
    let mechanics_first = "gauss-seidel-mechanics-first";
    for (h, first, end) in [(1e-3, 3.0, 7.0), (2e-3, 5.9, 13.5), (3e-3, 10.8, 20.6), (5e-3, 31.8, 39.1)] {
        for (found, published) in
            [(median_error(mechanics_first, "held", h), first), (median_error("gauss-seidel", "end", h), end)]
        {
            assert!((found / published - 1.0).abs() < 0.02, "{h} s: {found} N, there {published} N");
        }
    }
}
