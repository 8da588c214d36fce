//! Options that only schemes with a reduced interface model have.

use super::contact_choice::ContactChoice;
use super::contact_detection::ContactDetection;
use crate::complementarity::SolverEntry;
use crate::cosim::EnergyReturn;
use crate::error::{Error, Result};
use crate::interface_model::{ReducedInterfaceModel, Redundancy};
use crate::name::by_name;
use std::sync::Arc;

/// What happens to the matrices of a reduced interface model within a macro step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ModelMotion {
    /// `H` and `a` stay as they were at `t_k`.
    #[default]
    Frozen,
    /// `H` and `a` go on linearly from the last two communication points; frozen after a change of the contact set.
    Extrapolated,
    /// `H` stays as it was, `a` jumps where the geometry has its next kink: gap functions are sent with their curvature and the place
    /// where it changes.
    Piecewise,
}

impl ModelMotion {
    const NAMES: [(&'static str, ModelMotion); 3] = [
        ("frozen", ModelMotion::Frozen),
        ("extrapolated", ModelMotion::Extrapolated),
        ("piecewise", ModelMotion::Piecewise),
    ];
}

by_name!(ModelMotion, NAMES, "model motion");

/// Options of a reduced interface model.
#[derive(Debug, Clone)]
pub struct ModelOptions {
    /// Treatment of dependent contacts where they become bilateral.
    pub redundancy: Redundancy,
    /// Frozen model, or one that moves.
    pub motion: ModelMotion,
    /// Which contacts count as closed at a communication point; the scheme's default if not said.
    pub detection: Option<ContactDetection>,
    /// Contacts that take part within a macro step (non-smooth models only).
    pub contacts: ContactChoice,
    /// Solver of the complementarity problems inside the scheme.
    pub solver: Arc<SolverEntry>,
    /// What becomes of energy that the coupling creates.
    pub energy_return: EnergyReturn,
}

impl Default for ModelOptions {
    fn default() -> Self {
        ModelOptions {
            redundancy: Redundancy::default(),
            motion: ModelMotion::default(),
            detection: None,
            contacts: ContactChoice::default(),
            solver: Arc::new(SolverEntry::active_set()),
            energy_return: EnergyReturn::default(),
        }
    }
}

impl ModelOptions {
    /// Checks that the options go together.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for chosen contacts with a model that moves: the loads of contacts left out would get into the rates of
    /// an extrapolated one, and the choice is a prediction with the accelerations at the communication point.
    pub fn check(&self) -> Result<()> {
        if self.contacts != ContactChoice::All && self.motion != ModelMotion::Frozen {
            return Err(Error::Incompatible(format!(
                "contacts = {} does not go with model_motion = {}: use model_motion `frozen` or contacts `all`",
                self.contacts, self.motion
            )));
        }
        Ok(())
    }

    /// Tells whether there is one among them that not all mechanics go together with.
    pub fn depends_on_mechanics(&self) -> bool {
        self.contacts != ContactChoice::All
            || self.redundancy != Redundancy::Drop
            || self.energy_return != EnergyReturn::None
    }

    /// Checks that they go together with what a mechanics offers.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for what knows no friction, where there is some; for chosen contacts that bounce: the choice is a prediction of the whole macro step with plastic
    /// contacts, and a contact that is left out because it will stay open, or whose force is held, may be hit by a rebound.
    pub(super) fn check_model(&self, model: &ReducedInterfaceModel) -> Result<()> {
        if model.has_friction() {
            self.check_friction()?;
        }
        if self.contacts != ContactChoice::All && model.restitution > 0.0 {
            return Err(Error::Incompatible(format!(
                "contacts = {} does not go with restitution {}: contacts are chosen by a prediction that knows no rebounds; use \
                 contacts `all`, or a restitution of 0",
                self.contacts, model.restitution
            )));
        }
        if self.contacts != ContactChoice::All && model.spring.is_some() {
            return Err(Error::Incompatible(format!(
                "contacts = {} does not go with compliant contacts: contacts are chosen by a prediction with rigid ones; use contacts `all`, or \
                 a contact_compliance_m_n of 0",
                self.contacts
            )));
        }
        Ok(())
    }

    /// Checks that they go together with friction.
    fn check_friction(&self) -> Result<()> {
        let refused = |option: String, reason: &str| {
            Err(Error::Incompatible(format!("{option} does not go with friction: {reason}")))
        };
        if self.contacts != ContactChoice::All {
            let reason = "contacts are chosen by a prediction that knows none; use contacts `all`";
            return refused(format!("contacts = {}", self.contacts), reason);
        }
        if self.redundancy != Redundancy::Drop {
            let reason = "of dependent rows that stick or slide the equations drop out; use redundancy `drop`";
            return refused(format!("redundancy = {}", self.redundancy), reason);
        }
        if self.energy_return != EnergyReturn::None {
            let reason = "the impulse is found by a prediction of the step that knows none; use energy_return `none`";
            return refused(format!("energy_return = {}", self.energy_return), reason);
        }
        if !self.solver.goes_by_active_sets() {
            let reason = "contacts with friction are solved over their states; use solver `active-set`";
            return refused(format!("solver = {}", self.solver.name), reason);
        }
        Ok(())
    }
}
