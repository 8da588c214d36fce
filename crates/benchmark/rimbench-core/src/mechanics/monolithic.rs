//! The reference: both sides in one loop, with one small step and no communication points.

use crate::cosim::{CommunicationPoint, LentActuator, PerSide, Sides, StopFlag};
use crate::error::Failure;

/// The steps of a reference, and which of them are shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceSteps {
    /// Length, s.
    pub h: f64,
    /// How many.
    pub steps: usize,
    /// A row is due at the start, after every so many steps, and at the end.
    pub every: usize,
}

impl ReferenceSteps {
    /// Tells whether a row is due after so many steps.
    pub fn shows(&self, step: usize) -> bool {
        step.is_multiple_of(self.every) || step == self.steps
    }
}

/// Integrates two coupled subsystems as one system, calling `observe` where a row is due.
///
/// ```text
/// λ_k = y_actuator(x_k, w_k)        mechanics: (q, v)_k → (q, v)_{k+1} with λ_k
///                                   actuator:  x_k → x_{k+1} with (s, w)_{k+1}
/// ```
/// This is the semi-implicit Euler rule for the whole system: first order, and free of numerical damping of the
/// oscillation between fluid and mass. Richardson extrapolation over h, h/2, h/4 measures its error. Where the
/// mechanics steps by a rule of the second order, both sides take each piece of a step together
/// ([`ContactMechanics`](crate::cosim::ContactMechanics)), cut at its events.
///
/// # Errors
/// The first [`Failure`] of either side; [`Cause::Stopped`](crate::error::Cause::Stopped).
pub fn monolithic(
    sides: Sides<'_>,
    steps: ReferenceSteps,
    stop: StopFlag<'_>,
    observe: &mut dyn FnMut(CommunicationPoint<'_>),
) -> Result<(), Failure> {
    monolithic_with_events(sides, steps, stop, &mut |due, point| {
        if due == Due::Row {
            observe(point);
        }
    })
}

/// What is shown of a reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Due {
    /// A row that is due.
    Row,
    /// Where an event is met that is located within a step, before it acts.
    BeforeEvent,
    /// What it leaves.
    AfterEvent,
}

/// Integrates as [`monolithic`] does, and calls `observe` at located events as well.
///
/// # Errors
/// Those of [`monolithic`].
pub fn monolithic_with_events(
    mut sides: Sides<'_>,
    steps: ReferenceSteps,
    stop: StopFlag<'_>,
    observe: &mut dyn FnMut(Due, CommunicationPoint<'_>),
) -> Result<(), Failure> {
    let h = steps.h;
    let mut motion = vec![0.0; sides.mechanics.ports().outputs.len()];
    let mut force = vec![0.0; sides.actuator.ports().outputs.len()];
    let contacts = sides.mechanics.capabilities().contact_mechanics();
    let together = contacts.is_some_and(|mechanics| mechanics.is_of_second_order());
    let mut mean = vec![0.0; force.len()];
    for step in 0..=steps.steps {
        stop.check()?;
        sides.mechanics.outputs(&force, &mut motion)?;
        if step > 0 && !together {
            sides.actuator.step((step - 1) as f64 * h, &motion, h)?;
        }
        sides.actuator.outputs(&motion, &mut force)?;
        let mut show = |due, time, [motion, force, received]: [&[f64]; 3], mut sides: Sides<'_>| {
            let y = PerSide { mechanics: motion, actuator: force };
            let point = CommunicationPoint {
                audit: None,
                time,
                y,
                received,
                effective_mass: None,
                mechanics_step: h,
                interface_lambda: None,
                interface_residual: None,
                inside: None,
                sides: sides.lend(),
            };
            observe(due, point);
        };
        let start = step as f64 * h;
        if steps.shows(step) {
            let received = if together && step > 0 { &mean } else { &force };
            show(Due::Row, start, [&motion, &force, received], sides.lend());
        }
        if step == steps.steps {
            break;
        }
        if !together {
            sides.mechanics.step(start, &force, h)?;
            continue;
        }
        mean.fill(0.0);
        let mut due = Due::BeforeEvent;
        while let Some(mechanics) = sides.mechanics.capabilities().contact_mechanics() {
            let met = mechanics.step_together_to_event(
                &mut LentActuator(sides.actuator),
                start,
                h,
                &mut |length, sent, _| {
                    mean.iter_mut().zip(sent).for_each(|(mean, sent)| *mean += length / h * sent);
                },
            )?;
            let Some(done) = met else { break };
            sides.mechanics.outputs(&force, &mut motion)?;
            sides.actuator.outputs(&motion, &mut force)?;
            // Behind the row that starts the step, and not behind the one that ends it.
            let time = if done < h { (start + done).max(start.next_up()) } else { (step + 1) as f64 * h };
            show(due, time, [&motion, &force, &force], sides.lend());
            due = if due == Due::BeforeEvent { Due::AfterEvent } else { Due::BeforeEvent };
        }
    }
    Ok(())
}
