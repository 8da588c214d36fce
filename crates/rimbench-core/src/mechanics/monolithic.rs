//! The reference: both sides in one loop, with one small step and no communication points.

use crate::cosim::{CommunicationPoint, Diagnostics, Subsystem};
use crate::error::Failure;

/// Integrates two coupled subsystems as one system with step `h` (s), `steps` times, calling `observe` at the
/// start, after every `every` steps and at the end.
///
/// ```text
/// λ_k = y_actuator(x_k, w_k)        mechanics: (q, v)_k → (q, v)_{k+1} with λ_k
///                                   actuator:  x_k → x_{k+1} with (s, w)_{k+1}
/// ```
/// This is the semi-implicit Euler rule for the whole system: first order, and free of numerical damping of the
/// oscillation between fluid and mass. Richardson extrapolation over h, h/2, h/4 measures its error.
///
/// # Errors
/// The first [`Failure`] of either side.
pub fn monolithic(
    mechanics: &mut dyn Subsystem,
    actuator: &mut dyn Subsystem,
    h: f64,
    steps: usize,
    every: usize,
    observe: &mut dyn FnMut(CommunicationPoint<'_>),
) -> Result<(), Failure> {
    let mut y_mechanics = vec![0.0; mechanics.ports().outputs.len()];
    let mut y_actuator = vec![0.0; actuator.ports().outputs.len()];
    for step in 0..=steps {
        mechanics.outputs(&y_actuator, &mut y_mechanics);
        if step > 0 {
            actuator.step((step - 1) as f64 * h, &y_mechanics, h)?;
        }
        actuator.outputs(&y_mechanics, &mut y_actuator);
        if step % every == 0 || step == steps {
            observe(CommunicationPoint {
                time: step as f64 * h,
                y_mechanics: &y_mechanics,
                y_actuator: &y_actuator,
                received: &y_actuator,
                diagnostics: Diagnostics::default(),
                mechanics_step: h,
                mechanics,
                actuator,
            });
        }
        if step < steps {
            mechanics.step(step as f64 * h, &y_actuator, h)?;
        }
    }
    Ok(())
}
