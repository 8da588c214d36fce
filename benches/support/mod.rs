//! Whole runs of the wedge box, as the benches time them.

use rimbench::cases::Recorder;
use rimbench::catalogue::Catalogue;
use rimbench::cosim::{Bounds, Outcome, Supervision, Trajectory};
use rimbench::runs::{RunRequest, RunSpec};

/// Simulated time, s.
pub const DURATION: f64 = 2.5;
/// Micro step of the hydraulics, s.
#[allow(dead_code)] // Not every bench needs it.
pub const MICRO_STEP: f64 = 5e-5;

/// The case at its defaults.
pub fn wedge_box_run(scheme: &str, macro_step: f64) -> RunSpec {
    let request = RunRequest {
        macro_step_s: Some(macro_step),
        micro_step_s: Some(MICRO_STEP),
        duration_s: Some(DURATION),
        ..RunRequest::of("wedge-box", scheme)
    };
    request.resolve(&Catalogue::standard()).unwrap()
}

/// Runs the case with its defaults and records every communication point.
pub fn wedge_box(scheme: &str, macro_step: f64) -> Trajectory {
    let spec = wedge_box_run(scheme, macro_step);
    let mut system = (spec.case.build)(&spec.parameters, &spec.solver).unwrap();
    let setup = spec.setup(Bounds::default()).unwrap();
    let mut recorder = Recorder::new(&spec.case, &mut system).unwrap();
    let mut sides = system.sides.lend();
    let coupling = spec.scheme.couple(sides.lend(), spec.model.as_ref(), spec.gain).unwrap();
    let mut trajectory = Trajectory::with_capacity(spec.case.recorded_columns(), setup.grid.macro_steps() + 1);
    let report = coupling.run(&setup, None, sides, Supervision::default(), &mut |point| {
        recorder.record(point, &mut trajectory);
    });
    recorder.finish(&report, &mut trajectory);
    assert_eq!(report.outcome, Outcome::Completed);
    trajectory
}
