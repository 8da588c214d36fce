//! Options that only schemes with a reduced interface model have.

use super::contact_detection::ContactDetection;
use crate::error::{Error, Result};
use crate::interface_model::ReducedInterfaceModel;
use crate::name::by_name;
use rimbench_contact::solver_entry::SolverEntry;
use std::sync::Arc;

/// The motion of the matrices of a reduced interface model within a macro step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ModelMotion {
    /// `H` and `a` stay as they were at `t_k`.
    #[default]
    Frozen,
    /// `H` and `a` go on linearly from the last two communication points; frozen after a change of the contact set.
    Extrapolated,
}

impl ModelMotion {
    const NAMES: [(&'static str, ModelMotion); 2] =
        [("frozen", ModelMotion::Frozen), ("extrapolated", ModelMotion::Extrapolated)];
}

by_name!(ModelMotion, NAMES, "model motion");

/// The tangential rows of contacts in space within a reduced interface model.
///
/// ```text
/// cone              w_t1⁺, w_t2⁺ under |P_t| ≤ μ P_n
/// slip-direction    w_d⁺ = d · w_t⁺,  |P_d| ≤ μ P_n,  P_t = P_d d        d as at t_k
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FrictionRows {
    /// Two, under Coulomb's cone.
    #[default]
    Cone,
    /// One along the slip at `t_k`, so that contact problems are planar.
    SlipDirection,
}

impl FrictionRows {
    const NAMES: [(&'static str, FrictionRows); 2] =
        [("cone", FrictionRows::Cone), ("slip-direction", FrictionRows::SlipDirection)];
}

by_name!(FrictionRows, NAMES, "friction rows");

/// The step over which the contacts of a reduced interface model act.
///
/// ```text
/// micro-step        w⁺ = w + δ (a + H_·i λ) + H_·u P                  an impulse acts at once
/// mechanics-step    w⁺ = w + (δ/h) (Φ(λ) − w_s)                       Φ the mechanics' answer to λ over its own step h, from w_s
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ContactsAct {
    /// The actuator's.
    #[default]
    MicroStep,
    /// The mechanics' own.
    MechanicsStep,
}

impl ContactsAct {
    const NAMES: [(&'static str, ContactsAct); 2] =
        [("micro-step", ContactsAct::MicroStep), ("mechanics-step", ContactsAct::MechanicsStep)];
}

by_name!(ContactsAct, NAMES, "step over which contacts act");

/// Options of a reduced interface model.
#[derive(Debug, Clone, Default)]
pub struct ModelOptions {
    /// Frozen model, or one that moves.
    pub model_motion: ModelMotion,
    /// Which contacts count as closed at a communication point; the scheme's default if not said.
    pub detection: Option<ContactDetection>,
    /// Tangential rows of contacts in space.
    pub friction_rows: FrictionRows,
    /// The step over which contacts act.
    pub contacts_act: ContactsAct,
    /// Solver of the complementarity problems inside the scheme.
    pub solver: Arc<SolverEntry>,
}

impl ModelOptions {
    /// Tells whether there is one among them that not all mechanics go together with.
    pub fn depends_on_mechanics(&self) -> bool {
        self.friction_rows == FrictionRows::SlipDirection
    }

    /// Checks that they go together with what a mechanics offers.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for what knows no friction, where there is some, and for one row of friction where there
    /// are not two, or rows that turn.
    pub(super) fn check_model(&self, model: &ReducedInterfaceModel) -> Result<()> {
        if self.friction_rows == FrictionRows::SlipDirection {
            let why = match (model.has_friction(), model.is_in_space()) {
                (false, _) => "the contacts have no friction",
                (true, false) => "contacts in the plane have one tangential row anyway",
                (true, true) if self.model_motion == ModelMotion::Frozen => return self.check_friction(),
                (true, true) => "rows turn from one communication point to the next; use model_motion `frozen`",
            };
            return Err(Error::Incompatible(format!("friction_rows = {}: {why}", self.friction_rows)));
        }
        if model.has_friction() { self.check_friction() } else { Ok(()) }
    }

    /// Checks that they go together with friction.
    fn check_friction(&self) -> Result<()> {
        if self.solver.with_friction {
            return Ok(());
        }
        Err(Error::Incompatible(format!(
            "solver = {} does not go with friction: contacts with friction are solved over their states; use solver `active-set`",
            self.solver.name
        )))
    }
}
