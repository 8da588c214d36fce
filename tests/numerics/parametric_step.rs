//! Micro steps that go on with an active set, against micro steps that solve a contact problem each.
//!
//! The same solver behind a trait object is none that schemes know to go by active sets: with it every problem is
//! solved.

use crate::support::*;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rimbench::complementarity::SolverCounters;

/// Options with which micro steps go on, and with which each is solved: with friction, which no other solver knows, by
/// a model that could move. It has been received once, and so does not.
fn options_of_both(friction: bool) -> [ModelOptions; 2] {
    let usual = ModelOptions::default;
    let every = if friction {
        ModelOptions { model_motion: ModelMotion::Extrapolated, ..usual() }
    } else {
        ModelOptions { solver: opaque_active_set(), ..usual() }
    };
    [usual(), every]
}

fn scheme(
    name: &str,
    empty: &ReducedInterfaceModel,
    detection: Option<ContactDetection>,
    options: ModelOptions,
) -> Box<dyn CouplingScheme> {
    let (mechanics, actuator) = force_displacement_ports(empty.interface());
    let model = Some(ModelConstruction { empty, options: &options, detection });
    let ports = PerSide { mechanics: &mechanics, actuator: &actuator };
    (scheme_by_name(name).build)(&Construction { ports, model, gain: 1.0 }).unwrap()
}

/// Contacts on `bodies` coordinates, more of them than coordinates where `n > bodies`: then some depend on others. Gaps
/// are open, closed and penetrated, and one direction opens them all, so that no problem is without a solution.
fn random_model(rng: &mut impl Rng, n: usize, n_i: usize, bodies: usize, friction: &[f64]) -> ReducedInterfaceModel {
    let mut model = match friction {
        [] => ReducedInterfaceModel::zeros(n, n_i),
        friction => ReducedInterfaceModel::zeros_with_friction(friction, n_i),
    };
    let all = model.a.len();
    let mut rows: Vec<Vec<f64>> =
        (0..all).map(|_| (0..bodies).map(|_| rng.random_range(-1.0..1.0)).collect()).collect();
    rows[..n].iter_mut().for_each(|row| row[0] = rng.random_range(0.3..1.0));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    for (i, row) in rows.iter().enumerate() {
        for (j, other) in rows.iter().enumerate() {
            model.h[i * all + j] = product(row, other);
        }
    }
    // Free accelerations and velocities of the bodies, so that contacts that depend on each other move alike.
    let pull: Vec<f64> = (0..bodies).map(|_| rng.random_range(-10.0..10.0)).collect();
    let velocity: Vec<f64> = (0..bodies).map(|_| rng.random_range(-0.1..0.1)).collect();
    for (i, row) in rows.iter().enumerate() {
        (model.a[i], model.w[i]) = (product(row, &pull), product(row, &velocity));
    }
    for gap in &mut model.gap {
        *gap = [0.0, rng.random_range(0.0..2e-3), -rng.random_range(0.0..1e-4)][rng.random_range(0..3)];
    }
    (model.mechanics_step, model.stabilisation) = (H, 0.2);
    model
}

const GAP: &str = "rim-nonsmooth-gap";
const H: f64 = 5e-3;
const MICRO_STEPS: usize = 60;

/// Largest difference of the interface velocities (m/s) within a macro step, both from the same state, and the work of
/// both.
fn compare(
    (name, act): (&str, ContactsAct),
    detection: Option<ContactDetection>,
    model: &ReducedInterfaceModel,
    force: impl Fn(usize) -> Vec<f64>,
) -> Option<(f64, [SolverCounters; 2])> {
    let step = CommunicationGrid::new(H, 1.0, 1.0).unwrap().step(0);
    let n_i = model.interface();
    let both = options_of_both(model.has_friction()).map(|options| {
        let mut scheme = scheme(name, model, detection, ModelOptions { contacts_act: act, ..options });
        let y = vec![0.0; 2 * n_i];
        let actuator_micro_step = H / MICRO_STEPS as f64;
        let sample = Sample { model: Some(model), ..Sample::of_outputs(step, &y, actuator_micro_step) };
        scheme.receive(Side::Mechanics, &sample).unwrap();
        scheme.receive(Side::Actuator, &Sample { y: &force(0), model: None, ..sample }).unwrap();
        let mut inputs = Vec::new();
        for j in 0..MICRO_STEPS {
            let mut u = y.clone();
            scheme.input(Side::Actuator, MicroStep::new(step, j, MICRO_STEPS), &force(j), &mut u).ok()?;
            inputs.extend(u.split_off(n_i));
        }
        Some((inputs, scheme.report().counters))
    });
    let [Some((found, with_sets)), Some((solved, every))] = both else {
        assert!(both.iter().all(Option::is_none), "a problem without a solution is one either way");
        return None;
    };
    Some((largest(found.iter().zip(&solved).map(|(a, b)| (a - b).abs())), [with_sets, every]))
}

/// Both ways over 200 models of up to `most` contacts, and how often contacts and states change.
fn answers_alike(
    rng: &mut Pcg64,
    name: &str,
    detection: Option<ContactDetection>,
    most: usize,
    friction: bool,
    e: f64,
) {
    let (mut parametric, mut solved, mut lost, mut worst) = (0, 0, 0, 0.0_f64);
    for turn in 0..200 {
        let (n, n_i) = (1 + turn % most, 1 + turn % 2);
        let bodies = match (turn % 3 == 0, friction) {
            (true, false) => n + n_i + 1,
            (true, true) => 2 * n + n_i + 1,
            (false, false) => 2 + n / 2,
            (false, true) => 2 + n,
        };
        let coefficients: Vec<f64> = (0..if friction { n } else { 0 }).map(|_| rng.random_range(0.0..0.6)).collect();
        let mut model = random_model(rng, n, n_i, bodies, &coefficients);
        model.restitution = e;
        model.tangential_restitution = if friction { e } else { model.tangential_restitution };
        let (phase, pitch) = (rng.random_range(0.0..6.0), rng.random_range(0.0..0.3));
        // Forces of the size of the pull, and changing: contacts open and close.
        let force = |j: usize| (0..n_i).map(|i| 8.0 * (phase + i as f64 + pitch * j as f64).sin()).collect::<Vec<_>>();
        let Some((off, [with_sets, every])) = compare((name, ContactsAct::MicroStep), detection, &model, force) else {
            lost += 1;
            continue;
        };
        assert_eq!(with_sets.solves + with_sets.parametric, every.solves, "each micro step is answered");
        // One problem in each micro step; where contacts are hit others say which rebound, and where they are then.
        let more = every.solves - MICRO_STEPS as u64;
        assert!((e > 0.0 || more == 0) && every.parametric == 0, "{more} more");
        parametric += with_sets.parametric;
        solved += with_sets.solves;
        worst = worst.max(off);
    }
    // Velocities of 0.1 m/s, rounded to 1e-17 in each of 60 micro steps, times the condition of a random matrix; a
    // sliding contact may have a condition of its own, and a model with friction a problem without a solution.
    let (bound, may_be_lost) = if friction { (1e-11, 20) } else { (1e-12, 1) };
    assert!(worst < bound, "{name} {detection:?} e {e}: off by {worst:e} m/s");
    assert!(parametric > 3 * solved, "{name}: {parametric} parametric micro steps of {solved}");
    assert!(solved > 200 + 100, "{name}: sets and states change, too: {solved} problems");
    assert!(lost < may_be_lost, "{name}: {lost} models with a problem without a solution");
}

#[test]
fn a_micro_step_that_goes_on_with_its_set_answers_as_one_that_solves() {
    let mut rng = Pcg64::seed_from_u64(20);
    let schemes = [
        ("rim-nonsmooth-gap", None),
        ("rim-nonsmooth", Some(ContactDetection::MechanicsLaw)),
        ("rim-nonsmooth", Some(ContactDetection::Margin { width: 1e-3 })),
    ];
    for (name, detection) in schemes {
        for restitution in [0.0, 0.6] {
            answers_alike(&mut rng, name, detection, 11, false, restitution);
        }
    }
}

/// Over the mechanics' own step, contacts and their impacts included.
#[test]
fn an_answer_by_the_region_of_the_forces_is_that_of_the_contact_problem() {
    let mut rng = Pcg64::seed_from_u64(22);
    let (mut by_region, mut solved) = (0, 0);
    for turn in 0..600 {
        let (n, n_i) = (1 + turn % 7, 1 + turn / 7 % 2);
        let mut model = random_model(&mut rng, n, n_i, n + n_i + 1, &[]);
        model.restitution = [0.0, 0.6][turn % 2];
        let (phase, pitch) = (rng.random_range(0.0..6.0), rng.random_range(0.0..0.3));
        let force = |j: usize| (0..n_i).map(|i| 8.0 * (phase + i as f64 + pitch * j as f64).sin()).collect::<Vec<_>>();
        let (off, [counters, _]) = compare((GAP, ContactsAct::MechanicsStep), None, &model, force).unwrap();
        // As above.
        assert!(off < 1e-12, "{turn}: off by {off:e} m/s");
        // Where contacts are hit, every micro step is solved.
        if model.restitution == 0.0 {
            by_region += counters.parametric;
            solved += counters.solves;
        }
    }
    assert!(by_region > 3 * solved && solved > 300 + 100, "{by_region} by region, {solved} solved");
}

#[test]
fn with_friction_a_micro_step_that_goes_on_with_its_states_answers_as_one_that_solves() {
    let mut rng = Pcg64::seed_from_u64(21);
    for (name, detection) in [("rim-nonsmooth-gap", None), ("rim-nonsmooth", Some(ContactDetection::MechanicsLaw))] {
        for restitution in [0.0, 0.6] {
            answers_alike(&mut rng, name, detection, 5, true, restitution);
        }
    }
}

/// Cases whose motion does not amplify round-off, over whole runs with penetrations, impacts and rebounds.
#[test]
fn whole_runs_are_the_same_to_round_off() {
    let runs = [
        ("wedge-box", "rim-nonsmooth-gap", 5e-3),
        ("wedge-box", "rim-nonsmooth", 5e-3),
        ("gripper", "rim-nonsmooth-gap", 5e-3),
        ("disc-row", "rim-nonsmooth-gap", 5e-3),
        ("slider-between-stops", "rim-nonsmooth-gap", 5e-3),
    ];
    for (case, name, macro_step) in runs {
        let spec = usual_spec(case, name, macro_step);
        let (with_sets, solved) = (run(&spec), run(&with_opaque_solver(&spec)));
        let [counters, of_solved] = [&with_sets, &solved].map(|result| result.report.work.scheme);
        assert_eq!((counters.solves + counters.parametric, of_solved.parametric), (of_solved.solves, 0), "{case}");
        assert!(counters.parametric > 3 * counters.solves, "{case} {name}: {counters:?}");
        let names = with_sets.trajectory.columns().iter().filter(|name| {
            // Which of several redundant contacts carries is the solver's choice, and a gap is a small difference of
            // positions.
            let of_contact = name.starts_with("contact_force") || name.starts_with("gap");
            (name.ends_with("_n") || name.ends_with("_m")) && !of_contact
        });
        for name in names {
            let (off, size) = apart(&solved.trajectory, &with_sets.trajectory, name);
            // Thousands of roundings of 1e-16, in oil that answers a micrometre with newtons.
            assert!(off < 1e-10 * size, "{case}: {name} off by {off:e}");
        }
    }
}
