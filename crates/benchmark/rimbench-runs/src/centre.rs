//! The centre of a run, by which its error is divided into that of the coupling and that of the mechanics' own step.
//!
//! ```text
//! e = λ − λ_ref = a + b          a = λ − λ_c of the coupling          b = λ_c − λ_ref of the mechanics' own step
//! ```
//! λ_c is the actuator's force in the own-step model, asked anew at every own step of the mechanics, on the run's own
//! communication points with its own steps; where the mechanics has no model, in `rim-answers`.
//! # Source
//! `docs/method/own-step.md`

use super::reference::Reference;
use super::simulation::{Clock, run};
use super::spec::RunSpec;
use rimbench_core::cosim::{Exchange, ForceReturn, Outcome, RunControl, StopFlag};
use rimbench_core::error::{Error, Result};
use rimbench_core::iterative::IterativeDriver;
use rimbench_core::schemes::{ContactsAct, ModelOptions, SchemeEntry, standard_schemes};
use std::sync::Arc;

/// Schemes that can be a centre: with a model of the mechanics, and with a mechanics that can be copied.
const CENTRES: [&str; 2] = ["rim-nonsmooth-gap", "rim-answers"];

impl RunSpec {
    /// Makes the run that is the centre of this one, by one of these schemes.
    fn centre(&self, scheme: SchemeEntry) -> Result<RunSpec> {
        let why = match (&self.step_control, &self.star) {
            (Some(_), _) => "a step control sets its macro steps as it goes",
            (_, Some(_)) => "its mechanics has several bonds",
            _ => "",
        };
        if !why.is_empty() {
            return Err(Error::Incompatible(why.to_owned()));
        }
        self.with(|own| {
            let model = ModelOptions { contacts_act: ContactsAct::MechanicsStep, ..ModelOptions::default() };
            own.model = scheme.has_model().then(|| ModelOptions { solver: own.solver.clone(), ..model });
            let exchange = Exchange::new(own.micro_step, scheme.sequence, ForceReturn::Mean);
            let scheme = SchemeEntry { driver: IterativeDriver::AtOwnSteps(own.mechanics_steps), ..scheme };
            own.exchange = Exchange { actuator_integrator: own.actuator_integrator, ..exchange };
            (own.scheme, own.gain) = (Arc::new(scheme), None);
            (own.audit, own.predict_growth, own.divide_error) = (false, false, false);
        })
    }

    /// Computes the actuator's forces of the centre, N, row by row of the interface, at each communication point.
    ///
    /// # Errors
    /// Why there is no centre, in words.
    pub(super) fn forces_of_centre(
        &self,
        reference: &Reference,
        clock: Option<Clock>,
        stop: StopFlag<'_>,
    ) -> Result<Vec<Vec<f64>>, String> {
        let mut reasons = Vec::new();
        let entries =
            CENTRES.into_iter().filter_map(|name| standard_schemes().into_iter().find(|own| *own.name == *name));
        for entry in entries {
            let found = self.centre(entry).and_then(|spec| {
                let prepared = spec.prepare()?;
                let bounds = reference.bounds_of(&spec.case, prepared.system());
                run(prepared, bounds, clock, RunControl { stop, ..RunControl::default() }, None)
            });
            let found = found.map_err(|error| error.to_string())?;
            let trajectory = &found.trajectory;
            match found.report.outcome {
                Outcome::Completed => {
                    let forces = self.case.interface_columns.iter().filter_map(|row| trajectory.index_of(&row.force));
                    return Ok(forces.map(|force| trajectory.column(force).collect()).collect());
                }
                // Without a model of the mechanics, its answers.
                Outcome::Skipped { reason } => reasons.push(reason),
                outcome => return Err(format!("its centre is {}: {}", outcome.name(), outcome.reason())),
            }
        }
        Err(reasons.join("; "))
    }
}
