//! Coulomb's law, and what is put in its place elsewhere.

use crate::name::by_name;

/// The law of friction that contacts are given in a step.
///
/// ```text
/// coulomb   0 ≤ w_n + gap ⟂ P_n ≥ 0               |P_t| ≤ μ P_n,   w_t P_t = −μ P_n |w_t|
/// relaxed   0 ≤ w_n + gap − μ |w_t| ⟂ P_n ≥ 0     the same         convex; what slides is lifted by h μ |w_t|
/// box       0 ≤ w_n + gap ⟂ P_n ≥ 0               |P_t| ≤ B,       w_t P_t = −B |w_t|       B = μ h F_n of the step before
/// held      0 ≤ w_n + gap ⟂ P_n ≥ 0               P_t = h F_t of the mechanics' last step
/// ```
/// All but the first are there to be compared with it. The second and the third are laws of a simulator, and both sides of a coupling
/// have them: mechanics and model, each with its own step. The fourth is a way to send less: only the model has it, and the mechanics
/// has Coulomb's law.
///
/// # Source
/// Relaxed: Anitescu, *Optimization-based simulation of nonsmooth rigid multibody dynamics* (2006). Box, with the normal force lagged: as in
/// engines for games, and in Peiret, González, Kövecses, Teichmann, *Co-simulation of multibody systems with contact using reduced interface
/// models* (2020). Held: the plain extrapolation of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FrictionLaw {
    /// Coulomb's, exact in the plane.
    #[default]
    Coulomb,
    /// Anitescu's convex relaxation.
    Relaxed,
    /// Bounds from the normal force of the step before.
    Box,
    /// The friction force stays what it was in the mechanics' last step.
    Held,
}

impl FrictionLaw {
    const NAMES: [(&'static str, FrictionLaw); 4] = [
        ("coulomb", FrictionLaw::Coulomb),
        ("relaxed", FrictionLaw::Relaxed),
        ("box", FrictionLaw::Box),
        ("held", FrictionLaw::Held),
    ];

    /// Returns the law of the mechanics' own steps in a run with this one.
    pub fn of_mechanics(self) -> Self {
        if self == FrictionLaw::Held { FrictionLaw::Coulomb } else { self }
    }
}

by_name!(FrictionLaw, NAMES, "friction law");
