//! Whole runs of the wedge box, as the benches time them.

use rimbench::cases::{Recorder, case_by_name};
use rimbench::complementarity::solver_by_name;
use rimbench::cosim::{Bounds, Outcome, Setup, Timing, Trajectory, cosimulate};
use rimbench::harness::RunSpec;
use rimbench::schemes::scheme_by_name;

/// Simulated time, s.
pub const DURATION: f64 = 2.5;
/// Micro step of the hydraulics, s.
#[allow(dead_code)] // Not every bench needs it.
pub const MICRO_STEP: f64 = 5e-5;

/// Runs the case with its defaults and records every communication point.
pub fn wedge_box(scheme: &str, macro_step: f64) -> Trajectory {
    let (case, solver) = (case_by_name("wedge-box").unwrap(), solver_by_name("active-set").unwrap());
    let entry = scheme_by_name(scheme).unwrap();
    let spec = RunSpec {
        micro_step: MICRO_STEP,
        duration: DURATION,
        ..RunSpec::usual(case, entry, solver, macro_step).unwrap()
    };
    let mut system = (case.build)(&spec.parameters, solver).unwrap();
    let setup = Setup { timing: Timing::default(), ..spec.setup(&system, Bounds::default()).unwrap() };
    let mut scheme = (entry.build)(system.mechanics.ports(), system.actuator.ports(), &spec.options);
    let mut recorder = Recorder::new(case, &mut system);
    let mut trajectory = Trajectory::with_capacity(case.recorded_columns(), setup.grid.macro_steps() + 1);
    let report = cosimulate(&setup, &mut *system.mechanics, &mut *system.actuator, &mut *scheme, &mut |point| {
        recorder.record(point, &mut trajectory);
    });
    assert_eq!(report.outcome, Outcome::Completed);
    trajectory
}
