//! The hot path allocates nothing, whatever the scheme.

use crate::asked;
use crate::support::*;
use rimbench::complementarity::ComplementaritySolver;
use rimbench::solver_entry::SolverEntry;
use std::sync::Arc;

#[derive(Clone)]
struct Variant {
    scheme: &'static SchemeEntry,
    options: ModelOptions,
    sequence: Sequence,
    force_return: ForceReturn,
    mechanics_steps: MechanicsSteps,
    macro_step: f64,
    integrators: (MechanicsIntegrator, ActuatorIntegrator),
    step_rule: Option<StepRule>,
    delivery: Option<Delivery>,
    star: Option<StarPlan>,
}

/// Several in each macro step, and no more than it takes to run to the end, s.
const MICRO_STEP: f64 = 2.5e-4;

/// Both sides as they always stepped.
const FIRST_ORDER: (MechanicsIntegrator, ActuatorIntegrator) =
    (MechanicsIntegrator::SemiImplicit, ActuatorIntegrator::Euler);

/// Allocations between the communication points, the recording of a full row included; and how the run ended.
fn allocations(case: &Case, variant: &Variant) -> (Vec<u64>, Outcome) {
    let mut system = (case.build)(&case.default_parameters(), &variant.options.solver).unwrap();
    // Past the touch-down; machines on feet slide from the start.
    let end = if ["tripod", "four-legs"].contains(&&*case.name) { 0.5 } else { 1.8 };
    let grid = CommunicationGrid::new(variant.macro_step, 0.6, end).unwrap();
    let mut recorder = Recorder::new(case, &mut system).unwrap();
    let (mechanics_rule, actuator_integrator) = variant.integrators;
    if let Some(rule) = mechanics_rule.second_order() {
        system.sides.mechanics.capabilities().use_second_order(rule).unwrap();
    }
    if actuator_integrator == ActuatorIntegrator::Midpoint {
        system.sides.actuator.capabilities().use_second_order(SecondOrder::Midpoint).unwrap();
    }
    let mut sides = system.sides.lend();
    let couple = |sides: Sides<'_>| variant.scheme.couple(sides, Some(&variant.options), None);
    let exchange = Exchange {
        delivery: variant.delivery.clone(),
        mechanics_steps: variant.mechanics_steps,
        actuator_integrator,
        ..Exchange::new(MICRO_STEP, variant.sequence, variant.force_return)
    };
    // The receiver learns the mass wherever it may.
    let averaged = matches!(variant.force_return, ForceReturn::Mean | ForceReturn::Profile);
    let learns = averaged
        && variant.scheme.moves_model
        && variant.options.model_motion == ModelMotion::Frozen
        && variant.delivery.as_ref().is_none_or(|own| own.late.catches_up() && own.down.is_in_time());
    let exchange = Exchange { mass_learning: learns.then(MassLearning::default), ..exchange };
    let setup = Setup { grid, step_rule: variant.step_rule, exchange, bounds: Bounds::default() };
    let points = setup.expected_macro_steps() + 1;
    let mut trajectory = Trajectory::with_capacity(case.recorded_columns(), points);
    let mut counts = Vec::with_capacity(points + 1);
    let mut observe = |point: CommunicationPoint<'_>| {
        recorder.record(point, &mut trajectory);
        counts.push(asked());
    };
    // The account of a model is kept as well: without it there is less to do.
    // That of late samples follows a copy of the scheme, which makes room for itself as it goes.
    let control = RunControl { audit: variant.delivery.is_none(), ..RunControl::default() };
    let report = match &variant.star {
        Some(plan) => {
            let parts = |_, sides: Sides<'_>| couple(sides).map(|built| (built.scheme, built.exchange));
            let star = Star::new(&setup, plan, sides.lend(), parts).unwrap();
            star.run(&setup, sides, RunControl { inside: Some(usize::MAX), ..control }, &mut observe)
        }
        None => couple(sides.lend()).unwrap().run(&setup, sides, control, &mut observe),
    };
    // Once more after the loop. A failure that ends it is one block, and nothing else may be allocated with it.
    counts.push(asked());
    let mut counts: Vec<u64> = counts.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let failed = !matches!(report.outcome, Outcome::Completed | Outcome::Diverged { .. });
    if let Some(last) = counts.last_mut().filter(|_| failed) {
        *last = last.saturating_sub(1);
    }
    (counts, report.outcome)
}

fn variants(solver: &Arc<SolverEntry>) -> Vec<Variant> {
    let mut variants = Vec::new();
    // What takes steps on copies must allocate them, and says that it is not real-time.
    // Of the schemes that solve no contact problems one shows what the mechanics does with another solver.
    let seen = |scheme: &SchemeEntry| solver.name == DEFAULT || scheme.has_model() || scheme.name == "zero-order-hold";
    let on_copies = |scheme: &SchemeEntry| {
        [Requirement::Copies, Requirement::Trials].iter().any(|need| scheme.needs.contains(need))
    };
    for scheme in schemes().iter().filter(|scheme| !on_copies(scheme) && seen(scheme)) {
        let (own, own_return) = scheme.sequence_and_return(None, None).unwrap();
        let mut ways = vec![
            (own, own_return, ONE),
            (Sequence::Jacobi, ForceReturn::Held, ONE),
            (Sequence::GaussSeidel { first: Side::Actuator }, ForceReturn::End, MechanicsSteps::count(3).unwrap()),
            (Sequence::GaussSeidel { first: Side::Actuator }, ForceReturn::Profile, ALL),
        ];
        let mechanics_first = Sequence::GaussSeidel { first: Side::Mechanics };
        if scheme.check_sequence(mechanics_first).is_ok() {
            ways.push((mechanics_first, ForceReturn::Held, ONE));
        }
        // The solver is the same object in all of them: the others need to be seen once per scheme.
        if solver.name != DEFAULT {
            ways.truncate(1);
        }
        let motions: &[ModelMotion] = match scheme.family {
            Family::Model if scheme.moves_model => &[ModelMotion::Frozen, ModelMotion::Extrapolated],
            _ => &[ModelMotion::Frozen],
        };
        // Nor has another solver a part in how the model moves.
        let motions = if solver.name == DEFAULT { motions } else { &motions[..1] };
        ways.retain(|way| scheme.check_force_return(way.1).is_ok());
        for &(sequence, force_return, mechanics_steps) in &ways {
            for &motion in motions {
                // Holds survive the start only with the smaller one.
                let macro_steps: &[f64] = if scheme.family != Family::Model { &[1e-3, 5e-3] } else { &[5e-3] };
                for &macro_step in macro_steps {
                    for &detection in detections(scheme) {
                        let solver = solver.clone();
                        let options =
                            ModelOptions { model_motion: motion, detection, solver, ..ModelOptions::default() };
                        variants.push(Variant {
                            scheme,
                            options,
                            sequence,
                            force_return,
                            mechanics_steps,
                            macro_step,
                            integrators: FIRST_ORDER,
                            step_rule: None,
                            delivery: None,
                            star: None,
                        });
                    }
                }
            }
        }
    }
    variants
}

/// Every way in which a scheme detects contacts; nothing where it does not.
fn detections(scheme: &SchemeEntry) -> &'static [Option<ContactDetection>] {
    match scheme.contact_detection {
        None => &[None],
        Some(rule) if !rule.has_law => &[Some(ContactDetection::Active), MILLIMETRE],
        Some(_) => &[Some(ContactDetection::Active), Some(ContactDetection::MechanicsLaw), MILLIMETRE],
    }
}

const MILLIMETRE: Option<ContactDetection> = Some(ContactDetection::Margin { width: 1e-3 });

/// The solver that is seen with all variants.
const DEFAULT: &str = "active-set";

/// The same run of a variant with both sides of the second order, and with the force returned to the pieces of the
/// steps.
fn of_second_order(variant: Variant) -> Vec<Variant> {
    let with = |rule, force_return| Variant {
        integrators: (rule, ActuatorIntegrator::Midpoint),
        options: variant.options.clone(),
        force_return,
        delivery: None,
        star: None,
        ..variant
    };
    let own = variant.force_return;
    let mut variants = vec![with(MechanicsIntegrator::Midpoint, own), with(MechanicsIntegrator::EventSplit, own)];
    if ForceReturn::Pieces.check(variant.sequence).is_ok() && own != ForceReturn::Held {
        variants.push(with(MechanicsIntegrator::EventSplit, ForceReturn::Pieces));
    }
    variants
}

/// Runs all variants with some of the solvers; says how many there were, and how many came to the end.
fn nothing_is_allocated(with: impl Fn(&SolverEntry) -> bool, of: impl Fn(&Arc<SolverEntry>) -> Vec<Variant>) {
    nothing_is_allocated_in(wedge_box_case(), with, of);
}

fn nothing_is_allocated_in(
    case: &Case,
    with: impl Fn(&SolverEntry) -> bool,
    of: impl Fn(&Arc<SolverEntry>) -> Vec<Variant>,
) {
    let (mut runs, mut completed) = (0, 0);
    for solver in solvers().iter().filter(|solver| (solver.build)(4).capacity() >= 4 && with(solver)) {
        for variant in of(solver) {
            let (counts, outcome) = allocations(case, &variant);
            let name = format!(
                "{} with {}, {} {} n_m={} H={} {} ({outcome})",
                variant.scheme.name,
                solver.name,
                variant.sequence,
                variant.force_return,
                variant.mechanics_steps,
                variant.macro_step,
                variant.options.model_motion
            );
            assert!(counts.len() > 20, "{name}: only {} macro steps", counts.len());
            let guilty = counts.iter().position(|count| *count > 0);
            assert_eq!(guilty, None, "{name}: allocates in macro step {guilty:?}");
            runs += 1;
            completed += usize::from(outcome == Outcome::Completed);
        }
    }
    // Runs that end early are in on purpose, but most must see the touch-down.
    assert!(2 * completed > runs, "only {completed} of {runs} runs came to the end");
}

/// The same run of a variant with its macro steps placed by the model.
fn placed_by_the_model(variant: Variant) -> Variant {
    Variant {
        step_rule: Some(StepRule { control: StepControl::ModelDefect, tolerance: 1e-3, shortest: 5e-4, order: 2 }),
        ..variant
    }
}

#[test]
fn the_macro_loop_must_allocate_nothing_where_the_model_places_its_steps() {
    nothing_is_allocated(
        |solver| solver.name == DEFAULT,
        |solver| {
            let gap = |variant: &Variant| variant.scheme.name == "rim-nonsmooth-gap";
            variants(solver).into_iter().filter(gap).map(placed_by_the_model).collect()
        },
    );
}

/// The same run of a variant with late and lost samples of the mechanics, in each of the ways of making do with them,
/// and then with late forces bridged in each of the ways; nothing of a variant that has no late samples.
fn late(variant: Variant) -> Vec<Variant> {
    let averaged = matches!(variant.force_return, ForceReturn::Mean | ForceReturn::Profile);
    if variant.scheme.has_model() && (!averaged || variant.options.model_motion != ModelMotion::Frozen) {
        return Vec::new();
    }
    let channel: Channel = "delay:1,jitter:1,loss:0.05,seed:3".parse().unwrap();
    let with = |delivery| Variant { delivery: Some(delivery), ..variant.clone() };
    let up = |late| with(Delivery { up: channel.clone(), late, ..Delivery::default() });
    let down = |bridge| with(Delivery { down: channel.clone(), bridge, ..Delivery::default() });
    let catches_up = !variant.scheme.has_model() || variant.scheme.moves_model;
    let mut variants = vec![up(LateRule::Raw), down(ForceBridge::Hold)];
    if catches_up {
        variants.extend([LateRule::CatchUp, LateRule::CatchUpCoarse].map(up));
    }
    if averaged {
        variants.extend([down(ForceBridge::Linear), down(ForceBridge::Rates)]);
    }
    variants
}

#[test]
fn the_macro_loop_must_allocate_nothing_with_late_samples_and_late_forces() {
    // Late samples end the runs of most schemes soon: of those without a model the holds, and short macro steps.
    let lasts = |scheme: &SchemeEntry| scheme.family == Family::Model || scheme.name.ends_with("-order-hold");
    let of = |solver: &Arc<SolverEntry>| {
        let variants = variants(solver).into_iter().filter(|variant| lasts(variant.scheme));
        let mut variants: Vec<Variant> = variants.map(|variant| Variant { macro_step: 5e-4, ..variant }).collect();
        // What is closed for a model that is late is no other path.
        variants.dedup_by(|next, before| {
            let of = |own: &Variant| (own.scheme.name.clone(), own.force_return, own.options.model_motion);
            of(next) == of(before)
        });
        variants.into_iter().flat_map(late).collect()
    };
    nothing_is_allocated(|solver| solver.name == DEFAULT, of);
}

#[test]
fn the_macro_loop_must_allocate_nothing_once_the_first_macro_step_has_begun() {
    nothing_is_allocated(|solver| solver.name == DEFAULT, variants);
}

#[test]
fn the_macro_loop_must_allocate_nothing_with_friction() {
    // Holds leave the range of the machine in space within a few macro steps of 5 ms.
    for (case, longest_of_holds) in
        [("wedge-box-friction", 5e-3), ("tripod", 1e-3), ("four-legs", 1e-3), ("wedge-box-space", 1e-3)]
    {
        let that_know_it = |solver: &Arc<SolverEntry>| {
            let mut variants = variants(solver);
            variants.retain(|variant| {
                // In space there are other problems for the solver, and no other sequences. Of the schemes without a
                // model one shows what the mechanics does.
                let own = variant.scheme.sequence_and_return(None, None).unwrap();
                let own = (variant.sequence, variant.force_return) == own || variant.mechanics_steps == ALL;
                (case == "wedge-box-friction" || own)
                    && (variant.scheme.has_model() || variant.scheme.name == "zero-order-hold")
                    && (variant.scheme.family == Family::Model || variant.macro_step <= longest_of_holds)
            });
            if case != "wedge-box-friction" {
                let slide = |v: &&Variant| v.scheme.slides && v.options.model_motion == ModelMotion::Frozen;
                let on_one_row: Vec<Variant> = variants.iter().filter(slide).cloned().collect();
                variants.extend(on_one_row.into_iter().map(|mut variant| {
                    variant.options.friction_rows = FrictionRows::SlipDirection;
                    variant
                }));
            }
            variants
        };
        nothing_is_allocated_in(case_by_name(case), |solver| solver.name == DEFAULT, that_know_it);
    }
}

/// Bonds at once, one after the other, with rates of their own, told within a macro step, and with all that they may know.
#[test]
fn the_macro_loop_must_allocate_nothing_with_several_bonds() {
    let of_bonds = |solver: &Arc<SolverEntry>| {
        let with = |own: &Variant, [order, every]: [&str; 2], known: Known, share: Share| {
            let (order, every) = (order.parse().unwrap(), every.parse().unwrap());
            let share = if own.scheme.has_model() { share } else { Share::Whole };
            Variant { star: Some(StarPlan { order, every, known, share, ..StarPlan::default() }), ..own.clone() }
        };
        let mut variants = variants(solver);
        variants.retain(|own| ["rim-nonsmooth-gap", "zero-order-hold"].contains(&&*own.scheme.name));
        // Holds survive with the smaller step only.
        let after = |own: &&Variant| {
            own.scheme.name == "zero-order-hold" && own.force_return == ForceReturn::Held && own.macro_step < 2e-3
        };
        let mut stars: Vec<Variant> =
            variants.iter().filter(after).map(|own| with(own, ["hub;1,2", "1"], Known::Held, Share::Whole)).collect();
        for own in variants.iter().filter(|own| own.scheme.has_model()) {
            stars.push(with(own, ["together", "1/2"], Known::Mean, Share::Rows));
            stars.push(with(own, ["2;1", "1,3"], Known::Law, Share::Equal));
        }
        stars
    };
    for case in ["gripper", "half-car"] {
        nothing_is_allocated_in(case_by_name(case), |solver| solver.name == DEFAULT, of_bonds);
    }
}

/// In parts whose borders no micro step meets, with friction and without, samples late and in time.
#[test]
fn the_macro_loop_must_allocate_nothing_where_contacts_act_over_the_mechanics_step() {
    let over_own_step = |solver: &Arc<SolverEntry>| {
        let mut variants = variants(solver);
        variants.retain(|variant| {
            variant.scheme.acts_over_mechanics_step && variant.options.model_motion == ModelMotion::Frozen
        });
        variants.iter_mut().for_each(|variant| variant.options.contacts_act = ContactsAct::MechanicsStep);
        let parts = variants
            .clone()
            .into_iter()
            .map(|own| Variant { mechanics_steps: MechanicsSteps::count(3).unwrap(), ..own });
        variants.extend(parts.collect::<Vec<_>>());
        variants
    };
    for case in ["wedge-box", "gripper", "wedge-box-friction", "tripod"] {
        nothing_is_allocated_in(case_by_name(case), |solver| solver.name == DEFAULT, over_own_step);
    }
}

#[test]
fn the_macro_loop_must_allocate_nothing_with_both_sides_of_the_second_order() {
    let once_per_scheme = |solver: &Arc<SolverEntry>| {
        let mut variants = variants(solver);
        variants.dedup_by(|next, before| next.scheme.name == before.scheme.name);
        variants.into_iter().flat_map(of_second_order).collect()
    };
    nothing_is_allocated(|solver| solver.name == DEFAULT, once_per_scheme);
}

#[test]
fn the_macro_loop_must_allocate_nothing_with_any_solver_that_states_a_capacity() {
    nothing_is_allocated(|solver| solver.name != DEFAULT, variants);
}

#[test]
fn the_count_must_see_a_solver_that_allocates() {
    let clarabel = solver_by_name("clarabel");
    assert_eq!((clarabel.build)(4).capacity(), 0, "clarabel says of itself that it allocates");
    let scheme = scheme_by_name("rim-nonsmooth");
    let (sequence, force_return) = scheme.sequence_and_return(None, None).unwrap();
    let options = ModelOptions { solver: clarabel.clone(), ..ModelOptions::default() };
    let variant = Variant {
        scheme,
        options,
        sequence,
        force_return,
        mechanics_steps: ONE,
        macro_step: 2e-2,
        integrators: FIRST_ORDER,
        step_rule: None,
        delivery: None,
        star: None,
    };
    let (counts, _) = allocations(wedge_box_case(), &variant);
    assert!(counts[5] > 0, "a solver that allocates goes unseen");
}
