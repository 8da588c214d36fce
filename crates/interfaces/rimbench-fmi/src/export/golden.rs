//! What the two sides of a case say to each other, to hold an FMU against.

use rimbench_cases::cases::{Case, CoupledSystem};
use rimbench_cases::runs::{RunSpec, simulate};
use rimbench_core::cosim::{Bounds, Outcome, Side, StopFlag, Trajectory};
use rimbench_core::error::Result;
use rimbench_core::name::Name;
use std::sync::Arc;

/// Runs the case of `spec` with its scheme and records nothing but time, inputs and outputs of one side, every
/// communication point.
///
/// # Errors
/// Those of the run.
pub fn golden_run(spec: &RunSpec, side: Side) -> Result<(Trajectory, Outcome)> {
    let system = (spec.case.build)(&spec.parameters, &spec.solver)?;
    let ports = system.sides[side].ports();
    let names = ports.inputs.iter().chain(&ports.outputs).map(|port| port.name.clone());
    let columns = std::iter::once(Name::from("time_s")).chain(names).collect();
    let build = spec.case.build.clone();
    let bare = Case {
        trace_columns: columns,
        drawing_columns: Vec::new(),
        interface_columns: Vec::new(),
        linear_state: Vec::new(),
        build: Arc::new(move |parameters, solver| Ok(CoupledSystem::of(build(parameters, solver)?.sides))),
        ..Case::clone(&spec.case)
    };
    let spec = spec.with(|own| own.case = Arc::new(bare))?;
    let result = simulate(&spec, Bounds::default(), None, StopFlag::never())?;
    Ok((result.trajectory, result.report.outcome))
}
