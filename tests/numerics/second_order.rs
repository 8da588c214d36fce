//! Mechanics and actuators of the second order: closed forms, orders, books, and what refuses them.

use crate::support::*;
use rimbench::models::WedgeBox;

const EVENT_SPLIT: MechanicsIntegrator = MechanicsIntegrator::EventSplit;

/// A run of the second order on both sides.
fn second_order(case: &str, scheme: &str, macro_step: f64) -> RunSpec {
    usual_spec(case, scheme, macro_step).changed(|own| {
        (own.mechanics_integrator, own.actuator_integrator) = (EVENT_SPLIT, ActuatorIntegrator::Midpoint)
    })
}

#[test]
fn the_wedge_box_at_5_ms_is_within_2_newtons_at_every_phase_with_one_mechanics_solve_per_macro_step() {
    let (spec, reference) = (second_order("wedge-box", "rim-nonsmooth-gap", 5e-3), wedge_box_reference());
    for phase in 1..=16 {
        let spec = spec.changed(|own| own.phase = f64::from(phase) / 16.0);
        let run = run(&spec);
        assert_eq!(run.report.outcome, Outcome::Completed, "phase {phase}/16");
        let work = run.report.work;
        let force = metric(&spec, run, reference, "force_error_rms_n");
        assert!(force <= 2.0, "phase {phase}/16: {force} N");
        let solves = work.sides.mechanics.micro_steps as f64 / work.cosim.macro_steps as f64;
        assert!(solves <= 1.2, "phase {phase}/16: {solves} mechanics solves per macro step");
        assert_eq!((work.cosim.repeated_macro_steps, work.sides.mechanics.split_fallbacks), (0, 0));
        assert!(work.sides.mechanics.splits > 0);
    }
}

#[test]
fn the_position_converges_at_second_order_through_the_impacts_of_the_wedge_box() {
    let (spec, reference) = (second_order("wedge-box", "rim-nonsmooth-gap", 1e-3), wedge_box_reference());
    let uncertainty = reference.uncertainty_of("actuator_length_m").unwrap();
    let points: Vec<(f64, f64)> = [1e-3, 2e-3, 3e-3, 5e-3, 7e-3, 10e-3, 20e-3]
        .into_iter()
        .map(|macro_step| {
            let errors = (1..=4).map(|phase| {
                let spec = spec.changed(|own| {
                    (own.macro_step, own.micro_step, own.phase) = (macro_step, 2.5e-5, f64::from(phase) / 4.0)
                });
                metric(&spec, run(&spec), reference, "position_error_rms_m")
            });
            (macro_step, Pool::of(errors).median().unwrap())
        })
        .filter(|(_, error)| *error > 10.0 * uncertainty)
        .collect();
    assert_eq!(points.len(), 7, "uncertainty {uncertainty} m");
    let slope = order_of_convergence(&points).unwrap();
    assert!(slope >= 1.9, "slope {slope} through {points:?}");
}

#[test]
fn the_event_driven_reference_has_order_two_and_lies_where_the_first_order_solution_tends_to() {
    for case in ["wedge-box", "half-car", "crane-set-down"] {
        let spec = usual_spec(case, "zero-order-hold", 1e-3);
        let reference = match case {
            "half-car" => Reference::compute(&spec, StopFlag::never()).unwrap().into(),
            _ => coarse_reference(&spec),
        };
        let row = &spec.case.interface_columns[0];
        let column = reference.trajectory.index_of(&row.position).unwrap();
        let order = reference.order[column];
        // On the half car events of one solution fall into pieces of another: 1.37 there.
        assert!(order > 1.3 && order < 2.3, "{case}: order {order}");
        // The semi-implicit rule with both sides in one loop, at h and h/2: its error halves.
        let distance = |refinement: usize| {
            let every = refinement * reference_every(&spec);
            let steps = (reference.trajectory.len() - 1) * every;
            let trajectory = march(case, &[], spec.duration / steps as f64, steps, every);
            let [own, theirs] = [&trajectory, &reference.trajectory].map(|run| run.column(column).collect::<Vec<_>>());
            rms_difference(&own, &theirs)
        };
        let (coarse, fine) = (distance(2), distance(4));
        let ratio = coarse / fine;
        assert!((1.7..2.3).contains(&ratio), "{case}: {coarse:e} and {fine:e}");
    }
}

fn reference_every(spec: &RunSpec) -> usize {
    let defaults = spec.case.defaults;
    (defaults.reference_sampling_s / defaults.reference_step_s).round() as usize
}

/// State of a mechanics alone after `duration` under a constant force, in so many steps.
fn alone(case: &str, rule: SecondOrder, force: f64, duration: f64, steps: u32) -> Vec<f64> {
    let mut system = usual_system(case_by_name(case));
    let mechanics = &mut system.sides.mechanics;
    mechanics.capabilities().use_second_order(rule).unwrap();
    let outputs = mechanics.ports().outputs.len();
    let h = duration / f64::from(steps);
    let forces = vec![force; outputs / 2];
    for step in 0..steps {
        mechanics.step(f64::from(step) * h, &forces, h).unwrap();
    }
    let mut y = vec![0.0; outputs];
    mechanics.outputs(&forces, &mut y).unwrap();
    y
}

#[test]
fn forces_that_depend_on_the_velocity_keep_order_two() {
    // Coriolis terms of the crane with its dense mass matrix, and modal damping of the beam, both before any contact
    // closes.
    for (case, force, duration, steps) in [("hydraulic-crane", 2.0e4, 0.4, 200), ("beam-on-stops", 1.0, 0.02, 1000)] {
        for rule in [SecondOrder::Midpoint, SecondOrder::EventSplit] {
            let at = |steps| alone(case, rule, force, duration, steps);
            let (coarse, middle, fine) = (at(steps), at(2 * steps), at(4 * steps));
            for row in 0..coarse.len() {
                let ratio = (coarse[row] - middle[row]) / (middle[row] - fine[row]);
                assert!((3.5..4.5).contains(&ratio), "{case}, {rule:?}, output {row}: ratio {ratio}");
            }
        }
    }
}

#[test]
fn the_beam_goes_on_beyond_the_limit_of_its_highest_mode_and_is_only_as_wrong_as_both_sides_in_one_loop() {
    let reference = coarse_reference(&usual_spec("beam-on-stops", "zero-order-hold", 1e-3));
    // 2/ω₄ is 5.5 ms.
    for macro_step in [7e-3, 10e-3, 20e-3] {
        let error = |scheme: &str, micro_step: f64, phase: f64| {
            let spec = second_order("beam-on-stops", scheme, macro_step)
                .changed(|own| (own.micro_step, own.phase) = (micro_step, phase));
            let run = run(&spec);
            assert_eq!(run.report.outcome, Outcome::Completed, "{scheme}, H = {macro_step}, phase {phase}");
            assert_eq!(run.report.work.sides.mechanics.split_fallbacks, 0, "{scheme}, H = {macro_step}, phase {phase}");
            metric(&spec, run, &reference, "position_error_rms_m")
        };
        // Both sides together take steps of H with the force that belongs to each: what they have is the mechanics' own
        // error.
        let together = error("monolithic", macro_step, 1.0);
        for phase in [0.25, 0.5, 0.75, 1.0] {
            let coupled = error("rim-nonsmooth-gap", 5e-5, phase);
            assert!(
                coupled < 1.25 * together,
                "H = {macro_step}, phase {phase}: {coupled:e} m, together {together:e} m"
            );
        }
    }
}

#[test]
fn a_ball_bounces_to_its_rest_through_an_infinity_of_impacts() {
    // e = 0.8 from 1 m: nothing left after t = √(2h/g) (1 + e)/(1 − e); a Zeno sequence must end in rest, not in a
    // loop.
    let spec = second_order("bouncing-ball", "rim-nonsmooth-gap", 5e-3);
    let reference = Reference::compute(&spec, StopFlag::never()).unwrap();
    let run = run(&spec);
    assert_eq!(run.report.outcome, Outcome::Completed);
    assert_eq!(run.report.work.sides.mechanics.split_fallbacks, 0);
    let error = metric(&spec, run, &reference, "position_error_rms_m");
    assert!(error < 5e-5, "{error} m");
}

fn assert_books_close(spec: &RunSpec, name: &str) {
    let run = completed(spec);
    let residual = run.report.energy_identity_residual_j.unwrap();
    // Energies of up to 1e4 J in steps, rounded some ten times each.
    assert!(residual < 1e-10, "{name}: identity {residual} J");
    let closure = run.report.audit.closure().unwrap();
    assert!(closure.abs() < 1e-6, "{name}: closure {closure} J");
}

#[test]
fn the_books_close_to_round_off_whatever_the_integrators() {
    for case in ["wedge-box", "crane-set-down", "half-car", "gripper", "rocking-block", "wedge-box-two-ledges"] {
        let usual = usual_spec(case, "rim-nonsmooth-gap", case_by_name(case).defaults.macro_step_s);
        for (_, mechanics_integrator) in MechanicsIntegrator::ALL {
            for (_, actuator_integrator) in ActuatorIntegrator::ALL {
                let spec = usual.changed(|own| {
                    (own.mechanics_integrator, own.actuator_integrator) = (mechanics_integrator, actuator_integrator)
                });
                assert_books_close(&spec, &format!("{case}, {mechanics_integrator}, {actuator_integrator}"));
            }
        }
    }
    // And where every piece has its own force.
    for case in ["wedge-box", "half-car", "gripper", "rocking-block"] {
        assert_books_close(&in_pieces(case, case_by_name(case).defaults.macro_step_s), case);
    }
}

/// The same with the force returned to the pieces of the mechanics' steps.
fn in_pieces(case: &str, macro_step: f64) -> RunSpec {
    second_order(case, "rim-nonsmooth-gap", macro_step).changed(|own| own.force_return = ForceReturn::Pieces)
}

#[test]
fn a_force_that_jumps_at_a_rebound_leaves_order_two_where_every_piece_has_its_own() {
    let reference = coarse_reference(&usual_spec("slider-between-stops", "zero-order-hold", 1e-3));
    let points = |force_return: ForceReturn| -> Vec<(f64, f64)> {
        let of = |macro_step: f64| {
            let errors = (1..=4).map(|phase| {
                let phase = f64::from(phase) / 4.0;
                let of_force =
                    in_pieces("slider-between-stops", macro_step).changed(|own| own.force_return = force_return);
                let spec = of_force.changed(|own| (own.micro_step, own.phase) = (12.5e-6, phase));
                let run = run(&spec);
                let work = run.report.work;
                let solves = work.sides.mechanics.micro_steps as f64 / work.cosim.macro_steps as f64;
                assert!(macro_step > 5e-3 || solves < 1.5, "{force_return}, H = {macro_step}: {solves} solves");
                metric(&spec, run, &reference, "position_error_rms_m")
            });
            (macro_step, Pool::of(errors).median().unwrap())
        };
        [3e-3, 5e-3, 10e-3, 20e-3].map(of).to_vec()
    };
    let (mean, pieces) = (points(ForceReturn::Mean), points(ForceReturn::Pieces));
    let [of_mean, of_pieces] = [&mean, &pieces].map(|points| order_of_convergence(points).unwrap());
    // The misplaced impulse is of order H; in its place stands what the micro step leaves, and H².
    assert!(of_mean < 1.3, "slope {of_mean} through {mean:?}");
    assert!(of_pieces > 1.8, "slope {of_pieces} through {pieces:?}");
    assert!(pieces.iter().zip(&mean).all(|(pieces, mean)| pieces.1 < 0.15 * mean.1), "{pieces:?}, {mean:?}");
}

#[test]
fn without_events_one_step_in_pieces_is_as_many_steps_as_the_profile_has_where_the_matrices_are_constant() {
    // Until the first disc is met, after 0.17 s.
    let run_of = |spec: RunSpec| run(&spec.changed(|own| (own.duration, own.phase) = (0.15, 0.6)));
    let pieces = in_pieces("disc-row", 5e-3);
    let profile = pieces
        .changed(|own| (own.force_return, own.mechanics_steps) = (ForceReturn::Profile, MechanicsSteps::AsActuator));
    let mean = pieces.changed(|own| own.force_return = ForceReturn::Mean);
    let [pieces, profile, mean] = [pieces, profile, mean].map(run_of);
    let distance = |run: &RunResult| apart(&run.trajectory, &profile.trajectory, "actuator_length_m").0;
    // Positions of 1.5 m after 3000 steps of the one and 30 of the other, each rounded a few times.
    assert!(distance(&pieces) < 3000.0 * 1.5 * f64::EPSILON, "{:e} m", distance(&pieces));
    assert!(distance(&mean) > 1e-6, "{:e} m", distance(&mean));
}

#[test]
fn linearly_implicit_steps_close_their_books_on_the_beam_and_on_the_elastic_bar() {
    // Beyond 5.5 ms and 9.6 µs no explicit rule goes.
    for (case, macro_step) in
        [("beam-on-stops", 7e-3), ("beam-on-stops", 20e-3), ("elastic-bar", 10e-6), ("elastic-bar", 50e-6)]
    {
        for mechanics_integrator in [MechanicsIntegrator::Midpoint, EVENT_SPLIT] {
            let spec = second_order(case, "rim-nonsmooth-gap", macro_step)
                .changed(|own| own.mechanics_integrator = mechanics_integrator);
            let residual = completed(&spec).report.energy_identity_residual_j.unwrap();
            // Energies of up to 10 J, rounded some ten times in each step.
            assert!(residual < 1e-12, "{case} at {macro_step} s, {mechanics_integrator}: identity {residual} J");
        }
    }
}

#[test]
fn what_cannot_step_at_second_order_says_why() {
    let skipped = |request: RunRequest| {
        let spec = request.resolve(catalogue()).unwrap();
        match run(&spec).report.outcome {
            Outcome::Skipped { reason } => reason,
            other => panic!("{other:?}"),
        }
    };
    let event_split =
        |case: &str| RunRequest { mechanics_integrator: Some(EVENT_SPLIT), ..RunRequest::of(case, "zero-order-hold") };
    let whole = RunRequest { force_return: Some(ForceReturn::Pieces), ..RunRequest::of("wedge-box", "rim-smooth") };
    let message = whole.resolve(catalogue()).unwrap_err().to_string();
    assert!(message.contains("`pieces`") && message.contains("`event-split`"), "{message}");
    let compliant =
        RunRequest { set: vec![("contact_compliance_m_n".into(), "1e-6".into())], ..event_split("wedge-box") };
    assert!(skipped(compliant).contains("contacts that give way"), "compliant contacts");
    assert!(skipped(event_split("linear-oscillator")).contains("one integrator"), "two masses");
    let midpoint = RunRequest {
        actuator_integrator: Some(ActuatorIntegrator::Midpoint),
        ..RunRequest::of("precice-oscillator", "zero-order-hold")
    };
    assert!(skipped(midpoint).starts_with("actuator_integrator = midpoint"), "two masses");
}

#[test]
fn switches_say_how_far_the_disc_is_from_the_borders_of_its_corner() {
    let model = WedgeBox::new(wedge_box_geometry()).unwrap();
    let mut switches = vec![[0.0; 2]; model.size().switches];
    let (q, v) = model.initial_state();
    model.switch_values(&q, &v, &mut switches);
    // The disc starts on the ledge, 0.1 m behind the corner, at rest.
    assert_eq!(switches.len(), 2);
    approx::assert_relative_eq!(switches[0][0], -0.1, epsilon = 1e-12);
    assert_eq!([switches[0][1], switches[1][1]], [0.0; 2]);
}

/// A case with constant matrices, and a parameter with a small change of it: how rounding grows along the run.
///
/// Not the cradle: its balls touch at gaps of rounding, by which it is decided whether a pair collides (5e-10 m there).
const CONSTANT: [(&str, &str, f64); 5] = [
    ("bouncing-ball", "ball_mass_kg", 1e-10),
    ("impact-oscillator", "mass_kg", 1e-10),
    ("slider-between-stops", "mass_kg", 1e-10),
    ("gripper", "jaw_mass_kg", 1e-10),
    ("disc-row", "disc_mass_kg", 1e-10),
];

#[test]
fn with_constant_matrices_and_the_profile_returned_the_co_simulation_is_the_monolithic_stepper_for_every_macro_step() {
    for (case, parameter, change) in CONSTANT {
        let micro_step = case_by_name(case).defaults.micro_step_s;
        for factor in [4.0, 20.0, 100.0] {
            let spec = |scheme: &str, value: f64| {
                let mut request = RunRequest {
                    macro_step_s: Some(factor * micro_step),
                    micro_step_s: Some(micro_step),
                    phase: Some(0.6),
                    ..RunRequest::of(case, scheme)
                };
                if scheme == "rim-nonsmooth-gap" {
                    request.put("force_return", "profile").unwrap();
                    request.put("mechanics_steps", "all").unwrap();
                }
                if value != 1.0 {
                    let usual = case_by_name(case).default_parameters().setting::<f64>(parameter).unwrap();
                    request.set.push((parameter.into(), format!("{:?}", usual * value)));
                }
                request.resolve(catalogue()).unwrap()
            };
            let coupled = spec("rim-nonsmooth-gap", 1.0);
            assert!(coupled.model_is_exact(), "{case}");
            let [coupled, together, changed] =
                [coupled, spec("monolithic", 1.0), spec("monolithic", 1.0 + change)].map(|spec| run(&spec));
            let position = &case_by_name(case).interface_columns[0].position;
            let distance = |other: &RunResult| apart(&together.trajectory, &other.trajectory, position).0;
            // What a relative change of 1 becomes, times the rounding of the thousand operations of a step.
            let bound = 1e3 * f64::EPSILON * (distance(&changed) / change + 1.0);
            let found = distance(&coupled);
            assert!(found <= bound, "{case}, H = {factor} micro steps: {found:e} m, at most {bound:e}");
        }
    }
}
