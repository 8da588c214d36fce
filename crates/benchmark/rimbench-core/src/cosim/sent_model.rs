//! The mechanics' interface model on its way to the scheme.

use super::communication_grid::MacroStep;
use super::exchange_data::NO_INTERFACE_MODEL;
use super::late_samples::Shadow;
use super::mass_learner::MassLearner;
use super::model_audit::ModelAudit;
use super::output_history::OutputHistory;
use super::setup::Setup;
use super::subsystem::Subsystem;
use crate::error::{Cause, Failure};
use crate::interface_model::ReducedInterfaceModel;

/// The interface model of a communication point, as the mechanics sends it, and what follows it.
#[derive(Debug, Clone)]
pub(crate) struct SentModel {
    /// What is believed of the mechanics, where that is something else.
    pub(crate) model: ReducedInterfaceModel,
    /// Whether that of the next communication point is here already.
    is_here: bool,
    /// What the actuator learns of the mass, where it does.
    pub(crate) learner: Option<MassLearner>,
    /// The account of what the scheme's model creates, where it is kept.
    pub(crate) audit: Option<ModelAudit>,
    /// The scheme with samples in time, under the same forces, where they are late and there is an account.
    pub(crate) in_time: Option<Shadow>,
}

impl SentModel {
    /// Makes room for models like `empty`.
    pub(crate) fn new(setup: &Setup, empty: ReducedInterfaceModel) -> Self {
        let learner = setup.mass_learning.map(|rule| MassLearner::new(rule, &empty));
        SentModel { model: empty, is_here: false, learner, audit: None, in_time: None }
    }

    /// Takes the model of the next communication point, which the mechanics is then not asked for.
    pub(crate) fn take(&mut self, model: &ReducedInterfaceModel) {
        self.model.copy_from(model);
        self.is_here = true;
    }

    /// Fills in the model at the start of `step`.
    ///
    /// # Errors
    /// Those of the mechanics; [`Cause::NotOffered`] if it has none now.
    pub(crate) fn fill(
        &mut self,
        setup: &Setup,
        step: MacroStep,
        mechanics: &mut dyn Subsystem,
    ) -> Result<(), Failure> {
        let SentModel { model, audit, .. } = self;
        if !std::mem::take(&mut self.is_here)
            && !mechanics.capabilities().interface_model(setup.mechanics_step(step), model)?
        {
            return Err(Cause::NotOffered { what: NO_INTERFACE_MODEL.into() }.into());
        }
        if let Some(belief) = &setup.belief {
            if let Some(audit) = audit {
                audit.keep_own(model);
            }
            belief.distort(model);
        }
        Ok(())
    }

    /// Returns the model as it arrives at communication point `k`, the mass that is learned included.
    pub(crate) fn arrive(&mut self, k: usize) -> &ReducedInterfaceModel {
        match &mut self.learner {
            Some(learner) => learner.receive(k, &self.model),
            None => &self.model,
        }
    }

    /// Follows the actuator over `step`, which it has covered with these outputs and last velocities `w` (m/s).
    ///
    /// # Errors
    /// Those of the scheme.
    pub(crate) fn follow(&mut self, step: MacroStep, outputs: &OutputHistory, w: &[f64]) -> Result<(), Failure> {
        if let Some(learner) = &mut self.learner {
            learner.forecast(step, outputs, w);
        }
        self.in_time.as_mut().map_or(Ok(()), |in_time| in_time.replay(step, outputs))
    }
}
