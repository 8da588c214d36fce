//! Outputs and inputs of the actuator in each micro step.

use super::communication_grid::MicroStep;
use super::setup::Setup;
use super::subsystem::Sides;
use super::trajectory::Trajectory;

/// Makes room for the micro steps of a run, or for `most` of them. Where a rule sets its macro steps, each may add a
/// micro step to those of the grid.
///
/// One row per micro step: when it starts, its middle, the actuator's outputs at its start, its inputs over it (their
/// mean). Of one of the second order the outputs are those of its middle, which then stands in both columns.
pub(crate) fn micro_log(setup: &Setup, sides: &Sides<'_>, most: usize) -> Trajectory {
    let ports = sides.ports().actuator;
    let names = ports.outputs.iter().chain(&ports.inputs).map(|port| port.name.to_string());
    let columns = ["time_s", "middle_s"].map(str::to_owned).into_iter().chain(names).collect();
    let of_grid: usize = (0..setup.grid.macro_steps()).map(|k| setup.actuator_steps(setup.grid.step(k))).sum();
    let more = setup.step_rule.map_or(0, |_| setup.expected_macro_steps());
    Trajectory::with_capacity(columns, most.min(of_grid + more))
}

/// Notes one micro step.
#[inline]
pub(crate) fn record_micro_step(log: &mut Trajectory, at: MicroStep, outputs: &[f64], inputs: &[f64]) {
    log.push_parts([&[at.start, at.middle()], outputs, inputs]);
}

/// Notes one of the second order, whose outputs belong to its middle.
#[inline]
pub(crate) fn record_midpoint(log: &mut Trajectory, at: MicroStep, outputs: &[f64], inputs: &[f64]) {
    log.push_parts([&[at.middle(); 2], outputs, inputs]);
}
