//! The fixed suite: whole runs, the reference, kernels. Each benchmark knows the answer it must give.

use super::benchmark::{Benchmark, Repetition, Work, forces, whole_run};
use super::kernels;
use rimbench_cases::cases::Recorder;
use rimbench_core::cosim::{MechanicsSteps, StopFlag, Trajectory};
use rimbench_core::error::Result;
use rimbench_core::mechanics::{ReferenceSteps, monolithic};
use rimbench_core::solver_entry::SolverEntry;
use rimbench_runs::RunRequest;
use rimbench_runs::catalogue::Catalogue;

/// Every benchmark, in the order of the rows. Answers of runs are means of the interface force, N; of the reference its
/// peak.
pub const BENCHMARKS: &[Benchmark] = &[
    Benchmark::new("wedge-box/zero-order-hold", [-53.83786, 1e-3], |name| run(name, 2e-4)),
    Benchmark::new("wedge-box/rim-nonsmooth", [-53.19089, 1e-3], |name| run(name, 5e-3)),
    Benchmark::new("wedge-box/rim-nonsmooth-gap", [-53.25332, 1e-3], |name| run(name, 5e-3)),
    Benchmark::new("wedge-box/rim-smooth-active", [-53.17038, 1e-3], |name| run(name, 5e-3)),
    Benchmark::new("wedge-box/interface-jacobian", [-40.02672, 1e-3], |name| run(name, 5e-3)),
    Benchmark::new("hydraulic-crane/zero-order-hold", [7869.867, 1e-2], |name| run(name, 1e-3)),
    Benchmark::new("linear-oscillator/zero-order-hold", [1.046544, 1e-5], |name| run(name, 1e-3)),
    Benchmark::new("wedge-box/reference", [1008.79, 0.06], |_| reference()),
    // Effective mass at free contacts, kg.
    Benchmark::new("kernel/elimination", [154.0497, 1e-4], |_| kernels::elimination()),
    // 250 N / 250 kg · 0.2 s, m/s.
    Benchmark::new("kernel/mechanics-step", [0.2, 1e-9], |_| kernels::mechanics_step()),
    // Force at an equilibrium, N.
    Benchmark::new("kernel/hydraulics-step", [0.0, 1e-6], |_| kernels::hydraulics_step()),
    // Sum of contact velocities, m/s: `w` is unique where `P` is not.
    Benchmark::new("kernel/friction-warm", [0.122_257_4, 1e-7], |_| kernels::friction_warm()),
];

/// A whole run with the defaults of its case and scheme, recorded at every communication point.
fn run(name: &str, macro_step: f64) -> Result<Repetition> {
    let (case, scheme) = name.split_once('/').unwrap_or_default();
    // One step of the mechanics per macro step, also on linear cases, so that a record compares with older ones.
    let request = RunRequest {
        macro_step_s: Some(macro_step),
        mechanics_steps: Some(MechanicsSteps::ONE),
        ..RunRequest::of(case, scheme)
    };
    Ok(whole_run(request.resolve(&Catalogue::standard())?))
}

/// The first half second of the wedge box, by the loop that makes references, with the coarsest step.
fn reference() -> Result<Repetition> {
    const DURATION: f64 = 0.5;
    let case = Catalogue::standard().case("wedge-box")?.clone();
    let h = case.defaults.reference_step_s;
    let every = (case.defaults.reference_sampling_s / h).round().max(1.0) as usize;
    let steps = ReferenceSteps { h, steps: (DURATION / h).round() as usize, every };
    Ok(Box::new(move || {
        let mut system = (case.build)(&case.default_parameters(), &SolverEntry::active_set())?;
        let mut recorder = Recorder::new(&case, &mut system)?;
        let mut trajectory = Trajectory::with_capacity(case.recorded_columns(), steps.steps / every + 2);
        let ended = monolithic(system.sides.lend(), steps, StopFlag::never(), &mut |point| {
            recorder.record(point, &mut trajectory);
        });
        let (mechanics, actuator) = (system.sides.mechanics.counters(), system.sides.actuator.counters());
        let greatest = forces(&trajectory, "actuator_force_n")?.fold(f64::NEG_INFINITY, f64::max);
        Ok(Work {
            macro_steps: 0,
            mechanics_micro_steps: mechanics.micro_steps,
            actuator_micro_steps: actuator.micro_steps,
            eliminations: mechanics.eliminations,
            lcp: mechanics.solver,
            answer: if ended.is_ok() { greatest } else { f64::NAN },
        })
    }))
}
