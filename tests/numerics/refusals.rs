//! What a case cannot be is refused with the reason and the numbers, and each case goes with each scheme or says why
//! not.

use crate::support::*;

/// Case, what is set, and what the refusal says; `…` stands for anything.
const REFUSED: &str = "
bouncing-ball | start_height_m=-0.25 | start_height_m = -0.25 … 0.25 m inside
bouncing-ball | base_stiffness_n_m=0 base_amplitude_m=0.3 | 0.3 m … base_stiffness_n_m
impact-oscillator | start_position_m=0.06 | start_position_m = 0.06 … at most 0.05
slider-between-stops | start_position_m=-0.3 | start_position_m = -0.3 … at least -0.1
cradle | start_position_m=0.02 | start_position_m = 0.02 … 0.02 m inside
elastic-bar | elements=2.5 | elements = 2.5 … whole number
rocking-block | start_angle_rad=0.5 | start_angle_rad = 0.5 … 0.380506
rocking-block | cylinder_length_m=5 | cylinder_length_m = 5 … below 3.6
beam-on-stops | stop_1_position_m=2.5 | stop_1_position_m = 2.5 … from 0 to 2 m
beam-on-stops | modes=40 | modes = 40 … from 1 to 20
n-wedge-box | supports=65 | supports = 65 … from 2 to 64
n-wedge-box | ledge_height_m=3 | impossible geometry … 3.2
n-wedge-box | spool_ramp_end_s=0.05 | spool_ramp_end_s = 0.05 … 0.1
wedge-box-two-ledges | wedge_tip_y_m=-0.5 | gap_right_support_m … -0.05
wedge-box-two-ledges | disc_pin_x_m=0.1 | disc_pin_x_m = 0.1 … radius 0.2
wedge-box | ledge_height_m=1.5 | 1.7000 m above … 1.2182 m apart
wedge-box | contact_compliance_m_n=1e-7 restitution=0.5 | rebounds by its own spring
wedge-box | contact_damping_n_s_m=100 | needs a compliant contact
wedge-box | contact_compliance_m_n=-1 | 0 or above
wedge-box | tangential_restitution=0.5 | needs friction
wedge-box-friction | friction=-0.1 | friction = -0.1 is not valid
wedge-box-friction | friction=inf | friction = inf is not valid
crane-set-down | ground_height_m=0.1 | height of 0.000000 m, inside the ground
crane-set-down | cylinder_length_m=1.2 | cylinder_length_m = 1.2 is not valid; valid: below 1.000000
crane-set-down | load_mass_kg=1e5 | N needs chamber pressures of
crane-set-down | lower_end_s=0.1 | lower_end_s = 0.1 is not valid; valid: at least 0.22
half-car | start_height_m=-0.02 | the front wheel would start at -0.020000 m, inside the road
half-car | road_start_m=-0.3 | front wheel would start at -0.0
half-car | gas_exponent=0.9 | gas_exponent = 0.9 is not valid; valid: a number above 1
lift-table | cylinders=7 | a whole number from 1 to 6
lift-table | box_mass_kg=4e4 | outside tank
gripper | left_clearance_m=-0.01 | the left jaw would start -0.010000 m from the box, inside it
gripper | upper_pad_m=0.5 | a pad at 0.5 m is beside the box
gripper | cylinder_length_m=1.3 | cylinder_length_m = 1.3
disc-row | disc_gap_m=-0.01 | would start with a gap of -0.010000 m
disc-row | wall_gap_m=1 | no disc starts within 0.130000 m of the fixed wall
disc-row | discs=2.5 | discs = 2.5 is not valid; valid: a whole number from 2 to 2500
disc-pile | wall_gap_m=-0.01 | would start with a gap of -0.01
disc-pile | cylinder_length_m=3.5 | the actuator starts 1.500000 m long
disc-pile | layers=61 | layers = 61 is not valid; valid: a whole number from 1 to 60
packed-box | packing_angle_rad=0.5 | packing_angle_rad = 0.5 is not valid; valid: between π/6 = 0.523599 and
packed-box | packing_angle_rad=1.1 | π/3 = 1.047198
packed-box | columns=2 layers=1 packing_angle_rad=0.59 | packing_angle_rad = 0.59 is not valid; valid: above 0.600 … layers = 1
packed-box | disc_mass_kg=1000 | N needs chamber pressures of
packed-box | release_end_s=0.05 | release_end_s = 0.05 is not valid; valid: at least 0.12
woodpecker | friction=0 | above 0
woodpecker | friction=-0.3 | above 0
woodpecker | sleeve_radius_m=2e-3 | does not go over a pole
woodpecker | bird_angle_rad=0.2 | the beak would start
woodpecker | spring_lever_m=0 | above 0
slider-crank | friction=nan | above 0
slider-crank | clearance_m=0 | above 0
slider-crank | rod_length_m=0.1 | rod_length_m = 0.1 is not valid; valid: more than crank_length_m = 0.153
slider-crank | rod_length_m=0.153 | more than crank_length_m
mass-between-stops | friction_n=-1 | 0 or above
mass-between-stops | spool_amplitude=0.6 | at most 0.5: the spool must stay within [0, 1]
mass-between-stops | gravity_m_s2=0 | above 0
towed-block | friction=0 | friction = … above 0
towed-block | friction=inf | friction = … above 0
towed-block | static_friction=0.3 | static_friction = 0.3 is not valid; valid: 0, or at least friction = 0.4
towed-block | static_friction=-1 | 0 or above
towed-block | towing_speed_m_s=0 | above 0
crane-drag | friction=-0.1 | friction = … above 0
crane-drag | tangential_restitution=0.5 | 0 to that along the normal, 0
crane-drag | load_offset_m=0.6 | beyond the rope of 0.5 m
rocking-block-friction | friction=nan | friction = … above 0
rocking-block-friction | tangential_restitution=0.5 | 0 to that along the normal, 0
rocking-block-friction | start_angle_rad=0.6 | falls over
tripod | friction=-0.1 | friction = -0.1 is not valid
tripod | foot_2_angle_deg=90 | redundant: their normal rows have rank 2
four-legs | contact_compliance_m_n=0 contact_damping_n_s_m=0 | rank 3 … contact_compliance_m_n
wedge-box-space | friction=-0.1 | friction = -0.1 is not valid
wedge-box-space | ledge_height_m=1.5 | 1.7000 m above
tripod | spool_amplitude=0.6 | spool_amplitude = 0.6 … at most 0.5
tripod | cylinder_length_m=3.5 | cylinder_length_m = 3.5 … below 3.4
linear-oscillator | coupling=pressure-displacement | one of force-displacement, displacement-displacement, force-force
linear-oscillator | variant=2 | valid: one of 0, 1
hydraulic-crane | coupling=force-force | one of force-displacement, pressure-displacement
hydraulic-crane | manoeuvre=m3 | valid: one of m1, m2
precice-oscillator | integrator=trapezoidal | valid: one of exact, newmark, generalised-alpha
quarter-car | damper=cubic | valid: one of linear, nonlinear
quarter-car | damper=nonlinear integrator=trapezoidal | `exact` … `semi-implicit-euler`
";

/// Case, scheme, options and parameters of runs that are skipped, and the reason.
const SKIPPED: &str = "
linear-oscillator | hydraulic-line | | | oil
half-car | hydraulic-line | | | oil
bouncing-ball | hydraulic-line | | | oil
hydraulic-crane | hydraulic-line | | coupling=pressure-displacement | force-displacement
linear-oscillator | rim-smooth | | coupling=displacement-displacement | force-displacement
wedge-box | rim-split | | | use rim-nonsmooth-gap
wedge-box | interface-jacobian | step_control=model-defect step_tolerance=1e-3 | | interface-jacobian moves no model of the mechanics
wedge-box-friction | rim-nonsmooth-gap | mechanics_integrator=event-split | | mechanics_integrator = event-split
wedge-box-friction | rim-nonsmooth-gap | mechanics_integrator=midpoint | | mechanics_integrator = midpoint
";

/// Pairs `key=value`, with spaces between them.
fn settings(text: &str) -> Vec<(&str, &str)> {
    text.split_whitespace().map(|pair| pair.split_once('=').unwrap()).collect()
}

#[test]
fn what_a_run_lacks_skips_it_with_the_reason() {
    for row in SKIPPED.trim().lines() {
        let [case, scheme, options, set, wanted] =
            row.split('|').map(str::trim).collect::<Vec<_>>().try_into().unwrap();
        let outcome = run(&spec_with(case, scheme, &settings(options), &settings(set))).report.outcome;
        assert!(outcome.name() == "skipped" && outcome.reason().contains(wanted), "{row}: {outcome}");
    }
}

/// What is said of a case with these settings, as early as it can be said.
fn refusal(case: &str, set: &str) -> Option<String> {
    let mut request = RunRequest::of(case, "zero-order-hold");
    request.set = settings(set).into_iter().map(|(key, value)| (key.to_owned(), value.to_owned())).collect();
    let built = request.resolve(catalogue()).and_then(|spec| (spec.case.build)(&spec.parameters, solver()).map(drop));
    built.err().map(|error| error.to_string())
}

#[test]
fn what_a_case_cannot_be_is_refused_with_the_reason_and_the_numbers() {
    for row in REFUSED.trim().lines() {
        let [case, set, wanted] = row.split(" | ").collect::<Vec<_>>().try_into().unwrap();
        let said = refusal(case, set).unwrap_or_else(|| panic!("{row}: is built"));
        assert!(wanted.split(" … ").all(|part| said.contains(part)), "{row}: {said}");
    }
}

#[test]
fn every_case_runs_with_every_scheme_or_says_why_not() {
    for case in cases() {
        for scheme in schemes() {
            let usual = usual_spec(&case.name, &scheme.name, case.defaults.macro_step_s);
            let run = run(&usual.changed(|own| (own.duration, own.phase) = (20.0 * usual.macro_step, 0.6)));
            let (outcome, name) = (&run.report.outcome, format!("{} with {}", case.name, scheme.name));
            if run.report.work.cosim.macro_steps == 0 {
                assert!(!outcome.reason().is_empty(), "{name}: {outcome}");
                continue;
            }
            // An effective mass may be infinite, nothing may be NaN.
            let sound = run.trajectory.rows().flatten().all(|value| !value.is_nan());
            assert!(sound || *outcome != Outcome::Completed, "{name}: a completed run holds NaN");
            assert!(*outcome == Outcome::Completed || !scheme.name.starts_with("rim-nonsmooth"), "{name}: {outcome}");
        }
    }
}
