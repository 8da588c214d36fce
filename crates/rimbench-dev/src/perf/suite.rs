//! The fixed suite: whole runs, the reference, kernels. Each benchmark knows the answer it must give.

use super::benchmark::{Benchmark, Repetition, Size, WEDGE_BOX, Work};
use super::kernels;
use rimbench_cases::cases::Recorder;
use rimbench_cases::catalogue::Catalogue;
use rimbench_cases::runs::{RunRequest, simulate};
use rimbench_core::cosim::{Bounds, MechanicsSteps, Outcome, StopFlag, Trajectory};
use rimbench_core::error::{Error, Result};
use rimbench_core::mechanics::{ReferenceSteps, monolithic};
use rimbench_core::name::find_by_name;
use rimbench_core::solver_entry::SolverEntry;
use rimbench_harness::monotonic_clock;

/// Every benchmark, in the order of the rows.
pub const BENCHMARKS: &[Benchmark] = &[
    Benchmark {
        name: "wedge-box/zero-order-hold",
        about: "wedge box, H = 0.2 ms; answer: mean actuator force, N",
        answer: [-53.83786, 1e-3],
        prepare: || run("wedge-box", "zero-order-hold", 2e-4, WEDGE_BOX, "actuator_force_n"),
    },
    Benchmark {
        name: "wedge-box/rim-nonsmooth",
        about: "wedge box, H = 5 ms; answer: mean actuator force, N",
        answer: [-53.19089, 1e-3],
        prepare: || run("wedge-box", "rim-nonsmooth", 5e-3, WEDGE_BOX, "actuator_force_n"),
    },
    Benchmark {
        name: "wedge-box/rim-nonsmooth-gap",
        about: "wedge box, H = 5 ms; answer: mean actuator force, N",
        answer: [-53.25332, 1e-3],
        prepare: || run("wedge-box", "rim-nonsmooth-gap", 5e-3, WEDGE_BOX, "actuator_force_n"),
    },
    Benchmark {
        name: "wedge-box/rim-smooth-active",
        about: "wedge box, H = 5 ms; answer: mean actuator force, N",
        answer: [-53.17038, 1e-3],
        prepare: || run("wedge-box", "rim-smooth-active", 5e-3, WEDGE_BOX, "actuator_force_n"),
    },
    Benchmark {
        name: "wedge-box/interface-jacobian",
        about: "wedge box, H = 5 ms; answer: mean actuator force, N",
        answer: [-40.02672, 1e-3],
        prepare: || run("wedge-box", "interface-jacobian", 5e-3, WEDGE_BOX, "actuator_force_n"),
    },
    Benchmark {
        name: "hydraulic-crane/zero-order-hold",
        about: "crane, manoeuvre M1, H = 1 ms; answer: mean actuator force, N",
        answer: [7869.867, 1e-2],
        prepare: || run("hydraulic-crane", "zero-order-hold", 1e-3, CRANE, "actuator_force_n"),
    },
    Benchmark {
        name: "linear-oscillator/zero-order-hold",
        about: "two-mass oscillator, H = 1 ms; answer: mean coupling force, N",
        answer: [1.046544, 1e-5],
        prepare: || run("linear-oscillator", "zero-order-hold", 1e-3, Size::default(), "coupling_force_n"),
    },
    Benchmark {
        name: "wedge-box/reference",
        about: "first 0.5 s of the wedge box, monolithic, coarsest step; answer: greatest actuator force, N",
        answer: [1008.79, 0.06],
        prepare: reference,
    },
    kernels::ELIMINATION,
    kernels::MECHANICS_STEP,
    kernels::HYDRAULICS_STEP,
    kernels::LCP_WARM,
    kernels::LCP_COLD,
    kernels::LEMKE,
    kernels::FRICTION_WARM,
    kernels::FRICTION_LEMKE,
];

/// Looks a benchmark up in [`BENCHMARKS`].
///
/// # Errors
/// [`Error::UnknownName`] with the valid names.
pub fn benchmark_by_name(name: &str) -> Result<&'static Benchmark> {
    find_by_name("benchmark", BENCHMARKS, |entry| entry.name, name)
}

/// Two angles, no joints and no contacts.
const CRANE: Size = Size { n: 2, bilateral: 0, contacts: 0, interface: 1 };

/// A whole run with the defaults of its case and scheme, recorded at every communication point.
fn run(case: &str, scheme: &str, macro_step: f64, size: Size, column: &'static str) -> Result<Repetition> {
    // One step of the mechanics per macro step, also on linear cases, so that a record compares with older ones.
    let request = RunRequest {
        macro_step_s: Some(macro_step),
        mechanics_steps: Some(MechanicsSteps::ONE),
        ..RunRequest::of(case, scheme)
    };
    let spec = request.resolve(&Catalogue::standard())?;
    Ok(Box::new(move || {
        let result = simulate(&spec, Bounds::default(), Some(monotonic_clock), StopFlag::never())?;
        let work = &result.report.work;
        let mut lcp = work.sides.mechanics.solver;
        lcp.add(&work.scheme);
        let completed = result.report.outcome == Outcome::Completed;
        Ok(Work {
            macro_steps: work.cosim.macro_steps,
            mechanics_micro_steps: work.sides.mechanics.micro_steps,
            actuator_micro_steps: work.sides.actuator.micro_steps,
            eliminations: work.sides.mechanics.eliminations,
            lcp,
            flops_estimate: size.flops(work.sides.mechanics.eliminations, &lcp),
            answer: if completed { mean(&result.trajectory, column)? } else { f64::NAN },
        })
    }))
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
        Ok(Work {
            macro_steps: 0,
            mechanics_micro_steps: mechanics.micro_steps,
            actuator_micro_steps: actuator.micro_steps,
            eliminations: mechanics.eliminations,
            lcp: mechanics.solver,
            flops_estimate: WEDGE_BOX.flops(mechanics.eliminations, &mechanics.solver),
            answer: if ended.is_ok() { greatest(&trajectory, "actuator_force_n")? } else { f64::NAN },
        })
    }))
}

/// Schemes that agree on the peak to all digits still differ in the mean: the answer tells them apart.
fn mean(trajectory: &Trajectory, column: &str) -> Result<f64> {
    Ok(trajectory.column(index_of(trajectory, column)?).sum::<f64>() / trajectory.len() as f64)
}

fn greatest(trajectory: &Trajectory, column: &str) -> Result<f64> {
    Ok(trajectory.column(index_of(trajectory, column)?).fold(f64::NEG_INFINITY, f64::max))
}

fn index_of(trajectory: &Trajectory, column: &str) -> Result<usize> {
    let names = || trajectory.columns().iter().map(String::as_str);
    trajectory.index_of(column).ok_or_else(|| Error::unknown("column", column, names()))
}
