//! What little restitution changes: hardly anything.

use crate::support::*;

/// Machines that are not at rest with 5 ms, of which one lasts 1.2 ms: their own macro step.
const OWN_STEP: [&str; 2] = ["slider-crank", "elastic-bar"];
/// The wedge box once more, on other ground and in another manoeuvre.
const SAME_MACHINE: [&str; 2] = ["wedge-box-two-ledges", "wedge-box-reversal"];
/// A jaw that just touches at the end of a step, or is 4 µm short of that and touches a step later: with the one phase
/// of five at which that happens the error is 3.99 instead of 2.25 % of the peak. The bucket of the excavator's arm: at
/// one phase of three 42 instead of 21 N, of a peak of 17 kN; at the others 129 and 159 instead of 124 and 173 N.
const GRAZES: [(&str, &str); 2] = [("gripper", "rim-nonsmooth"), ("excavator-arm", "rim-nonsmooth")];
/// A sleeve that friction holds by a twentieth: a millionth of a metre decides when it lets go. The references with and
/// without are 0.8 % of the peak apart (rms), and the one without is uncertain by 1.5 %. With gaps 17 instead of 10 %.
const SENSITIVE: &str = "woodpecker";

const SCHEMES: [&str; 2] = ["rim-nonsmooth", "rim-nonsmooth-gap"];

/// Force errors (N) of each scheme at three phases, against a reference without uncertainty; none of a machine without
/// restitution.
fn errors(case: &Case, restitution: &str) -> Option<[Vec<f64>; 2]> {
    let own = if OWN_STEP.contains(&&*case.name) { case.defaults.macro_step_s } else { 5e-3 };
    let mut parameters = case.default_parameters();
    parameters.set("restitution", restitution).ok()?;
    if has_friction(&parameters) {
        // Along the surface as well, where it can be set.
        let _ = parameters.set("tangential_restitution", restitution);
    }
    let spec = |scheme| usual_spec(&case.name, scheme, own).changed(|own| own.parameters = parameters.clone());
    let coarse = with_coarse_reference(&spec(SCHEMES[0]));
    let solution = Reference::solution(&coarse, 2, StopFlag::never()).unwrap();
    let reference = Reference::of_one(&coarse, solution, f64::NAN).unwrap();
    Some(SCHEMES.map(|scheme| {
        let error = |phase: u32| {
            let spec = spec(scheme).changed(|own| own.phase = f64::from(phase) / 5.0);
            metric(&spec, completed(&spec), &reference, "force_error_rms_n")
        };
        [1, 3, 5].map(error).into()
    }))
}

/// The law with e → 0 is that with e = 0: errors were up to eleven times those without, when each contact that closed
/// was stopped above its surface and fell on.
///
/// It is a statement on positions, and on these rows at these phases. Where nothing presses the *velocity* jumps at e =
/// 0, see [`without_a_load_the_velocity_must_jump_at_no_restitution`] and `docs/method/mechanics.md`; other rows of the
/// row of discs and of the gripper have up to twice the error.
#[test]
fn a_thousandth_of_restitution_must_leave_force_errors_as_they_are_without() {
    let mut machines = 0;
    for case in cases().iter().filter(|case| !SAME_MACHINE.contains(&&*case.name)) {
        let Some(without) = errors(case, "0") else { continue };
        let with = errors(case, "0.001").unwrap();
        for ((scheme, without), with) in SCHEMES.into_iter().zip(without).zip(with) {
            machines += 1;
            let each = largest(with.iter().zip(&without).map(|(with, without)| with / without));
            let [with, without] = [with, without].map(|errors| Pool::of(errors).median().unwrap());
            if *case.name == *SENSITIVE {
                continue;
            }
            assert!(with <= 1.3 * without, "{} {scheme}: {with} instead of {without}", case.name);
            assert!(each <= 1.3 || GRAZES.contains(&(&*case.name, scheme)), "{} {scheme}: {each}-fold", case.name);
        }
    }
    assert!(machines >= 2 * 17, "{machines} machines and schemes");
}

/// A ball that closes a gap within a step, h = 0.01 s and w = −1 m/s, with what presses it. Its height and velocity
/// after one step and after two.
fn ball(restitution: f64, gravity: &str) -> [[f64; 2]; 2] {
    let set = [
        ("restitution", &*restitution.to_string()),
        ("gravity_m_s2", gravity),
        ("spring_stiffness_n_m", "0"),
        ("start_height_m", "0.004"),
        ("start_velocity_m_s", "-1"),
    ];
    let options = [("macro_step_s", "0.01"), ("mechanics_steps", "1"), ("duration_s", "0.02")];
    let trajectory = run(&spec_with("bouncing-ball", "zero-order-hold", &options, &set)).trajectory;
    let [height, velocity] = ["interface_position_m", "interface_velocity_m_s"].map(|name| column(&trajectory, name));
    [1, 2].map(|step| [height[step], velocity[step]])
}

/// The limit of the law: without a load the gap law leaves −g/h for a step, and a rebound of any e > 0 stops the
/// contact at once. Positions, and the state two steps later, are continuous. Under a load that outweighs the rebound
/// the velocity is continuous as well.
#[test]
fn without_a_load_the_velocity_must_jump_at_no_restitution() {
    let [without, with] = [0.0, 1e-9].map(|restitution| ball(restitution, "0"));
    assert!((without[0][1] + 0.4).abs() < 1e-12 && with[0][1].abs() < 1e-8, "{without:?} {with:?}");
    assert!((without[0][0] - with[0][0]).abs() < 1e-9 && (without[1][0] - with[1][0]).abs() < 1e-9);
    assert!((without[1][1] - with[1][1]).abs() < 1e-8, "{without:?} {with:?}");
    let [without, with] = [0.0, 1e-9].map(|restitution| ball(restitution, "9.81"));
    let apart = without.iter().flatten().zip(with.iter().flatten()).map(|(a, b)| (a - b).abs());
    assert!(largest(apart) < 1e-8, "{without:?} {with:?}");
}
