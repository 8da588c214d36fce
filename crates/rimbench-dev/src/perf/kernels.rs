//! The kernels of the suite: what every exchange is made of, repeated often enough to be measured.

use super::benchmark::{Benchmark, Repetition, Size, WEDGE_BOX, Work};
use rimbench_cases::cases::{Case, CoupledSystem, wedge_box_geometry};
use rimbench_cases::catalogue::Catalogue;
use rimbench_cases::models::WedgeBox;
use rimbench_core::complementarity::{Checked, Lcp, SolveStats, SolverCounters, Unsolved};
use rimbench_core::cosim::PerSide;
use rimbench_core::error::{Error, Failure, Result};
use rimbench_core::friction::{ContactState, CopositiveLemke, FrictionProblem, FrictionSolver};
use rimbench_core::interface_model::{Elimination, ReducedInterfaceModel};
use rimbench_core::mechanics::{ContactLaw, NonSmoothMechanics};
use rimbench_core::solver_entry::SolverEntry;
use std::hint::black_box;
use std::sync::Arc;

/// Eq. 3 → Eq. 4 at the start of the wedge box.
pub const ELIMINATION: Benchmark = Benchmark {
    name: "kernel/elimination",
    about: "eliminate the wedge box 5000 times; answer: effective mass at free contacts, kg",
    answer: [154.0497, 1e-4],
    prepare: elimination,
};

/// Mechanics steps of the wedge box.
pub const MECHANICS_STEP: Benchmark = Benchmark {
    name: "kernel/mechanics-step",
    about: "2000 steps of 0.1 ms of the wedge box under 250 N; answer: velocity, m/s (250 N / 250 kg · 0.2 s)",
    answer: [0.2, 1e-9],
    prepare: mechanics_step,
};

/// Micro steps of the hydraulics.
pub const HYDRAULICS_STEP: Benchmark = Benchmark {
    name: "kernel/hydraulics-step",
    about: "20000 steps of 0.05 ms at rest; answer: force, N (an equilibrium)",
    answer: [0.0, 1e-6],
    prepare: hydraulics_step,
};

/// The four-contact problem with the active set of the last solution.
pub const LCP_WARM: Benchmark = Benchmark {
    name: "kernel/lcp-warm",
    about: "50000 problems of four contacts by active-set, warm; answer: sum of contact velocities, m/s",
    answer: [ANSWER_LCP, 1e-8],
    prepare: || lcp(&SolverEntry::active_set(), 50_000, true),
};

/// The four-contact problem from nothing.
pub const LCP_COLD: Benchmark = Benchmark {
    name: "kernel/lcp-cold",
    about: "20000 problems of four contacts by active-set, reset before each; answer as warm",
    answer: [ANSWER_LCP, 1e-8],
    prepare: || lcp(&SolverEntry::active_set(), 20_000, false),
};

/// The same by Lemke.
pub const LEMKE: Benchmark = Benchmark {
    name: "kernel/lcp-lemke",
    about: "10000 problems of four contacts by lemke; answer as warm",
    answer: [ANSWER_LCP, 1e-8],
    prepare: || lcp(&SolverEntry::lemke(), 10_000, false),
};

/// Lemke and the active set agree on it; `w` is unique where `P` is not.
const ANSWER_LCP: f64 = 0.056_893_34;

/// Four contacts with friction from the states of the last solution.
pub const FRICTION_WARM: Benchmark = Benchmark {
    name: "kernel/friction-warm",
    about: "20000 problems of four contacts with friction, warm; answer: sum of contact velocities, m/s",
    answer: [ANSWER_FRICTION, 1e-7],
    prepare: || friction(20_000, |problem, solver, _, impulses| solver.solve(problem, impulses)),
};

/// The same by Lemke's method.
pub const FRICTION_LEMKE: Benchmark = Benchmark {
    name: "kernel/friction-lemke",
    about: "2000 problems of four contacts with friction by lemke; answer as warm",
    answer: [ANSWER_FRICTION, 1e-7],
    prepare: || {
        let mut states = [ContactState::Open; 4];
        friction(2_000, move |problem, _, lemke, impulses| lemke.attempt(problem, &mut states, impulses))
    },
};

/// Both agree on it.
const ANSWER_FRICTION: f64 = 0.122_257_4;

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

fn elimination() -> Result<Repetition> {
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
        let flops_estimate = WEDGE_BOX.flops(eliminations, &SolverCounters::default());
        let answer = 1.0 / model.entry(model.contacts(), model.contacts());
        Ok(Work { eliminations, flops_estimate, answer, ..Work::default() })
    }))
}

fn mechanics_step() -> Result<Repetition> {
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
            flops_estimate: WEDGE_BOX.flops(counters.eliminations, &counters.solver),
            answer: y[1],
            ..Work::default()
        })
    }))
}

fn hydraulics_step() -> Result<Repetition> {
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

/// `H_uu` of the wedge box with velocities of which the two closed contacts, and one more, want an impulse; slightly
/// different each time, so that nothing can be remembered but the active set.
fn lcp(solver: &SolverEntry, problems: u32, warm: bool) -> Result<Repetition> {
    let model = start_model(&mut system()?)?;
    let n = model.contacts();
    let h: Vec<f64> = (0..n * n).map(|index| model.entry(index / n, index % n)).collect();
    let mut checked: Checked = solver.checked(n);
    let (mut b, mut impulses) = (vec![0.0; n], vec![0.0; n]);
    Ok(Box::new(move || {
        let before = checked.counters();
        checked.reset();
        for problem in 0..problems {
            let scale = 1.0 + f64::from(problem % 8) / 64.0;
            b.iter_mut().zip(VELOCITIES).for_each(|(b, v)| *b = scale * v);
            if !warm {
                checked.reset();
            }
            checked.solve(Lcp::new(black_box(&h), &b), &mut impulses).map_err(broken)?;
        }
        let w = |row: usize| b[row] + (0..n).map(|k| h[row * n + k] * impulses[k]).sum::<f64>();
        let after = checked.counters();
        let lcp = SolverCounters {
            solves: after.solves - before.solves,
            pivots: after.pivots - before.pivots,
            factorisations: after.factorisations - before.factorisations,
            fallbacks: after.fallbacks - before.fallbacks,
            ..SolverCounters::default()
        };
        Ok(Work { flops_estimate: WEDGE_BOX.flops(0, &lcp), lcp, answer: (0..n).map(w).sum(), ..Work::default() })
    }))
}

/// m/s, one per contact of the wedge box.
const VELOCITIES: [f64; 4] = [-0.02, 0.03, -0.01, -0.002];

/// m/s along the surface: the wedges slide one way, one disc sticks, the other slides the other way.
const SLIPS: [f64; 4] = [0.05, 0.04, 0.001, -0.03];

/// The problem of [`lcp`] with friction of 0.3 and velocities along the surface, each solved by `solve`.
fn friction(
    problems: u32,
    mut solve: impl FnMut(FrictionProblem<'_>, &mut FrictionSolver, &mut CopositiveLemke, &mut [f64]) -> Solved + 'static,
) -> Result<Repetition> {
    let case = Catalogue::standard().case("wedge-box-friction").cloned()?;
    let model = start_model(&mut system_of(&case)?)?;
    let n = model.contacts();
    let h: Vec<f64> = (0..4 * n * n).map(|index| model.entry(index / (2 * n), index % (2 * n))).collect();
    let velocities: Vec<f64> = VELOCITIES.into_iter().chain(SLIPS).collect();
    let (mut solver, mut lemke) = (FrictionSolver::new(n, 1e-9), CopositiveLemke::new(n));
    let (mut b, mut impulses, mut w) = (vec![0.0; 2 * n], vec![0.0; 2 * n], vec![0.0; 2 * n]);
    Ok(Box::new(move || {
        solver.reset();
        let mut lcp = SolverCounters::default();
        for problem in 0..problems {
            let scale = 1.0 + f64::from(problem % 8) / 64.0;
            b.iter_mut().zip(&velocities).for_each(|(b, v)| *b = scale * v);
            let problem = FrictionProblem::with_friction(black_box(&h), &b, &model.friction);
            let stats = solve(problem, &mut solver, &mut lemke, &mut impulses).map_err(broken)?;
            problem.velocities(&impulses, &mut w);
            lcp.solves += 1;
            lcp.pivots += u64::from(stats.pivots);
            lcp.factorisations += u64::from(stats.factorisations);
        }
        let size = Size { contacts: 2 * n as u64, ..WEDGE_BOX };
        Ok(Work { flops_estimate: size.flops(0, &lcp), lcp, answer: w.iter().sum(), ..Work::default() })
    }))
}

type Solved = std::result::Result<SolveStats, Unsolved>;
