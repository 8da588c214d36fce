//! A machine in space against a trial independent of this code, and what bodies in space are not offered.

use crate::support::*;
use rimbench::contact_law::ContactSpring;
use rimbench::interface_model::Rows;
use rimbench::mechanics::{MechanicalModel, ModelSize};
use rimbench::models::{Foot, Pin, SpatialBody, SpatialBodyGeometry};
use std::sync::LazyLock;

/// Both sides in one loop at 12.5 µs, rows every 50 µs: what runs are held against.
static REFERENCE: LazyLock<Trajectory> = LazyLock::new(|| march("tripod", &[], 1.25e-5, 200_000, 4));

/// Time, forces (N), lengths (m), place (m) and yaw (rad) of the trial at 6.25 µs; its forces differ by 0.0152 and
/// 0.0151 N rms from those at 12.5 µs.
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

/// Time, force (N), length (m), place (m) and yaw (rad) of the wedge box of the trial at 6.25 µs; its force differs by
/// 0.47 N rms from that at 12.5 µs.
const TRIAL_OF_BOX: [[f64; 7]; 10] = [
    [0.25, 496.48, 2.539795, 0.025305, -0.001151, 0.416378, 0.014428],
    [0.50, 347.27, 2.608419, 0.089207, -0.011656, 0.415537, 0.058079],
    [0.75, 198.02, 2.677297, 0.154308, -0.029058, 0.410655, 0.106739],
    [1.00, 173.14, 2.746228, 0.216877, -0.048670, 0.405526, 0.159221],
    [1.25, 140.90, 2.815193, 0.273709, -0.071512, 0.400602, 0.225475],
    [1.50, 523.59, 2.883697, 0.317695, -0.095712, 0.400000, 0.313935],
    [1.75, 505.20, 2.952232, 0.355988, -0.120144, 0.400000, 0.404813],
    [2.00, 491.07, 3.020787, 0.393210, -0.139546, 0.400000, 0.488789],
    [2.25, 481.53, 3.089355, 0.429719, -0.154933, 0.400000, 0.568047],
    [2.50, 475.75, 3.157932, 0.465729, -0.166918, 0.400000, 0.643968],
];
static REFERENCE_OF_BOX: LazyLock<Trajectory> = LazyLock::new(|| march("wedge-box-space", &[], 1.25e-5, 200_000, 4));

#[test]
fn the_wedge_box_in_space_must_move_as_in_a_trial_independent_of_this_code_and_lift_a_loaded_foot() {
    let names = ["actuator_force_n", "actuator_length_m", "body_x_m", "body_y_m", "body_z_m", "yaw_rad"];
    let columns = names.map(|name| column(&REFERENCE_OF_BOX, name));
    let mut square = 0.0;
    for [time, row @ ..] in TRIAL_OF_BOX {
        let at = (time / 5e-5).round() as usize;
        for (k, (column, wanted)) in columns.iter().zip(row).enumerate() {
            let off = column[at] - wanted;
            if k == 0 {
                square += off * off / TRIAL_OF_BOX.len() as f64;
            } else {
                assert!(off.abs() <= 1e-5, "{}: {} at {time} s, trial {wanted}", names[k], column[at]);
            }
        }
    }
    assert!(square.sqrt() <= 3.0 * 0.4718, "{} N", square.sqrt());
    let peak = largest(columns[0].iter().map(|force| force.abs()));
    assert!((peak - 1766.4).abs() <= 3.0, "{peak} N");
    // Feet close for the first time after they were open.
    let closes = |contact: &str| {
        let gap = column(&REFERENCE_OF_BOX, &format!("gap_{contact}_m"));
        (1..gap.len()).filter(|k| gap[*k] <= 1e-9 && gap[k - 1] > 1e-9 && *k > 1000).map(|k| 5e-5 * k as f64).next()
    };
    for (contact, trial) in [("foot_1", 1.33270), ("foot_2", 1.33364), ("foot_3", 1.28173)] {
        let found = closes(contact);
        assert!(found.is_some_and(|time| (time - trial).abs() < 3e-4), "{contact}: {found:?} s, trial {trial} s");
    }
}

/// Without friction and offsets nothing is left of the third dimension.
#[test]
fn without_friction_and_offsets_the_wedge_box_in_space_must_be_the_planar_one() {
    let planar = march("wedge-box", &[], 5e-5, 50_000, 20);
    let flat = [
        ("friction", "1e-12"),
        ("attachment_y_m", "0"),
        ("ball_pin_y_m", "0"),
        ("short_wedge_m", "0"),
        ("ledge_lead_m", "0.1"),
        ("ramp_slope", "0.15"),
    ];
    let space = march("wedge-box-space", &flat, 5e-5, 50_000, 20);
    for (there, here, bound) in [
        ("actuator_force_n", "actuator_force_n", 1e-5),
        ("actuator_length_m", "actuator_length_m", 1e-12),
        ("box_x_m", "body_x_m", 1e-12),
        ("box_y_m", "body_z_m", 1e-12),
    ] {
        let off = max_difference(&column(&space, here), &column(&planar, there));
        // 50 000 problems, each solved to some 1e-11 m/s or better: 5e-16 m a step, and what oil of 5e7 N/m makes of
        // their sum.
        assert!(off <= bound, "{here}: {off:e}");
    }
    let sideways = largest(column(&space, "body_y_m").iter().map(|y| y.abs()));
    assert!(sideways < 1e-12, "{sideways} m");
}

/// Median over four phases of the larger rms error of the forces at communication points, N; none where a run fails.
fn middle_error(case: &str, options: &[(&str, &str)], scheme: &str, macro_step: f64) -> Option<f64> {
    let (reference, forces) = match case {
        "tripod" => (&REFERENCE, &["force_1_n", "force_2_n"][..]),
        _ => (&REFERENCE_OF_BOX, &["actuator_force_n"][..]),
    };
    let mut errors: Vec<f64> = [1.0, 0.382, 0.764, 0.146]
        .into_iter()
        .filter_map(|phase| {
            let spec =
                spec_with(case, scheme, options, &[]).changed(|own| (own.phase, own.macro_step) = (phase, macro_step));
            let result = run(&spec);
            (result.report.outcome == Outcome::Completed).then(|| {
                let own = result.trajectory;
                let there = reference.resampled(own.column(0));
                largest(forces.iter().map(|name| rms_difference(&column(&own, name), &column(&there, name))))
            })
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    (errors.len() == 4).then(|| 0.5 * (errors[1] + errors[2]))
}

/// Case, scheme, options, macro steps (ms) and the trial's medians (N), and by what part it may differ: 15 % with the
/// mean returned, 30 % with the profile. On one row under the profile the trial's box kept cones at contacts that
/// stick.
#[test]
fn errors_of_schemes_in_space_must_be_those_of_the_trial() {
    const PROFILE: &[(&str, &str)] = &[("force_return", "profile"), ("mechanics_steps", "all")];
    const MEAN: &[(&str, &str)] = &[];
    const AT_BOUND: &[(&str, &str)] = &[("contact_detection", "active")];
    const ROW: &[(&str, &str)] = &[("friction_rows", "slip-direction")];
    const ROW_PROFILE: &[(&str, &str)] = &[ROW[0], PROFILE[0], PROFILE[1]];
    let rows = [
        ("tripod", "rim-smooth", MEAN, &[(2.0, 6.68), (5.0, 13.56), (10.0, 66.11)][..]),
        ("tripod", "rim-smooth-active", MEAN, &[(2.0, 7.58), (5.0, 18.10), (10.0, 25.79)]),
        ("tripod", "rim-nonsmooth", MEAN, &[(5.0, 15.17)]),
        ("tripod", "rim-nonsmooth-gap", MEAN, &[(5.0, 15.17), (20.0, 37.25)]),
        ("tripod", "rim-nonsmooth-gap", PROFILE, &[(5.0, 0.13)]),
        ("wedge-box-space", "rim-smooth", AT_BOUND, &[(2.0, 26.34), (5.0, 41.42)]),
        ("wedge-box-space", "rim-smooth-active", MEAN, &[(2.0, 26.31), (5.0, 34.04), (10.0, 56.84)]),
        ("wedge-box-space", "rim-nonsmooth-gap", MEAN, &[(5.0, 30.60), (20.0, 40.81)]),
        ("wedge-box-space", "rim-nonsmooth-gap", PROFILE, &[(20.0, 10.38)]),
        ("tripod", "rim-nonsmooth-gap", ROW, &[(2.0, 6.664), (5.0, 12.92), (10.0, 38.58), (20.0, 200.5)]),
        ("tripod", "rim-nonsmooth-gap", ROW_PROFILE, &[(5.0, 6.924)]),
        ("wedge-box-space", "rim-nonsmooth-gap", ROW, &[(2.0, 29.0), (5.0, 32.0), (10.0, 35.0), (20.0, 55.0)]),
        ("wedge-box-space", "rim-nonsmooth-gap", ROW_PROFILE, &[(5.0, 2.23)]),
    ];
    let mut wrong = Vec::new();
    for (case, scheme, options, wanted) in rows {
        let part = if options.ends_with(PROFILE) { 0.3 } else { 0.15 };
        for &(step, trial) in wanted {
            let found = middle_error(case, options, scheme, 1e-3 * step);
            if !found.is_some_and(|found| (found / trial - 1.0).abs() <= part) {
                wrong.push((case, scheme, options.len(), step, found, trial));
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
fn a_point_on_a_spring_must_slide_to_its_stop_and_give_its_energy_to_friction_and_damper() {
    let law = Friction { coefficient: 0.25, at_rest: 0.25, restitution: 0.0 };
    // Aperiodic: 2 √(k m) = 2.8e3 N·s/m.
    let spring = ContactSpring { stiffness: 1e6, damping: 5e3 };
    let mut point =
        stepper(OneFoot, ContactLaw { spring: Some(spring), ..PLASTIC }).with_friction(law, solver()).unwrap();
    let (h, stops) = (1e-4, 0.5 / (0.25 * 9.81));
    for step in 0..2 * (stops / h) as usize {
        point.step(step as f64 * h, &[0.0], h).unwrap();
    }
    let ([x, y, z], sunk) = ([0, 1, 2].map(|k| point.position()[k]), 2.0 * 9.81 / 1e6);
    assert!((x / y - 0.75).abs() < 1e-9 && (z / -sunk - 1.0).abs() < 1e-6, "{x} {y} {z}");
    // As long as it sinks it presses with less than its weight.
    assert!((x.hypot(y) / (0.5 * 0.5 * stops) - 1.0).abs() < 0.02, "{x} {y}");
    let account = point.energy_account().unwrap();
    assert!(account.closure().abs() < 1e-12 && account.contact > 0.0, "{account:?}");
    assert!((account.friction - 0.25).abs() < 1e-9, "{account:?}");
}

/// Yaw (rad) of the machine on four legs after 2.5 s. The trial's reference, four rigid feet whose load is spread
/// evenly, has −0.03102.
#[test]
fn four_legs_that_give_way_must_yaw_as_the_trial_whatever_their_stiffness_and_by_how_they_share_the_load() {
    let yaw = |set: &[(&str, &str)]| *column(&march("four-legs", set, 5e-5, 50_000, 50), "yaw_rad").last().unwrap();
    for (compliance, damping) in [("1e-6", "1e4"), ("1e-8", "1e6")] {
        let found = yaw(&[("contact_compliance_m_n", compliance), ("contact_damping_n_s_m", damping)]);
        assert!((found + 0.03102).abs() < 2e-4, "{compliance} m/N: {found} rad");
    }
    // Feet that are longer by a few hundredths of a millimetre take load from the others.
    for (long, wanted) in [("-5e-5", -0.0445), ("1e-5", -0.0286)] {
        let found = yaw(&[("long_feet_m", long)]);
        assert!((found - wanted).abs() < 2e-4, "{long} m: {found} rad");
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
    const ROW: (&str, &str) = ("friction_rows", "slip-direction");
    for (scheme, (key, value), wanted) in [
        ("rim-nonsmooth-gap", ("mechanics_integrator", "midpoint"), "mechanics_integrator = midpoint"),
        ("rim-nonsmooth-gap", ("mechanics_integrator", "event-split"), "mechanics_integrator = event-split"),
        ("rim-smooth", ROW, "friction_rows = slip-direction: no contact of scheme `rim-smooth` sticks and slides"),
        ("interface-mass", ROW, "friction_rows = slip-direction: no contact of scheme `interface-mass`"),
        (
            "zero-order-hold",
            ROW,
            "friction_rows = slip-direction: scheme `zero-order-hold` has no reduced interface model",
        ),
        ("rim-nonsmooth in wedge-box", ROW, "friction_rows = slip-direction: the contacts have no friction"),
        ("rim-nonsmooth in wedge-box-friction", ROW, "contacts in the plane have one tangential row anyway"),
        ("rim-nonsmooth moving", ROW, "use model_motion `frozen`"),
    ] {
        let (name, case) = scheme.split_once(" in ").unwrap_or((scheme, "tripod"));
        let mut request = RunRequest::of(case, name.trim_end_matches(" moving"));
        if name.ends_with(" moving") {
            request.put("model_motion", "extrapolated").unwrap();
        }
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
        ball: None,
    });
    let refused = stepper(body.unwrap(), PLASTIC).capabilities().use_second_order(SecondOrder::Midpoint);
    assert!(refused.unwrap_err().contains("quaternions"));
}
