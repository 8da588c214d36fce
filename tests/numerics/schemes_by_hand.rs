//! Schemes alone, over macro steps small enough to be worked by hand.

use crate::support::*;
use approx::assert_relative_eq;
use rimbench::error::Result;
use rimbench::linear_algebra::SymmetricPattern;

/// A scheme for one interface row, with its gain.
fn built(
    scheme: &str,
    gain: f64,
    options: &ModelOptions,
    empty: Option<&ReducedInterfaceModel>,
) -> Result<Box<dyn CouplingScheme>> {
    let (mechanics, actuator) = force_displacement_ports(1);
    let scheme = scheme_by_name(scheme);
    let detection = scheme.contact_detection.map(|rule| rule.default);
    let model = empty.map(|empty| ModelConstruction { empty, options, detection });
    (scheme.build)(&Construction { ports: PerSide { mechanics: &mechanics, actuator: &actuator }, model, gain })
}

/// Macro steps of 1 s.
fn second(index: usize) -> MacroStep {
    MacroStep { index, start: index as f64, length: 1.0 }
}

/// An exchange, and one micro step of either side over 1 s: the force on the mechanics, and what the actuator gets.
fn exchange(
    scheme: &mut dyn CouplingScheme,
    index: usize,
    y: [f64; 2],
    force: f64,
    sent: Option<(&ReducedInterfaceModel, &OutputRates)>,
) -> (f64, [f64; 2]) {
    let sample = Sample::of_outputs(second(index), &y, 1.0);
    scheme.receive(Side::Mechanics, &Sample { model: sent.map(|sent| sent.0), ..sample }).unwrap();
    scheme.receive(Side::Actuator, &Sample { y: &[force], rates: sent.map(|sent| sent.1), ..sample }).unwrap();
    let at = MicroStep::new(second(index), 0, 1);
    // What the loop has ready: each side's last inputs.
    let (mut u, mut received) = (y, [force]);
    scheme.input(Side::Actuator, at, &[force], &mut u).unwrap();
    scheme.input(Side::Mechanics, at, &y, &mut received).unwrap();
    (received[0], u)
}

/// The force on the mechanics at a velocity, from the damper with this gain.
fn damped(scheme: &mut dyn CouplingScheme, index: usize, w: f64, force: f64) -> f64 {
    let (received, u) = exchange(scheme, index, [0.0, w], force, None);
    assert_eq!(u, [0.0, w]);
    received
}

fn damper(gain: f64) -> Box<dyn CouplingScheme> {
    built("energy-leak-damper", gain, &ModelOptions::default(), None).unwrap()
}

#[test]
fn a_joule_created_is_a_joule_taken_out() {
    let mut scheme = damper(0.5);
    // Held force 4 N, velocity 1 → 1.5 m/s: received 4 · 1.25, sent 4 · 1: one joule from nowhere.
    assert_eq!(damped(&mut *scheme, 0, 1.0, 4.0), 4.0);
    // 1 J over 1.5 m of way wants 2/3 N, less than half of 4 N.
    assert_relative_eq!(damped(&mut *scheme, 1, 1.5, 4.0), 4.0 - 1.0 / 1.5, epsilon = 4.0 * f64::EPSILON);
    // The velocity stays: the damper took 2/3 N · 1.5 m, and the pool is empty up to the rounding of 2/3.
    assert!((damped(&mut *scheme, 2, 1.5, 4.0) - 4.0).abs() <= 16.0 * f64::EPSILON);
    assert_relative_eq!(scheme.report().dissipated_j.unwrap(), 1.0, epsilon = 4.0 * f64::EPSILON);
}

#[test]
fn the_damper_pushes_no_harder_than_its_share_of_the_coupling_force_and_gives_nothing_back() {
    let mut scheme = damper(0.5);
    damped(&mut *scheme, 0, 1.0, 4.0);
    // 4 · (11 − 2)/2 = 18 J in the pool want 18/10 N; the coupling force has dropped to 2 N.
    assert_eq!(damped(&mut *scheme, 1, 10.0, 2.0), 1.0);
    assert_eq!(damped(&mut *damper(0.0), 0, 10.0, 2.0), 2.0);
    let mut scheme = damper(0.5);
    damped(&mut *scheme, 0, 1.0, -4.0);
    assert_eq!(damped(&mut *scheme, 1, 1.5, -4.0), -4.0);
    // One joule lost in the first macro step; gained in the second, which pays for it: the pool is empty again.
    assert_eq!(damped(&mut *scheme, 2, 1.0, -4.0), -4.0);
    assert_eq!(scheme.report().dissipated_j, Some(0.0));
}

/// A line between a mass of 1 kg and a spring of 4 N/m (`Ḟ = −4 w`): Z = 2.
#[test]
fn a_line_transmits_its_load_moves_both_ends_and_reflects_what_comes_back() {
    let mut model = ReducedInterfaceModel::zeros(0, 1);
    model.h[0] = 1.0;
    let rates = OutputRates { rate_gain: vec![0.0, -4.0], ..OutputRates::zeros(1, 2) };
    let line = || built("transmission-line", 1.0, &ModelOptions::default(), Some(&model)).unwrap();
    let step =
        |scheme: &mut dyn CouplingScheme, index, y, force| exchange(scheme, index, y, force, Some((&model, &rates)));
    let (mut at_rest, mut moving) = (line(), line());
    for k in 0..5 {
        assert_eq!(step(&mut *at_rest, k, [0.5, 0.0], 3.0), (3.0, [0.5, 0.0]));
        assert_eq!(step(&mut *moving, k, [k as f64, 1.0], 3.0), (3.0, [k as f64 + 1.0, 1.0]));
    }
    let mut pushed = line();
    // The actuator's force rises from 0 to 8 N at t = 1 against mechanics that do not move. c₂ = 0: w₂ = 8/2. c₁ = 8 +
    // 2·4 arrives at the fixed end, doubled as at every wall; c₂ = 0 still. Then the reflection is back: c₂ = 16, w₂ =
    // (8 − 16)/2.
    for (k, (force, wanted)) in
        [(0.0, (0.0, [0.0, 0.0])), (8.0, (0.0, [4.0, 4.0])), (8.0, (16.0, [8.0, 4.0])), (8.0, (16.0, [4.0, -4.0]))]
            .into_iter()
            .enumerate()
    {
        assert_eq!(step(&mut *pushed, k, [0.0, 0.0], force), wanted, "{k}");
    }
}

/// A mass of 1 kg at `s`, `w`, held by a spring of 1 N/m, over a macro step of `h`; increments of `w` and λ.
fn jacobian_increments(s: f64, w: f64, h: f64) -> [f64; 2] {
    let mut model = ReducedInterfaceModel::zeros(0, 1);
    let mut scheme = built("interface-jacobian", 1.0, &ModelOptions::default(), Some(&model)).unwrap();
    (model.h[0], model.w[0], model.position[0], model.mechanics_step) = (1.0, w, s, h);
    let step = MacroStep { index: 0, start: 0.0, length: h };
    let y = [s, w];
    let sample = Sample { model: Some(&model), ..Sample::of_outputs(step, &y, h) };
    scheme.receive(Side::Mechanics, &sample).unwrap();
    let mut rates = OutputRates::zeros(1, 2);
    rates.feedthrough[0] = -1.0;
    scheme.receive(Side::Actuator, &Sample { y: &[-s], model: None, rates: Some(&rates), ..sample }).unwrap();
    let (mut u, mut force) = ([0.0; 2], [0.0]);
    scheme.input(Side::Actuator, MicroStep::new(step, 0, 1), &[], &mut u).unwrap();
    scheme.input(Side::Mechanics, MicroStep::new(step, 0, 1), &[], &mut force).unwrap();
    [2.0 * (u[1] - w), 2.0 * (force[0] + s)]
}

#[test]
fn a_mass_on_a_spring_gets_the_trapezoidal_rule_from_the_interface_jacobian() {
    // s = 1, w = 0, H = 1: Δw = −1 + ½ Δλ, Δs = ½ Δw, Δλ = −Δs ⇒ Δw = −0.8, Δλ = 0.4.
    let [velocity, force] = jacobian_increments(1.0, 0.0, 1.0);
    assert_relative_eq!(velocity, -0.8, epsilon = 1e-15);
    assert_relative_eq!(force, 0.4, epsilon = 1e-15);
    // It keeps its energy at any macro step.
    for h in [0.01, 1.0, 100.0] {
        let (mut s, mut w) = (1.0, 0.5);
        for _ in 0..100 {
            let [velocity, force] = jacobian_increments(s, w, h);
            (s, w) = (s - force, w + velocity);
        }
        // 100 steps of a few roundings each; sums of a hundred times the state at H = 100.
        assert_relative_eq!(s * s + w * w, 1.25, epsilon = 100.0 * 100.0 * 10.0 * f64::EPSILON);
    }
}

/// NEPCE meets a ramp in the mean from the second macro step on, and sees what is put out between samples.
#[test]
fn nepce_gives_back_what_the_last_macro_step_lacked() {
    let nepce = || built("nepce", 1.0, &ModelOptions::default(), None).unwrap();
    let exchanged = |scheme: &mut dyn CouplingScheme, k: usize, y: f64| {
        let sample = Sample::of_outputs(second(k), &[0.0; 2], 1.0);
        scheme.receive(Side::Mechanics, &Sample { y: &[y, 0.0], ..sample }).unwrap();
        scheme.receive(Side::Actuator, &Sample { y: &[0.0], ..sample }).unwrap();
    };
    let (mut scheme, mut u) = (nepce(), [0.0; 2]);
    for k in 0..4 {
        // y = 2 t: the hold misses 1 on average over each macro step.
        let y = 2.0 * k as f64;
        exchanged(&mut *scheme, k, y);
        scheme.input(Side::Actuator, MicroStep::new(second(k), 0, 1), &[0.0], &mut u).unwrap();
        assert_eq!(u[0], if k == 0 { y } else { y + 1.0 });
    }
    // The actuator's output jumps to 4 within the macro step and back: mean over the trapezoids 0–4–0 of height 4 is 2.
    let mut scheme = nepce();
    exchanged(&mut *scheme, 0, 0.0);
    for (j, own) in [0.0, 4.0].into_iter().enumerate() {
        scheme.input(Side::Actuator, MicroStep::new(second(0), j, 2), &[own], &mut u).unwrap();
    }
    exchanged(&mut *scheme, 1, 0.0);
    let mut force = [0.0];
    scheme.input(Side::Mechanics, MicroStep::new(second(1), 0, 1), &[0.0; 2], &mut force).unwrap();
    assert_eq!(force, [2.0]);
}

#[test]
fn the_mass_of_the_start_stays_whatever_the_model_says_later() {
    let empty = ReducedInterfaceModel::zeros(0, 1);
    let mut scheme = built("rim-fixed-mass", 1.0, &ModelOptions::default(), Some(&empty)).unwrap();
    // 2 kg at first, then 1/2 kg; the free acceleration is never used.
    for (mass, y) in [(2.0, [1.0, 3.0]), (0.5, [4.0, -1.0])] {
        let mut model = empty.clone();
        (model.h[0], model.a[0], model.w[0]) = (1.0 / mass, 7.0, y[1]);
        let sample = Sample { model: Some(&model), ..Sample::of_outputs(second(0), &y, 0.5) };
        scheme.receive(Side::Mechanics, &sample).unwrap();
        assert_eq!(scheme.report().effective_mass, Some(2.0));
        let wanted = [[y[0] + 0.5 * (y[1] + 1.0), y[1] + 1.0], [y[0] + y[1] + 1.5, y[1] + 2.0]];
        for (index, wanted) in wanted.into_iter().enumerate() {
            let mut u = [0.0; 2];
            scheme.input(Side::Actuator, MicroStep::new(second(0), index, 2), &[4.0], &mut u).unwrap();
            assert_eq!(u, wanted);
        }
    }
}

const STEP: MacroStep = MacroStep { index: 0, start: 0.0, length: 4e-3 };

/// Gap tracking with this model, at its communication point, under no force.
fn tracking(model: &ReducedInterfaceModel, motion: ModelMotion) -> Box<dyn CouplingScheme> {
    let mut model = model.clone();
    model.mechanics_step = STEP.length;
    let options = ModelOptions { model_motion: motion, ..ModelOptions::default() };
    let mut scheme = built("rim-nonsmooth-gap", 1.0, &options, Some(&model)).unwrap();
    let sample = Sample { model: Some(&model), ..Sample::of_outputs(STEP, &[0.0, 0.0], 1e-3) };
    scheme.receive(Side::Mechanics, &sample).unwrap();
    scheme.receive(Side::Actuator, &Sample::of_outputs(STEP, &[0.0], 1e-3)).unwrap();
    scheme
}

/// Takes a micro step of 1 ms; returns the velocity of the interface.
fn micro_step(scheme: &mut dyn CouplingScheme, index: usize) -> f64 {
    let mut u = [0.0; 2];
    scheme.input(Side::Actuator, MicroStep::new(STEP, index, 4), &[0.0], &mut u).unwrap();
    u[1]
}

/// A body of 1 kg pushed by 2 N, less what its position and velocity take of them at once.
#[test]
fn a_micro_step_of_the_second_order_ends_twice_as_far_from_its_start_as_its_mean() {
    let mut model = ReducedInterfaceModel::zeros(0, 1);
    model.h[0] = 1.0;
    let mut scheme = tracking(&model, ModelMotion::Frozen);
    scheme.receive_feedthrough(&[-3.0, -0.5]).unwrap();
    let mut end = [0.0; 2];
    for index in 0..4 {
        let (at, [position, w], force) = (MicroStep::new(STEP, index, 4), end, 2.0 - 3.0 * end[0] - 0.5 * end[1]);
        scheme.input(Side::Actuator, at, &[force], &mut end).unwrap();
        let mean = end[1];
        scheme.input_at_end(Side::Actuator, &mut end);
        assert!(mean > w, "{index}");
        assert_relative_eq!(end[1], 2.0 * mean - w, max_relative = 1e-13);
        assert_relative_eq!(end[0], position + at.length * mean, max_relative = 1e-13);
    }
}

#[test]
fn a_scheme_that_keeps_every_entry_is_refused_where_only_what_is_not_zero_has_room() {
    let chain = |n: usize| (0..n).map(|i| vec![i.saturating_sub(1)]).collect::<Vec<_>>();
    let model = |n| ReducedInterfaceModel::zeros_of(std::sync::Arc::new(SymmetricPattern::new(&chain(n))), 1);
    let refused = |scheme: &str, n: usize| {
        let built = built(scheme, 1.0, &ModelOptions::default(), Some(&model(n)));
        built.err().map(|error| error.to_string())
    };
    // 12 matrices of 7000² entries are 4.4 GiB.
    let said = refused("rim-smooth", 7000).unwrap();
    assert!(said.contains("7000 contacts, up to 4.4 GiB, and the limit is 4.0 GiB"), "{said}");
    assert_eq!([refused("rim-nonsmooth-gap", 7000), refused("rim-smooth", 60)], [None, None]);
}

/// Two contacts of 1 kg, of which one stops in the second and third of four steps of 1 ms, and pulls the other along:
/// from 1.01 m/s to 1.22 and 1.43 m/s, by impulses of 0.5 N·s. No acceleration of 210 m/s² follows from that.
#[test]
fn the_next_closing_must_not_be_foreseen_by_the_impact_of_another_contact() {
    let mut model = ReducedInterfaceModel::zeros(2, 1);
    model.h.copy_from_slice(&[1.0, -0.4, 0.0, -0.4, 1.0, 0.0, 0.0, 0.0, 1.0]);
    model.a.copy_from_slice(&[0.0, -10.0, 0.0]);
    model.w.copy_from_slice(&[-1.0, -1.0, 0.0]);
    model.gap.copy_from_slice(&[1.5e-3, 0.1]);
    let mut scheme = tracking(&model, ModelMotion::Frozen);
    let (mut w, mut gap) = (-1.0, 0.1);
    let falls = |gap: f64, w: f64| 2.0 * gap / ((w * w + 20.0 * gap).sqrt() - w);
    for (index, impulse) in [0.0, 0.5, 0.5, 0.0].into_iter().enumerate() {
        micro_step(&mut *scheme, index);
        w += -0.01 - 0.4 * impulse;
        gap += 1e-3 * w;
        let expected = match index {
            // The other one closes before.
            0 => 0.5e-3 / 1.0,
            1 | 2 => gap / -w,
            // The first contact rests, loaded by nothing.
            _ => falls(gap, w),
        };
        assert_relative_eq!(scheme.forecast().unwrap().next_closing.unwrap(), expected, max_relative = 1e-12);
    }
    // A contact that touches up to rounding, and is not pressed, is none that closes.
    let mut model = ReducedInterfaceModel::zeros(1, 1);
    model.h.copy_from_slice(&[1.0, 0.0, 0.0, 1.0]);
    (model.gap[0], model.w[0]) = (1e-13, -1e-17);
    let mut scheme = tracking(&model, ModelMotion::Frozen);
    micro_step(&mut *scheme, 0);
    assert_eq!(scheme.forecast().unwrap().next_closing, None);
}

#[test]
fn the_class_of_a_scheme_is_the_most_that_it_asks_for() {
    for (name, wanted) in [
        ("zero-order-hold", "samples"),
        ("integral-correction-first-order", "derivatives"),
        ("hydraulic-line", "inside"),
        // It asks for derivatives as well.
        ("interface-jacobian", "model"),
        ("rim-nonsmooth-gap", "model"),
        ("iterated-aitken", "repetition"),
        ("monolithic", "whole"),
    ] {
        assert_eq!(InformationClass::of(scheme_by_name(name)).to_string(), wanted, "{name}");
    }
    assert_eq!("model".parse::<InformationClass>().unwrap(), InformationClass::Model);
    assert!("modell".parse::<InformationClass>().unwrap_err().to_string().contains("did you mean `model`"));
}
