//! Forces that a step of the second order takes implicitly, linear about where it stands.

use crate::interface_model::{MassMatrix, MatrixForm};

/// Stiffness and damping of a model, `K = −∂f/∂q` and `D = −∂f/∂v`.
///
/// They need not be those of all forces: a step keeps its order whatever they are, and is stable without limit as far
/// as they are right for what is stiff. Both must be symmetric and not negative, so that `M + ½hD + ¼h²K` stays a mass.
/// # Shapes and units
/// n×n; N/m and N·s/m (N·m and N·m·s of angles). Each is kept as masses are, by its diagonal where that is all there
/// is.
#[derive(Debug, Clone, PartialEq)]
pub struct StiffForces {
    /// `K`.
    pub stiffness: MassMatrix,
    /// `D`.
    pub damping: MassMatrix,
}

impl StiffForces {
    /// Makes zero matrices of `n` velocities.
    pub fn zeros(n: usize, form: MatrixForm) -> Self {
        StiffForces { stiffness: MassMatrix::zeros(n, form), damping: MassMatrix::zeros(n, form) }
    }
}
