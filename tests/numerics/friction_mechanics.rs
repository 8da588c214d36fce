//! Mechanics with Coulomb friction at its contacts: closed forms, the energy account, and what is refused.

use crate::support::*;
use rimbench::friction::ContactState;

const G: f64 = 9.81;

const fn coulomb(coefficient: f64) -> Friction {
    Friction { coefficient, at_rest: coefficient, restitution: 0.0 }
}

/// A point of `mass` on an incline: coordinates down the slope and off it; the interface row pulls down the slope.
fn on_incline(mass: f64, angle: f64, v: f64) -> LinearModel {
    let weight = mass * G;
    LinearModel::new(&[mass; 2], &[weight * angle.sin(), -weight * angle.cos()], &[(&[1.0, 0.0], 0.0)])
        .over(&[(&[0.0, 1.0], 0.0)])
        .along(&[(&[1.0, 0.0], 0.0)])
        .moving(&[v, 0.0])
}

/// A disc on a level floor, pulled at its centre.
fn disc(mass: f64, inertia: f64, radius: f64, weight: f64, v: [f64; 2]) -> LinearModel {
    LinearModel::new(&[mass, mass, inertia], &[0.0, -weight, 0.0], &[(&[1.0, 0.0, 0.0], 0.0)])
        .over(&[(&[0.0, 1.0, 0.0], 0.0)])
        .along(&[(&[1.0, 0.0, radius], 0.0)])
        .moving(&[v[0], v[1], 0.0])
}

fn with_friction(model: LinearModel, law: ContactLaw, friction: Friction) -> NonSmoothMechanics<LinearModel> {
    stepper(model, law).with_friction(friction, solver()).unwrap()
}

#[test]
fn a_block_must_rest_on_an_incline_up_to_the_angle_of_friction_and_slide_beyond_it() {
    let (angle, h, steps) = (0.3_f64, 1e-3, 1000);
    for (factor, slides) in [(1.0 + 1e-9, false), (1.0 - 1e-9, true), (0.5, true)] {
        let mu = factor * angle.tan();
        let mut block = with_friction(on_incline(10.0, angle, 0.0), PLASTIC, coulomb(mu));
        (0..steps).for_each(|_| block.step(0.0, &[0.0], h).unwrap());
        let wanted = if slides { G * (angle.sin() - mu * angle.cos()) * h * f64::from(steps) } else { 0.0 };
        // A few roundings a step, of the speed or of what a step gives.
        let v = block.velocity()[0];
        let bound = 4.0 * f64::EPSILON * wanted.max(G * h) * f64::from(steps);
        assert!((v - wanted).abs() <= bound, "{factor}: {v}, not {wanted}");
        assert_eq!(slides, v > 0.0, "{factor}");
    }
}

#[test]
fn a_model_must_say_what_a_contact_does_and_from_which_states_the_mechanics_itself_goes_on() {
    for (pressed, found) in [(0.0, ContactState::Open), (-1.0, ContactState::SlipPositive)] {
        let block = LinearModel { force: vec![0.0, pressed], ..on_incline(10.0, 0.0, 1.0) };
        let mut block = with_friction(block, PLASTIC, coulomb(0.3));
        block.step(0.0, &[0.0], 1e-3).unwrap();
        let mut model = block.empty_interface_model().unwrap();
        block.interface_model(1e-3, &mut model).unwrap();
        assert_eq!(model.states, [ContactState::SlipPositive], "it slides along its floor, loaded or not");
        assert_eq!(model.solved_states, [found], "with {pressed} N");
    }
}

#[test]
fn a_block_that_slides_down_an_incline_must_stop_after_the_distance_of_theory_and_stay() {
    let (angle, mu, v0) = (0.3_f64, 0.5, 1.0);
    let deceleration = G * (mu * angle.cos() - angle.sin());
    let distance = 0.5 * v0 * v0 / deceleration;
    assert!((distance - 0.279819).abs() < 5e-7);
    for h in [4e-3, 1e-3, 2.5e-4] {
        let mut block = with_friction(on_incline(10.0, angle, v0), PLASTIC, coulomb(mu));
        let start = block.energy();
        let steps = (1.0 / h) as usize;
        (0..steps).for_each(|_| block.step(0.0, &[0.0], h).unwrap());
        assert!(block.velocity()[0].abs() <= 4.0 * f64::EPSILON * G * h, "it stays");
        // v⁺ acts over each step: h v₀/2 too short in all, but for what the last step cuts off, a h²/8 at most.
        let error = block.position()[0] - (distance - 0.5 * h * v0);
        assert!((0.0..=0.125 * deceleration * h * h + 1e-12).contains(&error), "h = {h}: {error}");
        // All that is lost is lost to friction.
        let ledger = block.ledger();
        let lost = block.energy() - start;
        assert!(ledger.contact.abs() <= 1e-12 && ledger.slip <= 0.0);
        assert!((ledger.friction + ledger.applied - ledger.kinetic).abs() <= 1e-12);
        assert!((ledger.friction - lost).abs() <= 10.0 * G * h * v0 * angle.sin(), "up to the drop of the steps");
        assert!(ledger.identity_residual <= 1e-14);
    }
}

#[test]
fn a_disc_that_slides_must_roll_with_two_thirds_of_its_speed_and_lose_a_third_of_its_energy_to_friction() {
    let (mass, radius, mu, v0) = (5.0, 0.2, 0.2, 3.0);
    let inertia = 0.5 * mass * radius * radius;
    let rolls_after = v0 / (3.0 * mu * G);
    for h in [2e-3, 1e-3] {
        let mut disc = with_friction(disc(mass, inertia, radius, mass * G, [v0, 0.0]), PLASTIC, coulomb(mu));
        let mut rolling = None;
        for step in 1..=(1.0 / h) as u32 {
            disc.step(0.0, &[0.0], h).unwrap();
            let slides = disc.velocity()[0] + radius * disc.velocity()[2];
            if rolling.is_none() && slides.abs() <= 1e-14 {
                rolling = Some(f64::from(step) * h);
            }
        }
        // Friction acts on both, so the speed is that of theory whenever the rolling begins; a thousand steps round it.
        assert!((disc.velocity()[0] - 2.0 / 3.0 * v0).abs() <= 1e-13, "{}", disc.velocity()[0]);
        assert!((rolling.unwrap() - rolls_after).abs() <= h, "{rolling:?}");
        let start = 0.5 * mass * v0 * v0;
        assert!((disc.ledger().friction + start / 3.0).abs() <= 1e-12 * start, "{}", disc.ledger().friction);
        assert!(disc.ledger().slip <= 0.0 && disc.ledger().identity_residual <= 1e-14 * start);
    }
}

#[test]
fn an_oblique_impact_must_rebound_by_the_law_of_moreau_or_along_the_normal_alone_by_that_of_newton() {
    // A disc with I = m R²/2; with e in both directions it sticks up to 3 μ w_n, with none along the surface up to 3 μ
    // (1 + e) w_n.
    let e = 0.5;
    let law = ContactLaw { restitution: e, ..PLASTIC };
    for (along, w_t, sticks) in [(e, 0.8, true), (e, 1.0, false), (0.0, 1.3, true), (0.0, 1.4, false)] {
        let friction = Friction { restitution: along, ..coulomb(0.15) };
        let mut disc = with_friction(disc(1.0, 0.5, 1.0, 0.0, [w_t, -2.0]), law, friction);
        disc.step(0.0, &[0.0], 1e-9).unwrap();
        let v = disc.velocity();
        assert!((v[1] - 1.0).abs() <= 1e-15);
        let slip = v[0] + v[2];
        // Sticks: w_t⁺ = −e_t w_t; else what friction leaves of it, 3 μ (1 + e) w_n less.
        let wanted = if sticks { -along * w_t } else { w_t - 3.0 * 0.15 * (1.0 + e) * 2.0 };
        assert!((slip - wanted).abs() <= 1e-14, "{slip}, not {wanted}");
        assert!(disc.ledger().slip <= 0.0);
    }
}

#[test]
fn a_coefficient_of_zero_must_give_the_steps_without_friction() {
    let mut with = wedge_box_mechanics(PLASTIC).with_friction(coulomb(0.0), solver()).unwrap();
    let mut without = wedge_box_mechanics(PLASTIC);
    for step in 0..400 {
        let force = 300.0 * f64::from(step % 100) / 100.0;
        with.step(0.0, &[force], 5e-3).unwrap();
        without.step(0.0, &[force], 5e-3).unwrap();
    }
    // Two ways to the same numbers: 400 steps with the rounding of metres.
    assert!(max_difference(with.position(), without.position()) <= 1e-11);
    assert_eq!(with.ledger().friction, 0.0);
    assert!(with.friction_impulses().iter().all(|p| *p == 0.0));
}

#[test]
fn friction_must_never_push_along() {
    let mut box_ = wedge_box_mechanics(PLASTIC).with_friction(coulomb(0.3), solver()).unwrap();
    for step in 0..600 {
        let force = 900.0 * (f64::from(step) * 0.05).sin();
        let before = box_.ledger().slip;
        box_.step(0.0, &[force], 2e-3).unwrap();
        let slip = box_.ledger().slip - before;
        // Rounding of impulses of some N·s at velocities of some m/s.
        assert!(slip <= 1e-13, "step {step}: {slip} J");
    }
    assert!(box_.ledger().slip < -1.0);
}

/// Their rows along the surface are the same, so the solver loads one foot up to its border before the other takes
/// anything.
#[test]
fn two_feet_at_rest_must_hold_with_the_coefficient_at_rest_of_both() {
    let (mass, h) = (2.0, 1e-3);
    let weight = mass * G;
    // Pulled at the height of the floor, the feet half a metre ahead of the centre and one metre behind it.
    let block = LinearModel::new(&[mass, mass, 0.4], &[0.0, -weight, 0.0], &[(&[1.0, 0.0, 0.2], 0.0)])
        .over(&[(&[0.0, 1.0, 0.5], 0.0), (&[0.0, 1.0, -1.0], 0.0)])
        .along(&[(&[1.0, 0.0, 0.2], 0.0), (&[1.0, 0.0, 0.2], 0.0)]);
    let law = Friction { at_rest: 0.5, ..coulomb(0.3) };
    for (share, holds) in [(0.49, true), (0.31, true), (0.51, false)] {
        let mut block = with_friction(block.clone(), PLASTIC, law);
        (0..50).for_each(|_| block.step(0.0, &[share * weight], h).unwrap());
        let v = block.velocity()[0];
        if holds {
            assert!(v.abs() <= 1e-13, "{share}: {v}");
        } else {
            // One step with what held it, then with the coefficient in motion.
            let wanted = G * h * ((share - 0.5) + 49.0 * (share - 0.3));
            assert!((v - wanted).abs() <= 1e-12, "{share}: {v}, not {wanted}");
        }
    }
}

#[test]
fn what_cannot_be_had_with_friction_must_be_refused_with_the_reason() {
    let message = |law: ContactLaw, friction: Friction, model: LinearModel| {
        stepper(model, law).with_friction(friction, solver()).map(drop).unwrap_err().to_string()
    };
    let block = || on_incline(1.0, 0.3, 0.0);
    for bad in [-0.1, f64::NAN, f64::INFINITY] {
        let said = message(PLASTIC, coulomb(bad), block());
        assert!(said.contains("friction = ") && said.contains("0 or above"), "{said}");
    }
    let smooth = LinearModel { tangential: ConstantRows::default(), ..block() };
    assert!(message(PLASTIC, coulomb(0.3), smooth).contains("0 tangential rows for 1 contacts"));
    let bouncing = ContactLaw { restitution: 0.5, ..PLASTIC };
    for bad in [-0.1, 0.6, f64::NAN] {
        let said = message(bouncing, Friction { restitution: bad, ..coulomb(0.3) }, block());
        assert!(said.contains("along the surface is none; valid: 0 to that along the normal, 0.5"), "{said}");
    }
    for bad in [0.2, f64::NAN, f64::INFINITY] {
        let said = message(PLASTIC, Friction { at_rest: bad, ..coulomb(0.3) }, block());
        assert!(said.contains("friction at rest = ") && said.contains("at least that in motion, 0.3"), "{said}");
    }
    let mut mechanics = with_friction(block(), PLASTIC, coulomb(0.3));
    assert!(mechanics.use_second_order(SecondOrder::EventSplit).unwrap_err().contains("semi-implicit"));
}

#[test]
fn an_option_that_friction_rules_out_must_be_refused() {
    let friction = |key: &str, value: &str| {
        let mut request =
            RunRequest { duration_s: Some(0.05), ..RunRequest::of("wedge-box-friction", "rim-nonsmooth-gap") };
        request.put(key, value).unwrap();
        request.resolve(catalogue())
    };
    let built = simulate(&friction("solver", "lemke").unwrap(), Bounds::default(), None, StopFlag::never());
    assert!(built.map(drop).unwrap_err().to_string().contains("over their states"));
}

/// A controller asks the model when the next contact closes: the rows of friction have no gaps.
#[test]
fn macro_steps_placed_by_a_model_with_friction_must_come_to_the_end() {
    for scheme in ["rim-nonsmooth-gap", "rim-nonsmooth", "rim-smooth"] {
        let placed = [("step_control", "model-defect"), ("step_tolerance", "1e-3"), ("macro_step_s", "1e-2")];
        let options = [&placed[..], &[("duration_s", "0.5")]].concat();
        completed(&spec_with("wedge-box-friction", scheme, &options, &[]));
    }
}

/// Schemes that use the forces of the sample, and no contacts within the macro step.
const WITHOUT_CONTACTS: [&str; 5] =
    ["interface-mass", "true-acceleration", "interface-jacobian", "interface-exponential", "model-corrected-outputs"];

#[test]
fn schemes_without_contacts_of_their_own_must_follow_the_reference_where_contacts_rub() {
    for case in ["wedge-box-friction", "tripod", "four-legs", "wedge-box-space"] {
        let reference = coarse_reference(&usual_spec(case, "interface-mass", 1e-3));
        for scheme in WITHOUT_CONTACTS {
            let spec = usual_spec(case, scheme, 1e-3);
            let result = run_within(&spec, reference.bounds(&spec).unwrap());
            assert_eq!(result.report.outcome, Outcome::Completed, "{case} {scheme}");
            let error = metric(&spec, result, &reference, "force_error_rms_of_peak");
            assert!(error < 0.01, "{case} {scheme}: {error}");
        }
    }
}

/// Over one step of the mechanics under a force that is held, the acceleration that a scheme predicts is that of the
/// mechanics itself, whose own solver knows nothing of the scheme: sliding, sticking and coming to rest, in the plane
/// and in space.
#[test]
fn a_predicted_acceleration_must_be_the_one_that_the_mechanics_then_has() {
    let (h, mut stopped) = (1e-4, 0);
    for case in ["wedge-box-friction", "tripod"] {
        let mut system = usual_system(case_by_name(case));
        let mut coupling = coupled(scheme_by_name("true-acceleration"), system.sides.lend());
        let mechanics = &mut system.sides.mechanics;
        let mut model = mechanics.capabilities().empty_interface_model().unwrap();
        let m = model.interface();
        let (rates, mut y, mut u) = (OutputRates::zeros(m, 2 * m), vec![0.0; 2 * m], vec![0.0; 2 * m]);
        let (mut slid, mut stuck) = (0, 0);
        for index in 0..10_000 {
            let step = MacroStep { index, start: h * index as f64, length: h };
            let force = vec![1000.0 * (18.0 * step.start).sin(); m];
            mechanics.outputs(&force, &mut y).unwrap();
            mechanics.capabilities().interface_model(h, &mut model).unwrap();
            let sample = Sample { model: Some(&model), ..Sample::of_outputs(step, &y, h) };
            coupling.scheme.receive(Side::Mechanics, &sample).unwrap();
            let own = Sample { y: &force, model: None, rates: Some(&rates), ..sample };
            coupling.scheme.receive(Side::Actuator, &own).unwrap();
            u.copy_from_slice(&y);
            coupling.scheme.input(Side::Actuator, MicroStep::new(step, 0, 1), &force, &mut u).unwrap();
            let before = y[m..].to_vec();
            // Mean over the step of a velocity on a straight line.
            let predicted: Vec<f64> = (0..m).map(|row| 2.0 * u[m + row] - before[row]).collect();
            let lands = |model: &ReducedInterfaceModel| -> Vec<bool> {
                (0..model.contacts()).map(|contact| model.at_bound[contact] && model.w[contact].abs() < 1e-7).collect()
            };
            let resting = lands(&model);
            mechanics.step(step.start, &force, h).unwrap();
            mechanics.outputs(&force, &mut y).unwrap();
            mechanics.capabilities().interface_model(h, &mut model).unwrap();
            if resting != lands(&model) {
                continue;
            }
            // Rows turn by some 1e-4 rad in a step, of velocities of 1 m/s at most.
            let off = max_difference(&predicted, &y[m..]);
            assert!(off < 1e-7, "{case} at {} s: off by {off:e} m/s of {:e}", step.start, y[m] - before[0]);
            let still = |w: &[f64]| w.iter().all(|w| w.abs() < 1e-9);
            match (still(&before), still(&y[m..])) {
                (true, true) => stuck += 1,
                (false, true) => stopped += 1,
                _ => slid += 1,
            }
        }
        assert!(slid > 5000 && stuck > 100, "{case}: {slid} slid, {stuck} stuck");
    }
    assert!(stopped > 0);
}
