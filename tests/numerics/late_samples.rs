//! Samples that arrive late or never: identities, the trial's figures, and what is refused.

use crate::support::*;

/// A run of the wedge box to 2.5 s with samples late, in the trial's form: one mechanics step per macro step, the mean
/// returned.
fn late(case: &str, scheme: &str, macro_step: &str, options: &[(&str, &str)]) -> RunSpec {
    let options = [&[("macro_step_s", macro_step)], options].concat();
    spec_with(case, scheme, &options, &[])
}

/// The rms force error of such a run, N; infinite if it does not complete.
fn error(scheme: &str, macro_step: &str, options: &[(&str, &str)]) -> f64 {
    let spec = late("wedge-box", scheme, macro_step, options);
    let reference = wedge_box_reference();
    let run = run_within(&spec, reference.bounds(&spec).unwrap());
    if run.report.outcome != Outcome::Completed {
        return f64::INFINITY;
    }
    metric(&spec, run, reference, "force_error_rms_n")
}

#[test]
fn samples_that_are_all_in_time_must_change_no_bit() {
    let options: [(&str, &[(&str, &str)]); 5] = [
        ("zero-order-hold", &[]),
        ("zero-order-hold", &[("sequence", "gauss-seidel-mechanics-first")]),
        ("second-order-hold", &[]),
        ("rim-smooth", &[]),
        ("rim-nonsmooth-gap", &[("force_return", "profile"), ("mechanics_steps", "5")]),
    ];
    for (scheme, options) in options {
        let options = [options, &[("duration_s", "0.3"), ("phase", "0.4")]].concat();
        let in_time = late("wedge-box", scheme, "1e-3", &options);
        let delivered = in_time.changed(|own| own.delivery = Some(Delivery::default()));
        assert_eq!(bits(&run(&in_time).trajectory), bits(&run(&delivered).trajectory), "{scheme}");
    }
}

#[test]
fn an_exact_model_that_catches_up_must_bridge_any_delay_without_error() {
    // The model is the mechanics itself, contacts included: run forward with the same forces it is where the mechanics
    // is.
    for case in ["disc-row", "rocking-block", "wedge-box"] {
        let options = [("force_return", "profile"), ("mechanics_steps", "all"), ("duration_s", "0.4")];
        let in_time = late(case, "rim-nonsmooth-gap", "4e-3", &options);
        for delivery in ["delay:1", "delay:7", "delay:2,jitter:3,loss:0.3,seed:5"] {
            let mut spec = in_time.clone();
            let channel: Channel = delivery.parse().unwrap();
            spec = spec.changed(|own| own.delivery = Some(Delivery { up: channel, ..Delivery::default() }));
            let [fresh, old] = [&in_time, &spec].map(|spec| completed(spec).trajectory);
            let force = spec.case.interface_columns[0].force.clone();
            let (difference, peak) = apart(&fresh, &old, &force);
            // Frozen at t_m, the Jacobians of a body that turns are those of another place: exact where they do not
            // change.
            let bound = if spec.model_is_exact() { 1e-6 } else { 0.2 };
            assert!(difference <= bound * peak, "{case} {delivery}: {difference:e} of {peak:e}");
        }
    }
}

#[test]
fn the_figures_of_the_trial_must_be_met() {
    const X: f64 = f64::INFINITY;
    let (gap, hold, linear) = ("rim-nonsmooth-gap", "zero-order-hold", "first-order-hold");
    let steps = ["5e-4", "1e-3", "2e-3", "5e-3", "1e-2", "2e-2"];
    // (scheme, delay, treatment of late samples, N of the trial at each macro step); X: diverged.
    let rows: [(&str, u32, Option<&str>, [f64; 6]); 11] = [
        (hold, 0, None, [5.0, 12.0, 34.0, X, X, X]),
        (hold, 1, None, [22.0, 116.0, X, X, X, X]),
        (hold, 2, None, [59.0, X, X, X, X, X]),
        (linear, 0, None, [1.4, 3.8, 12.0, X, X, X]),
        (linear, 1, None, [4.0, 16.0, X, X, X, X]),
        (linear, 2, None, [9.0, 51.0, X, X, X, X]),
        (gap, 0, None, [1.9, 4.6, 10.0, 25.0, 45.0, 105.0]),
        (gap, 1, Some("raw"), [13.0, 37.0, X, X, X, 319.0]),
        (gap, 2, Some("raw"), [38.0, X, X, X, X, X]),
        (gap, 1, Some("catch-up"), [1.9, 5.3, 12.0, 28.0, 48.0, 102.0]),
        (gap, 2, Some("catch-up"), [2.0, 5.5, 12.0, 25.0, 53.0, 90.0]),
    ];
    // The trial's reference: gap tracking at 0.1 ms with the micro steps of all runs, whose error is then in none of
    // them.
    let forces = |scheme: &str, macro_step: &str, options: &[(&str, &str)]| {
        let spec = late("wedge-box", scheme, macro_step, options);
        let run = run_within(&spec, wedge_box_reference().bounds(&spec).unwrap());
        let force = run.trajectory.index_of("actuator_force_n").unwrap();
        let forces: Vec<f64> = run.trajectory.column(force).collect();
        (run.report.outcome == Outcome::Completed).then_some(forces)
    };
    let known = forces(gap, "1e-4", &[("force_return", "mean"), ("sequence", "gauss-seidel")]).unwrap();
    let mut told = String::new();
    for (scheme, delay, rule, trial) in rows {
        let delivery = format!("delay:{delay}");
        let mut options = vec![("force_return", "mean"), ("sequence", "gauss-seidel"), ("delivery_up", &delivery)];
        options.extend(rule.map(|rule| ("late_samples", rule)));
        for (macro_step, trial) in steps.into_iter().zip(trial) {
            let each = (macro_step.parse::<f64>().unwrap() / 1e-4).round() as usize;
            let own = forces(scheme, macro_step, &options).map_or(f64::INFINITY, |own| {
                let squares = own.iter().zip(known.iter().step_by(each)).map(|(own, known)| (own - known).powi(2));
                (squares.sum::<f64>() / own.len() as f64).sqrt()
            });
            // Its hold moves the position on with the velocity held, where ours holds both.
            let bound = trial * if scheme == hold { 0.25 } else { 0.15 };
            let within = if trial.is_finite() { (own - trial).abs() <= bound } else { own.is_infinite() };
            let mark = if within { " " } else { "✗" };
            told += &format!("{mark} {scheme} {delay} {rule:?} {macro_step}: {own:.4} N, trial {trial}\n");
        }
    }
    assert!(!told.contains('✗'), "{told}");
}

#[test]
fn an_extrapolation_must_use_the_times_of_late_samples_and_forgets_them_only_when_asked_to() {
    let options = [("delivery_up", "delay:1")];
    let [timed, forgetful] = [
        error("first-order-hold", "1e-3", &options),
        error("first-order-hold", "1e-3", &[&options[..], &[("late_samples", "raw")]].concat()),
    ];
    assert!(timed < forgetful, "{timed} against {forgetful} N");
}

#[test]
fn catching_up_must_cost_as_many_micro_steps_as_it_bridges_and_nothing_else() {
    let options = [("delivery_up", "delay:3"), ("duration_s", "0.2")];
    let result = completed(&late("wedge-box", "rim-nonsmooth-gap", "5e-3", &options));
    // 40 macro steps of 100 micro steps: the first three communication points bridge 0, 1 and 2 macro steps; the last
    // is one more.
    assert_eq!(result.report.work.cosim.catch_up_steps, 100 * (1 + 2 + 38 * 3));
}

#[test]
fn catching_up_in_coarse_steps_must_cost_no_more_with_age_and_lose_little() {
    let spec = |delivery: &str, rule: &str| {
        late("wedge-box", "rim-nonsmooth-gap", "5e-3", &[("delivery_up", delivery), ("late_samples", rule)])
    };
    // One macro step is as many steps either way.
    let [fine, coarse] = ["catch-up", "catch-up-coarse"].map(|rule| run(&spec("delay:1", rule)).trajectory);
    assert_eq!(bits(&fine), bits(&coarse));
    for (delivery, age) in [("delay:4", 4), ("delay:7", 7), ("delay:10", 10), ("delay:2,jitter:3,loss:0.3,seed:5", 10)]
    {
        let [fine, coarse] = ["catch-up", "catch-up-coarse"].map(|rule| completed(&spec(delivery, rule)));
        let (difference, peak) = apart(&fine.trajectory, &coarse.trajectory, "actuator_force_n");
        assert!(difference <= 0.02 * peak, "{delivery}: {difference:e} of {peak:e}");
        let [fine, coarse] = [fine, coarse].map(|result| result.report.work.cosim);
        // At most as many as the macro step has, and one for each macro step of age.
        assert!(coarse.catch_up_steps <= coarse.macro_steps * (100 + age), "{delivery}: {coarse:?}");
        assert!(2 * coarse.catch_up_steps <= fine.catch_up_steps, "{delivery}: {coarse:?} against {fine:?}");
    }
}

#[test]
fn a_load_whose_own_acceleration_turns_round_while_samples_age_must_be_told_from_one_that_keeps_it() {
    let correlation = |case: &str, delivery: &str| {
        let spec = late(case, "rim-nonsmooth-gap", "5e-3", &[("delivery_up", delivery), ("duration_s", "1")]);
        run(&spec).report.late_acceleration_correlation
    };
    assert_eq!(correlation("half-car", "delay:0"), None);
    // On the washboard it turns round in 50 ms, and is back after 100.
    let [two, ten, twenty] = ["delay:2", "delay:10", "delay:20"].map(|late| correlation("half-car", late).unwrap());
    assert!(two > 0.5 && ten < -0.5 && twenty < -0.5, "{two}, {ten}, {twenty}");
    let weight = correlation("wedge-box", "delay:10").unwrap();
    assert!(weight > 0.99 && weight <= 1.0 + 1e-12, "{weight}");
}

/// Where nothing turns, so that frozen rows are those of the mechanics: every part is what the parts say, and none is
/// what is left over.
#[test]
fn the_account_of_a_model_that_is_believed_must_name_what_its_mass_creates() {
    for (case, belief, mass) in [
        ("linear-oscillator", "mass:2", 1.0),
        ("linear-oscillator", "mass:0.5", -1.0),
        ("disc-row", "mass:1.5", 1.0),
        ("disc-row", "mass:0.8", -1.0),
        ("disc-row", "gap:-0.001", 0.0),
        ("disc-row", "missing:0", 0.0),
    ] {
        for scheme in ["rim-nonsmooth", "rim-nonsmooth-gap"] {
            let options = [("belief", belief), ("duration_s", "0.4")];
            let report = run(&late(case, scheme, "5e-3", &options).audited().unwrap()).report;
            let model = report.audit.model.unwrap_or_else(|| panic!("{case} {scheme} {belief}: no account"));
            let sent = report.audit.work.sent_j.unwrap();
            let scale = 1e-9 * (sent.abs() + model.jump.abs() + model.mass.abs() + model.contacts.abs());
            let told = format!("{case} {scheme} {belief}: {model:?}, {sent} J sent");
            assert!((model.created() + report.audit.work.residual_j().unwrap()).abs() <= scale, "{told}");
            assert!(model.mass * mass > 0.0 || (mass, model.mass) == (0.0, 0.0), "{told}");
            if case == "linear-oscillator" {
                // No contact has a part in it.
                assert!(model.jump == 0.0 && model.contacts.abs() <= scale, "{told}");
                // H_mech − H_model, relative to H_mech.
                let heaviness = 1.0 - 1.0 / belief.trim_start_matches("mass:").parse::<f64>().unwrap();
                assert!((model.heaviness - heaviness).abs() < 1e-12, "{told}");
            } else {
                assert!(model.unfrozen.abs() <= scale, "{told}");
            }
        }
    }
}

#[test]
fn the_energy_that_age_creates_must_close_the_account() {
    for (scheme, late) in
        [("rim-nonsmooth", "catch-up"), ("rim-nonsmooth-gap", "catch-up"), ("rim-nonsmooth-gap", "raw")]
    {
        let options = [("delivery_up", "delay:2,loss:0.2,seed:1"), ("late_samples", late), ("phase", "0.4")];
        let spec = late_spec(scheme, &options).audited().unwrap();
        let report = run(&spec).report;
        let model = report.audit.model.unwrap_or_else(|| panic!("{scheme} {late}: no account"));
        let parts = model.jump + model.first_moment + model.contacts + model.unfrozen + model.age;
        let residual = report.audit.work.residual_j().unwrap();
        let scale = report.audit.work.sent_j.unwrap().abs() + parts.abs() + model.age.abs();
        assert!((parts + residual).abs() <= 1e-9 * scale, "{scheme} {late}: {parts} J, residual {residual} J");
        assert!(model.age.abs() > 1e-6, "{scheme} {late}: age creates {:e} J", model.age);
    }
}

fn late_spec(scheme: &str, options: &[(&str, &str)]) -> RunSpec {
    // Short enough for an old model taken for the present to complete.
    late("wedge-box", scheme, "5e-4", options)
}

#[test]
fn late_forces_must_be_those_of_earlier_macro_steps_and_lost_ones_are_bridged() {
    let spec = |options: &[(&str, &str)]| {
        late("wedge-box", "rim-nonsmooth-gap", "1e-3", &[options, &[("duration_s", "0.1")]].concat())
    };
    let result = run(&spec(&[("delivery_down", "delay:2")]));
    let received = column(&result.trajectory, "force_to_mechanics_n");
    let in_time = column(&run(&spec(&[])).trajectory, "force_to_mechanics_n");
    // Until the first force arrives the one of the start is held.
    assert_eq!(received[1], received[2]);
    assert!((received[3] - in_time[1]).abs() < 1e-3 * in_time[1].abs().max(1.0), "{} {}", received[3], in_time[1]);
    for bridge in ["hold", "linear", "rates"] {
        let result = run(&spec(&[("delivery_down", "loss:0.3,seed:2"), ("late_forces", bridge)]));
        assert_eq!(result.report.outcome, Outcome::Completed, "{bridge}");
    }
}

#[test]
fn what_does_not_go_with_late_samples_is_refused_with_what_does() {
    let refused = |scheme: &str, options: &[(&str, &str)]| {
        let mut request = RunRequest::of("wedge-box", scheme);
        let put = options.iter().try_for_each(|(key, value)| request.put(key, value));
        put.and_then(|()| request.resolve(catalogue()).map(|_| ())).unwrap_err().to_string()
    };
    let up = ("delivery_up", "delay:1");
    for (scheme, options, expected) in [
        ("rim-nonsmooth", &[("delivery_up", "delay:1000")][..], "below the 500 macro steps"),
        ("rim-nonsmooth", &[("delivery_up", "loss:1")], "below 1"),
        ("rim-nonsmooth", &[("delivery_up", "missed:9+3")], "in the order of time"),
        ("rim-nonsmooth", &[("delivery_up", "missed:700")], "those of the run"),
        ("rim-nonsmooth", &[("late_samples", "raw")], "no sample is late"),
        ("rim-nonsmooth", &[up, ("late_forces", "hold")], "no sample is late"),
        ("rim-nonsmooth", &[up, ("force_return", "held"), ("sequence", "jacobi")], "needs `mean` or `profile`"),
        ("rim-nonsmooth", &[up, ("actuator_integrator", "midpoint")], "first order"),
        ("rim-fixed-mass", &[up, ("late_samples", "catch-up")], "use `raw`"),
        ("rim-fixed-mass", &[up, ("late_samples", "catch-up-coarse")], "late_samples = catch-up-coarse"),
        ("iterated-aitken", &[up], "does not iterate"),
        ("zero-order-hold", &[up, ("step_control", "energy-residual"), ("step_tolerance", "0.1")], "use `none`"),
        ("zero-order-hold", &[("delivery_down", "delay:1"), ("late_forces", "rates")], "held"),
    ] {
        let message = refused(scheme, options);
        assert!(message.contains(expected), "{scheme} {options:?}: {message}");
    }
}

#[test]
fn a_model_that_believes_the_truth_changes_no_bit_and_a_wrong_one_does() {
    for scheme in ["rim-nonsmooth-gap", "rim-smooth"] {
        let spec = |belief: &str| late("wedge-box", scheme, "2e-3", &[("belief", belief), ("duration_s", "0.3")]);
        let truth = bits(&run(&spec("mass:1,friction:1,gap:0")).trajectory);
        assert_eq!(truth, bits(&run(&late("wedge-box", scheme, "2e-3", &[("duration_s", "0.3")])).trajectory));
        // Twice: what is filled once only would be made wrong at every exchange again.
        let wrong = run(&spec("mass:1.1"));
        assert_ne!(truth, bits(&wrong.trajectory));
        let heavier = column(&wrong.trajectory, "effective_mass_kg");
        let own =
            column(&run(&late("wedge-box", scheme, "2e-3", &[("duration_s", "0.3")])).trajectory, "effective_mass_kg");
        let last = own.len() - 1;
        assert!((heavier[last] / own[last] - 1.1).abs() < 0.05, "{} of {}", heavier[last], own[last]);
    }
}

/// With contacts that stick, slide and open.
#[test]
fn a_mass_that_is_wrong_is_learned_whatever_contacts_do_and_however_late_samples_are() {
    let learned = |options: &[(&str, &str)]| {
        let options = [&[("macro_step_s", "5e-3"), ("duration_s", "1")][..], options].concat();
        let spec = spec_with("wedge-box-friction", "rim-nonsmooth-gap", &options, &[]);
        run(&spec).report.learned_mass
    };
    assert_eq!(learned(&[("belief", "mass:2")]), None);
    for belief in ["0.5", "1", "2"] {
        for delivery in ["delay:0", "delay:2", "loss:0.5,seed:1"] {
            let wrong = format!("mass:{belief}");
            let factor = learned(&[("belief", &wrong), ("delivery_up", delivery), ("mass_learning", "within:10")]);
            let found = factor.unwrap() * belief.parse::<f64>().unwrap();
            assert!((found - 1.0).abs() < 0.05, "{belief} {delivery}: {found}");
        }
    }
}

#[test]
fn a_mass_is_not_learned_from_jumps_that_say_something_else() {
    for (scheme, options, wanted) in [
        ("rim-nonsmooth-gap", [("model_motion", "extrapolated"), ("phase", "1")], "model_motion = extrapolated"),
        ("rim-nonsmooth-gap", [("force_return", "end"), ("phase", "1")], "force return `end`"),
        ("rim-nonsmooth-gap", [("delivery_down", "delay:1"), ("phase", "1")], "forces are late"),
        ("rim-nonsmooth-gap", [("delivery_up", "delay:1"), ("late_samples", "raw")], "late_samples = raw"),
        ("rim-fixed-mass", [("phase", "1"), ("duration_s", "1")], "scheme `rim-fixed-mass`"),
        ("zero-order-hold", [("phase", "1"), ("duration_s", "1")], "has no reduced interface model"),
    ] {
        let mut request = RunRequest::of("wedge-box", scheme);
        [("mass_learning", "within:10")]
            .iter()
            .chain(&options)
            .for_each(|(key, value)| request.put(key, *value).unwrap());
        let message = request.resolve(&rimbench::catalogue::Catalogue::standard()).unwrap_err().to_string();
        assert!(message.contains(wanted) && message.starts_with("mass_learning = "), "{message}");
    }
}

#[test]
fn friction_that_is_believed_to_be_another_is_so_at_every_exchange() {
    let with = |belief: &str| {
        let options = [("macro_step_s", "5e-3"), ("belief", belief), ("duration_s", "0.2")];
        run(&spec_with("wedge-box-friction", "rim-nonsmooth-gap", &options, &[])).trajectory
    };
    let force = case_by_name("wedge-box-friction").interface_columns[0].force.clone();
    let [twice_half, half] = ["friction:0.5", "friction:0.5,gap:0"].map(with);
    assert_eq!(bits(&twice_half), bits(&half));
    assert_ne!(bits(&half), bits(&with("friction:2")));
    // No friction is no limit that is reached after many exchanges: a factor of 1 − 1e-12 leaves the run as it is.
    let (difference, peak) = apart(&with("mass:1"), &with("friction:0.999999999999"), &force);
    assert!(difference <= 1e-6 * peak, "{difference:e} of {peak:e}");
}
