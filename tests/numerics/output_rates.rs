//! What actuators say of the rates of their forces, against differences of the forces.

use crate::support::*;
use rimbench::models::{Carriage, Cylinder, HydropneumaticStrut, Oil, Spool, SpringActuator, Strut};
use rimbench::parameter::ParameterSet;

/// Holds the rates at inputs `u` (m, m/s) against steps of `h` (s) from inputs that are moved by `by`; `error` is
/// relative.
fn check<A: Subsystem + Clone>(actuator: &A, u: [f64; 2], h: f64, by: [f64; 2], error: f64) {
    let force = |actuator: &A, u: [f64; 2]| {
        let mut y = [0.0];
        actuator.clone().outputs(&u, &mut y).unwrap();
        y[0]
    };
    let rate = |u: [f64; 2]| {
        let mut after = actuator.clone();
        after.step(0.0, &u, h).unwrap();
        (force(&after, u) - force(actuator, u)) / h
    };
    let mut rates = OutputRates::zeros(1, 2);
    assert_eq!(actuator.clone().capabilities().output_rates(0.0, &u, &mut rates), Ok(true));
    let known = rates.rate[0];
    approx::assert_relative_eq!(known, rate(u), max_relative = error);
    for i in 0..2 {
        let moved = |by: f64| if i == 0 { [u[0] + by, u[1]] } else { [u[0], u[1] + by] };
        let slope = |of: &dyn Fn([f64; 2]) -> f64| (of(moved(by[i])) - of(moved(-by[i]))) / (2.0 * by[i]);
        let gain = rates.rate_gain[i];
        approx::assert_abs_diff_eq!(gain, slope(&rate), epsilon = error * gain.abs().max(1e-3 * known.abs()));
        let feedthrough = slope(&|u| force(actuator, u));
        approx::assert_relative_eq!(rates.feedthrough[i], feedthrough, max_relative = 1e-9, epsilon = 1e-9);
    }
}

#[test]
fn output_rates_are_the_differences_of_forces() {
    // Euler is exact here; the rate is linear in ṡ, and its relative curvature in s is 1/l² with l = 1 m.
    let spool = Spool::new(vec![(0.0, 0.3)]);
    let cylinder = Cylinder::defaults().starting_at(2.5, &Oil::defaults(), [2.9e6, 4.1e6], spool).unwrap();
    check(&cylinder, [2.6, 0.05], 1e-7, [1e-3, 1e-2], 1e-5);
    // Curvature of the gas law: (κ + 1)/2 · A h w/V = 1.2e-6 of the rate.
    check(&HydropneumaticStrut::new(Strut::defaults(), 2500.0).unwrap(), [0.0, 0.2], 1e-6, [0.1, 0.01], 1e-5);
    for carriage_mass_kg in [0.7, 0.0] {
        let carriage = Carriage {
            spring_stiffness_n_m: 300.0,
            spring_damping_n_s_m: 4.0,
            carriage_mass_kg,
            base_stiffness_n_m: 500.0,
            base_damping_n_s_m: 2.0,
            base_position_m: 0.1,
            base_amplitude_m: 0.05,
            base_frequency_hz: 2.0,
            base_phase_rad: 0.4,
            carriage_position_m: 0.1,
            carriage_velocity_m_s: 0.0,
        };
        // One-sided difference: h/2 times the second rate, itself about ω_max² F with ω_max below 40 rad/s.
        check(&SpringActuator::new(carriage).unwrap(), [0.08, 0.3], 1e-6, [0.5, 0.5], 1e-3);
    }
}
