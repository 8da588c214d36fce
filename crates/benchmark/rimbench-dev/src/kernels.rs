//! The kernels of the suite: what every exchange is made of, repeated often enough to be measured.

use super::benchmark::{Repetition, Work};
use rimbench_cases::cases::{Case, CoupledSystem, wedge_box_geometry};
use rimbench_cases::models::WedgeBox;
use rimbench_core::complementarity::SolverCounters;
use rimbench_core::cosim::PerSide;
use rimbench_core::error::{Error, Failure, Result};
use rimbench_core::friction::{FrictionProblem, FrictionSolver};
use rimbench_core::interface_model::{Elimination, ReducedInterfaceModel};
use rimbench_core::mechanics::{ContactLaw, NonSmoothMechanics};
use rimbench_core::solver_entry::SolverEntry;
use rimbench_runs::catalogue::Catalogue;
use std::hint::black_box;
use std::sync::Arc;

/// N.
const FORCE: f64 = 250.0;

fn wedge_box() -> Result<Arc<Case>> {
    Catalogue::standard().case("wedge-box").cloned()
}

fn system() -> Result<CoupledSystem> {
    system_of(&*wedge_box()?)
}

fn system_of(case: &Case) -> Result<CoupledSystem> {
    (case.build)(&case.default_parameters(), &SolverEntry::active_set())
}

/// A benchmark that fails is a defect of this suite or of what it measures.
fn broken(failure: impl Into<Failure>) -> Error {
    Error::Incompatible(format!("a benchmark failed: {}", failure.into()))
}

/// The interface model at the start, for a macro step of 5 ms.
fn start_model(system: &mut CoupledSystem) -> Result<ReducedInterfaceModel> {
    let mechanics = system.sides.mechanics.capabilities();
    let mut model = mechanics.empty_interface_model().unwrap_or_else(|| ReducedInterfaceModel::zeros(0, 0));
    mechanics.interface_model(5e-3, &mut model).map_err(broken)?;
    Ok(model)
}

/// Eq. 3 of the wedge box at its start.
fn start_linearisation() -> Result<NonSmoothMechanics<WedgeBox>> {
    let model = WedgeBox::new(wedge_box_geometry(&wedge_box()?.default_parameters()))?;
    let law = ContactLaw { stabilisation: 0.2, restitution: 0.0, spring: None };
    let ports = system()?.sides.mechanics.ports().clone();
    Ok(NonSmoothMechanics::new(model, law, ports, SolverEntry::active_set().checked(4)))
}

/// Eliminates Eq. 3 → Eq. 4 at the start of the wedge box 5000 times.
pub(super) fn elimination() -> Result<Repetition> {
    const ELIMINATIONS: u32 = 5_000;
    let mechanics = start_linearisation()?;
    let mut elimination = Elimination::new(mechanics.linearisation());
    let mut model = start_model(&mut system()?)?;
    Ok(Box::new(move || {
        let (eq3, v) = (mechanics.linearisation(), mechanics.velocity());
        for _ in 0..ELIMINATIONS {
            elimination.reduce(black_box(eq3), black_box(v), 5e-3, 0.2, &mut model).map_err(broken)?;
            black_box(&model);
        }
        let eliminations = u64::from(ELIMINATIONS);
        let answer = 1.0 / model.entry(model.contacts(), model.contacts());
        Ok(Work { eliminations, answer, ..Work::default() })
    }))
}

/// Takes 2000 steps of 0.1 ms of the wedge box under 250 N.
pub(super) fn mechanics_step() -> Result<Repetition> {
    const STEPS: usize = 2_000;
    const H: f64 = 1e-4;
    let case = wedge_box()?;
    Ok(Box::new(move || {
        let mut mechanics = system_of(&case)?.sides.mechanics;
        for step in 0..STEPS {
            mechanics.step(step as f64 * H, black_box(&[FORCE]), H).map_err(broken)?;
        }
        let mut y = [0.0; 2];
        mechanics.outputs(&[FORCE], &mut y).map_err(broken)?;
        let counters = mechanics.counters();
        Ok(Work {
            mechanics_micro_steps: counters.micro_steps,
            eliminations: counters.eliminations,
            lcp: counters.solver,
            answer: y[1],
            ..Work::default()
        })
    }))
}

/// Takes 20000 micro steps of 0.05 ms of the hydraulics at rest.
pub(super) fn hydraulics_step() -> Result<Repetition> {
    let PerSide { mut mechanics, mut actuator } = system()?.sides;
    let mut y = [0.0; 2];
    mechanics.outputs(&[0.0], &mut y).map_err(broken)?;
    Ok(Box::new(move || {
        let before = actuator.counters().micro_steps;
        for _ in 0..20_000 {
            // With the spool in the middle the start pressures, half way between pump and tank, are an equilibrium.
            actuator.step(0.0, black_box(&y), 5e-5).map_err(broken)?;
        }
        let mut force = [f64::NAN];
        actuator.outputs(&y, &mut force).map_err(broken)?;
        let actuator_micro_steps = actuator.counters().micro_steps - before;
        Ok(Work { actuator_micro_steps, answer: force[0], ..Work::default() })
    }))
}

/// m/s, one per contact of the wedge box.
const VELOCITIES: [f64; 4] = [-0.02, 0.03, -0.01, -0.002];

/// m/s along the surface: the wedges slide one way, one disc sticks, the other slides the other way.
const SLIPS: [f64; 4] = [0.05, 0.04, 0.001, -0.03];

/// Solves 20000 problems of the wedge box with friction of 0.3, each from the states of the last solution and slightly
/// different, with velocities of which two closed contacts, and one more, want an impulse.
pub(super) fn friction_warm() -> Result<Repetition> {
    let case = Catalogue::standard().case("wedge-box-friction").cloned()?;
    let model = start_model(&mut system_of(&case)?)?;
    let n = model.contacts();
    let h: Vec<f64> = (0..4 * n * n).map(|index| model.entry(index / (2 * n), index % (2 * n))).collect();
    let velocities: Vec<f64> = VELOCITIES.into_iter().chain(SLIPS).collect();
    let mut solver = FrictionSolver::new(n, 1e-9);
    let (mut b, mut impulses, mut w) = (vec![0.0; 2 * n], vec![0.0; 2 * n], vec![0.0; 2 * n]);
    Ok(Box::new(move || {
        solver.reset();
        let mut lcp = SolverCounters::default();
        for problem in 0..20_000 {
            let scale = 1.0 + f64::from(problem % 8) / 64.0;
            b.iter_mut().zip(&velocities).for_each(|(b, v)| *b = scale * v);
            let problem = FrictionProblem::with_friction(black_box(&h), &b, &model.friction);
            let stats = solver.solve(problem, &mut impulses).map_err(broken)?;
            problem.velocities(&impulses, &mut w);
            lcp.solves += 1;
            lcp.pivots += u64::from(stats.pivots);
            lcp.factorisations += u64::from(stats.factorisations);
        }
        Ok(Work { lcp, answer: w.iter().sum(), ..Work::default() })
    }))
}
