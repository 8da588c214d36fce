//! Whole runs of the wedge box, as the benches time them.

use rimbench::cases::{Recorder, case_by_name};
use rimbench::complementarity::solver_by_name;
use rimbench::cosim::{Bounds, CommunicationGrid, Outcome, Setup, StepControl, Timing, Trajectory, cosimulate};
use rimbench::interface_model::Redundancy;
use rimbench::schemes::{ModelMotion, SchemeOptions, scheme_by_name};

/// Simulated time, s.
pub const DURATION: f64 = 2.5;
/// Micro step of the hydraulics, s.
#[allow(dead_code)] // Not every bench needs it.
pub const MICRO_STEP: f64 = 5e-5;

/// Runs the case with its defaults and records every communication point.
pub fn wedge_box(scheme: &str, macro_step: f64) -> Trajectory {
    let case = case_by_name("wedge-box").unwrap();
    let solver = solver_by_name("active-set").unwrap();
    let entry = scheme_by_name(scheme).unwrap();
    let (sequence, force_return) = entry.sequence_and_return(None, None).unwrap();
    let setup = Setup {
        grid: CommunicationGrid::new(macro_step, 1.0, DURATION).unwrap(),
        step_control: StepControl::None,
        micro_step: MICRO_STEP,
        mechanics_steps: 1,
        sequence,
        force_return,
        stale_feedthrough: false,
        bounds: Bounds::default(),
        timing: Timing::default(),
    };
    let mut system = (case.build)(&case.default_parameters(), solver).unwrap();
    let options = SchemeOptions { redundancy: Redundancy::Drop, motion: ModelMotion::Frozen, solver, gain: None };
    let mut scheme = (entry.build)(system.mechanics.ports(), system.actuator.ports(), &options);
    let mut recorder = Recorder::new(case, &mut system);
    let mut trajectory = Trajectory::with_capacity(case.recorded_columns(), setup.grid.macro_steps() + 1);
    let report = cosimulate(&setup, &mut *system.mechanics, &mut *system.actuator, &mut *scheme, &mut |point| {
        recorder.record(point, &mut trajectory);
    });
    assert_eq!(report.outcome, Outcome::Completed);
    trajectory
}
