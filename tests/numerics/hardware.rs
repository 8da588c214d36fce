//! A simulated mass on contacts that are hardware, which see its motion late.

use crate::support::*;

const CASE: &str = "hardware-contact";

/// Speeds of the mass whenever it has left a contact and no force acts on it any more, m/s.
fn bounces(run: &Trajectory) -> Vec<f64> {
    let [given, taken, velocity] =
        ["actuator_force_n", "force_to_mechanics_n", "interface_velocity_m_s"].map(|name| column(run, name));
    let flies = |k: usize| given[k] == 0.0 && taken[k] == 0.0;
    (1..given.len()).filter(|&k| flies(k) && !flies(k - 1)).map(|k| velocity[k].abs()).collect()
}

/// Of one impact on a spring and a damper that let go where they would pull (Schwager and Pöschel 2007).
fn given_back(mass: f64, stiffness: f64, damping: f64) -> f64 {
    let share = damping / (2.0 * (stiffness * mass).sqrt());
    let rest = (1.0 - share * share).sqrt();
    let angle = std::f64::consts::PI - (2.0 * share * rest / (1.0 - 2.0 * share * share)).atan();
    (-share / rest * angle).exp()
}

#[test]
fn a_contact_in_hardware_must_give_back_what_the_closed_form_says() {
    let speeds = bounces(&march(CASE, &[], 1e-4, 60_000, 1));
    let share = given_back(500.0, 11_691.0, 131.4);
    assert!(speeds.len() == 3 && (share - 0.92).abs() < 1e-3, "{share}");
    for (bounce, speed) in speeds.iter().enumerate() {
        // Of the first order: ω h = 5e-4.
        let wanted = 0.1 * share.powi(bounce as i32 + 1);
        assert!((speed / wanted - 1.0).abs() < 1e-3, "{speeds:?}");
    }
}

#[test]
fn late_by_108_ms_a_hold_must_gain_in_each_bounce_and_a_model_that_is_run_forward_in_none() {
    let late = |scheme: &str, more: &[(&str, &str)]| {
        let options = [&[("macro_step_s", "2e-3"), ("delivery_up", "delay:54")], more].concat();
        let result = run(&spec_with(CASE, scheme, &options, &[]));
        (bounces(&result.trajectory), result.report.audit.work.residual_j().unwrap())
    };
    let (held, created) = late("zero-order-hold", &[]);
    let speeds = [&[0.1], &held[..3]].concat();
    assert!(speeds.windows(2).all(|pair| pair[1] > 1.9 * pair[0]) && created < -1e3, "{speeds:?} {created}");
    let (model, created) = late("rim-nonsmooth-gap", &[]);
    let speeds = [&[0.1], &model[..]].concat();
    assert!(speeds.len() == 4 && speeds.windows(2).all(|pair| pair[1] < 0.93 * pair[0]), "{speeds:?}");
    assert!(created.abs() < 1e-9, "{created}");
    // What the damper counts is what the audit does: what is left is what its bound leaves.
    let (_, created) = late("energy-leak-damper", &[("gain", "1")]);
    assert!(created > -2.5, "{created}");
}
