//! A machine in space against a trial independent of this code, and what bodies in space are not offered.

use crate::support::*;
use rimbench::interface_model::Rows;
use rimbench::mechanics::{MechanicalModel, ModelSize};
use rimbench::models::{Foot, Pin, SpatialBody, SpatialBodyGeometry};
use std::sync::LazyLock;

/// Both sides in one loop at 6.25 µs, rows every 50 µs: what runs are held against.
static REFERENCE: LazyLock<Trajectory> = LazyLock::new(|| march("tripod", &[], 6.25e-6, 400_000, 8));

/// Time, forces (N), lengths (m), place (m) and yaw (rad) of the trial at 6.25 µs; its forces differ by 0.0152 and 0.0151 N rms from those
/// at 12.5 µs.
const TRIAL: [[f64; 8]; 10] = [
    [0.25, 377.59, -761.91, 1.735636, 1.714868, 0.026522, 0.009708, 0.044109],
    [0.50, -602.49, -403.89, 1.715745, 1.664067, 0.014656, -0.036348, 0.003402],
    [0.75, 974.22, 1008.36, 1.694415, 1.640394, -0.001340, -0.057194, -0.025329],
    [1.00, -696.18, 649.76, 1.744500, 1.698555, 0.035167, -0.006894, 0.044611],
    [1.25, -84.21, -981.91, 1.695321, 1.703833, -0.003044, 0.004644, -0.008301],
    [1.50, 664.22, -61.10, 1.715026, 1.643963, 0.019708, -0.053491, -0.026952],
    [1.75, -974.50, 1033.72, 1.736314, 1.656966, 0.036045, -0.043288, -0.001307],
    [2.00, 500.34, 266.72, 1.686414, 1.712698, -0.008708, 0.015086, -0.025656],
    [2.25, 55.22, -767.73, 1.735438, 1.682007, 0.033090, -0.019495, 0.010905],
    [2.50, -825.75, 707.36, 1.715812, 1.635791, 0.020441, -0.061585, -0.027846],
];

#[test]
fn the_tripod_must_move_as_in_a_trial_independent_of_this_code() {
    let names = ["force_1_n", "force_2_n", "length_1_m", "length_2_m", "body_x_m", "body_y_m", "yaw_rad"];
    let columns = names.map(|name| column(&REFERENCE, name));
    let mut squares = [0.0; 2];
    for [time, row @ ..] in TRIAL {
        let at = (time / 5e-5).round() as usize;
        for (k, (column, wanted)) in columns.iter().zip(row).enumerate() {
            let off = column[at] - wanted;
            match squares.get_mut(k) {
                Some(sum) => *sum += off * off / TRIAL.len() as f64,
                // Printed to a millionth, and of the first order in the step.
                None => assert!(off.abs() <= 2e-6, "{}: {} at {time} s", names[k], column[at]),
            }
        }
    }
    let rms = squares.map(f64::sqrt);
    assert!(rms.iter().all(|rms| *rms <= 3.0 * 0.0151), "{rms:?} N");
    let peaks = [0, 1].map(|k| largest(columns[k].iter().map(|force| force.abs())));
    assert!((peaks[0] - 1573.33).abs() <= 0.1 && (peaks[1] - 1417.77).abs() <= 0.1, "{peaks:?} N");
}

/// Median over four phases of the larger rms error of both forces at communication points, N; none where a run fails.
fn middle_error(options: &[(&str, &str)], scheme: &str, macro_step: f64) -> Option<f64> {
    let mut errors: Vec<f64> = [1.0, 0.382, 0.764, 0.146]
        .into_iter()
        .filter_map(|phase| {
            let spec = spec_with("tripod", scheme, options, &[])
                .changed(|own| (own.phase, own.macro_step) = (phase, macro_step));
            let result = run(&spec);
            (result.report.outcome == Outcome::Completed).then(|| {
                let own = result.trajectory;
                let there = REFERENCE.resampled(own.column(0));
                let rms = |name| rms_difference(&column(&own, name), &column(&there, name));
                rms("force_1_n").max(rms("force_2_n"))
            })
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    (errors.len() == 4).then(|| 0.5 * (errors[1] + errors[2]))
}

/// Scheme, options, macro step (ms), the trial's median (N), and by what part it may differ: 15 % with the mean returned, 30 % with the profile.
#[test]
fn errors_of_schemes_on_the_tripod_must_be_those_of_the_trial() {
    const PROFILE: &[(&str, &str)] = &[("force_return", "profile"), ("mechanics_steps", "all")];
    const MEAN: &[(&str, &str)] = &[];
    let rows = [
        ("rim-smooth", MEAN, &[(2.0, 6.68), (5.0, 13.56), (10.0, 66.11)][..]),
        ("rim-smooth-active", MEAN, &[(2.0, 7.58), (5.0, 18.10), (10.0, 25.79)]),
        ("rim-nonsmooth", MEAN, &[(2.0, 7.08), (5.0, 15.17), (10.0, 15.88), (20.0, 37.25)]),
        ("rim-nonsmooth-gap", MEAN, &[(2.0, 7.08), (5.0, 15.17), (10.0, 15.88), (20.0, 37.25)]),
        ("rim-nonsmooth-gap", PROFILE, &[(2.0, 0.11), (5.0, 0.13), (10.0, 0.76), (20.0, 5.41)]),
    ];
    let mut wrong = Vec::new();
    for (scheme, options, wanted) in rows {
        let part = if options.is_empty() { 0.15 } else { 0.3 };
        for &(step, trial) in wanted {
            let found = middle_error(options, scheme, 1e-3 * step);
            println!("{scheme} {options:?} {step} ms: {found:?}, trial {trial}");
            if !found.is_some_and(|found| (found / trial - 1.0).abs() <= part) {
                wrong.push((scheme, options.len(), step, found, trial));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// A body that slides on one foot, with a restitution and coefficients that contacts in space do not have.
#[derive(Clone)]
struct OneFoot;

impl MechanicalModel for OneFoot {
    fn size(&self) -> ModelSize {
        ModelSize { velocities: 3, unilateral: 1, tangential: 2, interface: 1, ..ModelSize::default() }
    }
    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (vec![0.0; 3], vec![0.3, 0.4, 0.0])
    }
    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        mass.fill(2.0);
    }
    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        force.copy_from_slice(&[0.0, 0.0, -2.0 * 9.81]);
    }
    fn unilateral(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian.copy_from_slice(&[0.0, 0.0, 1.0]);
        rows.position[0] = q[2];
    }
    fn tangential(&self, _q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian.copy_from_slice(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    }
    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian.copy_from_slice(&[1.0, 0.0, 0.0]);
        rows.position[0] = q[0];
    }
    fn potential_energy(&self, q: &[f64]) -> f64 {
        2.0 * 9.81 * q[2]
    }
}

#[test]
fn a_point_must_slide_straight_to_its_stop_and_its_account_close() {
    let law = Friction { coefficient: 0.25, at_rest: 0.25, restitution: 0.0 };
    let mut point = stepper(OneFoot, PLASTIC).with_friction(law, solver()).unwrap();
    let (h, stops) = (1e-4, 0.5 / (0.25 * 9.81));
    let mut steps = 0;
    while point.velocity().iter().any(|v| v.abs() > 1e-12) {
        point.step(0.0, &[0.0], h).unwrap();
        steps += 1;
    }
    assert_eq!(steps, (stops / h).ceil() as usize);
    let [x, y] = [point.position()[0], point.position()[1]];
    assert!((x / y - 0.75).abs() < 1e-12, "{x} {y}");
    // All of its energy goes to friction.
    assert!((point.ledger().friction + 0.25).abs() < 1e-12, "{:?}", point.ledger());
}

#[test]
fn what_contacts_in_space_do_not_have_must_be_refused_by_name() {
    let plain = Friction { coefficient: 0.25, at_rest: 0.25, restitution: 0.0 };
    let bouncing = ContactLaw { restitution: 0.5, ..PLASTIC };
    for (law, friction, wanted) in [
        (bouncing, plain, "restitution = 0.5 does not go with friction in space"),
        (PLASTIC, Friction { at_rest: 0.4, ..plain }, "static_friction = 0.4 does not go with friction in space"),
        (PLASTIC, Friction { coefficient: -0.1, ..plain }, "friction = -0.1"),
    ] {
        let refused = stepper(OneFoot, law).with_friction(friction, solver()).err().unwrap().to_string();
        assert!(refused.contains(wanted), "{refused}");
    }
    for (scheme, (key, value), wanted) in [
        ("rim-nonsmooth-gap", ("mechanics_integrator", "midpoint"), "mechanics_integrator = midpoint"),
        ("rim-nonsmooth-gap", ("mechanics_integrator", "event-split"), "mechanics_integrator = event-split"),
        ("rim-nonsmooth-gap", ("model_motion", "half-kick"), "model_motion = half-kick"),
        ("rim-smooth", ("redundancy", "regularised:1e-3"), "redundancy"),
        ("interface-jacobian", ("macro_step_s", "1e-3"), "knows no friction"),
    ] {
        let mut request = RunRequest::of("tripod", scheme);
        request.put(key, value).unwrap();
        let said = match request.resolve(catalogue()) {
            Ok(spec) => run(&spec).report.outcome.to_string(),
            Err(refused) => refused.to_string(),
        };
        assert!(said.contains(wanted), "{scheme} {key} = {value}: {said}");
    }
    // Without friction a body in space still has a quaternion.
    let body = SpatialBody::new(SpatialBodyGeometry {
        mass: 1.0,
        inertia: [1.0; 3],
        position: [0.0; 3],
        orientation: [1.0, 0.0, 0.0, 0.0],
        velocity: [0.0; 6],
        gravity: 0.0,
        feet: vec![Foot::over_floor([0.0; 3])],
        pins: vec![Pin { fixed: [-1.0, 0.0, 0.0].into(), arm: [0.0; 3].into() }],
    });
    let refused = stepper(body.unwrap(), PLASTIC).capabilities().use_second_order(SecondOrder::Midpoint);
    assert!(refused.unwrap_err().contains("quaternions"));
}
