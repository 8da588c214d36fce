//! Options that only schemes with a reduced interface model have.

use super::contact_detection::ContactDetection;
use crate::error::{Error, Result};
use crate::interface_model::{PSEUDO_INVERSE_LIMIT, ReducedInterfaceModel, Redundancy};
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
    /// `H` stays as it was; what of `a` depends on the state acts at `t_k`, as a half-kick `w + ½ H a` along closed
    /// contacts.
    HalfKick,
    /// `H` stays as it was, `a` jumps where the geometry has its next kink: gap functions are sent with their curvature
    /// and the place where it changes.
    Piecewise,
}

impl ModelMotion {
    const NAMES: [(&'static str, ModelMotion); 4] = [
        ("frozen", ModelMotion::Frozen),
        ("extrapolated", ModelMotion::Extrapolated),
        ("half-kick", ModelMotion::HalfKick),
        ("piecewise", ModelMotion::Piecewise),
    ];
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
    /// Treatment of dependent contacts where they become bilateral.
    pub redundancy: Redundancy,
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
        self.redundancy != Redundancy::Drop
            || self.model_motion == ModelMotion::HalfKick
            || self.friction_rows == FrictionRows::SlipDirection
    }

    /// Checks that they go together with what a mechanics offers.
    ///
    /// # Errors
    /// [`Error::Incompatible`] for what knows no friction, where there is some, for a half-kick of what is not known,
    /// for a pseudo-inverse of more contacts than it has room for, and for one row of friction where there are not two,
    /// or rows that turn.
    pub(super) fn check_model(&self, model: &ReducedInterfaceModel) -> Result<()> {
        if self.model_motion == ModelMotion::HalfKick && !model.has_friction() && model.state_bias.is_empty() {
            return Err(Error::Incompatible(format!(
                "model_motion = {}: the mechanics does not say which part of its free acceleration depends on the state; use `frozen`",
                self.model_motion
            )));
        }
        if self.redundancy == Redundancy::PseudoInverse && model.contacts() > PSEUDO_INVERSE_LIMIT {
            return Err(Error::Incompatible(format!(
                "redundancy = {}: available for up to {PSEUDO_INVERSE_LIMIT} contacts, and this mechanics has {}; use `drop` or \
                 `regularised`",
                self.redundancy,
                model.contacts()
            )));
        }
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
        let refused = |option: String, reason: &str| {
            Err(Error::Incompatible(format!("{option} does not go with friction: {reason}")))
        };
        if self.redundancy != Redundancy::Drop {
            let reason = "of dependent rows that stick or slide the equations drop out; use redundancy `drop`";
            return refused(format!("redundancy = {}", self.redundancy), reason);
        }
        if self.model_motion == ModelMotion::HalfKick {
            let reason = "a kick along a surface that may stick or slide is not defined; use model_motion `frozen`";
            return refused(format!("model_motion = {}", self.model_motion), reason);
        }
        if !self.solver.with_friction {
            let reason = "contacts with friction are solved over their states; use solver `active-set`";
            return refused(format!("solver = {}", self.solver.name), reason);
        }
        Ok(())
    }
}
