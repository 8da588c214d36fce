//! What is asked of a run, and what then determines it.

use crate::support::*;
use rimbench::cases::PossibleSteps;
use rimbench::catalogue::Catalogue;
use rimbench::runs::Given;
use std::collections::HashMap;
use std::sync::Arc;

#[test]
fn a_request_written_as_texts_is_read_as_the_same() {
    let mut request = RunRequest::of("wedge-box", "nepce");
    for (key, text) in [
        ("sequence", "gauss-seidel-mechanics-first"),
        ("force_return", "profile"),
        ("mechanics_steps", "10"),
        ("contact_detection", "margin:1e-3"),
        ("gain", "0.1"),
        ("macro_step_s", "1.3e-4"),
        ("step_control", "energy-residual-libcosim"),
    ] {
        request.put(key, text).unwrap();
    }
    let mut again = RunRequest::default();
    request.given().into_iter().for_each(|(key, value)| again.put(key, &value.to_string()).unwrap());
    assert_eq!(again, request);
    assert_eq!(request.given().len(), 9);
    // A number stays the number that it is.
    again.put("macro_step_s", f64::from_bits(0x3f21_2345_6789_abcd)).unwrap();
    assert_eq!(again.macro_step_s.map(f64::to_bits), Some(0x3f21_2345_6789_abcd));
}

fn refused(change: impl FnOnce(&mut RunRequest)) -> String {
    let mut request = RunRequest::of("wedge-box", "zero-order-hold");
    change(&mut request);
    request.resolve(&Catalogue::standard()).unwrap_err().to_string()
}

#[test]
fn what_a_scheme_does_not_have_cannot_be_asked_of_it() {
    let message = refused(|request| request.gain = Some(0.5));
    assert!(message.contains("has no gain; schemes that have one: ") && message.contains("nepce"), "{message}");
    for (key, text) in [("model_motion", "frozen"), ("contact_detection", "active")] {
        let message = refused(|request| request.put(key, text).unwrap());
        assert_eq!(message, format!("{key} = {text}: scheme `zero-order-hold` has no reduced interface model"));
    }
}

#[test]
fn a_contact_detection_that_a_scheme_does_not_have_is_refused_with_what_it_has() {
    for (scheme, text, wanted) in [
        ("rim-nonsmooth-gap", "active", "its contacts are all that there are"),
        ("rim-fixed-mass", "margin:1e-3", "its contacts are all that there are"),
        ("rim-smooth", "mechanics-law", "use `active` or `margin:<m>`"),
    ] {
        let message = refused(|request| {
            request.scheme = Some(scheme.into());
            request.put("contact_detection", text).unwrap();
        });
        assert!(message.starts_with(&format!("contact_detection = {text}: scheme `{scheme}`")), "{message}");
        assert!(message.contains(wanted), "{message}");
    }
}

#[test]
fn runs_that_are_equal_have_one_id_and_what_has_no_effect_is_refused() {
    let resolved = |scheme: &str, options: &[(&str, &str)]| {
        let mut request = RunRequest::of("wedge-box", scheme);
        options.iter().for_each(|(key, value)| request.put(key, value).unwrap());
        request.resolve(&Catalogue::standard()).unwrap()
    };
    let steps = |steps: &'static str, phase: &'static str| {
        let options = [("macro_step_s", "1e-3"), ("duration_s", "0.5"), ("mechanics_steps", steps), ("phase", phase)];
        resolved("rim-smooth", &options)
    };
    // The micro step is 0.05 ms.
    assert_eq!(steps("20", "1.0").id(), steps("all", "1.0").id());
    assert_eq!(steps("20", "1.0").mechanics_steps, MechanicsSteps::AsActuator);
    for (count, phase) in [("19", "1.0"), ("20", "0.5")] {
        assert_ne!(steps(count, phase).id(), steps("all", phase).id());
    }
    let base = |carriage: &str| {
        refused(|request| {
            request.case = Some("impact-oscillator".into());
            request.set = [("carriage_mass_kg", carriage), ("base_stiffness_n_m", "7"), ("mass_kg", "-1")]
                .map(|(key, value)| (key.to_owned(), value.to_owned()))
                .to_vec();
        })
    };
    assert!(base("1").contains("mass_kg = -1"), "{}", base("1"));
    let mut request = RunRequest::of("impact-oscillator", "zero-order-hold");
    request.set = vec![("base_stiffness_n_m".into(), "7".into())];
    let message = request.resolve(&Catalogue::standard()).unwrap_err().to_string();
    assert!(message.contains("has no effect with carriage_mass_kg = 0"), "{message}");
    assert!(message.ends_with("set carriage_mass_kg > 0"), "{message}");
}

/// A value of each option that differs from the usual one, and the scheme that takes it.
const CHANGES: &[(&str, &str, &str)] = &[
    ("case", "wedge-box-two-ledges", "rim-smooth"),
    ("scheme", "rim-nonsmooth", "rim-smooth"),
    ("sequence", "jacobi", "rim-smooth"),
    ("force_return", "end", "rim-smooth"),
    ("mechanics_steps", "all", "rim-smooth"),
    ("mechanics_step_s", "1e-3", "rim-smooth"),
    ("mechanics_integrator", "midpoint", "rim-smooth"),
    ("actuator_integrator", "midpoint", "rim-smooth"),
    ("model_motion", "extrapolated", "rim-smooth"),
    ("contact_detection", "margin:1e-3", "rim-nonsmooth"),
    ("partition", "each", "rim-smooth"),
    ("order", "2;1", "rim-smooth"),
    ("every", "1/2", "rim-smooth"),
    ("known", "held", "rim-smooth"),
    ("tells", "mean", "rim-smooth"),
    ("share", "equal", "rim-smooth"),
    ("bond_schemes", "rim-smooth,zero-order-hold", "rim-smooth"),
    ("bond_micro_steps", "5e-5,1e-4", "rim-smooth"),
    ("friction_rows", "slip-direction", "rim-nonsmooth"),
    ("contacts_act", "mechanics-step", "rim-nonsmooth"),
    ("delivery_up", "delay:1", "rim-smooth"),
    ("delivery_down", "loss:0.1", "rim-smooth"),
    ("late_samples", "raw", "rim-smooth"),
    ("late_forces", "linear", "rim-smooth"),
    ("belief", "mass:1.2", "rim-smooth"),
    ("perturbation", "within:0.1,seed:1", "rim-smooth"),
    ("mass_learning", "within:5", "rim-smooth"),
    ("trials", "most:9", "rim-answers"),
    ("solver", "lemke", "rim-smooth"),
    ("gain", "0.25", "nepce"),
    ("macro_step_s", "1e-3", "rim-smooth"),
    ("phase", "0.5", "rim-smooth"),
    ("micro_step_s", "1e-5", "rim-smooth"),
    ("duration_s", "1.25", "rim-smooth"),
    ("step_control", "energy-residual", "zero-order-hold"),
    ("step_tolerance", "0.01", "zero-order-hold"),
    ("min_macro_step_s", "1e-4", "zero-order-hold"),
];

#[test]
fn every_option_changes_the_fact_of_its_name_and_the_id() {
    let catalogue = Catalogue::standard();
    let resolved = |request: &RunRequest| request.resolve(&catalogue).unwrap();
    let by_name = |request: &RunRequest| -> HashMap<&str, String> {
        resolved(request).facts().into_iter().map(|fact| (fact.name, fact.cell())).collect()
    };
    for &(key, text, scheme) in CHANGES {
        let of_bonds =
            ["partition", "order", "every", "known", "tells", "share"].contains(&key) || key.starts_with("bond_");
        let case = if of_bonds { "gripper" } else { "wedge-box" };
        let mut usual = RunRequest::of(if key == "friction_rows" { "tripod" } else { case }, scheme);
        if of_bonds && key != "partition" {
            usual.put("partition", "1|2").unwrap();
        }
        if ["step_tolerance", "min_macro_step_s"].contains(&key) {
            usual.put("step_control", "energy-residual").unwrap();
            usual.put("step_tolerance", "0.1").unwrap();
        }
        if key.starts_with("late_") {
            usual.put("delivery_down", "delay:1").unwrap();
        }
        let mut changed = usual.clone();
        changed.put(key, text).unwrap();
        if key == "step_control" {
            changed.put("step_tolerance", "0.1").unwrap();
        }
        assert_ne!(by_name(&usual)[key], by_name(&changed)[key], "{key}");
        assert_ne!(resolved(&usual).id(), resolved(&changed).id(), "{key}");
    }
    // All but the wall limit, which is no part of what a run is.
    let usual = resolved(&RunRequest::of("wedge-box", "rim-smooth"));
    assert_ne!(usual.clone().audited().unwrap().id(), usual.id());
    let missing: Vec<&str> = RunRequest::OPTIONS
        .iter()
        .map(|option| option.key)
        .filter(|key| !CHANGES.iter().any(|(changed, ..)| changed == key))
        .collect();
    assert_eq!(missing, ["wall_limit_s"]);
}

#[test]
fn a_side_that_takes_equal_steps_or_multiples_only_is_not_asked_for_others() {
    let catalogue = Catalogue::standard();
    let report = |equal: bool, multiple_of: Option<f64>, options: &[(&str, &str)]| {
        let mut request = RunRequest::of("wedge-box", "zero-order-hold");
        options.iter().for_each(|(key, value)| request.put(key, value).unwrap());
        let mut spec = request.resolve(&catalogue).unwrap();
        let mut case = Case::clone(&spec.case);
        case.steps.mechanics = PossibleSteps { equal, multiple_of };
        spec = spec.with(|own| own.case = Arc::new(case)).unwrap();
        run(&spec).report
    };
    let skipped = |equal: bool, multiple_of: Option<f64>, options: &[(&str, &str)]| {
        report(equal, multiple_of, options).outcome.name() == "skipped"
    };
    let even = [("macro_step_s", "1e-2"), ("duration_s", "0.1")];
    let with = |more: (&'static str, &'static str)| [even[0], even[1], more];
    assert!(!skipped(true, Some(1e-3), &even));
    assert!(!skipped(false, None, &with(("phase", "0.5"))));
    assert!(skipped(true, None, &with(("phase", "0.5"))));
    // It ends with the last whole macro step.
    let longer = report(true, None, &[even[0], ("duration_s", "0.105")]);
    assert_eq!((longer.outcome.name(), longer.work.cosim.macro_steps), ("completed", 10));
    assert!((longer.ended_at_s - 0.1).abs() < 1e-15, "{}", longer.ended_at_s);
    assert!(skipped(false, Some(4e-3), &even));
    assert!(skipped(false, Some(1e-3), &with(("phase", "0.55"))));
}

/// What a longest step of the mechanics must be as well as their number: macro steps of 10 ms of a gripper that is held
/// for 0.2 s.
const WITH_STEPS: &[(&str, &[(&str, &str)])] = &[
    ("zero-order-hold", &[("sequence", "jacobi")]),
    ("zero-order-hold", &[("sequence", "gauss-seidel-mechanics-first")]),
    ("interface-mass", &[("force_return", "end")]),
    ("iterated-aitken", &[]),
    ("rim-nonsmooth", &[("delivery_up", "delay:1"), ("delivery_down", "delay:1,jitter:1"), ("late_forces", "linear")]),
    ("rim-nonsmooth-gap", &[("force_return", "mean")]),
    ("rim-nonsmooth-gap", &[("force_return", "profile"), ("actuator_integrator", "midpoint")]),
    ("rim-nonsmooth-gap", &[("force_return", "pieces"), ("mechanics_integrator", "event-split")]),
    ("rim-smooth-active", &[("force_return", "profile"), ("delivery_down", "loss:0.2"), ("late_forces", "rates")]),
];

#[test]
fn a_longest_step_of_the_mechanics_is_as_many_as_it_takes_and_one_run_has_one_id() {
    let catalogue = Catalogue::standard();
    let resolved = |scheme: &str, options: &[(&str, &str)], more: &[(&str, &str)]| {
        let mut request = RunRequest::of("wedge-box", scheme);
        let usual = [("macro_step_s", "1e-2"), ("duration_s", "0.6")];
        usual.iter().chain(options).chain(more).for_each(|(key, value)| request.put(key, value).unwrap());
        request.resolve(&catalogue).unwrap()
    };
    for (scheme, options) in WITH_STEPS {
        for (step, count) in [("1e-3", "10"), ("3e-3", "4"), ("1e-2", "1"), ("5e-5", "all")] {
            let [by_step, by_count] = [("mechanics_step_s", step), ("mechanics_steps", count)]
                .map(|steps| resolved(scheme, options, &[steps]));
            assert_eq!(by_step.id(), by_count.id(), "{scheme} {options:?} {step}");
            let [one, other] = [&by_step, &by_count].map(run);
            assert_ne!(one.report.outcome.name(), "skipped", "{scheme} {options:?}: {}", one.report.outcome);
            assert!(one.trajectory.data() == other.trajectory.data(), "{scheme} {options:?} {step}");
            assert_eq!(one.report.work, other.report.work);
        }
    }
    // Where macro steps are not of one length it is no number of them, unless it is one or that of the actuator.
    let uneven = |steps| resolved("rim-nonsmooth-gap", &[("phase", "0.25")], &[steps]);
    assert_ne!(uneven(("mechanics_step_s", "1e-3")).id(), uneven(("mechanics_steps", "10")).id());
    assert_eq!(uneven(("mechanics_step_s", "5e-5")).id(), uneven(("mechanics_steps", "all")).id());
    let result = completed(&uneven(("mechanics_step_s", "1e-3")));
    // 2.5 ms take three steps, 59 times 10 ms ten, and what is left, 7.5 ms, eight.
    assert_eq!(result.report.work.sides.mechanics.micro_steps, 3 + 59 * 10 + 8);
    // Where a step control sets the macro steps, the number follows their length.
    let control = [("step_control", "energy-residual"), ("step_tolerance", "0.05"), ("phase", "0.02")];
    let of_control = [("sequence", "gauss-seidel-mechanics-first"), ("mechanics_step_s", "1e-3")];
    let result = run(&resolved("zero-order-hold", &control, &of_control));
    let time = column(&result.trajectory, "time_s");
    let taken = |pair: &[f64]| ((pair[1] - pair[0]) / 1e-3 - 1e-6).ceil().max(1.0) as u64;
    let counts: Vec<u64> = time.windows(2).map(taken).collect();
    assert_eq!(result.report.work.sides.mechanics.micro_steps, counts.iter().sum::<u64>());
    assert!(counts.contains(&1) && counts.iter().any(|count| *count > 1), "{counts:?}");
}

#[test]
fn every_case_takes_a_longest_step_of_its_mechanics() {
    let catalogue = Catalogue::standard();
    for case in catalogue.cases() {
        // At the macro step that is the case's own it is one step where that is shorter.
        let mut usual = RunRequest::of(case.name.clone(), "zero-order-hold");
        usual.put("mechanics_step_s", "1e-3").unwrap();
        let usual = usual.resolve(&catalogue).unwrap_or_else(|error| panic!("{}: {error}", case.name));
        assert!(usual.mechanics_steps.within(usual.macro_step, usual.micro_step) >= 1);
        let duration = case.defaults.duration_s.min(0.05);
        let macro_step = if duration < 5e-3 { 1e-3 } else { 5e-3 };
        for (scheme, force_return) in [("zero-order-hold", "held"), ("rim-nonsmooth-gap", "profile")] {
            let resolved = |key: &str, value: &str| {
                let mut request = RunRequest::of(case.name.clone(), scheme);
                (request.macro_step_s, request.duration_s) = (Some(macro_step), Some(duration));
                request.put(key, value).unwrap();
                request.put("force_return", force_return).unwrap();
                request.resolve(&catalogue).unwrap_or_else(|error| panic!("{}: {error}", case.name))
            };
            let count = (macro_step / 1e-3).round().to_string();
            let (by_step, by_count) = (resolved("mechanics_step_s", "1e-3"), resolved("mechanics_steps", &count));
            let [one, other] = [&by_step, &by_count].map(run);
            let name = format!("{} {scheme}: {}", case.name, one.report.outcome);
            assert!(one.trajectory.data() == other.trajectory.data(), "{name}");
            assert_eq!(one.report.outcome.name(), other.report.outcome.name(), "{name}");
            if one.report.outcome.name() == "completed" && duration == 0.05 {
                assert_eq!(one.report.work.sides.mechanics.micro_steps, 50, "{name}");
            }
        }
    }
}

#[test]
fn a_longest_step_of_the_mechanics_that_cannot_be_is_refused_with_what_would_be_valid() {
    let message = |change: &[(&str, &str)]| {
        refused(|request| change.iter().for_each(|(key, value)| request.put(key, value).unwrap()))
    };
    let step = |step: &str| message(&[("macro_step_s", "1e-2"), ("mechanics_step_s", step)]);
    for (value, wanted) in [
        ("0", "a finite time above 0 s"),
        ("-1e-3", "a finite time above 0 s"),
        ("NaN", "a finite time above 0 s"),
        ("inf", "a finite time above 0 s"),
        ("0.02", "at most the macro step, 0.01 s"),
        ("1e-9", "at least 1e-8 s for this macro step"),
    ] {
        assert!(step(value).starts_with("mechanics_step_s = "), "{value}: {}", step(value));
        assert!(step(value).contains(wanted), "{value}: {}", step(value));
    }
    let both = message(&[("mechanics_steps", "2"), ("mechanics_step_s", "1e-3")]);
    assert_eq!(both, "mechanics_steps = 2 and mechanics_step_s = 0.001: give one of the two");
    for control in ["by=energy-residual,tolerance=1e-3", "by=energy-residual,shortest=1e-4"] {
        let key = if control.contains("tolerance") { "step_tolerance" } else { "min_macro_step_s" };
        let mut given = vec![("step_control", Given::from(control)), (key, Given::from("1e-3"))];
        for _ in 0..2 {
            let said = RunRequest::default().put_all(&given).unwrap_err().to_string();
            assert!(said.ends_with(&format!(" and {key}: give one of the two")), "{said}");
            given.reverse();
        }
    }
    let bonds = [("case", "gripper"), ("scheme", "rim-nonsmooth-gap"), ("partition", "each")];
    let told = message(&[&bonds[..], &[("known", "nothing"), ("tells", "mean")]].concat());
    assert_eq!(told, "tells = mean: with known = nothing no bond is told of another");
    let as_one = message(&[("scheme", "monolithic"), ("mechanics_step_s", "1e-3")]);
    assert!(as_one.starts_with("mechanics_step_s = 0.001: scheme `monolithic` has no such choice"), "{as_one}");
    // A mechanics of steps of its own.
    let catalogue = Catalogue::standard();
    let fixed = |unit: f64, step: &str| {
        let mut case = Case::clone(catalogue.case("wedge-box").unwrap());
        case.steps.mechanics = PossibleSteps { equal: true, multiple_of: Some(unit) };
        let (case, mut request) = (Arc::new(case), RunRequest::of("wedge-box", "zero-order-hold"));
        request.macro_step_s = Some(1e-2);
        request.put("mechanics_step_s", step).unwrap();
        request.resolve_for(&catalogue, &case, &case.default_parameters()).map_err(|error| error.to_string())
    };
    assert!(fixed(1e-3, "2e-3").is_ok());
    for (unit, step, wanted) in [
        (2e-3, "1e-3", "0.002 s: the mechanics takes multiples of 2e-3 s only, and the macro step is 0.01 s"),
        (1e-3, "3e-3", "0.002 s: the mechanics takes multiples of 1e-3 s only"),
        (3e-3, "1e-3", "a macro step that is a multiple of 3e-3 s"),
    ] {
        let message = fixed(unit, step).unwrap_err();
        assert!(message.starts_with("mechanics_step_s = ") && message.contains(wanted), "{message}");
    }
}
