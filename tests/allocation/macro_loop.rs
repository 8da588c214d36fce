//! The hot path allocates nothing, whatever the scheme.

use crate::asked;
use crate::support::*;
use rimbench::cases::Recorder;
use rimbench::complementarity::{ComplementaritySolver, SolverEntry};
use rimbench::cosim::Trajectory;
use rimbench::cosim::{CommunicationGrid, CommunicationPoint, ForceReturn, Outcome, Sequence, Setup, Side, cosimulate};
use rimbench::interface_model::Redundancy;
use rimbench::schemes::{ContactChoice, Family, ModelMotion, Need, SchemeEntry, SchemeOptions};

struct Variant {
    scheme: &'static SchemeEntry,
    options: SchemeOptions,
    sequence: Sequence,
    force_return: ForceReturn,
    mechanics_steps: usize,
    macro_step: f64,
}

/// Allocations between the communication points, the recording of a full row included; and how the run ended.
fn allocations(variant: &Variant) -> (Vec<u64>, Outcome) {
    let case = wedge_box_case();
    let mut system = (case.build)(&case.default_parameters(), variant.options.solver).unwrap();
    let mut scheme = (variant.scheme.build)(system.mechanics.ports(), system.actuator.ports(), &variant.options);
    let grid = CommunicationGrid::new(variant.macro_step, 0.6, case.defaults.duration_s).unwrap();
    let points = grid.macro_steps() + 1;
    let mut recorder = Recorder::new(case, &mut system);
    let mut trajectory = Trajectory::with_capacity(case.recorded_columns(), points);
    let mut counts = Vec::with_capacity(points);
    let setup = Setup {
        mechanics_steps: variant.mechanics_steps,
        ..setup(grid, case.defaults.micro_step_s, variant.sequence, variant.force_return)
    };
    let mut observe = |point: CommunicationPoint<'_>| {
        recorder.record(point, &mut trajectory);
        counts.push(asked());
    };
    let report = cosimulate(&setup, &mut *system.mechanics, &mut *system.actuator, &mut *scheme, &mut observe);
    // Once more after the loop: a failure that ends it must not allocate either.
    counts.push(asked());
    (counts.windows(2).map(|pair| pair[1] - pair[0]).collect(), report.outcome)
}

fn variants(solver: &'static SolverEntry) -> Vec<Variant> {
    let mut variants = Vec::new();
    // What takes steps on copies must allocate them, and says that it is not real-time.
    for scheme in schemes().into_iter().filter(|scheme| !scheme.needs.contains(&Need::Copies)) {
        let (own, own_return) = scheme.sequence_and_return(None, None).unwrap();
        let mut ways = vec![
            (own, own_return, 1),
            (Sequence::Jacobi, ForceReturn::Held, 1),
            (Sequence::GaussSeidel { first: Side::Actuator }, ForceReturn::End, 3),
            (Sequence::GaussSeidel { first: Side::Actuator }, ForceReturn::Profile, 0),
        ];
        if scheme.family == Family::Signal {
            ways.push((Sequence::GaussSeidel { first: Side::Mechanics }, ForceReturn::Held, 1));
        }
        // The solver is the same object in all of them: the others need to be seen once per scheme.
        if solver.name != solvers()[0].name {
            ways.truncate(1);
        }
        let models: &[(ModelMotion, Redundancy)] = match scheme.family {
            Family::Signal | Family::Ceiling => &[(ModelMotion::Frozen, Redundancy::Drop)],
            Family::Model => &[
                (ModelMotion::Frozen, Redundancy::Drop),
                (ModelMotion::Extrapolated, Redundancy::PseudoInverse),
                (ModelMotion::Extrapolated, Redundancy::Regularised { epsilon: 1e-9 }),
            ],
        };
        ways.retain(|way| scheme.check_force_return(way.1).is_ok());
        for &(sequence, force_return, mechanics_steps) in &ways {
            for &(motion, redundancy) in models {
                // Holds survive the start only with the smaller one.
                let macro_steps: &[f64] = if scheme.family != Family::Model { &[1e-3, 5e-3] } else { &[5e-3] };
                for &macro_step in macro_steps {
                    let choices: &[ContactChoice] = match (scheme.family, motion) {
                        (Family::Model, ModelMotion::Frozen) => {
                            &[ContactChoice::All, ContactChoice::Coupled { tolerance: 1e-3 }]
                        }
                        _ => &[ContactChoice::All],
                    };
                    for &contacts in choices {
                        let options = SchemeOptions { redundancy, motion, contacts, solver, gain: None };
                        variants.push(Variant { scheme, options, sequence, force_return, mechanics_steps, macro_step });
                    }
                }
            }
        }
    }
    variants
}

#[test]
fn the_macro_loop_must_allocate_nothing_once_the_first_macro_step_has_begun() {
    let (mut runs, mut completed) = (0, 0);
    for solver in solvers().into_iter().filter(|solver| (solver.build)(4).capacity() >= 4) {
        for variant in variants(solver) {
            let (counts, outcome) = allocations(&variant);
            let name = format!(
                "{} with {}, {} {} n_m={} H={} {:?} {:?} ({outcome})",
                variant.scheme.name,
                solver.name,
                variant.sequence,
                variant.force_return,
                variant.mechanics_steps,
                variant.macro_step,
                variant.options.motion,
                variant.options.redundancy
            );
            assert!(counts.len() > 20, "{name}: only {} macro steps", counts.len());
            let guilty = counts.iter().position(|count| *count > 0);
            assert_eq!(guilty, None, "{name}: allocates in macro step {guilty:?}");
            runs += 1;
            completed += usize::from(outcome == Outcome::Completed);
        }
    }
    println!("{runs} runs, {completed} completed");
    // Runs that end early are in on purpose, but most must see the touch-down.
    assert!(2 * completed > runs, "only {completed} of {runs} runs came to the end");
}

#[test]
fn the_count_must_see_a_solver_that_allocates() {
    let clarabel = solvers().into_iter().find(|solver| solver.name == "clarabel").unwrap();
    assert_eq!((clarabel.build)(4).capacity(), 0, "clarabel says of itself that it allocates");
    let scheme = schemes().into_iter().find(|scheme| scheme.name == "rim-nonsmooth").unwrap();
    let (sequence, force_return) = scheme.sequence_and_return(None, None).unwrap();
    let options = SchemeOptions { solver: clarabel, ..options() };
    let variant = Variant { scheme, options, sequence, force_return, mechanics_steps: 1, macro_step: 2e-2 };
    let (counts, _) = allocations(&variant);
    assert!(counts[5] > 0, "a solver that allocates goes unseen");
}
